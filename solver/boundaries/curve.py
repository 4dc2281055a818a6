"""A boundary in the plane of two parameters."""

from dataclasses import dataclass, field

import numpy as np

from solver.boundaries.chain import Chain
from solver.boundaries.incidence import distances
from solver.boundaries.problem import SAME, BoundaryProblem, Stretch
from solver.boundaries.special_points import SpecialPoint, end_of, joint, named_points
from solver.continuation.continuation import Continuation, EndReason, Event
from solver.continuation.on_curve import curve_crossings
from solver.model.checks import ParameterError, finite_array, instance_of

__all__ = ["BoundaryCurve", "assembled", "unfollowed"]


@dataclass(frozen=True)
class BoundaryCurve:
    """One boundary; its k points are in order of arc length.

    Where the fold's motion touches a flank, the curve in (lambda_m, ..., p) has a corner: the point is stored twice
    (alike within rounding), with the slopes of arrival and of departure. So is the joint of a closed curve.

    Parameters
    ----------
    kind : Event
        FOLD, the grazing that happens along it, PERIOD_DOUBLING, NEIMARK_SACKER or UNIT_MULTIPLIER.
    points : (k, 5) array
        lambda_m, lambda_c, lambda_s, x, p.
    slopes : (k, 5) array
        Their derivatives by arc length.
    arclength : (k,) array
        In scaled unknowns, contact angles included.
    stable : (k,) int8 array
        1 where the motion is statically stable; 0 where it is not and along folds.
    special : (k,) int8 array
        `SpecialPoint`. A corner at which the curve reverses in the plane is FOLD_GRAZING where it arrives and CUSP
        where it departs.
    ends : tuple of EndReason
        Why it ends at its first and at its last point. RANGE_LEFT is the border of the plane, or a DOUBLE_GRAZING
        beyond which the motion has no contact (f_pm = 0: the balance does not determine the mean there).
    stretches : tuple of Stretch
        What continuation computed, for those who need more points.
    shown : tuple of int
        Which components of their y are shown.
    """

    kind: Event
    points: np.ndarray
    slopes: np.ndarray
    arclength: np.ndarray
    stable: np.ndarray
    special: np.ndarray
    ends: tuple[EndReason, EndReason]
    stretches: tuple[Stretch, ...] = field(repr=False, compare=False)
    shown: tuple[int, ...] = field(repr=False)

    @property
    def x(self) -> np.ndarray:
        """First axis of the plane, (k,)."""
        return self.points[:, 3]

    @property
    def parameter(self) -> np.ndarray:
        """Second axis of the plane, (k,)."""
        return self.points[:, 4]

    @property
    def mean(self) -> np.ndarray:
        """lambda_m, (k,)."""
        return self.points[:, 0]

    @property
    def cos(self) -> np.ndarray:
        """lambda_c, (k,)."""
        return self.points[:, 1]

    @property
    def sin(self) -> np.ndarray:
        """lambda_s, (k,)."""
        return self.points[:, 2]

    @property
    def amplitude(self) -> np.ndarray:
        """lambda_a, (k,)."""
        return np.hypot(self.cos, self.sin)

    @property
    def scale(self) -> np.ndarray:
        """Typical size of the components shown, (5,)."""
        return self.stretches[0].problem.scale[list(self.shown)]

    @property
    def closed(self) -> bool:
        """Whether the last point is the first one again."""
        return self.ends[1] is EndReason.CLOSED

    def crossings(self, values, continuation: Continuation | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Where the boundary meets given values of p, solved and not interpolated.

        Parameters
        ----------
        values : (v,) array_like
            Ascending.
        continuation : Continuation, optional
            Whose corrector is used.

        Returns
        -------
        column : (c,) int array
            Which value each place belongs to.
        points : (c, 5) array
            lambda_m, lambda_c, lambda_s, x, p.

        Raises
        ------
        ParameterError
            If an argument is not allowed.
        ArithmeticError
            If the corrector cannot reach a value that the boundary passes.
        """
        values, continuation = finite_array("values", values, (None,)), _settings(continuation)
        if np.any(values[1:] < values[:-1]):
            raise ParameterError("values", values.tolist(), "ascending")
        columns, points = [np.empty(0, np.int64)], [np.empty((0, 5))]
        for stretch in self.stretches:
            met = curve_crossings(stretch.problem, stretch.curve, values, continuation)
            if met.unreached.size:
                value = values[met.unreached[0]]
                raise ArithmeticError(f"the boundary passes {value!r}, but the corrector does not converge there")
            columns.append(met.column)
            points.append(np.column_stack([met.unknowns[:, self.shown[:-1]], values[met.column]]))
        return np.concatenate(columns), np.concatenate(points)

    def distances(self, points: np.ndarray, continuation: Continuation | None = None) -> np.ndarray:
        """Distance of points (n, 5) from the boundary in scaled unknowns, (n,); see `solver.boundaries.incidence`.

        Raises
        ------
        ParameterError
            If an argument is not allowed.
        """
        return self._distances(points, continuation, 0.0)

    def meets(self, points: np.ndarray, continuation: Continuation | None = None) -> np.ndarray:
        """Which of the points (n, 5) lie on the boundary, (n,) bool: no further off than 1e-6 in scaled unknowns.

        Raises
        ------
        ParameterError
            If an argument is not allowed.
        """
        return self._distances(points, continuation, SAME) <= SAME

    def _distances(self, points, continuation: Continuation | None, asked: float) -> np.ndarray:
        points, continuation = finite_array("points", points, (None, 5)), _settings(continuation)
        nearest = np.full(len(points), np.inf)
        for stretch in self.stretches:
            targets = np.zeros((len(points), stretch.problem.unknowns + 1))
            targets[:, self.shown] = points
            here = distances(stretch.problem, stretch.curve, targets, self.shown, continuation, asked)
            nearest = np.minimum(nearest, here)
        return nearest


def _settings(continuation: Continuation | None) -> Continuation:
    return Continuation() if continuation is None else instance_of("continuation", continuation, Continuation)


def unfollowed(boundary: BoundaryProblem, kind: Event, point: np.ndarray) -> BoundaryCurve:
    """A start from which no boundary could be followed, as a curve of one point.

    Parameters
    ----------
    boundary : BoundaryProblem
    kind : Event
    point : (n + 2,) array
        (u, x, p).
    """
    nothing, shown, components = np.zeros(1, np.int8), boundary.shown(kind), boundary.components(kind)
    points = point[[components.index(i) for i in shown]][None]
    ends = (EndReason.STEP_TOO_SMALL,) * 2
    return BoundaryCurve(kind, points, np.zeros((1, 5)), np.zeros(1), nothing, nothing, ends, (), shown)


def assembled(boundary: BoundaryProblem, kind: Event, chain: Chain) -> BoundaryCurve:
    """One curve of the stretches of a chain, with its special points named.

    Parameters
    ----------
    boundary : BoundaryProblem
    kind : Event
    chain : Chain
    """
    shown, stretches, ends = boundary.shown(kind), chain.stretches, chain.ends
    columns, travelled = list(shown), 0.0
    points, slopes, lengths, special, stable = [], [], [], [], []
    for stretch in stretches:
        curve, problem = stretch.curve, stretch.problem
        codes = named_points(boundary, kind, stretch)
        points.append(curve.points[:, columns])
        slopes.append((curve.tangents * problem.scale)[:, columns])
        lengths.append(travelled + curve.arclength)
        travelled = lengths[-1][-1]
        special.append(codes)
        signs = 0.0 if kind is Event.FOLD else boundary.static_determinants(problem, curve.points)
        stable.append((signs > 0.0) & ~np.isin(codes, (SpecialPoint.FOLD_GRAZING, SpecialPoint.FOLD_CROSSING)))
    # The last stretch of a closed curve is followed by its first one.
    for number in range(0 if chain.closed and len(stretches) > 1 else 1, len(stretches)):
        special[number - 1][-1], special[number][0] = joint(kind, stretches[number - 1], stretches[number])
    codes, points = np.concatenate(special), np.concatenate(points)
    for reason, index, y in zip(ends, (0, -1), chain.tips, strict=True):
        if reason is EndReason.RANGE_LEFT:
            codes[index] = end_of(boundary.plane, kind, y)
    return BoundaryCurve(
        kind,
        points,
        np.concatenate(slopes),
        np.concatenate(lengths),
        np.concatenate(stable).astype(np.int8),
        codes,
        ends,
        stretches,
        shown,
    )
