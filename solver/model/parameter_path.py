"""Smooth one-parameter paths of models as an axis, and what two axes of a plane add to the numbers that kernels read.

A plain parameter moves the numbers along a straight line: parameters + p * parameter_slope. A path bends: every number
is some function of p. Kernels read it as a polynomial for each number that moves, in Chebyshev form on each stretch
between two knots, to the last digits; residuals and first derivatives at p need nothing of it but its value and its
slope there.

Flat form: the PATH slots of `solver.model.parameters`, s + 1 edges, k slots, (s, k, m + 1) coefficients; (0,) where
nothing bends.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.model.checks import ParameterError
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.parameters import DEGREE, EDGES, MOVING, STRETCHES

__all__ = ["ParameterPath", "PlaneVectors", "add_path", "place_on", "plane_vectors"]

_DEGREES = (8, 16, 32, 64)
# Coefficients this small, as a share of a number's largest value, are rounding.
_ROUNDING = 1e-15


@dataclass(frozen=True)
class ParameterPath:
    """Models along one parameter that moves several others, for example a temperature.

    Parameters
    ----------
    name : str
        Of the axis.
    changes : callable
        changes(model, value) -> keyword arguments of `Model.replace`; the model is the one that the path starts from.
    uses : tuple of str
        Parameters that it sets or that what it sets was derived from: none of them may be the other axis.
    knots : tuple of float
        Values at which `changes` is not smooth.
    shifts : tuple of str
        Of `uses`, parameters to which it adds what does not depend on their own value, and from which nothing else was
        derived.
    """

    name: str
    changes: Callable[[Model, float], dict] = field(repr=False)
    uses: tuple[str, ...]
    knots: tuple[float, ...] = ()
    shifts: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.name


def place_on(
    axis: str | ParameterPath, value: float, model: Model | ContactSystem, omega: float | None = None
) -> tuple[Model | ContactSystem, float | None]:
    """The system and the frequency at one value of an axis.

    Parameters
    ----------
    axis : str or ParameterPath
    value : float
    model : Model or ContactSystem
        Its own value of a plain axis is not used; a path starts from it.
    omega : float, optional

    Returns
    -------
    Model or ContactSystem, float or None

    Raises
    ------
    ParameterError
        If the value is not allowed.
    """
    if isinstance(axis, ParameterPath):
        return model.replace(**axis.changes(model, float(value))), omega
    if axis == "omega":
        return model, float(value)
    if isinstance(model, ContactSystem):
        return model.at(axis, float(value)), omega
    return model.replace(**{axis: float(value)}), omega


class PlaneVectors(NamedTuple):
    """What kernels read of a plane: the numbers with both axes at 0, what either adds, and how p bends them."""

    base: np.ndarray
    along_x: np.ndarray
    along_p: np.ndarray
    bent: np.ndarray


def plane_vectors(
    vectors: Callable, x_axis: str, p_axis: str | ParameterPath, p_range: tuple[float, float]
) -> PlaneVectors:
    """The numbers of a plane.

    Parameters
    ----------
    vectors : callable
        vectors(axis, p) -> parameters with the axis at 0, and parameter_slope, of the model at a place p of the p axis.
    x_axis, p_axis : str, str or ParameterPath
    p_range : (low, high)

    Returns
    -------
    PlaneVectors

    Raises
    ------
    ParameterError
        If the path uses the x axis, or is not smooth between its knots.
    """
    middle = 0.5 * (p_range[0] + p_range[1])
    first, along_x = vectors(x_axis, middle)
    if isinstance(p_axis, ParameterPath):
        if x_axis in p_axis.uses:
            taken = ", ".join(p_axis.uses)
            raise ParameterError("x_axis", x_axis, f"another parameter than {taken}, which {p_axis} sets")
        slots, bent = _bent(lambda p: vectors(x_axis, p)[0], p_axis, p_range)
        base = first.copy()
        base[slots] = 0.0
        return PlaneVectors(base, along_x, np.zeros_like(base), bent)
    second, along_p = vectors(p_axis, middle)
    # What either axis sets is 0 in the vector that belongs to it.
    return PlaneVectors(np.where(second == 0.0, 0.0, first), along_x, along_p, np.zeros(1))


def _bent(numbers: Callable, path: ParameterPath, p_range: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Slots of the numbers that move along a path, and the path in flat form."""
    low, high = p_range
    edges = np.array([low, *sorted(knot for knot in set(path.knots) if low < knot < high), high])
    for degree in _DEGREES:
        # Chebyshev points of the first kind on every stretch.
        unit = chebyshev.chebpts1(degree + 1)
        places = 0.5 * (edges[:-1] + edges[1:])[:, None] + 0.5 * np.diff(edges)[:, None] * unit
        values = np.array([[numbers(p) for p in stretch] for stretch in places])
        slots = np.flatnonzero(np.any(values != values[0, 0], axis=(0, 1)))
        moving = values[:, :, slots]
        # Discrete orthogonality: the interpolating polynomial exactly.
        weights = chebyshev.chebvander(unit, degree) * (2.0 / (degree + 1))
        weights[:, 0] *= 0.5
        coefficients = np.einsum("jm,sjk->skm", weights, moving)
        size = np.max(np.abs(moving), axis=(0, 1))[:, None]
        if np.all(np.abs(coefficients[:, :, -2:]) <= _ROUNDING * degree * size):
            head = [edges.size - 1, slots.size, degree]
            return slots, np.concatenate([head, edges, slots, coefficients.ravel()])
    raise ParameterError("p_axis", path.name, f"smooth between its knots {edges.tolist()}")


@kernel(types.void(ARRAY, types.int64, types.float64, ARRAY, ARRAY), inner=True)
def add_path(parameters, start, p, numbers, slopes):
    """Add to `numbers` what a path has moved them to at p, and to `slopes` their derivatives by p.

    Parameters
    ----------
    parameters : array
        Holds the path in flat form from `start` on.
    start : int
    p : float
    numbers, slopes : arrays
    """
    stretches = int(parameters[start + STRETCHES])
    if stretches == 0:
        return
    moving, degree, edges = int(parameters[start + MOVING]), int(parameters[start + DEGREE]), start + EDGES
    slots = edges + stretches + 1
    stretch = 0
    while stretch < stretches - 1 and p >= parameters[edges + stretch + 1]:
        stretch += 1
    low, high = parameters[edges + stretch], parameters[edges + stretch + 1]
    per = 2.0 / (high - low)
    u = (p - 0.5 * (low + high)) * per
    at = slots + moving + stretch * moving * (degree + 1)
    for i in range(moving):
        # Clenshaw's recurrence for the sum and, differentiated, for its slope.
        value_1, value_2, slope_1, slope_2 = 0.0, 0.0, 0.0, 0.0
        for m in range(degree, 0, -1):
            value = parameters[at + m] + 2.0 * u * value_1 - value_2
            slope = 2.0 * value_1 + 2.0 * u * slope_1 - slope_2
            value_1, value_2, slope_1, slope_2 = value, value_1, slope, slope_1
        slot = int(parameters[slots + i])
        numbers[slot] += parameters[at] + u * value_1 - value_2
        slopes[slot] += (value_1 + u * slope_1 - slope_2) * per
        at += degree + 1
