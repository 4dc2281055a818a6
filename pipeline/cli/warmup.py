"""The very first run: half of the kernels are compiled by a second process while this one compiles the other half.

Numba compiles one function after the other, and a run has two cores. What the helper compiles goes into the cache on
disk, where this process finds it when its imports get there. Nothing depends on it: what it left undone is done here.
"""

import importlib.util
import subprocess
import sys
from pathlib import Path

__all__ = ["compile_all", "compile_beside", "is_cold"]

# The packages' own imports would compile everything in the same order; as bare folders they let one module be chosen.
_HELPER = """
import sys, types
from pathlib import Path

for folder in [Path(sys.argv[1]), *(inner.parent for inner in Path(sys.argv[1]).glob("*/__init__.py"))]:
    name = "solver" if folder == Path(sys.argv[1]) else f"solver.{folder.name}"
    package = sys.modules[name] = types.ModuleType(name)
    package.__path__ = [str(folder)]
import solver.stability.bifurcations, solver.boundaries.tracer
"""


def is_cold() -> bool:
    """Whether kernels are kept and none of these sources has been compiled yet; imports no kernel."""
    folder = _solver_folder()
    if folder is None:
        return False
    module = importlib.util.spec_from_file_location("_compile", folder / "kernels/compile.py")
    compiling = importlib.util.module_from_spec(module)
    module.loader.exec_module(compiling)
    return compiling.is_cold(folder / "continuation/arclength.py")


def _solver_folder() -> Path | None:
    spec = importlib.util.find_spec("solver")
    return None if spec is None else Path(spec.origin).parent


def compile_beside() -> subprocess.Popen | None:
    """Start the helper if no kernel has been compiled yet; call before anything imports the solver.

    Returns
    -------
    subprocess.Popen or None
        The helper, None where the cache is warm or the solver imported already.
    """
    if "solver" in sys.modules or not is_cold():
        return None
    return subprocess.Popen([sys.executable, "-c", _HELPER, str(_solver_folder())], stdout=subprocess.DEVNULL)


def compile_all() -> None:
    """Compile the kernels of every module of the solver, with the helper beside; cached ones stay as they are."""
    import pkgutil

    helper = compile_beside()
    import solver

    for module in pkgutil.walk_packages(solver.__path__, "solver."):
        importlib.import_module(module.name)
    if helper is not None:
        helper.wait()
