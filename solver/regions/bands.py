"""Parts of a divided plane: rows with their labels from end to end, and bands of rows with the labels' shares."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.model.checks import ParameterError
from solver.regions.areas import slab_areas
from solver.regions.regions import Regions
from solver.regions.slabs import RegionError, RowCrossings, Slab

__all__ = ["Band", "Line", "band", "lines"]

# Relative to the plane's area.
_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Line:
    """One row.

    Parameters
    ----------
    value : float
        Of p.
    labels : tuple of str
        By ascending x.
    ends : (labels + 1,) array
        Where each label begins and the last one ends; the outer two are the sides of the plane.
    """

    value: float
    labels: tuple[str, ...]
    ends: np.ndarray

    @property
    def lengths(self) -> dict[str, float]:
        """Length in x of every label."""
        totals: dict[str, float] = {}
        for label, size in zip(self.labels, np.diff(self.ends), strict=True):
            totals[label] = totals.get(label, 0.0) + float(size)
        return totals


@dataclass(frozen=True, eq=False)
class Band:
    """Rows between two values of p; of a single value, where both are equal, the shares are shares of the length.

    Parameters
    ----------
    low, high : float
    shares : dict of str to float
        Of the band's area, in the order of the labels' codes; they add up to 1. Labels without a share are left out.
    error : float
        Measured error of the shares' quadrature, summed over all; 0 for a single value.
    """

    low: float
    high: float
    shares: dict[str, float]
    error: float


def lines(regions: Regions, values: Sequence[float]) -> list[Line]:
    """The labels of rows from end to end; their limits are solved for and not interpolated.

    Parameters
    ----------
    regions : Regions
        For a part of the swept axis, those of `Regions.within`.
    values : sequence of float
        Of p, within the plane. A row in which a boundary turns round, ends or meets another is looked at a millionth of
        its slab's height further inside.

    Raises
    ------
    ParameterError
        If a value lies outside of the plane.
    """
    crossings = RowCrossings(regions.curves, regions.plane.x_range)
    lows = np.array([part.slab.low for part in regions.slabs])
    result = []
    for value in values:
        _refuse_outside(regions, "p", value)
        part = regions.slabs[max(int(np.searchsorted(lows, value, side="right")) - 1, 0)]
        slab = part.slab
        arcs, x = crossings.matrix(np.clip([value], *slab.inner_ends))
        result.append(Line(float(value), part.labels, np.array([x[0, arcs.index(arc)] for arc in slab.arcs])))
    return result


def band(regions: Regions, low: float, high: float) -> Band:
    """The shares of the labels between two rows.

    Parameters
    ----------
    regions : Regions
        For a part of the swept axis, those of `Regions.within`.
    low, high : float
        Values of p, within the plane; equal ones mean a single row.

    Returns
    -------
    Band

    Raises
    ------
    ParameterError
        If the band is not inside the plane, or `low` is above `high`.

    Notes
    -----
    What the labels are is known from the whole plane; only the areas are integrated anew.
    """
    for name, value in (("low", low), ("high", high)):
        _refuse_outside(regions, name, value)
    if low > high:
        raise ParameterError("low", low, f"at most high = {high!r}")
    if low == high:
        (one,) = lines(regions, [low])
        return _band(regions, low, high, one.lengths, 0.0)
    parts = [
        (replace(part.slab, low=max(part.slab.low, low), high=min(part.slab.high, high)), part.labels)
        for part in regions.slabs
        if min(part.slab.high, high) - max(part.slab.low, low) > 0.0
    ]
    slabs: list[Slab] = [slab for slab, _ in parts]
    crossings = RowCrossings(regions.curves, regions.plane.x_range)
    sizes: dict[str, float] = {}
    areas, error, disorder = slab_areas(crossings, slabs, _TOLERANCE * np.ptp(regions.plane.x_range) * (high - low))
    if disorder:
        raise RegionError(f"the boundaries change their order at {disorder[0]!r} inside a slab")
    for (_, labels), row in zip(parts, areas, strict=True):
        for label, size in zip(labels, row, strict=True):
            sizes[label] = sizes.get(label, 0.0) + float(size)
    return _band(regions, low, high, sizes, error)


def _band(regions: Regions, low: float, high: float, sizes: dict[str, float], error: float) -> Band:
    whole = sum(sizes.values())
    shares = {label: sizes[label] / whole for label in regions.labels if sizes.get(label, 0.0) > 0.0}
    return Band(float(low), float(high), shares, float(error / whole))


def _refuse_outside(regions: Regions, name: str, value: float) -> None:
    if not regions.plane.p_range[0] <= value <= regions.plane.p_range[1]:
        raise ParameterError(name, value, f"within {regions.plane.p_range}")
