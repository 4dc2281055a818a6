"""What a boundary is to those who follow it: the plane, the protocol of a boundary problem, and the vectors of kernels.

A boundary is made of stretches: along each of them the motion touches the flanks in one way, its contact, and the
equations are smooth. A boundary problem says which equations hold on a stretch, where it ends, and how the boundary
goes on beyond; `solver.boundaries.tracer` follows it. There are two of them: `solver.boundaries.first_order` and
`solver.boundaries.harmonic`.

Kernels read `parameters`, those of a plane in `solver.model.parameters`, and `parameter_slope`, what p adds to them
along a straight line. The system's part is that of `solver.model.packing.packed`; how p bends it is the flat form of
`solver.model.parameter_path`.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.continuation.continuation import Curve, Event, Problem
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.model.checks import (
    ParameterError,
    finite_array,
    frequency,
    instance_of,
    instances_of,
    list_length,
    value_range,
)
from solver.model.contact_system import SYSTEM_AXES, ContactSystem, refuse_cubic
from solver.model.gear_model import Model
from solver.model.packing import AXES, GAP_AXES, check_values, dead_zone_ends, packed
from solver.model.parameter_path import ParameterPath, add_path, place_on, plane_vectors
from solver.model.parameters import P_STEP, PLANE_HEADER, X_STEP

__all__ = [
    "BIFURCATIONS",
    "FOLDS_AND_GRAZINGS",
    "GRAZINGS",
    "SAME",
    "SPECTRAL",
    "BoundaryProblem",
    "Contact",
    "Guess",
    "Plane",
    "Stretch",
    "curve_tangent",
    "parameters_at",
    "plane_parameters",
]

GRAZINGS = (Event.MIN_AT_DRIVE, Event.MIN_AT_BACK, Event.MAX_AT_DRIVE, Event.MAX_AT_BACK)
FOLDS_AND_GRAZINGS = (Event.FOLD, *GRAZINGS)
BIFURCATIONS = (Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER)
#: What test functions of the monodromy matrix tell.
SPECTRAL = (*BIFURCATIONS, Event.UNIT_MULTIPLIER)

#: Points this close, in scaled unknowns, are the same one.
SAME = 1e-6

#: How the motion touches the front and the back flank all along a stretch: the zones of the contact angles at first
#: order, how often it switches contact at higher ones; None where nothing depends on it.
Contact = tuple[int, int] | None

# Steps of central differences by x and p, as a share of their typical step (a tenth of the range): what they
# difference is analytic, with some 1e-14 of rounding.
_DIFFERENCE = 1e-5


_KINDS = frozenset(map(int, Event))
#: Axes that move the same numbers: what one adds depends on the other.
_TOGETHER = ({"gap", "gap_scale"}, {"damping", "contact_damping"})


@dataclass(frozen=True)
class Plane:
    """Where boundaries are sought.

    Parameters
    ----------
    system : Model or ContactSystem
        Its own values of the two axes are not used; a path starts from it.
    x_axis : str
        One of `solver.model.packing.AXES`, or of `SYSTEM_AXES` for a ContactSystem.
    p_axis : str or ParameterPath
        Another one, or a path of models.
    x_range, p_range : (low, high)
    omega : float, optional
        The mesh frequency; needed unless it is an axis.

    Raises
    ------
    ParameterError
        If the axes are equal or unknown, a range is empty, or the frequency is missing.
    """

    system: Model | ContactSystem
    x_axis: str
    p_axis: str | ParameterPath
    x_range: tuple[float, float]
    p_range: tuple[float, float]
    omega: float | None = None

    def __post_init__(self):
        instance_of("system", self.system, Model, ContactSystem)
        refuse_cubic(self.system, "for boundaries")
        allowed = AXES if isinstance(self.system, Model) else SYSTEM_AXES
        for name in ("x_axis", "p_axis"):
            axis = getattr(self, name)
            if not (name == "p_axis" and isinstance(axis, ParameterPath)) and (
                not isinstance(axis, str) or axis not in allowed
            ):
                raise ParameterError(name, axis, f"one of {', '.join(allowed)}")
        if self.x_axis == self.p_axis or {self.x_axis, self.p_axis} in _TOGETHER:
            raise ParameterError("p_axis", self.p_axis, "another parameter than x_axis")
        for name in ("x_range", "p_range"):
            object.__setattr__(self, name, value_range(name, getattr(self, name)))
        if "omega" not in (self.x_axis, self.p_axis) or self.omega is not None:
            frequency(self.omega)
        for axis, ends in ((self.x_axis, self.x_range), (self.p_axis, self.p_range)):
            if isinstance(axis, str):
                check_values(self.system, axis, np.array(ends), 1.0)

    def system_at(self, p: float) -> Model | ContactSystem:
        """The system of the row p, in the middle of the range of x."""
        return place_on(self.p_axis, p, place_on(self.x_axis, 0.5 * sum(self.x_range), self.system)[0])[0]

    def dead_zone(self, x, p: float) -> tuple[np.ndarray, np.ndarray]:
        """Ends of the dead zone, low and high, at places x, a number or an array, of the row p."""
        moves = not isinstance(self.p_axis, str) or self.p_axis in GAP_AXES
        system = place_on(self.p_axis, p, self.system)[0] if moves else self.system
        return dead_zone_ends(system, self.x_axis, np.asarray(x, dtype=float))

    @property
    def motion_size(self) -> float:
        """Typical size of lambda in the middle of the plane."""
        return self.system_at(0.5 * sum(self.p_range)).motion_size

    @property
    def scale(self) -> list[float]:
        """Typical step of x and of p."""
        return [0.1 * (high - low) for low, high in (self.x_range, self.p_range)]


def checked_events(events, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Kinds (k,) and points (k, size) of starts.

    Parameters
    ----------
    events : iterable of (Event, (size,) array_like)
    size : int

    Raises
    ------
    ParameterError
        If one is no pair of a kind and so many finite numbers.
    """
    events = instances_of("starts", events, object)
    for event in events:
        if list_length(event) != 2 or not isinstance(event[0], int | np.integer) or event[0] not in _KINDS:
            raise ParameterError("starts", event, "pairs of an Event and a point")
    if not events:
        return np.empty(0, np.int64), np.empty((0, size))
    kinds, points = zip(*events, strict=True)
    return np.array(kinds, dtype=np.int64), finite_array("starts", points, (None, size))


