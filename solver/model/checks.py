"""The one exception of the solver, a parameter with a value that is not allowed, and the checks that raise it."""

import math
from collections.abc import Iterable, Mapping, Sequence, Set
from numbers import Integral, Real

import numpy as np

__all__ = [
    "ParameterError",
    "ascending_grid",
    "finite_array",
    "finite_number",
    "finite_numbers",
    "frequency",
    "has_methods",
    "instance_of",
    "instances_of",
    "list_length",
    "number_array",
    "one_of",
    "value_range",
    "whole_number",
]

# Characters of a value that a message shows.
_LONGEST = 300


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
        super().__init__(f"{name} = {_shown(value)} is not allowed: it must be {allowed}")
        self.name, self.value, self.allowed = name, value, allowed

    def __reduce__(self):
        return type(self), (self.name, self.value, self.allowed)


def _shown(value) -> str:
    """A value on one line that is not too long."""
    text = " ".join(repr(value).split("\n"))
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def finite_number(
    name: str,
    value,
    *,
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
    at_most: float | None = None,
) -> float:
    """`value` as a float: a finite number within the bounds that are given.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    value : float
    above, at_least, below, at_most : float, optional
        Bounds of it.

    Raises
    ------
    ParameterError
        If it is something else; truth values and text are.
    """
    if _is_finite(value) and not (
        (above is not None and value <= above)
        or (at_least is not None and value < at_least)
        or (below is not None and value >= below)
        or (at_most is not None and value > at_most)
    ):
        return float(value)
    words = {"above": above, "at least": at_least, "below": below, "at most": at_most}
    bounds = " and".join(f" {word} {bound:g}" for word, bound in words.items() if bound is not None)
    raise ParameterError(name, value, f"a finite number{bounds}")


def _is_finite(value) -> bool:
    # Real is asked last, as that takes ten times as long as the others.
    if not isinstance(value, float | int) and not isinstance(value, Real):
        return False
    if isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def finite_numbers(name: str, value, count: int, **bounds: float) -> tuple[float, ...]:
    """One number for all, or exactly `count` of them, each as `finite_number`.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    value : float or (count,) sequence
    count : int
    **bounds : float
        As for `finite_number`.

    Raises
    ------
    ParameterError
        If it is something else.
    """
    if isinstance(value, Real):
        return (finite_number(name, value, **bounds),) * count
    if list_length(value) != count:
        raise ParameterError(name, value, f"one number or a list of {count}")
    return tuple(finite_number(f"{name}[{i}]", entry, **bounds) for i, entry in enumerate(value))


def list_length(value) -> int:
    """Number of entries of something that has an order; -1 where it has none, as text and sets."""
    try:
        return -1 if isinstance(value, str | bytes | Mapping | Set) else len(value)
    except TypeError:
        return -1


def whole_number(name: str, value, low: int, high: int) -> int:
    """`value` as an int from `low` to `high`.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    value : int
    low, high : int

    Raises
    ------
    ParameterError
        If it is something else; truth values and 2.0 are.
    """
    if not isinstance(value, Integral) or isinstance(value, bool) or not low <= value <= high:
        raise ParameterError(name, value, f"a whole number from {low} to {high}")
    return int(value)


def frequency(value) -> float:
    """A mesh frequency omega: a finite number above 0; raises ParameterError otherwise."""
    return finite_number("omega", value, above=0.0)


def one_of(name: str, value, allowed: Sequence[str]) -> str:
    """`value`, one of the names allowed.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    value : str
    allowed : sequence of str

    Raises
    ------
    ParameterError
        If it is something else.
    """
    if not isinstance(value, str) or value not in allowed:
        raise ParameterError(name, value, f"one of {', '.join(allowed)}")
    return value


def instance_of(name: str, value, *kinds: type):
    """`value`, an object of one of some classes.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    value : object
    *kinds : type

    Raises
    ------
    ParameterError
        If it is something else.
    """
    if not isinstance(value, kinds):
        raise ParameterError(name, value, f"of the type {' or '.join(kind.__name__ for kind in kinds)}")
    return value


