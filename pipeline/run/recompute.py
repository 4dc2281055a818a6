"""Stored rows against the same rows computed anew: whether numbers are right, not only whether bytes are as written."""

from dataclasses import dataclass

import numpy as np

from pipeline import store
from pipeline.config.places import Place
from pipeline.plan.numerics import balance_of, continuation_of, seeds_of
from pipeline.plan.plan import Block, Plan
from pipeline.run.rows import stored_row

__all__ = ["Difference", "compare_row", "drawn_rows"]


@dataclass(frozen=True)
class Difference:
    """One array in which a stored row differs from the computed one; `most` is by how much at most, where it has
    numbers that are finite in both."""

    array: str
    entries: int
    most: float

    @property
    def sentence(self) -> str:
        """For the terminal."""
        return f"{self.array} ({self.entries} entries, by up to {self.most:.3g})"


def drawn_rows(path: Place, plan: Plan, count: int, seed: int) -> list[int]:
    """Complete rows of a store, drawn at random without repetition: the same ones for the same seed.

    Parameters
    ----------
    path : Place
    plan : Plan
        Of the store.
    count : int
        All complete rows where there are fewer.
    seed : int
    """
    complete = np.flatnonzero(store.statuses(path) == store.COMPLETE)
    drawn = np.random.default_rng(seed).permutation(complete)[:count]
    return sorted(drawn.tolist())


def compare_row(path: str, plan: Plan, row: int) -> list[Difference]:
    """Compute a row and compare it, bit by bit, with what is stored; what a worker does.

    Raises
    ------
    DamagedError
        If anything that is stored of the row is missing or damaged.
    RowError
        If the row cannot be computed here.
    """
    stored = store.read_rows(path, plan, Block(row, row + 1))
    settings = plan.solver
    found = stored_row(*plan.row(row), balance_of(settings), continuation_of(settings), seeds_of(settings))
    computed = store.row_values(plan, found)
    pairs = ((name, values[0, ...], computed[name]) for name, values in stored.items())
    return [difference for pair in pairs if (difference := _difference(*pair)) is not None]


def _difference(name: str, stored: np.ndarray, computed: np.ndarray) -> Difference | None:
    if stored.dtype == object:
        return None if stored.tolist() == computed.tolist() else Difference(name, 1, np.nan)
    bits = [np.ascontiguousarray(values).reshape(-1).view(np.uint8) for values in (stored, computed)]
    differing = np.any((bits[0] != bits[1]).reshape(stored.size, -1), axis=1)
    if not differing.any():
        return None
    with np.errstate(invalid="ignore"):
        gaps = np.abs(stored.reshape(-1)[differing].astype(float) - computed.reshape(-1)[differing].astype(float))
    return Difference(name, int(differing.sum()), float(np.max(gaps[np.isfinite(gaps)], initial=0.0)))
