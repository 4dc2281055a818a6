"""All boundaries of a plane, each traced once from the events that the sweeps of its rows have met."""

import itertools
from collections.abc import Iterable

import numpy as np

from solver.boundaries.chain import MEET, Chain, joined
from solver.boundaries.curve import BoundaryCurve, assembled, unfollowed
from solver.boundaries.first_order import FirstOrderProblem
from solver.boundaries.harmonic import HarmonicProblem
from solver.boundaries.incidence import distances
from solver.boundaries.problem import (
    FOLDS_AND_GRAZINGS,
    SAME,
    SPECTRAL,
    BoundaryProblem,
    Contact,
    Guess,
    Plane,
    Stretch,
    checked_events,
    curve_tangent,
)
from solver.continuation.continuation import Continuation, Curve, EndReason, Event
from solver.continuation.problem import Balance
from solver.harmonic.describing_function import DescribingFunction
from solver.kernels.threads import side_by_side
from solver.model.checks import ParameterError, finite_number, has_methods, instance_of, instances_of
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.parameter_path import ParameterPath

__all__ = ["Tracer", "boundary_curves", "events_near", "row_events"]

_MOST_STRETCHES = 1000


def row_events(
    curves: Iterable[Curve], parameter: float, kinds: Iterable[Event] = FOLDS_AND_GRAZINGS
) -> list[tuple[Event, np.ndarray]]:
    """The events of one row, as starts for `boundary_curves`.

    Parameters
    ----------
    curves : iterable of Curve
        The branches of the row; for period doublings and Neimark-Sackers with what
        `solver.stability.bifurcations.with_bifurcations` locates.
    parameter : float
        The row's value of the plane's second axis.
    kinds : iterable of Event
        Those wanted.

    Returns
    -------
    list of (Event, (n + 2,) array)
        Kind and (u, x, p): at first order lambda_m, lambda_c, lambda_s, x, p.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    curves, parameter = instances_of("curves", curves, Curve), finite_number("parameter", parameter)
    wanted = [int(kind) for kind in instances_of("kinds", kinds, Event)]
    return [
        (Event(curve.event[i]), np.append(curve.points[i], parameter))
        for curve in curves
        for i in np.flatnonzero(np.isin(curve.event, wanted))
    ]


def boundary_curves(
    system: Model | ContactSystem,
    x_axis: str,
    p_axis: str | ParameterPath,
    x_range: tuple[float, float],
    p_range: tuple[float, float],
    starts: Iterable[tuple[Event, np.ndarray]],
    *,
    omega: float | None = None,
    balance: Balance | None = None,
    continuation: Continuation | None = None,
) -> tuple[BoundaryCurve, ...]:
    """Follow every boundary on which a start lies until it leaves the plane, closes or cannot be followed further.

    Parameters
    ----------
    system : Model or ContactSystem
        Its own values of the two axes are not used; a path starts from it.
    x_axis : str
        One of `solver.model.packing.AXES`, or of `SYSTEM_AXES` for a ContactSystem.
    p_axis : str or ParameterPath
        Another one, or a path of models.
    x_range, p_range : (low, high)
        The plane.
    starts : iterable of (Event, (n + 2,) array)
        Kind and (u, x, p) of points on boundaries, in any order; see `row_events`.
    omega : float, optional
        The mesh frequency; needed unless it is an axis.
    balance : Balance, optional
        Whose boundaries; the describing function of first order unless given.
    continuation : Continuation, optional

    Returns
    -------
    tuple of BoundaryCurve
        Every boundary once, whatever the order of the starts: sorted by kind and first point. Open ones run from the
        end with the smaller p (then x). A start from which no boundary could be followed is a curve of one point that
        ends for STEP_TOO_SMALL.

    Raises
    ------
    ParameterError
        If the plane is not allowed, or a start is of another kind or outside of it.

    Notes
    -----
    Away from the contact angles of first order a boundary has a corner with an infinite gradient where its motion
    begins to touch a flank. Continuation stops there on either side, and what meets is joined; where the other side is
    not found, neither by a hop nor from a start, the boundary ends for STEP_TOO_SMALL.

    Folds, period doublings and Neimark-Sackers are curves of minimally augmented and squared systems (W. J. F.
    Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, SIAM 2000; docs/physics.md, sections 5.5 and
    6.4).
    """
    plane = Plane(system, x_axis, p_axis, x_range, p_range, omega)
    balance = DescribingFunction() if balance is None else has_methods("balance", balance, "problem", "extremes")
    continuation = Continuation() if continuation is None else instance_of("continuation", continuation, Continuation)
    kinds, points = _sorted(plane, balance.unknowns, starts)
    boundary = _boundary_problem(plane, balance)
    wanted = [kind for kind in map(Event, np.unique(kinds)) if not boundary.repeats(kind)]

    def curves_of(kind: Event) -> list[BoundaryCurve]:
        return _curves(Tracer(boundary, kind, continuation), points[kinds == kind])

    # Those of multipliers, which take longest, come last in the order of kinds.
    curves = itertools.chain.from_iterable(side_by_side(curves_of, wanted[::-1]))
    return tuple(sorted(curves, key=lambda curve: (curve.kind, *curve.points[0, [4, 3, 0, 1, 2]])))


def events_near(
    system: Model | ContactSystem,
    x_axis: str,
    p_axis: str | ParameterPath,
    x_range: tuple[float, float],
    p_range: tuple[float, float],
    guesses: Iterable[tuple[Event, np.ndarray]],
    reach: float,
    *,
    omega: float | None = None,
    balance: Balance | None = None,
    continuation: Continuation | None = None,
) -> list[tuple[Event, np.ndarray]]:
    """Points of boundaries in the rows of guesses, as starts for `boundary_curves`.

    Parameters
    ----------
    system, x_axis, p_axis, x_range, p_range, omega, balance, continuation
        As for `boundary_curves`.
    guesses : iterable of (Event, (n + 2,) array)
        Kind and (u, x, p) near a boundary.
    reach : float
        Largest distance along x of a point from its guess.

    Returns
    -------
    list of (Event, (n + 2,) array)
        With p as guessed; guesses that lead nowhere, or beyond the plane, are left out.

    Raises
    ------
    ParameterError
        As `boundary_curves`.
    """
    plane, reach = Plane(system, x_axis, p_axis, x_range, p_range, omega), finite_number("reach", reach, above=0.0)
    balance = DescribingFunction() if balance is None else has_methods("balance", balance, "problem", "extremes")
    corrector = (Continuation() if continuation is None else continuation).corrector
    boundary = _boundary_problem(plane, balance)

    def point_near(start) -> tuple[Event, np.ndarray] | None:
        kind, guess = Event(start[0]), start[1]
        here = list(boundary.components(kind))
        for contact, y in boundary.starts(kind, guess):
            y = boundary.problem(kind, contact).corrected(y, corrector, max_iterations=2 * corrector.max_iterations)
            if y is None:
                continue
            point = y[here]
            if abs(point[-2] - guess[-2]) <= reach and x_range[0] <= point[-2] <= x_range[1]:
                return kind, point
        return None

    starts = zip(*_sorted(plane, balance.unknowns, guesses), strict=True)
    return [point for point in side_by_side(point_near, starts) if point is not None]


def _boundary_problem(plane: Plane, balance: Balance) -> BoundaryProblem:
    return FirstOrderProblem(plane) if balance.truncated else HarmonicProblem(plane, balance)


def _sorted(plane: Plane, unknowns: int, starts) -> tuple[np.ndarray, np.ndarray]:
    """Kinds (k,) and points (k, n + 2) of the starts, checked, in the order in which they are tried.

    By kind, p, x and unknowns, but those on the plane's border last: a boundary that ends there may do so at a
    singular point (b = 0).
    """
    size, allowed = unknowns + 2, (*FOLDS_AND_GRAZINGS, *SPECTRAL)
    kinds, points = checked_events(starts, size)
    for kind in np.unique(kinds):
        if kind not in allowed:
            raise ParameterError("starts", int(kind), f"of the kinds {', '.join(k.name for k in allowed)}")
    low, high = np.transpose([plane.x_range, plane.p_range])
    outside = np.any((points[:, -2:] < low) | (points[:, -2:] > high), axis=1)
    if np.any(outside):
        raise ParameterError("starts", points[np.argmax(outside)].tolist(), "inside the plane")
    border = np.any((points[:, -2:] == low) | (points[:, -2:] == high), axis=1)
    order = np.lexsort((*points[:, [*range(size - 2)[::-1], -2, -1]].T, border, kinds))
    return kinds[order], points[order]


def _curves(tracer: "Tracer", waiting: np.ndarray) -> list[BoundaryCurve]:
    """All boundaries of one kind on which starts (k, n + 2) lie."""
    curves, chains = [], list[Chain]()
    while len(waiting):
        chain = tracer.boundary(waiting[0])
        off = np.ones(len(waiting), dtype=bool) if chain is None else tracer.off(chain, waiting)
        if off[0]:
            curves.append(unfollowed(tracer.boundary_problem, tracer.kind, waiting[0]))
            waiting = waiting[1:]
            continue
        # Two starts may lead to the same stretch between two corners, and from one of them alone across.
        for part in chain.parts():
            if not any(tracer.covers(known, part) for known in chains):
                chains = [*(known for known in chains if not tracer.covers(part, known)), part]
        waiting = waiting[off]
    return [*curves, *(assembled(tracer.boundary_problem, tracer.kind, chain) for chain in joined(chains))]


class Tracer:
    """Follows boundaries of one kind.

    Parameters
    ----------
    boundary_problem : BoundaryProblem
    kind : Event
    continuation : Continuation
    """

    def __init__(self, boundary_problem: BoundaryProblem, kind: Event, continuation: Continuation):
        self.boundary_problem, self.kind, self.continuation = boundary_problem, kind, continuation

    def boundary(self, point: np.ndarray) -> Chain | None:
        """The whole boundary through a start (u, x, p), as far as it can be followed; None if there is none."""
        first = self._through(point)
        if first is None:
            return None
        chain = self._extended(Chain((first,), first.curve.closed))
        return chain if chain.closed else self._extended(chain.reversed())

    def off(self, chain: Chain, points: np.ndarray) -> np.ndarray:
        """Which points (k, n + 2) lie off a boundary, all of the motion counted, (k,) bool."""
        here = list(self.boundary_problem.components(self.kind))
        off = np.ones(len(points), dtype=bool)
        for stretch in chain.stretches:
            targets = np.zeros((np.count_nonzero(off), stretch.problem.unknowns + 1))
            targets[:, here] = points[off]
            off[off] = distances(stretch.problem, stretch.curve, targets, here, self.continuation, SAME) > SAME
        return off

    def covers(self, chain: Chain, other: Chain) -> bool:
        """Whether a chain runs through the middle of every stretch of another one."""
        here = list(self.boundary_problem.components(self.kind))
        middles = [stretch.curve.points[len(stretch.curve.points) // 2, here] for stretch in other.stretches]
        return not np.any(self.off(chain, np.array(middles)))

    def _through(self, point: np.ndarray) -> Stretch | None:
        """The stretch on which a start (u, x, p) lies."""
        longest = None
        for contact, y in self.boundary_problem.starts(self.kind, point):
            # Held at its own p, so that a start on the border stays there, unless the boundary runs along the row.
            heading = curve_tangent(self.boundary_problem.problem(self.kind, contact), y)
            normal = np.eye(y.size)[-1] if abs(heading[-1]) > 0.01 else heading
            y = self._correct_onto_curve(contact, y, normal, 10.0 * SAME, SAME)
            if y is None:
                continue
            heading = curve_tangent(self.boundary_problem.problem(self.kind, contact), y)
            if not _finite(heading):
                continue
            stretch = self._followed(contact, y, heading, self.continuation.trace_both_ways)
            longest = stretch if len(stretch.curve.points) else longest
            # A start on a wall and on the plane's border has its boundary on one side of the wall only.
            if len(stretch.curve.points) > 1:
                break
        return longest

    def _correct_onto_curve(
        self, contact: Contact, y: np.ndarray, normal: np.ndarray, reach: float, beyond: float
    ) -> np.ndarray | None:
        """The point of the boundary next to y across `normal`; None if there is none.

        It may move by `reach` in (u, x, p) and lie outside of the box by `beyond`, in scaled unknowns.
        """
        if not _finite(y, normal):
            return None
        problem, (low, high) = (
            self.boundary_problem.problem(self.kind, contact),
            self.boundary_problem.box(self.kind, contact),
        )
        corrector, before = self.continuation.corrector, y
        y = problem.corrected(y, corrector, normal, 2 * corrector.max_iterations)
        if y is None:
            return None
        inside = np.clip(y, low, high)
        moved = (np.abs(y - before) / problem.scale)[list(self.boundary_problem.components(self.kind))]
        if np.max(moved) > reach or np.max(np.abs(y - inside) / problem.scale) > beyond:
            return None
        return inside

    def _followed(self, contact: Contact, y: np.ndarray, heading: np.ndarray, trace) -> Stretch:
        """The stretch through a point of the boundary."""
        problems, kind = self.boundary_problem, self.kind
        contact = problems.contact_at(kind, contact, y)
        curve = trace(problems.confined(kind, contact), y, *problems.box(kind, contact), heading)
        return Stretch(contact, problems.problem(kind, contact), curve)

    def _extended(self, chain: Chain) -> Chain:
        """Follow a boundary beyond its last stretch."""
        while len(chain.stretches) < _MOST_STRETCHES and not chain.closed:
            last = chain.stretches[-1]
            candidates = (self._beyond(last, guess) for guess in self.boundary_problem.guesses_beyond(self.kind, last))
            stretch = next((stretch for stretch in candidates if stretch is not None), None)
            if stretch is None:
                break
            chain = chain.followed_by(stretch)
        return chain

    def _beyond(self, last: Stretch, guess: Guess) -> Stretch | None:
        """The stretch that a guess leads to, from the end of the last one on; None if it leads nowhere."""
        if not _finite(guess.y, guess.heading):
            return None
        if guess.reach == 0.0:
            return self._followed(guess.contact, guess.y, guess.heading, self.continuation.trace)
        y = self._correct_onto_curve(guess.contact, guess.y, guess.heading, guess.reach, guess.reach)
        if y is None or self.boundary_problem.contact_at(self.kind, guess.contact, y) == last.contact:
            return None
        stretch = self._followed(guess.contact, y, guess.heading, self.continuation.trace_both_ways)
        if len(stretch.curve.points) > 1:
            for way in (stretch, stretch.reversed()):
                gap = np.max(np.abs(way.curve.points[0] - last.curve.points[-1]) / last.problem.scale)
                if way.curve.ends[0] is EndReason.STEP_TOO_SMALL and gap < MEET:
                    return way
        return None


def _finite(*arrays: np.ndarray) -> bool:
    """Whether continuation can start there: next to singular points a tangent cannot be told."""
    return all(np.isfinite(array).all() for array in arrays)
