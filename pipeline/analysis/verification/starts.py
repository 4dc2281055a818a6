"""The map's stable solutions at chosen cells, as starts of integrations."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane

__all__ = ["Start", "read_starts"]


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


def read_starts(path: Path, plan: Plan, row: np.ndarray, column: np.ndarray) -> list[Start]:
    """All stable solutions at these cells, in the order of the cells and of the store; rows ascend."""
    starts = []
    for part in StoredPlane(path, plan).parts:
        here = slice(*np.searchsorted(row, (part.block.start, part.block.stop)))
        if here.start < here.stop:
            starts += _starts_in(part, row[here], column[here])
    return starts


def _starts_in(part: StoredPlane, row: np.ndarray, column: np.ndarray) -> list[Start]:
    cells = row - part.block.start, column
    mean, amplitude, phase, impact = (array[cells] for array in (part.mean, part.amplitude, part.phase, part.impact))
    # Lambda_1 = amplitude exp(i phase) = c_1 - i s_1.
    motion = np.stack([mean, amplitude * np.cos(phase), -amplitude * np.sin(phase)], axis=-1)
    if part.plan.motion_size:
        motion = part.motion[cells]
    return [
        Start(
            int(row[cell]),
            int(column[cell]),
            solution,
            float(mean[cell, solution]),
            float(amplitude[cell, solution]),
            int(impact[cell, solution]),
            tuple(motion[cell, solution].tolist()),
        )
        for cell, solution in np.argwhere(part.stable[cells] == 1).tolist()
    ]
