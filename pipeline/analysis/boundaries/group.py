"""The group `boundaries` of a store: curves one after the other, CF's contiguous ragged arrays."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from pipeline import store
from pipeline.analysis.boundaries.arcs import Arcs, arcs_of
from pipeline.plan.plan import Plan
from pipeline.store import groups
from solver import EndReason, Event
from solver.boundaries import SpecialPoint

__all__ = [
    "COMPONENTS",
    "StoredBoundaries",
    "StoredCurve",
    "read_boundaries",
    "remove_boundaries",
    "special_places",
    "write_boundaries",
]

GROUP = "boundaries"
COMPONENTS = ("mean", "cos", "sin")


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
        """(k - 1,) bool: arcs on whose two sides the labels differ, which are folds and grazings of stable motions."""
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
    """All boundaries of a plane, and the digest of the events that they were started from."""

    curves: tuple[StoredCurve, ...]
    digest: str


def _arrays(plan: Plan) -> dict[str, tuple]:
    """name -> dim, dtype, attributes."""
    x, p = plan.sweep.name, plan.parameter.name
    quantities = {
        "mean": ("mean of the mesh displacement", "1"),
        "cos": ("cosine amplitude of the mesh displacement", "1"),
        "sin": ("sine amplitude of the mesh displacement", "1"),
        **{name: (text["long_name"], text["units"]) for name, text in ((a, store.axis_attributes(a)) for a in (x, p))},
        "amplitude": ("amplitude of the fundamental of the mesh displacement", "1"),
        "arclength": ("arc length along the boundary, in scaled unknowns", "1"),
    }
    curve, point = "curve", "boundary_point"

    def flags(members, long_name):
        return {"long_name": long_name, **store.flags(members)}

    return {
        "row_size": (curve, "int32", {"long_name": "number of points of the boundary", "sample_dimension": point}),
        "kind": (curve, "int8", flags(Event, "what happens along the boundary")),
        "closed": (
            curve,
            "int8",
            {
                "long_name": "1: the last point is the first one again",
                "flag_values": [0, 1],
                "flag_meanings": "open closed",
            },
        ),
        "side": (
            curve,
            "int8",
            {
                "long_name": "side, looking along the curve, on which a fold's pair of solutions exists and on which "
                "the margin of a stable grazing is positive",
                "flag_values": [-1, 0, 1],
                "flag_meanings": "right unknown left",
            },
        ),
        "end_reason": ((curve, "end"), "int8", flags(EndReason, "why the boundary ends")),
        **{name: (point, "float64", {"long_name": text, "units": units}) for name, (text, units) in quantities.items()},
        **{
            f"{name}_slope": (
                point,
                "float64",
                {"long_name": f"derivative by arc length of the {quantities[name][0]}", "units": quantities[name][1]},
            )
            for name in (*COMPONENTS, x, p)
        },
        "stable": (
            point,
            "int8",
            {
                "long_name": "1: the grazing motion is statically stable; 0 along folds",
                "flag_values": [0, 1],
                "flag_meanings": "unstable stable",
            },
        ),
        "special": (point, "int8", flags(SpecialPoint, "what is special about the point")),
    }


def write_boundaries(path: Path, plan: Plan, boundaries: StoredBoundaries) -> None:
    """Put the boundaries of a plane into its store, in place of what was there."""
    curves, names = boundaries.curves, (*COMPONENTS, plan.sweep.name, plan.parameter.name)
    points = np.concatenate([np.empty((0, 5)), *(curve.points for curve in curves)])
    slopes = np.concatenate([np.empty((0, 5)), *(curve.slopes for curve in curves)])

    def along(name):
        return np.concatenate([np.empty(0), *(getattr(curve, name) for curve in curves)])

    values = {
        "row_size": [len(curve.points) for curve in curves],
        "kind": [curve.kind for curve in curves],
        "closed": [curve.closed for curve in curves],
        "side": [curve.side for curve in curves],
        "end_reason": np.array([curve.ends for curve in curves]).reshape(-1, 2),
        **dict(zip(names, points.T, strict=True)),
        **{f"{name}_slope": column for name, column in zip(names, slopes.T, strict=True)},
        **{name: along(name) for name in ("amplitude", "arclength", "stable", "special")},
    }
    # Places are coordinates; as plain variables they would be hidden by the plane's axes of the same names.
    attributes = {
        "coordinates": f"{plan.sweep.name} {plan.parameter.name}",
        "configuration_hash": plan.digest,
        "events_hash": boundaries.digest,
    }
    variables = {
        name: groups.Variable(dims, kind, values[name], described)
        for name, (dims, kind, described) in _arrays(plan).items()
    }
    groups.write_group(path, GROUP, attributes, variables)


def remove_boundaries(path: Path) -> None:
    """Take the group away, if there is one or the metadata still lists one that a killed run has taken away."""
    groups.remove_group(path, GROUP)


def read_boundaries(path: Path, plan: Plan) -> StoredBoundaries | None:
    """The boundaries of a stored plane; None if they have not been traced since its rows were computed."""
    group = groups.open_group(path, GROUP)
    if group is None or group.attrs["configuration_hash"] != plan.digest:
        return None
    values = {name: group[name][...] for name in _arrays(plan)}
    names = (*COMPONENTS, plan.sweep.name, plan.parameter.name)
    points = np.column_stack([values[name] for name in names])
    slopes = np.column_stack([values[f"{name}_slope"] for name in names])
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
                *(values[name][here] for name in ("arclength", "stable", "special")),
            )
        )
    return StoredBoundaries(tuple(curves), group.attrs["events_hash"])
