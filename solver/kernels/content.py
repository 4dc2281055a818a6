"""What a kernel depends on, as text: its code, and the values that it finds outside, other kernels included.

The text names an entry of the cache. It holds values and not files or lines: an edit is felt by the kernels that it can
change and by no others, whatever way a name was imported, and two checkouts share what is equal in both.
"""

import dis
import enum
import types
from collections.abc import Iterator

import numpy as np

from solver.kernels.types import Declared

__all__ = ["described_code"]

#: Modules whose contents belong to the versions that a cache entry is named after.
_LIBRARIES = {"numpy", "math", "cmath", "builtins"}


def described_code(function: types.FunctionType, kernel_class: type) -> str:
    """Text of a function and of everything that it finds outside.

    Parameters
    ----------
    function : function
    kernel_class : type
        Values of this class describe themselves by their attribute `content`.

    Raises
    ------
    TypeError
        If the function uses something whose contents cannot be told, such as a list or an object that may change.
    """
    code, cells = function.__code__, function.__closure__ or ()
    outside = {name: cell.cell_contents for name, cell in zip(code.co_freevars, cells, strict=True)}
    if function.__doc__ is not None:
        code = code.replace(co_consts=(None, *code.co_consts[1:]))
    try:
        values = _described_globals(function, kernel_class)
        values |= {name: _described(value, kernel_class) for name, value in outside.items()}
        return repr((_described(code, kernel_class), values))
    except TypeError as error:
        raise TypeError(f"kernel {function.__qualname__}: {error}") from None


def _described_globals(function: types.FunctionType, kernel_class: type) -> dict[str, str]:
    """Texts of globals by name: of all that a function names, as attributes too, which is a superset found quickly."""
    values, looked_up = {}, None
    for name in sorted(_names(function.__code__) & function.__globals__.keys()):
        try:
            values[name] = _described(function.__globals__[name], kernel_class)
        except TypeError:
            looked_up = looked_up or set(_global_names(function.__code__))
            if name in looked_up:
                raise
    return values


def _names(code: types.CodeType) -> set[str]:
    inner = (constant for constant in code.co_consts if isinstance(constant, types.CodeType))
    return set(code.co_names).union(*map(_names, inner))


def _global_names(code: types.CodeType) -> Iterator[str]:
    """Names that a function looks up among globals, those of functions inside it included; attributes are none."""
    for step in dis.get_instructions(code):
        if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
            yield step.argval
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _global_names(constant)


def _described(value, kernel_class: type) -> str:
    """Text of a value that a kernel may use: equal texts, equal values."""
    if isinstance(value, kernel_class):
        return value.content
    if isinstance(value, types.CodeType):
        consts = [_described(constant, kernel_class) for constant in value.co_consts]
        parts = ["code", "names", "varnames", "freevars", "cellvars", "argcount", "flags", "exceptiontable"]
        return repr((consts, [getattr(value, f"co_{part}") for part in parts]))
    if isinstance(value, (bool, int, float, complex, str, bytes, type(None), type(Ellipsis), np.generic)):
        return f"{type(value).__name__} {value!r}"
    if isinstance(value, (tuple, frozenset)):
        inner = [_described(item, kernel_class) for item in value]
        return f"{type(value).__qualname__}{inner if isinstance(value, tuple) else sorted(inner)}"
    if isinstance(value, np.ndarray):
        return f"array {value.dtype.str} {value.shape} {value.tobytes()!r}"
    if isinstance(value, Declared):
        return repr(value)
    if isinstance(value, enum.EnumMeta):
        return repr({name: member.value for name, member in value.__members__.items()})
    if isinstance(value, type) and hasattr(value, "_fields"):
        return f"{value.__qualname__}{value._fields}"
    library = (
        value.__name__ if isinstance(value, types.ModuleType) else getattr(value, "__module__", None) or "builtins"
    )
    if library.split(".")[0] in _LIBRARIES and hasattr(value, "__name__"):
        return f"{library} {value.__name__}"
    raise TypeError(f"it uses {value!r}, and a kernel may use numbers, arrays, tuples, enumerations, NumPy and kernels")
