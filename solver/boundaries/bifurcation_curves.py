"""All bifurcation curves of a balance in a plane, each traced once from what the sweeps of its rows have met."""

from collections.abc import Iterable

import numpy as np

from solver.boundaries.bifurcation_plane import ANY, WINDOW, BifurcationPlane
from solver.boundaries.bifurcation_points import named_points
from solver.boundaries.chain import MEET, Chain, joined, reversed_piece
from solver.boundaries.curve import BoundaryCurve, Piece
from solver.boundaries.incidence import distances
from solver.boundaries.tangent import curve_tangent
from solver.continuation.continuation import Continuation, Curve, EndReason, Event
from solver.continuation.correctors import workspace_rows
from solver.continuation.problem import Balance
from solver.model.checks import ParameterError
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.parameter_path import ParameterPath
from solver.stability.hill_determinant import HALF
from solver.stability.scan import critical_shares

__all__ = ["bifurcation_curves", "bifurcation_events"]

# A start that lies this close to a traced curve, in scaled unknowns, belongs to it.
_SAME = 1e-6
_MOST_PIECES = 100
# How far to look for the other side of a corner, in scaled unknowns.
_HOPS = (1e-3, 1e-2, 1e-4)
# How far the two truncations may disagree where a Neimark-Sacker curve changes its window.
_WINDOWS_AGREE = 0.3


def bifurcation_events(
    curves: Iterable[Curve], parameter: float, kinds: Iterable[Event]
) -> list[tuple[Event, np.ndarray]]:
    """The events of one row, as starts for `bifurcation_curves`.

    Parameters
    ----------
    curves : iterable of Curve
        Of the row, with the bifurcations that `solver.stability.bifurcations.with_bifurcations` locates.
    parameter : float
        The row's value of the plane's second axis.
    kinds : iterable of Event
        Those wanted.

    Returns
    -------
    list of (Event, (n + 2,) array)
        Kind and (u, x, p).
    """
    wanted = [int(kind) for kind in kinds]
    return [
        (Event(curve.event[i]), np.append(curve.points[i], parameter))
        for curve in curves
        for i in np.flatnonzero(np.isin(curve.event, wanted))
    ]


def bifurcation_curves(
    balance: Balance,
    system: Model | ContactSystem,
    x_axis: str,
    p_axis: str | ParameterPath,
    x_range: tuple[float, float],
    p_range: tuple[float, float],
    starts: Iterable[tuple[Event, np.ndarray]],
    *,
    omega: float | None = None,
    continuation: Continuation | None = None,
) -> tuple[BoundaryCurve, ...]:
    """Follow every bifurcation curve on which a start lies until it leaves the plane, closes or cannot be followed
    further.

    Where the motion of a fold, period doubling or Neimark-Sacker begins to touch a flank, the curve has a corner with
    an infinite gradient. Continuation stops there on either side, and what meets is joined; where the other side is not
    found, neither by a hop nor by a start, the curve ends for STEP_TOO_SMALL.

    Parameters
    ----------
    balance : DescribingFunction or Galerkin
    system : Model or ContactSystem
        Its own values of the two axes are not used; a path starts from it.
    x_axis : str
        A name that the balance knows as an axis.
    p_axis : str or ParameterPath
        Another one, or a path of models.
    x_range, p_range : (low, high)
        The plane.
    starts : iterable of (Event, (n + 2,) array)
        Kind and (u, x, p) of points on the curves, in any order; see `bifurcation_events`.
    omega : float, optional
        The mesh frequency; needed unless it is an axis.
    continuation : Continuation, optional

    Returns
    -------
    tuple of BoundaryCurve
        Every curve once: sorted by kind and first point. Open ones run from the end with the smaller p (then x). A
        start from which nothing could be followed is a curve of one point that ends for STEP_TOO_SMALL.

    Raises
    ------
    ParameterError
        If the plane is not allowed, or a start is of another kind or outside of it.
    """
    plane = BifurcationPlane(balance, system, x_axis, p_axis, x_range, p_range, omega)
    continuation = continuation or Continuation()
    kinds, points = _sorted(plane, starts)
    curves = []
    for kind in plane.kinds:
        tracer = _Tracer(plane, kind, continuation)
        waiting, found = points[kinds == kind], list[Chain]()
        while len(waiting):
            chain = tracer.boundary(waiting[0])
            nearest = np.full(len(waiting), np.inf) if chain is None else tracer.distances(chain, waiting)
            if nearest[0] > _SAME:
                curves.append(tracer.unfollowed(waiting[0]))
                waiting = waiting[1:]
                continue
            # Two starts may lead to the same stretch between two corners, and from one of them alone across.
            for part in chain.parts():
                if not any(tracer.covers(known, part) for known in found):
                    found.append(part)
            waiting = waiting[nearest > _SAME]
        curves += [named_points(plane, kind, list(chain.pieces), chain.ends) for chain in joined(found)]
    return tuple(sorted(curves, key=lambda curve: (curve.kind, *curve.points[0, [4, 3, 0, 1, 2]])))