def instances_of(name: str, values, *kinds: type) -> tuple:
    """`values` as a tuple of objects of one of some classes.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    values : iterable
    *kinds : type

    Raises
    ------
    ParameterError
        If it is no iterable, or an entry is something else.
    """
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise ParameterError(name, values, f"a list of {' or '.join(kind.__name__ for kind in kinds)}")
    return tuple(instance_of(name, value, *kinds) for value in values)


def has_methods(name: str, value, *methods: str):
    """`value`, an object that has some methods.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    value : object
    *methods : str

    Raises
    ------
    ParameterError
        If it is a class, or has not all of them.
    """
    if isinstance(value, type) or not all(callable(getattr(value, method, None)) for method in methods):
        raise ParameterError(name, value, f"an object with {' and '.join(f'{method}()' for method in methods)}")
    return value


# Letters of numpy's kinds, and what they are called.
_KINDS = {
    bool: ("biuf", "truth values or real numbers"),
    int: ("iu", "whole numbers"),
    float: ("iuf", "real numbers"),
    complex: ("iufc", "numbers"),
}


def number_array(name: str, values, *, kind: type = float, last: int | None = None) -> np.ndarray:
    """`values` as an array of numbers of any shape; nan and infinity are allowed.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    values : array_like
    kind : type
        What is allowed: int (whole numbers only), float (real numbers), complex (any), or bool (real ones and truth
        values).
    last : int, optional
        Expected length of the last axis.

    Raises
    ------
    ParameterError
        If an entry is masked or no number, as truth values and text, or the last axis has another length.
    """
    array = _array(name, values, *_KINDS[kind])
    if last is not None and (array.ndim == 0 or array.shape[-1] != last):
        raise ParameterError(name, f"array of shape {array.shape}", f"of shape (..., {last})")
    return array


def _array(name: str, values, kinds: str, allowed: str) -> np.ndarray:
    """`values` as an array whose numbers are of one of some kinds of numpy."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise ParameterError(name, "array with masked entries", allowed)
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        raise ParameterError(name, values, allowed) from None
    if array.dtype.kind not in kinds and array.size:
        raise ParameterError(name, values, allowed)
    return array


def finite_array(name: str, values, shape: tuple[int | None, ...] | None, kind=float) -> np.ndarray:
    """A copy of `values` as an array of finite numbers.

    Parameters
    ----------
    name : str
        The parameter as the user knows it.
    values : array_like
    shape : tuple or None
        Expected lengths, None where any is allowed; None for any shape.
    kind : type
        float or complex.

    Raises
    ------
    ParameterError
        If the shape differs, or an entry is masked, no number or not finite.
    """
    array = _array(name, values, _KINDS[kind][0], "finite numbers").astype(kind)
    if shape is not None and (
        array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True))
    ):
        lengths = ", ".join("any" if length is None else str(length) for length in shape)
        allowed = f"finite numbers of shape ({lengths}{',' if len(shape) == 1 else ''})"
        raise ParameterError(name, f"array of shape {array.shape}" if array.ndim else values, allowed)
    if not np.isfinite(array).all():
        raise ParameterError(name, array[~np.isfinite(array)][0].item(), "finite numbers")
    return array


def ascending_grid(name: str, values) -> np.ndarray:
    """A copy of `values` as a vector of at least two finite ascending numbers; raises ParameterError otherwise."""
    allowed = "at least 2 finite ascending numbers"
    try:
        grid = finite_array(name, values, (None,))
    except ParameterError as error:
        raise ParameterError(name, error.value, allowed) from None
    if grid.size < 2 or not np.all(grid[1:] > grid[:-1]):
        raise ParameterError(name, f"array of shape {grid.shape}" if grid.size > 4 else grid.tolist(), allowed)
    return grid


def value_range(name: str, value) -> tuple[float, float]:
    """A range (low, high) of finite numbers, low below high; raises ParameterError otherwise."""
    try:
        low, high = ascending_grid(name, value)
    except ValueError:
        raise ParameterError(name, value, "two finite ascending numbers") from None
    return float(low), float(high)
