"""Where labels change between neighbouring cells, as line segments along cell borders and as the curves they form."""

import numpy as np

__all__ = ["curves_along", "label_edges"]


def label_edges(code: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Borders between neighbouring cells with different labels.

    Parameters
    ----------
    code : (P, X) array
        Codes of the labels, 0 where not computed; such cells have no edges.
    n : (P, X) array
        Number of stable solutions.

    Returns
    -------
    fold, grazing : (k, 2, 2) int arrays
        One segment per border: its two corners as (row, column) of the lattice of (P + 1) x (X + 1) corners. Where n
        differs a fold lies between the cells, where only the impact states differ a grazing.
    """
    parts = {True: [], False: []}
    for axis in (0, 1):
        one, other = np.delete(code, -1, axis), np.delete(code, 0, axis)
        changed = (one != other) & (one != 0) & (other != 0)
        folded = np.delete(n, -1, axis) != np.delete(n, 0, axis)
        for kind in (True, False):
            corner = np.argwhere(changed & (folded == kind))
            corner[:, axis] += 1
            along = np.array([axis, 1 - axis])
            parts[kind].append(np.stack([corner, corner + along], axis=1))
    return np.concatenate(parts[True]), np.concatenate(parts[False])


def curves_along(segments: np.ndarray) -> list[np.ndarray]:
    """Join segments that meet end to end, so that dashes run on and straight stretches are one line.

    Parameters
    ----------
    segments : (k, 2, 2) int array
        As `label_edges` gives them.

    Returns
    -------
    list of (m, 2) int arrays
        Corners in order, without those on straight stretches; together they cover every segment once.
    """
    ends = [(tuple(first), tuple(second)) for first, second in segments.tolist()]
    meeting: dict[tuple[int, int], list[int]] = {}
    for number, pair in enumerate(ends):
        for corner in pair:
            meeting.setdefault(corner, []).append(number)
    free = [True] * len(ends)

    def follow(corner, number):
        path = [corner]
        while True:
            free[number] = False
            first, second = ends[number]
            corner = second if corner == first else first
            path.append(corner)
            onward = [other for other in meeting[corner] if free[other]]
            if len(meeting[corner]) != 2 or not onward:
                return path
            number = onward[0]

    # Open curves start where they end or meet others; what is left afterwards are closed ones.
    starts = [corner for corner, numbers in meeting.items() if len(numbers) != 2]
    curves = [follow(corner, number) for corner in starts for number in meeting[corner] if free[number]]
    curves += [follow(ends[number][0], number) for number in range(len(ends)) if free[number]]
    return [_without_straight(np.array(curve)) for curve in curves]


def _without_straight(curve: np.ndarray) -> np.ndarray:
    steps = np.diff(curve, axis=0)
    turns = np.any(steps[1:] != steps[:-1], axis=1)
    return curve[np.concatenate([[True], turns, [True]])]
