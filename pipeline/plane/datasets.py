"""Motions and branches as xarray has them: every variable with its name and its unit, dimensionless or physical."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from pipeline.config.quantities import QUANTITIES
from pipeline.plan.plan import Plan
from pipeline.plane.row_curves import RowCurves
from pipeline.store.arrays import arrays_of
from pipeline.store.attributes import axis_attributes
from solver import Scale, Scales

__all__ = ["dataset_of_branches", "dataset_of_motions"]

_BRANCH = ("cos", "sin", "stable", "impact", "branch", "event")


def dataset_of_motions(
    plan: Plan, values: Mapping[str, np.ndarray], place: Mapping[str, float], scales: Scales | None
) -> xr.Dataset:
    """Motions at one place.

    Parameters
    ----------
    plan : Plan
    values : mapping
        Name, as in a store -> (S,) array.
    place : mapping
        Name of an axis -> value.
    scales : Scales or None
        Turns everything that has a unit into physical values; None leaves it dimensionless.
    """
    told = arrays_of(plan)
    variables = {name: ("solution", *_shown(name, array, told, scales)) for name, array in values.items()}
    return xr.Dataset(variables, {name: ((), *_shown_axis(name, value, plan, scales)) for name, value in place.items()})


def dataset_of_branches(row: RowCurves, scales: Scales | None) -> xr.Dataset:
    """The branches of a row one after the other, along `point`; `scales` as above."""
    sweep, parameter, told = row.plan.sweep.name, row.plan.parameter.name, arrays_of(row.plan)
    told |= {name: told[f"branches/{name}"] for name in _BRANCH}
    # Those of no point are floats.
    kinds = {name: told[name]["dtype"] for name in _BRANCH}
    values = {name: row.values(name) for name in QUANTITIES}
    values |= {name: row.points[name].astype(kind) for name, kind in kinds.items()}
    return xr.Dataset(
        {name: ("point", *_shown(name, array, told, scales)) for name, array in values.items()},
        {
            sweep: ("point", *_shown_axis(sweep, row.points["position"], row.plan, scales)),
            parameter: ((), *_shown_axis(parameter, row.value, row.plan, scales)),
        },
    )


def _shown(name: str, values, told: dict, scales: Scales | None) -> tuple:
    """Values and attributes of a variable."""
    wanted = QUANTITIES[name].scale if name in QUANTITIES else "length" if name in ("cos", "sin") else None
    return _scaled(values, told[name]["attributes"], None if scales is None or wanted is None else scales[wanted])


def _shown_axis(name: str, values, plan: Plan, scales: Scales | None) -> tuple:
    """The same of an axis, which has another name where its physical value is another quantity."""
    if scales is None or name not in scales:
        return values, axis_attributes(name, plan.kind)
    return _scaled(values, {"long_name": scales[name].name}, scales[name])


def _scaled(values, attributes: dict, scale: Scale | None) -> tuple:
    return (values, attributes) if scale is None else (values * scale.shown, {**attributes, "units": scale.unit})
