"""Cells of a lattice as few boxes."""

import numpy as np

__all__ = ["cell_boxes"]


def cell_boxes(marked: np.ndarray, x: np.ndarray, y: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Boxes that cover the marked cells without overlap: runs along a row, as high as they stay the same.

    Parameters
    ----------
    marked : (P, X) bool array
    x, y : (X + 1,), (P + 1,) arrays
        Borders of the cells.
    size : (2,) array
        What x and y are multiplied with.

    Returns
    -------
    (k, 4) array
        Left, right, bottom, top.

    Examples
    --------
    >>> cell_boxes(np.array([[1, 1], [1, 1], [0, 1]]) > 0, np.arange(3.0), np.arange(4.0), np.ones(2)).tolist()
    [[0.0, 2.0, 0.0, 2.0], [1.0, 2.0, 2.0, 3.0]]
    """
    found, growing = [], {}
    for row in range(len(marked) + 1):
        change = np.diff(marked[row].astype(np.int8), prepend=0, append=0) if row < len(marked) else np.zeros(1)
        runs = set(zip(np.flatnonzero(change == 1).tolist(), np.flatnonzero(change == -1).tolist(), strict=True))
        for run in [run for run in growing if run not in runs]:
            found.append((growing.pop(run), row, *run))
        growing |= {run: row for run in runs if run not in growing}
    low, high, left, right = np.array(sorted(found), dtype=int).reshape(-1, 4).T
    return np.column_stack([x[left] * size[0], x[right] * size[0], y[low] * size[1], y[high] * size[1]])
