"""The one exception of the solver, a parameter with a value that is not allowed, and the checks that raise it."""

import math
from collections.abc import Sequence
from numbers import Integral, Real

import numpy as np

__all__ = [
    "ParameterError",
    "ascending_grid",
    "finite_array",
    "finite_number",
    "finite_numbers",
    "frequency",
    "one_of",
    "value_range",
    "whole_number",
]


class ParameterError(ValueError):
    """A parameter has a value that is not allowed.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    value
        What it was.
    allowed : str
        What it may be, as the end of the sentence "... is not allowed: it must be".
    """

    def __init__(self, name: str, value, allowed: str):
        super().__init__(f"{name} = {value!r} is not allowed: it must be {allowed}")
        self.name, self.value, self.allowed = name, value, allowed

    def __reduce__(self):
        return type(self), (self.name, self.value, self.allowed)


def finite_number(name: str, value, *, above: float | None = None, at_least: float | None = None) -> float:
    """`value` as a float: a finite number, above one bound or at least the other where one is given.

    Raises
    ------
    ParameterError
        If it is something else; truth values and text are.
    """
    allowed = "a finite number"
    if above is not None:
        allowed += f" above {above:g}"
    if at_least is not None:
        allowed += f" at least {at_least:g}"
    number = isinstance(value, Real) and not isinstance(value, bool | np.bool_) and math.isfinite(value)
    if not number or (above is not None and value <= above) or (at_least is not None and value < at_least):
        raise ParameterError(name, value, allowed)
    return float(value)


def finite_numbers(name: str, value, count: int, **bounds: float) -> tuple[float, ...]:
    """One number for all, or exactly `count` of them, each as `finite_number`; raises ParameterError otherwise."""
    if isinstance(value, Real):
        return (finite_number(name, value, **bounds),) * count
    if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != count:
        raise ParameterError(name, value, f"one number or a list of {count}")
    return tuple(finite_number(f"{name}[{i}]", entry, **bounds) for i, entry in enumerate(value))


def whole_number(name: str, value, low: int, high: int) -> int:
    """`value` as an int from `low` to `high`; raises ParameterError otherwise."""
    if not isinstance(value, Integral) or isinstance(value, bool) or not low <= value <= high:
        raise ParameterError(name, value, f"a whole number from {low} to {high}")
    return int(value)


def frequency(value) -> float:
    """A mesh frequency omega: a finite number above 0; raises ParameterError otherwise."""
    return finite_number("omega", value, above=0.0)


def one_of(name: str, value, allowed: Sequence[str]) -> str:
    """`value`, one of the names allowed; raises ParameterError otherwise."""
    if not isinstance(value, str) or value not in allowed:
        raise ParameterError(name, value, f"one of {', '.join(allowed)}")
    return value


def finite_array(name: str, values, shape: tuple[int | None, ...], kind=float) -> np.ndarray:
    """A copy of `values` as an array of finite numbers.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    values : array_like
    shape : tuple
        Expected lengths, None where any is allowed.
    kind : type
        float or complex.

    Raises
    ------
    ParameterError
        If the shape differs, or an entry is masked, no number or not finite.
    """
    lengths = ", ".join("any" if length is None else str(length) for length in shape)
    allowed = f"finite numbers of shape ({lengths}{',' if len(shape) == 1 else ''})"
    if np.ma.is_masked(values):
        raise ParameterError(name, "array with masked entries", allowed)
    try:
        array = np.array(values, dtype=kind)
    except (TypeError, ValueError):
        raise ParameterError(name, values, allowed) from None
    if array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True)):
        raise ParameterError(name, f"array of shape {array.shape}", allowed)
    if not np.all(np.isfinite(array)):
        raise ParameterError(name, array[~np.isfinite(array)][0].item(), allowed)
    return array


def ascending_grid(name: str, values, at_least: int = 1) -> np.ndarray:
    """A copy of `values` as a vector of at least so many finite ascending numbers; raises ParameterError otherwise."""
    allowed = f"at least {at_least} finite ascending numbers"
    try:
        grid = finite_array(name, values, (None,))
    except ParameterError as error:
        raise ParameterError(name, error.value, allowed) from None
    if grid.size < at_least or not np.all(grid[1:] > grid[:-1]):
        raise ParameterError(name, f"array of shape {grid.shape}", allowed)
    return grid


def value_range(name: str, value) -> tuple[float, float]:
    """A range (low, high) of finite numbers, low below high; raises ParameterError otherwise."""
    try:
        low, high = ascending_grid(name, value, 2)
    except ValueError:
        raise ParameterError(name, value, "two finite ascending numbers") from None
    return float(low), float(high)
