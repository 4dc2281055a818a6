"""The group `boundaries` of a store as it is written: curves one after the other, CF's contiguous ragged arrays."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeline import store
from pipeline.plan.plan import Plan
from pipeline.plane.boundaries import COMPONENTS, GROUP, StoredBoundaries
from pipeline.store import groups
from solver import EndReason, Event
from solver.boundaries import SpecialPoint

__all__ = ["write_boundaries"]


def _arrays(plan: Plan) -> dict[str, tuple]:
    """name -> dims, dtype, attributes."""
    x, p = plan.sweep.name, plan.parameter.name
    quantities = {
        "mean": ("mean of the mesh displacement", "1"),
        "cos": ("cosine amplitude of the mesh displacement", "1"),
        "sin": ("sine amplitude of the mesh displacement", "1"),
        **{name: (text["long_name"], text["units"]) for name, text in ((a, store.axis_attributes(a)) for a in (x, p))},
        "amplitude": ("amplitude of the fundamental of the mesh displacement", "1"),
        "arclength": ("arc length along the boundary, in scaled unknowns", "1"),
    }
    curve, point = ("curve",), ("boundary_point",)

    def flags(members, long_name):
        return {"long_name": long_name, **store.flags(members)}

    of_volume = {"long_name": f"number of the layer along {plan.parameter2.name}"} if plan.parameter2 else {}
    return {
        **({"layer": (curve, "int32", of_volume)} if of_volume else {}),
        "row_size": (curve, "int32", {"long_name": "number of points of the boundary", "sample_dimension": point[0]}),
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
        "end_reason": ((*curve, "end"), "int8", flags(EndReason, "why the boundary ends")),
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


def write_boundaries(path: Path, plan: Plan, boundaries: StoredBoundaries | Sequence[StoredBoundaries | None]) -> None:
    """Put the boundaries of a plane into its store, in place of what was there.

    Parameters
    ----------
    path : Path
    plan : Plan
        Of the store.
    boundaries : StoredBoundaries or sequence of StoredBoundaries or None
        Of a volume those of every layer, None where they have not been traced.
    """
    volume = plan.parameter2 is not None
    layers = list(boundaries) if volume else [boundaries]
    digests = ["" if one is None else one.digest for one in layers]
    numbered = [(number, curve) for number, one in enumerate(layers) if one is not None for curve in one.curves]
    curves, names = [curve for _, curve in numbered], (*COMPONENTS, plan.sweep.name, plan.parameter.name)
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
    if volume:
        values["layer"] = [number for number, _ in numbered]
    variables = {
        name: groups.Variable(dims, np.asarray(values[name], kind), described)
        for name, (dims, kind, described) in _arrays(plan).items()
    }
    # Places are coordinates; as plain variables they would be hidden by the plane's axes of the same names.
    places = (plan.sweep.name, plan.parameter.name)
    attributes = {"configuration_hash": plan.fingerprint, "events_hash": digests if volume else digests[0]}
    groups.write_group(path, GROUP, groups.Arrays(variables, places, attributes))