def plane_parameters(plane: Plane, order: int, period: int) -> tuple[np.ndarray, np.ndarray]:
    """`parameters`, of its header only the steps, and `parameter_slope` of a plane.

    Parameters
    ----------
    plane : Plane
    order, period : int
        Of the balance: harmonics of the mesh frequency, and nu.
    """

    def vectors(axis: str, p: float):
        # A factor that is an axis multiplies what the system has itself.
        system = plane.system_at(p) if isinstance(plane.system, Model) else plane.system
        return packed(system, axis, plane.omega or 0.0, order, period)

    read = plane_vectors(vectors, plane.x_axis, plane.p_axis, plane.p_range)
    header = np.zeros(PLANE_HEADER)
    header[[X_STEP, P_STEP]] = np.multiply(_DIFFERENCE, plane.scale)
    return np.concatenate([header, read.base, read.along_x, read.bent]), read.along_p


@dataclass(frozen=True)
class Stretch:
    """The part of a boundary along which the contact stays the same, smooth to its ends.

    Parameters
    ----------
    contact : Contact
    problem : Problem
    curve : Curve
        Of that problem.
    """

    contact: Contact
    problem: Problem
    curve: Curve

    def reversed(self) -> "Stretch":
        """The same stretch, the other way."""
        return Stretch(self.contact, self.problem, self.curve.reversed())


