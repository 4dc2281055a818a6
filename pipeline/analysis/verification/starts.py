"""The map's stable solutions at chosen cells, as starts of integrations."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import zarr

from pipeline.plan.plan import Plan
from pipeline.store import COMPLETE

__all__ = ["Start", "read_labels", "read_starts"]


@dataclass(frozen=True)
class Start:
    """One stable solution of the map.

    Parameters
    ----------
    row, column, solution : int
        Its place in the store.
    mean, amplitude : float
    impact : int
        `ImpactState`.
    coefficients : tuple of float
        Lambda_0, c_1, s_1, ... as `solver.timedomain.orbit_state` takes them.
    """

    row: int
    column: int
    solution: int
    mean: float
    amplitude: float
    impact: int
    coefficients: tuple[float, ...]


def read_labels(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Labels (P, X), 0 in rows that are not complete, and where there are stable solutions to start from."""
    root = zarr.open_group(path, mode="r")
    domain = np.where((root["status"][:] == COMPLETE)[:, None], root["domain"][:], 0).astype(np.uint16)
    return domain, (domain != 0) & (root["n_stable"][:] > 0)


def read_starts(path: Path, plan: Plan, row: np.ndarray, column: np.ndarray) -> list[Start]:
    """All stable solutions at these cells, in the order of the cells and of the store."""
    root = zarr.open_group(path, mode="r")
    lifted = plan.solver["balance"] == "galerkin"
    names = ("mean", "amplitude", "phase", "stable", "impact", *(("motion",) if lifted else ()))
    rows, place = np.unique(row, return_inverse=True)
    # Only what is asked for: the whole of a large plane may not fit into memory.
    values = {name: root[name].oindex[rows][place, column] if rows.size else np.empty((0, 1)) for name in names}
    starts = []
    for cell, solution in np.argwhere(values["stable"] == 1).tolist():
        mean, amplitude, phase = (float(values[name][cell, solution]) for name in names[:3])
        if lifted:
            coefficients = tuple(values["motion"][cell, solution].tolist())
        else:
            # Lambda_1 = amplitude exp(i phase) = c_1 - i s_1.
            coefficients = (mean, amplitude * float(np.cos(phase)), -amplitude * float(np.sin(phase)))
        impact = int(values["impact"][cell, solution])
        starts.append(Start(int(row[cell]), int(column[cell]), solution, mean, amplitude, impact, coefficients))
    return starts