def _sorted(plane: BifurcationPlane, starts) -> tuple[np.ndarray, np.ndarray]:
    """Kinds (k,) and points (k, n + 2) of the starts, checked, by kind, p, x and unknowns; those on the border last."""
    starts = list(starts)
    kinds = np.array([kind for kind, _ in starts], dtype=np.int64)
    size = plane.balance.unknowns + 2
    for kind in np.unique(kinds):
        if kind not in plane.kinds:
            raise ParameterError("starts", int(kind), f"of the kinds {', '.join(k.name for k in plane.kinds)}")
    for _, point in starts:
        if np.shape(point) != (size,):
            raise ParameterError("starts", point, f"points (u, x, p) of {size} numbers")
    points = np.array([point for _, point in starts], dtype=float).reshape(-1, size)
    low, high = np.transpose([plane.x_range, plane.p_range])
    outside = ~np.all(np.isfinite(points), axis=1) | np.any((points[:, -2:] < low) | (points[:, -2:] > high), axis=1)
    if np.any(outside):
        raise ParameterError("starts", points[np.argmax(outside)].tolist(), "finite points inside the plane")
    border = np.any((points[:, -2:] == low) | (points[:, -2:] == high), axis=1)
    order = np.lexsort((*points[:, [*range(size - 2)[::-1], -2, -1]].T, border, kinds))
    return kinds[order], points[order]


