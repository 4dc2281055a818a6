"""All boundaries of a plane, each traced once from the events that the sweeps of its rows have met."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from solver.boundaries.assembly import assembled, unfollowed
from solver.boundaries.contact_angles import BACK, FRONT, P, X
from solver.boundaries.curve import SEEN, BoundaryCurve, Piece
from solver.boundaries.plane import KINDS, Plane
from solver.boundaries.tangent import curve_tangent
from solver.continuation.continuation import Continuation, Curve, EndReason, Event, Problem
from solver.continuation.correctors import workspace_rows
from solver.model.checks import ParameterError
from solver.model.gear_model import Model
from solver.model.parameter_path import ParameterPath
from solver.rows.row import Row

__all__ = ["boundary_curves", "row_events"]

# A start that lies this close to a traced boundary, in scaled unknowns, belongs to it.
_SAME = 1e-6
_MOST_LEGS = 1000


def row_events(row: Row, parameter: float) -> list[tuple[Event, np.ndarray]]:
    """The folds and grazings of one row, as starts for `boundary_curves`.

    Parameters
    ----------
    row : Row
    parameter : float
        The row's value of the plane's second axis.

    Returns
    -------
    list of (Event, (5,) array)
        Kind and lambda_m, lambda_c, lambda_s, x, p.
    """
    return [
        (Event(curve.event[i]), np.append(curve.points[i], parameter))
        for curve in row.curves
        for i in np.flatnonzero(np.isin(curve.event, KINDS))
    ]


def boundary_curves(
    model: Model,
    x_axis: str,
    p_axis: str | ParameterPath,
    x_range: tuple[float, float],
    p_range: tuple[float, float],
    starts: Iterable[tuple[Event, np.ndarray]],
    *,
    omega: float | None = None,
    continuation: Continuation | None = None,
) -> tuple[BoundaryCurve, ...]:
    """Follow every boundary on which a start lies to the border of the plane, or until it closes.

    Parameters
    ----------
    model : Model
        Its own values of the two axes are not used; a path starts from it.
    x_axis : str
        One of `solver.model.condensation.AXES`.
    p_axis : str or ParameterPath
        Another one, or a path of models.
    x_range, p_range : (low, high)
        The plane.
    starts : iterable of (Event, (5,) array)
        Kind and (lambda_m, lambda_c, lambda_s, x, p) of points on boundaries, in any order; see `row_events`.
    omega : float, optional
        The frequency; needed unless it is an axis.
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
    """
    plane = Plane(model, x_axis, p_axis, x_range, p_range, omega)
    continuation = continuation or Continuation()
    kinds, points = _sorted(plane, starts)
    curves = []
    for kind in KINDS:
        tracer = Tracer(plane, kind, continuation)
        waiting = points[kinds == kind]
        while len(waiting):
            curve = tracer.boundary(waiting[0])
            nearest = np.full(len(waiting), np.inf) if curve is None else curve.distances(waiting, continuation)
            if nearest[0] > _SAME:
                curve, nearest[0] = unfollowed(kind, waiting[0]), 0.0
            waiting = waiting[nearest > _SAME]
            curves.append(curve)
    return tuple(sorted(curves, key=lambda curve: (curve.kind, *curve.points[0, [4, 3, 0, 1, 2]])))


def _sorted(plane: Plane, starts) -> tuple[np.ndarray, np.ndarray]:
    """Kinds (k,) and points (k, 5) of the starts, checked, in the order in which they are tried.

    By kind, p, x and unknowns, but those on the plane's border last: a boundary that ends there may do so at a
    singular point (b = 0).
    """
    starts = list(starts)
    kinds = np.array([kind for kind, _ in starts], dtype=np.int64)
    for kind in np.unique(kinds):
        if kind not in KINDS:
            raise ParameterError("starts", int(kind), f"of the kinds {', '.join(k.name for k in KINDS)}")
    for _, point in starts:
        if np.shape(point) != (5,):
            raise ParameterError("starts", point, "points (lambda_m, lambda_c, lambda_s, x, p)")
    points = np.array([point for _, point in starts], dtype=float).reshape(-1, 5)
    low, high = np.transpose([plane.x_range, plane.p_range])
    outside = ~np.all(np.isfinite(points), axis=1) | np.any((points[:, 3:] < low) | (points[:, 3:] > high), axis=1)
    if np.any(outside):
        raise ParameterError("starts", points[np.argmax(outside)].tolist(), "finite points inside the plane")
    border = np.any((points[:, 3:] == low) | (points[:, 3:] == high), axis=1)
    order = np.lexsort((*points[:, [2, 1, 0, 3, 4]].T, border, kinds))
    return kinds[order], points[order]


class Tracer:
    """Follows boundaries of one kind through the zones of the contact angles."""

    def __init__(self, plane: Plane, kind: Event, continuation: Continuation):
        self.plane, self.kind, self.continuation = plane, kind, continuation

    def boundary(self, point: np.ndarray) -> BoundaryCurve | None:
        """The whole boundary through a point (5,); None if none could be followed from it."""
        first = self._through(point)
        if first is None:
            return None
        chain = [first]
        closed = chain[0].curve.closed or self._extend(chain)
        if not closed:
            chain = [leg.reversed() for leg in reversed(chain)]
            self._extend(chain)
            if tuple(chain[0].curve.points[0, [P, X]]) > tuple(chain[-1].curve.points[-1, [P, X]]):
                chain = [leg.reversed() for leg in reversed(chain)]
        ends = (EndReason.CLOSED,) * 2 if closed else (chain[0].curve.ends[0], chain[-1].curve.ends[1])
        return assembled(self.plane, self.kind, [Piece(leg.problem, leg.curve) for leg in chain], ends)

    def _through(self, point: np.ndarray) -> "_Leg | None":
        """The boundary through a start (5,) within its zones."""
        leg = None
        for zones in self.plane.zones(self.kind, point):
            y = None if self.plane.contact_free(self.kind, zones) else self._land(zones, point)
            if y is not None:
                tangent = curve_tangent(self.plane.problem(self.kind, zones), y)
                leg = self._leg(zones, y, tangent, self.continuation.trace_both_ways)
                # A start on a wall and on the plane's border has its boundary on one side of the wall only.
                if len(leg.curve.points) > 1:
                    break
        return leg

    def _land(self, zones: tuple[int, int], point: np.ndarray) -> np.ndarray | None:
        """The y (7,) on the boundary next to a start (5,); None if there is none in these zones."""
        problem, (low, high) = self.plane.problem(self.kind, zones), self.plane.box(self.kind, zones)
        y = self.plane.lift(self.kind, zones, point)
        before, tangent, corrector = y.copy(), curve_tangent(problem, y), self.continuation.corrector
        # Held at its own p, so that a start on the border stays there, unless the boundary is level.
        normal = np.eye(7)[P] if abs(tangent[P]) > 0.01 else tangent
        iterations = corrector.kernel(
            problem.balance,
            problem.theta,
            problem.direction,
            problem.scale,
            y,
            normal,
            corrector.tolerance,
            2 * corrector.max_iterations,
            np.empty((workspace_rows(6), 7)),
        )
        inside = np.clip(y, low, high)
        moved = np.abs(y - before)[list(SEEN)] / problem.scale[list(SEEN)]
        if iterations < 0 or np.max(moved) > 10.0 * _SAME or np.max(np.abs(y - inside) / problem.scale) > _SAME:
            return None
        return inside

    def _leg(self, zones, y, heading, trace) -> "_Leg":
        problem = self.plane.problem(self.kind, zones)
        return _Leg(zones, problem, trace(problem, y, *self.plane.box(self.kind, zones), heading))

    def _extend(self, chain: list["_Leg"]) -> bool:
        """Follow the boundary from zone to zone beyond the last leg; whether it returned to the first one."""
        while len(chain) < _MOST_LEGS:
            leg = chain[-1]
            slot = self._wall(leg)
            if slot is None:
                return False
            y, move = leg.curve.points[-1], int(np.sign(leg.curve.tangents[-1, slot]))
            zones = tuple(z + move * (FRONT + i == slot) for i, z in enumerate(leg.zones))
            home = chain[0]
            if zones == home.zones and np.max(np.abs(y - home.curve.points[0]) / home.problem.scale) < _SAME:
                return True
            if self.plane.contact_free(self.kind, zones):
                return False
            chain.append(self._leg(zones, y, move * np.eye(7)[slot], self.continuation.trace))
        return False

    def _wall(self, leg: "_Leg") -> int | None:
        """The contact angle that ends a leg at one of its walls; None if it ends otherwise."""
        if leg.curve.ends[1] is not EndReason.RANGE_LEFT:
            return None
        y, (low, high) = leg.curve.points[-1], self.plane.box(self.kind, leg.zones)
        ended = np.flatnonzero((y == low) | (y == high))
        return int(ended[0]) if ended.size == 1 and ended[0] in (FRONT, BACK) else None


@dataclass(frozen=True)
class _Leg:
    """What was traced within one pair of zones."""

    zones: tuple[int, int]
    problem: Problem
    curve: Curve

    def reversed(self) -> "_Leg":
        curve = self.curve
        back = Curve(
            curve.points[::-1].copy(),
            -curve.tangents[::-1],
            curve.arclength[-1] - curve.arclength[::-1],
            curve.stable[::-1].copy(),
            curve.event[::-1].copy(),
            curve.ends[::-1],
            curve.refused,
        )
        return _Leg(self.zones, self.problem, back)