@dataclass(frozen=True)
class Guess:
    """Where a boundary may go on beyond the end of a stretch.

    Parameters
    ----------
    contact : Contact
        Of the next stretch.
    y : (n + 1,) array
    heading : (n + 1,) array
        In scaled unknowns.
    reach : float
        0 if y lies on the boundary, which is followed from there towards `heading`. Otherwise y is corrected across
        `heading` by at most this, in scaled unknowns, and what is found there must come from the end.
    """

    contact: Contact
    y: np.ndarray
    heading: np.ndarray
    reach: float


class BoundaryProblem(Protocol):
    """What a tracer needs to know of the boundaries of a plane."""

    plane: Plane

    @property
    def unknowns(self) -> int:
        """Number n of unknowns u of a motion."""

    def components(self, kind: Event) -> tuple[int, ...]:
        """Where (u, x, p) stand among the unknowns y of a kind, (n + 2,)."""

    def shown(self, kind: Event) -> tuple[int, ...]:
        """Which components of y a boundary shows: mean, cosine and sine amplitude of the mesh frequency, x and p."""

    def starts(self, kind: Event, point: np.ndarray) -> Iterable[tuple[Contact, np.ndarray]]:
        """The y that a point (u, x, p) may stand for, each with the contact for which it is one."""

    def problem(self, kind: Event, contact: Contact) -> Problem:
        """The equations with this contact; they may hold beyond it."""

    def confined(self, kind: Event, contact: Contact) -> Problem:
        """The equations as they are followed: not numbers where the contact is another one."""

    def repeats(self, kind: Event) -> bool:
        """Whether every boundary of a kind is one of another kind as well, which stands for both."""

    def box(self, kind: Event, contact: Contact) -> tuple[np.ndarray, np.ndarray]:
        """Low and high border of y, infinite where it is free: the plane, and what else ends a stretch."""

    def contact_at(self, kind: Event, contact: Contact, y: np.ndarray) -> Contact:
        """The contact at y, a point of the boundary found with the equations of `contact`."""

    def guesses_beyond(self, kind: Event, stretch: Stretch) -> Iterable[Guess]:
        """How the boundary may go on beyond the last point of a stretch; nothing where it ends there."""

    def static_determinants(self, problem: Problem, points: np.ndarray) -> np.ndarray:
        """Numbers (k,) of the sign of det dE/du at points (k, n + 1) of y."""

    def fold_rows(self, problem: Problem, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """dE/du (n, n), dE/dp (n,) and the derivatives of det dE/du by u (n,) at a fold, each up to a positive factor.

        The determinant of the first has the sign of det dE/du where that does not vanish.
        """


def curve_tangent(problem: Problem, y: np.ndarray) -> np.ndarray:
    """Unit tangent (n + 1,) of a curve at one of its points in scaled unknowns, towards growing p."""
    jacobian = problem.evaluated(y)[1] * problem.scale
    if not np.all(np.isfinite(jacobian)):
        return np.full(y.size, np.nan)
    # The rows differ by orders of magnitude next to grazings.
    size = np.linalg.norm(jacobian, axis=1, keepdims=True)
    tangent = np.linalg.svd(jacobian / np.where(size > 0.0, size, 1.0))[2][-1]
    return tangent if tangent[-1] >= 0.0 else -tangent


@kernel(types.UniTuple(ARRAY, 3)(ARRAY, ARRAY, ARRAY), inner=True, shared=True)
def parameters_at(parameters, parameter_slope, y):
    """The parameters at y = (..., x, p), and what either axis adds to them there.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        A plane's header, its parameters at x = p = 0 and what x adds to them; what p adds to them.
    y : array
        Unknowns of the boundary, with x and p last.
    """
    size, last = parameter_slope.shape[0], y.shape[0] - 1
    here, along_x, along_p = np.empty(size), np.empty(size), np.empty(size)
    for i in range(size):
        along_x[i], along_p[i] = parameters[PLANE_HEADER + size + i], parameter_slope[i]
        here[i] = parameters[PLANE_HEADER + i] + y[last - 1] * along_x[i] + y[last] * along_p[i]
    add_path(parameters, PLANE_HEADER + 2 * size, y[last], here, along_p)
    return here, along_x, along_p
