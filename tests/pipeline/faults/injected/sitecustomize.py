"""Put on PYTHONPATH by tests of this folder: makes rows fail, clocks jump, or bevelmap absent."""

import importlib.abc
import os
import sys

_FAULT = os.environ.get("BEVELMAP_TEST_FAULT", "")


def _fail(kind: str) -> None:
    if kind == "raise":
        raise FloatingPointError("injected")
    if kind == "sleep":
        import time

        time.sleep(1000.0)
    if kind == "spin":
        # Compiled as everything of the solver is.
        from solver.kernels import types
        from solver.kernels.compile import kernel

        @kernel(types.float64(types.float64))
        def spin(x):
            while x != 0.0:
                x = x * 1.0000001 if x < 1e6 else 1.0
            return x

        spin(1.0)
    if kind == "allocate":
        import time

        held = []
        while True:
            held.append(bytearray(os.urandom(2**20)) * 20)
            time.sleep(0.02)


def _patch(module) -> None:
    """Let the row at f_e = 0.25 fail, on every worker; or let every row take long enough to be interrupted."""
    kind, honest = _FAULT, module.stored_row

    def stored_row(plan, value, *rest):
        if kind == "slow":
            import time

            time.sleep(0.3)
        elif abs(value - plan.parameter.values[plan.parameter.num // 2]) < 1e-12:
            _fail(kind)
        return honest(plan, value, *rest)

    module.stored_row = stored_row


class _Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name != "pipeline.run.rows":
            return None
        sys.meta_path.remove(self)
        import importlib.util

        spec = importlib.util.find_spec(name)
        execute = spec.loader.exec_module

        def exec_module(module):
            execute(module)
            _patch(module)

        spec.loader.exec_module = exec_module
        return spec


def _turn_clock_back() -> None:
    """Some seconds after it has begun, every process finds its wall clock an hour back."""
    import datetime
    import time

    honest, begin = time.time, time.monotonic()

    def offset() -> float:
        return -3600.0 if time.monotonic() - begin > 3.0 else 0.0

    class Turned(datetime.datetime):
        # Compiled packages look at the size.
        __slots__ = ()

        @classmethod
        def now(cls, tz=None):
            return cls.fromtimestamp(honest() + offset(), tz)

    time.time = lambda: honest() + offset()
    datetime.datetime = Turned


class _Absent(importlib.abc.MetaPathFinder):
    """As where bevelmap is not installed."""

    def find_spec(self, name, path, target=None):
        if name.split(".")[0] in ("pipeline", "solver"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


if _FAULT == "absent":
    sys.meta_path.insert(0, _Absent())
elif _FAULT == "clock":
    _turn_clock_back()
elif _FAULT:
    sys.meta_path.insert(0, _Finder())