class _Tracer:
    """Follows curves of one kind."""

    def __init__(self, plane: BifurcationPlane, kind: Event, continuation: Continuation):
        self.plane, self.kind, self.continuation = plane, kind, continuation

    def distances(self, chain: Chain, points: np.ndarray) -> np.ndarray:
        """Distance of starts (k, n + 2) from a curve in scaled unknowns, all of the motion counted, (k,)."""
        here = self.plane.components(self.kind)
        nearest = np.full(len(points), np.inf)
        for piece in chain.pieces:
            targets = np.zeros((len(points), piece.problem.unknowns + 1))
            targets[:, here] = points
            found = distances(piece.problem, piece.curve, targets, here, self.continuation)
            nearest = np.minimum(nearest, found)
        return nearest

    def covers(self, chain: Chain, other: Chain) -> bool:
        """Whether a chain runs through the middle of another one."""
        longest = max((piece.curve.points for piece in other.pieces), key=len)
        middle = longest[len(longest) // 2, self.plane.components(self.kind)]
        return bool(self.distances(chain, middle[None])[0] <= _SAME)

    def unfollowed(self, point: np.ndarray) -> BoundaryCurve:
        """A start from which no curve could be followed."""
        shown = point[[0, *self.plane.balance.fundamental, -2, -1]]
        nothing = np.zeros(1, np.int8)
        return BoundaryCurve(
            self.kind,
            shown[None],
            np.zeros((1, 5)),
            np.zeros(1),
            nothing,
            nothing,
            (EndReason.STEP_TOO_SMALL,) * 2,
            (),
            self.plane.seen(self.kind),
        )

    def boundary(self, point: np.ndarray) -> Chain | None:
        """The whole curve through a start (n + 2,), as far as it can be followed; None if there is none."""
        first = self._through(point)
        if first is None:
            return None
        chain = Chain((first,), first.curve.closed)
        return self._extended(self._extended(chain).reversed())

    def _through(self, point: np.ndarray) -> Piece | None:
        """The curve through a start (n + 2,) within its window."""
        for share in self._shares(point):
            for window in self.plane.windows(self.kind, share):
                y = np.insert(point, -2, share) if self.kind is Event.NEIMARK_SACKER else point.copy()
                y = self._landed(window, y, np.eye(y.size)[-1], 10.0 * _SAME)
                if y is not None:
                    tangent = curve_tangent(self.plane.problem(self.kind, window), y)
                    leg = self._leg(window, y, tangent, self.continuation.trace_both_ways)
                    if len(leg.curve.points):
                        return leg
        return None

    def _shares(self, point: np.ndarray) -> list[float]:
        """Second frequencies over the base frequency that the motion of a start may have."""
        if self.kind is not Event.NEIMARK_SACKER:
            return [0.0]
        theta, found = self.plane.parameters(point), np.empty(64)
        motion = np.append(point[:-2], 0.0)
        truncated = self.plane.balance.truncated
        for tolerance in (1e-8, 1e-5):
            count = critical_shares(theta, np.zeros_like(theta), motion, truncated, tolerance, found)
            if count:
                break
        shares = np.sort(found[:count])
        return shares[np.diff(shares, prepend=-1.0) > 1e-6].tolist()

    def _landed(self, window: int, y: np.ndarray, normal: np.ndarray, reach: float) -> np.ndarray | None:
        """The point of the curve next to y across `normal`, within reach in (u, x, p); None if there is none.

        Across the tangent instead where the curve is level there, that is where it runs along the hyperplane.
        """
        problem, (low, high) = self.plane.problem(self.kind, window), self.plane.box(self.kind, window)
        before, corrector = y.copy(), self.continuation.corrector
        tangent = curve_tangent(problem, y)
        if not np.all(np.isfinite(tangent)):
            return None
        iterations = corrector.kernel(
            problem.balance,
            problem.theta,
            problem.direction,
            problem.scale,
            y,
            np.ascontiguousarray(normal if abs(tangent @ normal) > 0.01 else tangent),
            corrector.tolerance,
            2 * corrector.max_iterations,
            np.empty((workspace_rows(y.size - 1), y.size)),
        )
        inside = np.clip(y, low, high)
        moved = (np.abs(y - before) / problem.scale)[self.plane.components(self.kind)]
        if iterations < 0 or np.max(moved) > reach or np.max(np.abs(y - inside) / problem.scale) > reach:
            return None
        return inside

    def _leg(self, window: int, y: np.ndarray, heading: np.ndarray, trace) -> Piece:
        problem = self.plane.problem(self.kind, window, self.plane.switches(self.kind, y))
        # Confined only while it is traced: between two of its points the equations hold without.
        return Piece(
            self.plane.problem(self.kind, window), trace(problem, y, *self.plane.box(self.kind, window), heading)
        )

    def _extended(self, chain: Chain) -> Chain:
        """Follow a curve beyond its last piece, from window to window and across corners."""
        while len(chain.pieces) < _MOST_PIECES and not chain.closed:
            last = chain.pieces[-1].curve
            piece, end = None, last.ends[1]
            if end is EndReason.STEP_TOO_SMALL:
                piece = self._hop(chain)
            elif self.kind is Event.NEIMARK_SACKER and end is EndReason.RANGE_LEFT and last.points[-1, -3] == 0.25:
                piece = self._next_window(chain)
            if piece is None:
                break
            chain = chain.followed_by(piece)
        return chain

    def _next_window(self, chain: Chain) -> Piece | None:
        """The piece of a Neimark-Sacker curve in the other window; None if it is not found.

        The windows cut off different harmonics, so that the curve moves by what the truncation leaves out.
        """
        last = chain.pieces[-1]
        window, normal = 1 - int(last.problem.theta[WINDOW]), np.eye(last.curve.points.shape[1])[-3]
        y = self._landed(window, last.curve.points[-1].copy(), normal, _WINDOWS_AGREE)
        if y is None or abs(y[-3] - 0.25) > 1e-9:
            return None
        y[-3] = 0.25
        piece = self._leg(window, y, normal if window == HALF else -normal, self.continuation.trace)
        return piece if len(piece.curve.points) > 1 else None

    def _hop(self, chain: Chain) -> Piece | None:
        """The piece on the other side of the corner at which the last one stops; None if it is not found.

        Somewhere close by, along the tangents of arrival, lies a motion with other switches of contact whose curve,
        followed back, stops at the same corner.
        """
        last, window = chain.pieces[-1], int(chain.pieces[-1].problem.theta[WINDOW])
        corner, tangent = last.curve.points[-1], last.curve.tangents[-1]
        # At the corner itself rounding decides.
        switches = self.plane.switches(self.kind, last.curve.points[len(last.curve.points) // 2])
        if switches == ANY:
            return None
        for length in _HOPS:
            for sense in (1.0, -1.0):
                guess = corner + sense * length * tangent * last.problem.scale
                y = self._landed(window, guess, tangent, length)
                if y is None or self.plane.switches(self.kind, y) == switches:
                    continue
                piece = self._leg(window, y, tangent, self.continuation.trace_both_ways)
                if len(piece.curve.points) > 1:
                    for way in (piece, reversed_piece(piece)):
                        gap = np.max(np.abs(way.curve.points[0] - corner) / piece.problem.scale)
                        if way.curve.ends[0] is EndReason.STEP_TOO_SMALL and gap < MEET:
                            return way
        return None
