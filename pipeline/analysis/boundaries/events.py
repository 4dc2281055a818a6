"""The folds and grazings that the rows of a store have located: starts of boundaries, and which side is which."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.boundaries.contradictions import contradictory_cells
from pipeline.plan.numerics import balance_of, frame_of
from pipeline.plan.plan import Plan
from pipeline.plan.traits import dead_zone
from pipeline.plane.stored import StoredPlane
from solver import Event
from solver.boundaries import BIFURCATIONS, FOLDS_AND_GRAZINGS
from solver.kernels.threads import side_by_side
from solver.model.packing import GAP_AXES, dead_zone_ends
from solver.model.parameter_path import place_on

__all__ = ["MARGINS", "RowEvents", "dead_zone_at", "read_events"]

#: Grazing -> (sign of the amplitude, sign of the flank) in its margin lambda_m +- lambda_a -+ b.
MARGINS = {
    Event.MIN_AT_DRIVE: (-1.0, 1.0),
    Event.MIN_AT_BACK: (-1.0, -1.0),
    Event.MAX_AT_DRIVE: (1.0, 1.0),
    Event.MAX_AT_BACK: (1.0, -1.0),
}


@dataclass(frozen=True)
class RowEvents:
    """All events of the complete rows, in the order of rows and points.

    Parameters
    ----------
    kind : (k,) int array
        `Event`: folds and grazings.
    points : (k, 5) array
        lambda_m, lambda_c, lambda_s, x, p.
    motions : (k, n) array
        All unknowns of the balance there.
    ahead : (k,) array
        In which direction of x, +1 or -1, a fold's pair of solutions exists, and the margin of a grazing is positive
        where the grazing solution is stable (negative where it is not); 0 where that cannot be told, and for events
        that change neither number nor impact state.
    contradictory : (c, n + 2) array
        `contradictory_cells`.
    rows : int
        Number of complete rows.
    """

    kind: np.ndarray
    points: np.ndarray
    motions: np.ndarray
    ahead: np.ndarray
    contradictory: np.ndarray
    rows: int

    @property
    def digest(self) -> str:
        """Digest of what boundaries depend on besides the configuration."""
        parts = (np.int64(self.rows), self.kind.astype(np.int8), self.points, self.motions, self.ahead.astype(np.int8))
        parts = (*parts, self.contradictory)
        return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()[:16]

    def starts(self, kinds=FOLDS_AND_GRAZINGS) -> list[tuple[Event, np.ndarray]]:
        """(kind, (unknowns, x, p)) of the events of some kinds, as the solver starts boundaries from them."""
        points = np.column_stack([self.motions, self.points[:, 3:]])
        return [(Event(kind), y) for kind, y in zip(self.kind.tolist(), points, strict=True) if kind in kinds]


def dead_zone_at(plan: Plan, x, p) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the gap, low and high, at places of the plane, arrays of one shape."""
    system, x_axis, axis, _, _ = frame_of(plan)
    if isinstance(axis, str) and axis not in GAP_AXES:
        return dead_zone_ends(system, x_axis, np.asarray(x, dtype=float))
    rows, place = np.unique(p, return_inverse=True)
    if isinstance(axis, str):
        ends = dead_zone_ends(system, axis, rows)
    else:
        zones = [dead_zone(place_on(axis, row, system)[0]) for row in rows]
        ends = np.array(zones).reshape(-1, 2).T
    low, high = (end[place].reshape(np.shape(p)) for end in ends)
    return low, high


def read_events(path: Path, plan: Plan, layer: int | None = None) -> RowEvents:
    """Read the events of the complete rows of a store, or of one layer of a volume."""
    plane = StoredPlane(path, plan)
    plane = plane if layer is None else plane.layer_at(layer)
    # Part by part, so that memory does not depend on the number of rows.
    parts = list(side_by_side(lambda block: _events_of(plane.part(block)), plane.plan.parts))
    arrays = ("kind", "points", "motions", "ahead", "contradictory")
    return RowEvents(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in arrays), sum(part.rows for part in parts)
    )


def _events_of(part: StoredPlane) -> RowEvents:
    """The events of some rows."""
    plan, complete, values = part.plan, part.complete, part.rows
    names = ("mean", "cos", "sin", plan.sweep.name, "stable", "branch", "event")
    table = {name: part.along(name) for name in names}
    row, point = np.nonzero(np.isin(table["event"], (*FOLDS_AND_GRAZINGS, *BIFURCATIONS)) & complete[:, None])
    kind = table["event"][row, point].astype(np.int64)
    columns = [table[name][row, point] for name in names[:4]]
    points = np.column_stack([*columns, values[row]]).reshape(-1, 5)
    balance = balance_of(plan.solver)
    if plan.motion_size:
        motions = part.along("motion")
    else:
        motions = np.stack([table[name] for name in ("mean", "cos", "sin")], axis=2)
    lowest, highest = balance.extremes(motions)
    x, p = table[plan.sweep.name], np.broadcast_to(values[:, None], table["mean"].shape)
    back, front = dead_zone_at(plan, x, p)
    # Of the two neighbours on the branch the one that tells more decides.
    ahead, telling = np.zeros(row.size), np.zeros(row.size)
    for step in (-1, 1):
        other = np.clip(point + step, 0, max(x.shape[1] - 1, 0))
        same = (other != point) & (table["branch"][row, other] == table["branch"][row, point])
        move = x[row, other] - points[:, 3]
        weight = np.abs(move)
        side = np.sign(move)
        for grazing, (of_size, of_b) in MARGINS.items():
            here = kind == grazing
            margin = ((lowest if of_size < 0.0 else highest) - (back if of_b < 0.0 else front))[row[here], other[here]]
            weight[here] = np.abs(margin)
            side[here] *= np.sign(margin) * np.where(table["stable"][row[here], point[here]] == 1, 1.0, -1.0)
        better = same & (weight > telling)
        ahead[better], telling[better] = side[better], weight[better]
    ahead[np.isin(kind, BIFURCATIONS)] = 0.0
    return RowEvents(kind, points, motions[row, point], ahead, contradictory_cells(part), int(complete.sum()))
