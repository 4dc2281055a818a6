"""Boundaries of a balance of any order over a plane, as the curve problems that continuation follows.

Unknowns and rows are those of `solver.boundaries.harmonic_rows`. Determinants depend on the motion through the angles
of contact, which move infinitely fast where it grazes a flank: there their curves have corners. The contact of a
stretch says how often the motion switches contact at the front and at the back flank. A problem may be confined to it:
beyond, its equations are not numbers, and continuation stops at the corner.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from solver.boundaries.bifurcations import critical_cosines
from solver.boundaries.harmonic_rows import harmonic_rows
from solver.boundaries.problem import GRAZINGS, SPECTRAL, Contact, Guess, Plane, Stretch, plane_parameters
from solver.continuation.continuation import EndReason, Event, Problem
from solver.harmonic.galerkin import Galerkin
from solver.model.parameters import BACK_CONTACT, EVENT, FRONT_CONTACT

__all__ = ["HarmonicProblem"]

# Any number of switches of contact.
_ANY = (-1, -1)
# How far to look about a corner for motions with another contact, how deep to start among them, and how far the curve
# may be from there, in scaled unknowns.
_PROBES = (1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
_DEPTHS = (1e-6, 1e-8, 1e-4, 1e-10)
_REACH = 0.05


@dataclass(frozen=True)
class HarmonicProblem:
    """Boundaries of a balance of any order; see `solver.boundaries.problem.BoundaryProblem`.

    Parameters
    ----------
    plane : Plane
    balance : Galerkin

    Raises
    ------
    ParameterError
        If the path of the plane uses its x axis, or is not smooth between its knots.
    """

    plane: Plane
    balance: Galerkin

    def __post_init__(self):
        plane, balance = self.plane, self.balance
        parameters, parameter_slope = plane_parameters(plane, balance.order, balance.period)
        scale = np.array([*[plane.motion_size] * balance.unknowns, *plane.scale])
        for name, value in (("parameters", parameters), ("parameter_slope", parameter_slope), ("scale", scale)):
            value.setflags(write=False)
            object.__setattr__(self, f"_{name}", value)

    @property
    def unknowns(self) -> int:
        """Number n of unknowns u of a motion."""
        return self.balance.unknowns

    def components(self, kind: Event) -> tuple[int, ...]:
        """Where (u, x, p) stand among the unknowns y of a kind."""
        n, gap = self.unknowns, int(kind is Event.NEIMARK_SACKER)
        return *range(n), n + gap, n + gap + 1

    def shown(self, kind: Event) -> tuple[int, ...]:
        """Which components of y a boundary shows: mean, fundamental, x and p."""
        return 0, *self.balance.fundamental, *self.components(kind)[-2:]

    def starts(self, kind: Event, point: np.ndarray) -> Iterable[tuple[Contact, np.ndarray]]:
        """The y of a point (u, x, p); for a Neimark-Sacker one for every pair of multipliers next to the circle."""
        if kind is not Event.NEIMARK_SACKER:
            yield None, point.copy()
            return
        for kappa in critical_cosines(self.problem(kind, None), np.insert(point, -2, 0.0)):
            yield None, np.insert(point, -2, kappa)

    def problem(self, kind: Event, contact: Contact) -> Problem:
        """The curve of one kind, whatever the contact."""
        return self._problem(kind, _ANY)

    def confined(self, kind: Event, contact: Contact) -> Problem:
        """The curve of one kind, confined to motions of so many switches of contact."""
        return self._problem(kind, contact or _ANY)

    def _problem(self, kind: Event, contact: tuple[int, int]) -> Problem:
        parameters, parameter_slope, scale = self._parameters.copy(), self._parameter_slope.copy(), self._scale.copy()
        parameters[EVENT], parameters[[FRONT_CONTACT, BACK_CONTACT]] = kind, contact
        if kind is Event.NEIMARK_SACKER:
            scale = np.insert(scale, self.unknowns, 1.0)
        test_count = 2 if kind in (*GRAZINGS, *SPECTRAL) else 1
        return Problem(harmonic_rows, harmonic_rows, parameters, parameter_slope, scale, test_count)

    def repeats(self, kind: Event) -> bool:
        """No kind stands for another: motions need not be symmetric."""
        return False

    def box(self, kind: Event, contact: Contact) -> tuple[np.ndarray, np.ndarray]:
        """Low and high border of y: the plane, and for Neimark-Sackers the resonances kappa = -1 and 1."""
        size = len(self._scale) + (kind is Event.NEIMARK_SACKER)
        low, high = np.full(size, -np.inf), np.full(size, np.inf)
        (low[-2], high[-2]), (low[-1], high[-1]) = self.plane.x_range, self.plane.p_range
        if kind is Event.NEIMARK_SACKER:
            low[-3], high[-3] = -1.0, 1.0
        return low, high

    def contact_at(self, kind: Event, contact: Contact, y: np.ndarray) -> Contact:
        """How often the motion at y switches contact; None for a grazing, along which that changes nothing."""
        if kind in GRAZINGS:
            return None
        front, back = self.problem(Event.NONE, None).observed(y[list(self.components(kind))], 2)
        return int(front), int(back)

    def guesses_beyond(self, kind: Event, stretch: Stretch) -> Iterable[Guess]:
        """Beyond a corner, at some distance from the grazing there.

        Along the curve that distance is a minimum or moves with the square of the arc, on the side with more contact.
        Held, it leaves a regular problem on either side.
        """
        curve, problem = stretch.curve, stretch.problem
        if kind in GRAZINGS or curve.ends[1] is not EndReason.STEP_TOO_SMALL:
            return
        corner, across = curve.points[-1], self._across_grazing(kind, stretch)
        if across is None:
            return
        for depth in _DEPTHS:
            for sense in (1.0, -1.0):
                y = corner + sense * depth * across * problem.scale
                if self.contact_at(kind, None, y) != stretch.contact:
                    yield Guess(None, y, across, _REACH)

    def _across_grazing(self, kind: Event, stretch: Stretch) -> np.ndarray | None:
        """Unit vector across the grazing at which a stretch ends, in scaled unknowns; None if there is none.

        It is where the row behind the balance changes most on the side with more contact.
        """
        problem, n = stretch.problem, self.unknowns
        corner = stretch.curve.points[-1]

        def steepest(y):
            _, jacobian = problem.evaluated(y)
            row = jacobian[n + np.argmax(np.linalg.norm(jacobian[n:] * problem.scale, axis=1))] * problem.scale
            return row / np.linalg.norm(row)

        for length in _PROBES:
            for way in (stretch.curve.tangents[-1], steepest(corner)):
                for sense in (1.0, -1.0):
                    y = corner + sense * length * way * problem.scale
                    contact = self.contact_at(kind, None, y)
                    if contact != stretch.contact:
                        return steepest(y if sum(contact) > sum(stretch.contact) else corner)
        return None

    def static_determinants(self, problem: Problem, points: np.ndarray) -> np.ndarray:
        """Sign of det dE/du."""
        return np.linalg.slogdet([self.fold_rows(problem, y)[0] for y in points])[0]

    def fold_rows(self, problem: Problem, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """dE/du (n, n), dE/dp (n,) and the derivatives by u (n,) of the row behind the balance."""
        n, (_, jacobian) = self.unknowns, problem.evaluated(y)
        return jacobian[:n, :n], jacobian[:n, -1], jacobian[n, :n]
