"""A plane divided along its boundaries: slabs, and what holds between every two neighbouring boundaries of a slab.

What holds at a place is one whole number, whatever it means: `solver.regions.labelling` has the functions that give it.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from solver.boundaries.curve import BoundaryCurve
from solver.boundaries.problem import Plane
from solver.kernels.threads import side_by_side
from solver.model.checks import ParameterError
from solver.regions.areas import slab_areas
from solver.regions.slabs import RegionError, RowCrossings, Slab, SlabCurve, slabs

__all__ = ["DividedSlab", "Division", "Labels", "divided"]

# Relative to the plane's area.
_TOLERANCE = 1e-9
_MOST_ROUNDS = 100


@dataclass(frozen=True)
class DividedSlab:
    """Rows between two critical values.

    Parameters
    ----------
    slab : Slab
    codes : tuple of int
        What holds from arc to arc, by ascending x.
    areas : (codes,) array
        Area of each in the (x, p) plane.
    """

    slab: Slab
    codes: tuple[int, ...]
    areas: np.ndarray

    def merged(self, codes: Sequence[int]) -> "DividedSlab":
        """With other codes, and without the arcs on whose two sides they are equal."""
        kept = [i for i in range(len(codes)) if i == 0 or codes[i] != codes[i - 1]]
        arcs = (*(self.slab.arcs[i] for i in kept), self.slab.arcs[-1])
        areas = np.add.reduceat(self.areas, kept)
        return DividedSlab(Slab(self.slab.low, self.slab.high, arcs), tuple(codes[i] for i in kept), areas)


@dataclass(frozen=True, eq=False)
class Division:
    """What the boundaries of a plane divide it into.

    Parameters
    ----------
    plane : Plane
    curves : tuple of BoundaryCurve
        Those given, and where branches pass the ceiling.
    slabs : tuple of DividedSlab
        The plane, from its lowest row upwards; their areas add up to that of the plane.
    error : float
        Measured error of the areas' quadrature, summed over all.
    """

    plane: Plane
    curves: tuple[BoundaryCurve, ...] = field(repr=False)
    slabs: tuple[DividedSlab, ...] = field(repr=False)
    error: float

    def beside(self, curve: int, points: np.ndarray) -> np.ndarray:
        """What holds on the left and on the right of a curve, in its rows.

        Parameters
        ----------
        curve : int
            Number of the curve.
        points : (k, 2) array
            Places (x, p) on it, in any order.

        Returns
        -------
        (k, 2) int64 array
            Twice the same where the curve is not met.
        """
        order = np.argsort(points[:, 1], kind="stable")
        number, table = self._met(points[order, 1], (self.curves[curve],))
        found, start = np.zeros((len(points), 2), np.int64), 0
        for (k, _), rows in itertools.groupby(zip(number, table, strict=True), lambda row: (row[0], row[1][1].size)):
            # The sides of the plane come first.
            x = np.stack([x for _, (_, x) in rows])[:, 2:]
            here, start = order[start : start + len(x)], start + len(x)
            if x.size:
                part = self.slabs[k]
                at = {arc: i for i, arc in enumerate(part.slab.arcs)}
                at = np.array([at.get((curve, which), 0) for which in range(x.shape[1])])
                at = at[np.argmin(np.abs(x - points[here, :1]), axis=1)]
                codes, here, at = np.array(part.codes), here[at > 0], at[at > 0]
                found[here] = np.column_stack([codes[at - 1], codes[at]])
        return found

    def _met(self, p: np.ndarray, curves: tuple[SlabCurve, ...]):
        """The number of the slab of every ascending p, and what its row meets of some curves: `RowCrossings.table`."""
        # A row between two slabs, or on the border of one, is looked at inside.
        lows, firsts, lasts = np.array([(part.slab.low, *part.slab.inner_ends) for part in self.slabs]).T
        number = np.clip(np.searchsorted(lows, p, side="right") - 1, 0, None)
        inside = np.clip(p, firsts[number], lasts[number])
        return number, RowCrossings(curves, self.plane.x_range).table(inside)

    def shares(
        self, x_window: tuple[float, float] | None = None, p_window: tuple[float, float] | None = None
    ) -> dict[int, float]:
        """Share of every code of the area of the plane, or of a part of it, ascending by code; they add up to 1.

        Raises
        ------
        ParameterError
            If a window is not inside the plane.
        """
        parts = self.slabs if x_window is p_window is None else self._cut(x_window, p_window)
        sizes: dict[int, float] = {}
        for part in parts:
            for code, size in zip(part.codes, part.areas, strict=True):
                sizes[code] = sizes.get(code, 0.0) + float(size)
        whole = sum(sizes.values())
        return {code: sizes[code] / whole for code in sorted(sizes) if sizes[code] > 0.0}

    def _cut(self, x_window, p_window) -> list[DividedSlab]:
        """The slabs within windows, with the areas there."""
        ends = []
        for name, window, whole in (
            ("x_window", x_window, self.plane.x_range),
            ("p_window", p_window, self.plane.p_range),
        ):
            low, high = whole if window is None else window
            if not whole[0] <= low < high <= whole[1]:
                raise ParameterError(name, window, f"ascending and within {whole}")
            ends.append((low, high))
        x, (low, high) = ends
        parts = [
            (replace(part.slab, low=max(part.slab.low, low), high=min(part.slab.high, high)), part.codes)
            for part in self.slabs
            if min(part.slab.high, high) - max(part.slab.low, low) > 0.0
        ]
        slabs = [slab for slab, _ in parts]
        crossings = RowCrossings(self.curves, self.plane.x_range)
        areas, _, _ = slab_areas(crossings, slabs, _TOLERANCE * np.ptp(x) * (high - low), x)
        return [DividedSlab(slab, codes, size) for (slab, codes), size in zip(parts, areas, strict=True)]

    def codes_at(self, x: np.ndarray, p: np.ndarray) -> np.ndarray:
        """What holds on a lattice.

        Parameters
        ----------
        x, p : ascending arrays
            Places within the plane.

        Returns
        -------
        (p, x) int64 array
        """
        codes, number = self.lattice(x, p)
        return codes[number]

    def lattice(self, x: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """`codes_at` as the codes of the division, ascending (k,) int64, and which of them holds, (p, x) uint16."""
        codes = np.unique(np.array([code for part in self.slabs for code in part.codes], np.int64))
        number, table = self._met(p, self.curves)
        found, alike = [np.empty((0, x.size), np.uint16)], zip(number.tolist(), table, strict=True)
        for (k, _), rows in itertools.groupby(alike, lambda row: (row[0], row[1][0].tobytes())):
            arcs, ends = zip(*(row for _, row in rows), strict=True)
            part, arcs, ends = self.slabs[k], list(map(tuple, arcs[0].tolist())), np.stack(ends)
            ends = np.maximum.accumulate(ends[:, [arcs.index(arc) for arc in part.slab.arcs[1:-1]]], axis=1)
            # How many of x lie between every two of them.
            count = np.diff(np.searchsorted(x, ends), axis=1, prepend=0, append=x.size)
            here = np.tile(np.searchsorted(codes, part.codes).astype(np.uint16), len(ends))
            found.append(np.repeat(here, count.ravel()).reshape(len(ends), x.size))
        return codes, np.concatenate(found)


class Labels(Protocol):
    """What is known of the slabs that curves divide a plane into."""

    def expect(self, slabs: Sequence[Slab]) -> None:
        """Look up together what `sequence` will need of slabs."""

    def sequence(self, slab: Slab) -> list[int] | float | BoundaryCurve:
        """The codes between every two neighbouring arcs of a slab; or what divides it further: a row along which a
        boundary runs, or a boundary."""


def divided(plane: Plane, curves: tuple[SlabCurve, ...], labels_of: Callable[[RowCrossings], Labels]) -> Division:
    """Divide a plane along its boundaries.

    Parameters
    ----------
    plane : Plane
    curves : tuple of BoundaryCurve or StoredCurve
        All boundaries at which codes change.
    labels_of : callable
        (crossings of rows with all boundaries) -> Labels

    Raises
    ------
    RegionError
        If codes change where no boundary is, or can nowhere be told.
    """
    width, height = np.ptp(plane.x_range), np.ptp(plane.p_range)
    levels: list[float] = []
    watched: list[float] = []
    known: dict[Slab, list[int]] = {}
    for _ in range(_MOST_ROUNDS):
        crossings = RowCrossings(curves, plane.x_range)
        found = slabs(crossings, plane.p_range, watched, levels)
        sequences, further = _labelled(labels_of(crossings), found, known)
        if isinstance(further, float):
            levels.append(further)
        elif further is not None:
            curves = (*curves, further)
        else:
            areas, error, disorder = slab_areas(crossings, found, _TOLERANCE * width * height)
            if not disorder:
                break
            # Arcs that intersect twice between two samples: these are looked at as well.
            watched += disorder
    else:
        slab = found[min(len(sequences), len(found) - 1)]
        raise RegionError(f"the plane is divided too often, last above {plane.p_axis} = {slab.low!r}")
    # Slabs leave out what lies between critical values too close to be told apart: their neighbours share it.
    stops = [0.5 * (a.high + b.low) for a, b in zip(found[:-1], found[1:], strict=True)]
    heights = np.diff([plane.p_range[0], *stops, plane.p_range[1]])
    parts = tuple(
        DividedSlab(slab, tuple(sequence), area * (tall / (slab.high - slab.low)))
        for slab, sequence, area, tall in zip(found, sequences, areas, heights, strict=True)
    )
    return Division(plane, curves, parts, float(error))


def _labelled(
    labels: Labels, found: tuple[Slab, ...], known: dict[Slab, list[int]]
) -> tuple[list[list[int]], float | BoundaryCurve | None]:
    """Codes of all slabs; or of the first ones, and what divides the next one further.

    What is `known` of slabs that no further boundary has divided is kept.
    """
    fresh = [slab for slab in found if slab not in known]
    labels.expect(fresh)
    for slab, sequence in zip(fresh, side_by_side(labels.sequence, fresh), strict=True):
        if not isinstance(sequence, list):
            return [known[slab] for slab in found[: found.index(slab)]], sequence
        known[slab] = sequence
    return [known[slab] for slab in found], None
