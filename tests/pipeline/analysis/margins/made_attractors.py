"""A group `attractors` made up by hand: what integration would have found."""

import numpy as np
import xarray as xr

from pipeline.store import groups

__all__ = ["BOUND", "KINDS", "LOUD", "QUIET", "put_attractors"]

KINDS = ["none", *(f"{n}T" for n in range(1, 9)), "quasi_periodic", "chaotic", "unbounded", "unsettled"]
QUIET = {"kind": 1, "impact": 0, "force": 1.2, "rms": 0.1, "contact_loss": 0.0}
LOUD = {"kind": 2, "impact": 1, "force": 2.5, "rms": 0.4, "contact_loss": 0.25}
BOUND = "With 4 random starts nothing is certain."


def put_attractors(path, plan, cells, rows=None, columns=None, digest=None):
    """A group `attractors` of some rows and columns with one quiet motion a cell, but for `cells`."""
    rows = np.arange(plan.parameter.num) if rows is None else rows
    columns = np.arange(plan.sweep.num) if columns is None else columns
    shape = rows.size, columns.size, 2
    values = {name: np.zeros(shape, np.int8 if name in ("kind", "impact") else float) for name in QUIET}
    labels, codes = ["", "1T/0"], np.ones(shape[:2], np.int16)
    for name, value in QUIET.items():
        values[name][..., 0] = value
    for (row, column), motions in cells.items():
        texts = [KINDS[one["kind"]] + (f"/{one['impact']}" if one["impact"] >= 0 else "") for one in motions]
        labels.append(" + ".join(texts))
        codes[row, column] = len(labels) - 1
        for number, motion in enumerate(motions):
            for name, value in motion.items():
                values[name][row, column, number] = value
    places = (plan.parameter.name, plan.sweep.name, "attractor")
    variables = {name: (places, value) for name, value in values.items()}
    variables["label"] = (places[:2], codes, {"labels": labels})
    axes = {
        plan.parameter.name: (plan.parameter.name, plan.parameter.values[rows]),
        plan.sweep.name: (plan.sweep.name, plan.sweep.values[columns]),
    }
    attributes = {"configuration_hash": digest or plan.fingerprint, "bound": BOUND}
    groups.write_group(path, "attractors", xr.Dataset(variables, axes, attributes))
