"""All boundaries of a plane, each traced once from the events that the sweeps of its rows have met."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from solver.boundaries.contact_angles import BACK, FRONT, P, X
from solver.boundaries.curve import SEEN, BoundaryCurve, Piece, SpecialPoint
from solver.boundaries.incidence import distances
from solver.boundaries.plane import KINDS, Plane
from solver.boundaries.special import static_determinant, turning_point
from solver.continuation import Continuation, Curve, EndReason, Event, Problem
from solver.correctors import workspace_rows
from solver.errors import ParameterError
from solver.model import Model
from solver.row import Row

__all__ = ["BoundaryError", "boundary_curves", "row_events"]

# A start that lies this close to a traced boundary, in scaled unknowns, belongs to it.
_SAME = 1e-6
_MOST_LEGS = 1000


class BoundaryError(ArithmeticError):
    """A boundary could not be followed; the message says where."""


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
    p_axis: str,
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
        Its own values of the two axes are not used.
    x_axis, p_axis : str
        Two names of `solver.condensation.AXES`.
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
        Every boundary once, whatever the order of the starts: sorted by kind and first point. Open ones run from the end
        with the smaller p (then x).

    Raises
    ------
    ParameterError
        If the plane is not allowed, or a start is of another kind or outside of it.
    BoundaryError
        If a start lies on no boundary.
    """
    plane = Plane(model, x_axis, p_axis, x_range, p_range, omega)
    continuation = continuation or Continuation()
    sorted_starts = _sorted(plane, starts)
    curves = []
    for kind in KINDS:
        tracer = _Tracer(plane, kind, continuation)
        targets = np.array([plane.lift(kind, (0, 0), point) for k, point in sorted_starts if k == kind])
        waiting = np.array([point for k, point in sorted_starts if k == kind])
        while len(waiting):
            curve = tracer.boundary(waiting[0])
            nearest = np.min([distances(p.problem, p.curve, targets, SEEN, continuation) for p in curve.pieces], axis=0)
            if nearest[0] > _SAME:
                raise BoundaryError(f"The boundary traced {tracer.place(waiting[0])} does not pass through its own start.")
            targets, waiting = targets[nearest > _SAME], waiting[nearest > _SAME]
            curves.append(curve)
    return tuple(sorted(curves, key=lambda curve: (curve.kind, *curve.points[0, [4, 3, 0, 1, 2]])))


def _sorted(plane: Plane, starts) -> list[tuple[Event, np.ndarray]]:
    """The starts by kind, p, x and unknowns, checked."""
    checked = []
    for kind, point in starts:
        point = np.asarray(point, dtype=float)
        if kind not in KINDS:
            raise ParameterError("starts", kind, f"one of {', '.join(k.name for k in KINDS)}")
        if point.shape != (5,) or not np.all(np.isfinite(point)):
            raise ParameterError("starts", point.tolist(), "five finite numbers: lambda_m, lambda_c, lambda_s, x, p")
        for value, (low, high) in zip(point[3:], (plane.x_range, plane.p_range), strict=True):
            if not low <= value <= high:
                raise ParameterError("starts", point.tolist(), "inside the plane")
        checked.append((Event(kind), point))
    return sorted(checked, key=lambda start: (start[0], *start[1][[4, 3, 0, 1, 2]]))


