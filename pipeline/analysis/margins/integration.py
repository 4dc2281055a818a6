"""What direct integration found in the cells of a rectangle: read from the group `attractors` of the store."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from pipeline.config.places import Place
from pipeline.plan.plan import Plan
from pipeline.store.stored_arrays import open_group

__all__ = ["QUANTITIES", "Integrated", "Largest", "cells_in", "integrated"]

GROUP = "attractors"
#: Quantities of a motion whose largest value says something about a box: variable, name, unit.
QUANTITIES = (("force", "dynamic factor K_v", ""), ("rms", "RMS of λ", ""), ("contact_loss", "contact loss", "%"))


@dataclass(frozen=True)
class Largest:
    """The largest value of one quantity among all motions found in a rectangle, and where."""

    name: str
    unit: str
    value: float
    x: float
    p: float


@dataclass(frozen=True)
class Integrated:
    """What integration found in a rectangle.

    Parameters
    ----------
    cells : int
        Cells of the plane in it.
    motions : dict of str to int
        What was found together in a cell, such as "1T/0" or "1T/0 + 2T/1" -> in how many cells, the most frequent
        first. Cells that were not integrated are in none of them.
    bound : str
        What random starts cannot tell, in a sentence.
    largest : tuple of Largest
    """

    cells: int
    motions: dict[str, int]
    bound: str
    largest: tuple[Largest, ...]

    @property
    def looked_at(self) -> int:
        """Cells that were integrated."""
        return sum(self.motions.values())


def cells_in(axis, low: float, high: float) -> np.ndarray:
    """Numbers of the values of an axis in a closed range; the nearest one where the range is a single value."""
    if low == high:
        return np.array([np.argmin(np.abs(axis.values - low))])
    return np.flatnonzero((axis.values >= low) & (axis.values <= high))


def integrated(path: Place, plan: Plan, x: tuple[float, float], p: tuple[float, float]) -> Integrated | None:
    """Read what was found in a rectangle; of a single place in its nearest cell.

    Parameters
    ----------
    path : Place
    plan : Plan
        The store's own.
    x, p : (low, high)

    Returns
    -------
    Integrated or None
        None where the store has no attractors of its rows as they are.
    """
    group = open_group(path, GROUP)
    if group is None or group.attributes["configuration_hash"] != plan.fingerprint:
        return None
    axes = (plan.parameter, p), (plan.sweep, x)
    values = [group.read(axis.name) for axis, _ in axes]
    wanted = [axis.values[cells_in(axis, *ends)] for axis, ends in axes]
    rows, columns = (np.flatnonzero(np.isin(found, want)) for found, want in zip(values, wanted, strict=True))

    def part(name: str) -> np.ndarray:
        """The cells of the rectangle, (rows, columns, ...)."""
        if not (rows.size and columns.size):
            return group.read(name, slice(0), slice(0))
        whole = group.read(name, slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
        return whole[rows - rows[0]][:, columns - columns[0]]

    found = Counter(group.attributes_of("label")["labels"][code] for code in part("label").ravel().tolist())
    # Cells of which nothing is known.
    found.pop("", None)
    there, largest = part("kind") > 0, []
    for name, words, unit in QUANTITIES:
        sizes = np.where(there, part(name), np.nan)
        if np.any(np.isfinite(sizes)):
            row, column, _ = np.unravel_index(np.nanargmax(sizes), sizes.shape)
            where = float(values[1][columns[column]]), float(values[0][rows[row]])
            largest.append(Largest(words, unit, float(np.nanmax(sizes)), *where))
    cells = wanted[0].size * wanted[1].size
    return Integrated(cells, dict(found.most_common()), group.attributes["bound"], tuple(largest))
