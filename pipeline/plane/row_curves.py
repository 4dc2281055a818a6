"""The branches of one row, at exactly the value that is asked for: stored, or solved where no row has the value."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.config.quantities import QUANTITIES
from pipeline.plan.numerics import System, balance_of, continuation_of, row_of, row_system, seeds_of, sweep_axis
from pipeline.plan.plan import Plan
from pipeline.plane.resonances import contact_modes
from pipeline.plane.segments import BranchSegment, segments_of_row
from pipeline.plane.stored import StoredPlane
from pipeline.store import COMPLETE, FAILED
from solver import EndReason, RowError
from solver.harmonic.quantities import balance_quantities
from solver.model.packing import dead_zone_ends
from solver.stability import assess, multipliers
from solver.stability.instability import LEFT_TO_FOLDS

__all__ = ["RowCurves", "curves_at", "solved_curves", "stored_row"]

# A value this close to a stored row's, as a share of the axis, is that row's.
_SAME = 1e-12


@dataclass(frozen=True, eq=False)
class RowCurves:
    """Branches of one row.

    Parameters
    ----------
    plan : Plan
    value : float
        Of the row parameter.
    status : int
        Whether the row is complete, failed or not computed, as stored; solved here it is one of the first two.
    points : dict of str to (point,) array
        position, mean, cos, sin, amplitude, stable, impact, branch, event; `motion` (point, n).
    ends : tuple of (int, int, EndReason)
        Branch, 0 or -1 (its first or its last point), and why it ends there.
    """

    plan: Plan
    value: float
    status: int
    points: dict[str, np.ndarray]
    ends: tuple[tuple[int, int, EndReason], ...]

    @cached_property
    def system(self) -> System:
        """The system of the row, to be varied along the swept parameter."""
        return row_system(self.plan, self.value)

    @property
    def modes(self) -> tuple[float, ...]:
        """Linear natural frequencies in contact, ascending."""
        return tuple(natural for natural, _ in contact_modes(self.system))

    @cached_property
    def segments(self) -> list[BranchSegment]:
        """The branches cut at their events."""
        return segments_of_row(self.points, *dead_zone_ends(self.system, self._axis, self.points["position"]))

    @cached_property
    def _quantities(self) -> np.ndarray:
        """What is read of the motions at the points, (point, 13)."""
        place = self.points["position"], self.points["motion"]
        return balance_quantities(balance_of(self.plan.solver), self.system, self._axis, *place, omega=self._omega)

    def values(self, name: str) -> np.ndarray:
        """One of `pipeline.config.quantities.QUANTITIES` at the points, (point,)."""
        slot = QUANTITIES[name].slot
        return self.points[name] if name in self.points else self._quantities[:, slot]

    @cached_property
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers at the points, (point, m) complex."""
        place = self.points["position"], self.points["motion"]
        period = balance_of(self.plan.solver).period
        return multipliers(self.system, self._axis, *place, omega=self._omega, period=period)

    @property
    def _axis(self) -> str:
        """The swept parameter as the solver calls it."""
        return sweep_axis(self.plan)

    @property
    def _omega(self) -> float | None:
        """The frequency, where it is not swept."""
        return self.plan.frequency(self.value)

    @cached_property
    def lasting(self) -> np.ndarray:
        """Whether the motions of a segment are dynamically stable, (segment,) bool: from one in its middle.

        A multiplier beyond +1 is left to static stability, as in labels.
        """
        inner = np.array([(segment.start + segment.stop - 1) // 2 for segment in self.segments], dtype=int)
        stable = np.array([segment.stable for segment in self.segments], dtype=bool)
        if not np.any(stable):
            return stable
        left, right = inner[stable], np.array([segment.stop for segment in self.segments])[stable] - 1
        # Two events may be neighbours: their middle is taken.
        right = np.where(left + 1 < right, left, np.minimum(left + 1, right))
        position, motion = (
            0.5 * (array[left] + array[right]) for array in (self.points["position"], self.points["motion"])
        )
        balance, omega = balance_of(self.plan.solver), self._omega
        kind = assess(
            self.system, self._axis, position, motion, omega=omega, balance=balance, static=np.ones(left.size)
        ).kind
        found = stable.copy()
        found[stable] = np.isin(kind, LEFT_TO_FOLDS)
        return found


def curves_at(plane: StoredPlane, value: float) -> RowCurves:
    """The branches at a value of the row parameter: stored where a row has it, else solved; FAILED where they cannot
    be."""
    axis = plane.plan.parameter
    row = int(np.argmin(np.abs(plane.rows - value)))
    if abs(plane.rows[row] - value) <= _SAME * (axis.high - axis.low):
        return stored_row(plane, row)
    try:
        return solved_curves(plane.plan, value)
    except (RowError, ArithmeticError):
        return RowCurves(plane.plan, value, FAILED, _no_points(plane.plan), ())


def stored_row(plane: StoredPlane, row: int) -> RowCurves:
    """The branches of a stored row, by number."""
    count = int(plane.n_points[row])
    points = plane.row_points(row)
    if plane.plan.motion_size:
        points["motion"] = plane.array("branches/motion")[row, :count]
    else:
        points["motion"] = np.column_stack([points[name] for name in ("mean", "cos", "sin")])
    places = np.argwhere(plane.end_reason[row] > 0)
    ends = tuple((int(branch), -int(end), EndReason(int(plane.end_reason[row, branch, end]))) for branch, end in places)
    return RowCurves(plane.plan, float(plane.rows[row]), int(plane.status[row]), points, ends)


def solved_curves(plan: Plan, value: float) -> RowCurves:
    """The branches at a value of the row parameter, computed anew.

    Raises
    ------
    RowError, ArithmeticError
        If a branch cannot be followed.
    """
    row = row_of(plan, value, balance_of(plan.solver), continuation_of(plan.solver), seeds_of(plan.solver))
    parts: dict[str, list[np.ndarray]] = {name: [empty] for name, empty in _no_points(plan).items()}
    ends = []
    for number, curve in enumerate(row.curves):
        mean, cos, sin = row.branch_motions(curve)
        found = (curve.points[:, -1], mean, cos, sin, np.hypot(cos, sin), curve.stable, row.branch_impact(curve))
        found = (*found, np.full(len(curve.points), number), curve.event, curve.points[:, :-1])
        for name, array in zip(parts, found, strict=True):
            parts[name].append(array)
        ends += [(number, 0, curve.ends[0]), (number, -1, curve.ends[1])]
    points = {name: np.concatenate(arrays) for name, arrays in parts.items()}
    return RowCurves(plan, value, COMPLETE, points, tuple(ends))


def _no_points(plan: Plan) -> dict[str, np.ndarray]:
    names = ("position", "mean", "cos", "sin", "amplitude", "stable", "impact", "branch", "event")
    return {**{name: np.empty(0) for name in names}, "motion": np.empty((0, balance_of(plan.solver).unknowns))}
