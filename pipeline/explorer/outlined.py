"""Cells of a lattice as few polygons."""

import numpy as np

__all__ = ["cell_polygons"]


def cell_polygons(marked: np.ndarray, x: np.ndarray, y: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, ...]:
    """Rectangles that cover the marked cells without overlap: runs along a row, as high as they stay the same.

    Parameters
    ----------
    marked : (P, X) bool array
    x, y : (X + 1,), (P + 1,) arrays
        Borders of the cells.
    size : (2,) array
        What corners are multiplied with.

    Returns
    -------
    tuple of (4, 2) arrays

    Examples
    --------
    >>> found = cell_polygons(np.array([[1, 1], [1, 1], [0, 1]]) > 0, np.arange(3.0), np.arange(4.0), np.ones(2))
    >>> [polygon[[0, 2]].tolist() for polygon in found]
    [[[0.0, 0.0], [2.0, 2.0]], [[1.0, 2.0], [2.0, 3.0]]]
    """
    found, growing = [], {}
    for row in range(len(marked) + 1):
        change = np.diff(marked[row].astype(np.int8), prepend=0, append=0) if row < len(marked) else np.zeros(1)
        runs = set(zip(np.flatnonzero(change == 1).tolist(), np.flatnonzero(change == -1).tolist(), strict=True))
        for run in [run for run in growing if run not in runs]:
            found.append((growing.pop(run), row, *run))
        growing |= {run: row for run in runs if run not in growing}
    return tuple(
        np.array([(x[a], y[low]), (x[b], y[low]), (x[b], y[high]), (x[a], y[high])]) * size
        for low, high, a, b in sorted(found)
    )