class _Tracer:
    """Follows boundaries of one kind through the zones of the contact angles."""

    def __init__(self, plane: Plane, kind: Event, continuation: Continuation):
        self.plane, self.kind, self.continuation = plane, kind, continuation

    def place(self, point: np.ndarray) -> str:
        """Where a start is, for a message."""
        return f"of {self.kind.name} from {self.plane.x_axis} = {point[3]:.9g}, {self.plane.p_axis} = {point[4]:.9g}"

    def boundary(self, point: np.ndarray) -> BoundaryCurve:
        """The whole boundary through a point (5,)."""
        zones, y, tangent = self._land(point)
        chain = [self._leg(zones, y, tangent, self.continuation.trace_both_ways)]
        closed = chain[0].curve.closed or self._extend(chain)
        if not closed:
            chain = [leg.reversed() for leg in reversed(chain)]
            self._extend(chain)
            if tuple(chain[0].curve.points[0, [P, X]]) > tuple(chain[-1].curve.points[-1, [P, X]]):
                chain = [leg.reversed() for leg in reversed(chain)]
        ends = (EndReason.CLOSED,) * 2 if closed else (chain[0].curve.ends[0], chain[-1].curve.ends[1])
        return _assembled(self.kind, [Piece(leg.problem, leg.curve) for leg in chain], ends)

    def _land(self, point: np.ndarray) -> tuple[tuple[int, int], np.ndarray, np.ndarray]:
        """Zones of a start (5,), the y (7,) on the boundary next to it and the tangent there."""
        zones = self.plane.zones(self.kind, point)
        corrector = self.continuation.corrector
        for _ in range(3):
            problem, (low, high) = self.plane.problem(self.kind, zones), self.plane.box(self.kind, zones)
            y = self.plane.lift(self.kind, zones, point)
            before, tangent = y.copy(), _tangent(problem, y)
            # Held at its own p, so that a start on the border stays there, unless the boundary is level.
            normal = np.eye(7)[P] if abs(tangent[P]) > 0.01 else tangent
            iterations = corrector.kernel(
                problem.balance, problem.theta, problem.direction, problem.scale, y, normal,
                corrector.tolerance, 2 * corrector.max_iterations, np.empty((workspace_rows(6), 7)),
            )  # fmt: skip
            if iterations < 0 or np.max(np.abs((y - before) / problem.scale)[list(SEEN)]) > 10.0 * _SAME:
                break
            # Next to a corner the start may have been put on the wrong side of it.
            flanks = slice(FRONT, BACK + 1)
            shift = (y[flanks] > high[flanks]).astype(int) - (y[flanks] < low[flanks])
            if not np.any(shift):
                y[[X, P]] = np.clip(y[[X, P]], low[[X, P]], high[[X, P]])
                return zones, y, _tangent(problem, y)
            zones = tuple(int(z) for z in zones + shift)
        raise BoundaryError(f"There is no boundary {self.place(point)}.")

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
            curve.points[::-1].copy(), -curve.tangents[::-1], curve.arclength[-1] - curve.arclength[::-1],
            curve.stable[::-1].copy(), curve.event[::-1].copy(), curve.ends[::-1], curve.refused,
        )  # fmt: skip
        return _Leg(self.zones, self.problem, back)


def _tangent(problem: Problem, y: np.ndarray) -> np.ndarray:
    """Unit tangent in scaled unknowns, towards growing p."""
    jacobian = np.empty((6, 7))
    problem.balance(problem.theta, problem.direction, y, np.empty(6), jacobian)
    jacobian *= problem.scale
    # The rows differ by orders of magnitude next to grazings.
    size = np.linalg.norm(jacobian, axis=1, keepdims=True)
    tangent = np.linalg.svd(jacobian / np.where(size > 0.0, size, 1.0))[2][-1]
    return tangent if tangent[P] >= 0.0 else -tangent


def _assembled(kind: Event, pieces: list[Piece], ends: tuple[EndReason, EndReason]) -> BoundaryCurve:
    """One curve of its pieces, with the special points named."""
    shown, points, slopes, lengths, special, stable = list(SEEN), [], [], [], [], []
    travelled = 0.0
    closed = ends[1] is EndReason.CLOSED
    for number, piece in enumerate(pieces):
        curve, scale = piece.curve, piece.problem.scale
        codes = np.zeros(len(curve.points), np.int8)
        for i in np.flatnonzero(curve.event):
            if kind is not Event.FOLD:
                codes[i] = SpecialPoint.EXTREMUM if curve.event[i] == Event.FOLD else SpecialPoint.FOLD_GRAZING
            elif curve.event[i] == Event.FOLD:
                codes[i] = turning_point(piece.problem, curve, i)
        if number > 0 or (closed and len(pieces) > 1):
            before, tangent = pieces[number - 1].curve.tangents[-1, [X, P]], curve.tangents[0, [X, P]]
            codes[0] = SpecialPoint.CUSP if before @ tangent < 0.0 else SpecialPoint.NONE
        if number < len(pieces) - 1 or (closed and len(pieces) > 1):
            codes[-1] = SpecialPoint.FOLD_GRAZING if kind is Event.FOLD else SpecialPoint.DOUBLE_GRAZING
        points.append(curve.points[:, shown])
        slopes.append((curve.tangents * scale)[:, shown])
        lengths.append(travelled + curve.arclength)
        travelled = lengths[-1][-1]
        special.append(codes)
        determinants = [0.0 if kind is Event.FOLD else static_determinant(piece.problem, y) for y in curve.points]
        stable.append((np.array(determinants) > 0.0) & (codes != SpecialPoint.FOLD_GRAZING))
    codes = np.concatenate(special)
    for end, place in zip(ends, (0, -1), strict=True):
        if end is EndReason.RANGE_LEFT:
            codes[place] = SpecialPoint.BORDER
    return BoundaryCurve(
        kind, np.concatenate(points), np.concatenate(slopes), np.concatenate(lengths),
        np.concatenate(stable).astype(np.int8), codes, ends, tuple(pieces),
    )  # fmt: skip
