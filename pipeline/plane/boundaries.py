"""The boundaries of a stored plane, as the group `boundaries` keeps them: curves one after the other."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.config.places import Place
from pipeline.plan.plan import Plan
from pipeline.plane.arcs import Arcs, arcs_of
from pipeline.store.stored_arrays import open_group
from solver import EndReason, Event
from solver.boundaries import SpecialPoint

__all__ = ["COMPONENTS", "GROUP", "StoredBoundaries", "StoredCurve", "read_boundaries", "special_places"]

GROUP = "boundaries"
COMPONENTS = ("mean", "cos", "sin")
_OF_CURVES, _OF_POINTS = ("row_size", "kind", "side", "end_reason"), ("arclength", "stable", "special")


@dataclass(frozen=True)
class StoredCurve:
    """One boundary as stored; k points in order of arc length, doubled at corners.

    Parameters
    ----------
    kind : Event
    ends : tuple of EndReason
    side : int
        On which side of the curve, looking along it in the (x, p) plane, a fold's pair of solutions exists and the
        margin of a stable grazing is positive: 1 left, -1 right, 0 unknown.
    points, slopes : (k, 5) arrays
        lambda_m, lambda_c, lambda_s, x, p and their derivatives by arc length.
    arclength : (k,) array
    stable, special : (k,) int8 arrays
    """

    kind: Event
    ends: tuple[EndReason, EndReason]
    side: int
    points: np.ndarray
    slopes: np.ndarray
    arclength: np.ndarray
    stable: np.ndarray
    special: np.ndarray

    @property
    def closed(self) -> bool:
        """Whether the last point is the first one again."""
        return self.ends[1] is EndReason.CLOSED

    @property
    def amplitude(self) -> np.ndarray:
        """lambda_a, (k,)."""
        return np.hypot(self.points[:, 1], self.points[:, 2])

    @cached_property
    def arcs(self) -> Arcs:
        """The curve between its points."""
        return arcs_of(self.points, self.slopes, self.arclength)

    @property
    def arc_shows(self) -> np.ndarray:
        """(k - 1,) bool: arcs on whose two sides something differs: folds, and what happens to stable motions."""
        if self.kind is Event.FOLD:
            return np.ones(max(len(self.points) - 1, 0), dtype=bool)
        # Where stability changes, at a fold, there is a point, and it counts as unstable.
        return (self.stable[:-1] == 1) | (self.stable[1:] == 1)


def special_places(curve: StoredCurve) -> np.ndarray:
    """Indices of the points of codimension two and the extrema: each once, fold-grazings on the fold curve only."""
    skipped = [SpecialPoint.NONE, SpecialPoint.BORDER]
    if curve.kind is not Event.FOLD:
        skipped.append(SpecialPoint.FOLD_GRAZING)
    return np.flatnonzero(~np.isin(curve.special, skipped))


@dataclass(frozen=True)
class StoredBoundaries:
    """All boundaries of a plane, or of a volume's layer, and the digest of the events that they were started from."""

    curves: tuple[StoredCurve, ...]
    digest: str


def read_boundaries(path: Place, plan: Plan, layer: int | None = None) -> StoredBoundaries | None:
    """The boundaries of a stored plane; None if they have not been traced since its rows were computed.

    Parameters
    ----------
    path : Place
    plan : Plan
        Of the store.
    layer : int, optional
        Of a volume, which has boundaries layer by layer.
    """
    group = open_group(path, GROUP)
    if group is None or group.attributes["configuration_hash"] != plan.fingerprint:
        return None
    digest, here, inside = group.attributes["events_hash"], slice(None), slice(None)
    if plan.parameter2 is not None:
        if layer is None or not (digest := digest[layer]):
            return None
        # Curves of a layer follow one another, and so do their points.
        here = slice(*np.searchsorted(group.read("layer"), [layer, layer + 1]).tolist())
        ends = np.cumsum([0, *group.read("row_size")])
        inside = slice(int(ends[here.start]), int(ends[here.stop]))
    names = (*COMPONENTS, plan.sweep.name, plan.parameter.name)
    slopes = tuple(f"{name}_slope" for name in names)
    values = {name: group.read(name, here) for name in _OF_CURVES}
    values |= {name: group.read(name, inside) for name in (*_OF_POINTS, *names, *slopes)}
    points = np.column_stack([values[name] for name in names])
    slopes = np.column_stack([values[name] for name in slopes])
    last = np.cumsum(values["row_size"])
    curves = []
    for number, size in enumerate(values["row_size"].tolist()):
        here = slice(int(last[number]) - size, int(last[number]))
        ends = tuple(EndReason(int(end)) for end in values["end_reason"][number])
        curves.append(
            StoredCurve(
                Event(int(values["kind"][number])),
                ends,
                int(values["side"][number]),
                points[here],
                slopes[here],
                *(values[name][here] for name in _OF_POINTS),
            )
        )
    return StoredBoundaries(tuple(curves), digest)
