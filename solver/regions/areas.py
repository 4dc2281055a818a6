"""Areas between neighbouring arcs: Gauss-Legendre quadrature over slabs, without the square roots of turning points."""

from collections.abc import Sequence

import numpy as np

from solver.regions.slabs import RegionError, RowCrossings, Slab

__all__ = ["slab_areas"]

# Fewer nodes measure the error of more.
_FEW, _MANY = (np.polynomial.legendre.leggauss(n) for n in (8, 16))
_DEEPEST = 40


def _nodes(rule) -> tuple[np.ndarray, np.ndarray]:
    """Fractions of the height and weights.

    With p = low + height sin^2(pi u/2) a width that varies with the root of the distance from a turning point is smooth
    in u, and so is the power 3/2 at cusps.
    """
    u, weights = 0.5 * (rule[0] + 1.0), 0.5 * rule[1]
    return np.sin(0.5 * np.pi * u) ** 2, weights * 0.5 * np.pi * np.sin(np.pi * u)


_RULES = [_nodes(rule) for rule in (_FEW, _MANY)]
_FRACTIONS = np.concatenate([fractions for fractions, _ in _RULES])
_SORTED = np.argsort(_FRACTIONS)
_WEIGHTS = np.zeros((2, _FRACTIONS.size))
_WEIGHTS[0, : _FEW[0].size], _WEIGHTS[1, _FEW[0].size :] = _RULES[0][1], _RULES[1][1]
_WEIGHTS = _WEIGHTS[:, _SORTED]
_FRACTIONS = _FRACTIONS[_SORTED]


def slab_areas(
    crossings: RowCrossings, slabs: Sequence[Slab], tolerance: float, window: tuple[float, float] | None = None
) -> tuple[list[np.ndarray], float, list[float]]:
    """Area between neighbouring arcs of every slab.

    Parameters
    ----------
    crossings : RowCrossings
    slabs : sequence of Slab
        Ascending.
    tolerance : float
        Largest difference between two quadratures of one area, per share of the height.
    window : (low, high), optional
        Only the areas within this range of x.

    Returns
    -------
    areas : list of (arcs - 1,) arrays
    error : float
        Sum of the differences between the two quadratures.
    disorder : list of float
        Rows in which the arcs are not in the slab's order: some of them intersect inside.
    """
    areas = [np.zeros(len(slab.arcs) - 1) for slab in slabs]
    height = sum(slab.high - slab.low for slab in slabs)
    open_panels = [(number, slab.low, slab.high) for number, slab in enumerate(slabs)]
    total_error, disorder = 0.0, []
    for depth in range(_DEEPEST):
        if not open_panels:
            return areas, total_error, disorder
        rows = [low + (high - low) * _FRACTIONS for _, low, high in open_panels]
        table, start, divided = crossings.table(np.concatenate(rows)), 0, []
        for (number, low, high), values in zip(open_panels, rows, strict=True):
            widths = _widths(crossings, slabs[number], table[start : start + values.size], values, window)
            start += values.size
            few, many = (high - low) * (_WEIGHTS @ widths)
            error = np.abs(few - many)
            disorder.extend(values[np.min(widths, axis=1) < -1e-9 * np.ptp(crossings.x_range)])
            if np.max(error) > tolerance * (high - low) / height and depth < _DEEPEST - 1:
                middle = 0.5 * (low + high)
                divided += [(number, low, middle), (number, middle, high)]
            else:
                areas[number] += many
                total_error += float(np.sum(error))
        open_panels = divided
    return areas, total_error, disorder


def _widths(crossings: RowCrossings, slab: Slab, table, values: np.ndarray, window) -> np.ndarray:
    """Distances of neighbouring arcs (rows, arcs - 1) of one slab, within a range of x."""
    arcs, x = crossings.joined(table, values)
    x = x if window is None else np.clip(x, *window)
    column = {arc: k for k, arc in enumerate(arcs)}
    try:
        return np.diff(x[:, [column[arc] for arc in slab.arcs]], axis=1)
    except KeyError as error:
        raise RegionError(f"the boundary {error} does not cross the row at {values[0]!r}") from None
