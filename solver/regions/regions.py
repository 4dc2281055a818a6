"""Regions of equal n/I label in a plane: their shares of the area, where they begin and end, and what parts them.

The labels of a row change only where boundary curves cross it, and the order of these crossings changes only at
critical values of the row parameter (`solver.regions.slabs`). Between two of those the sequence of labels is the
same in every row, so that enumerating every solution between every two neighbouring crossings gives the whole plane.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from solver.boundaries.curve import BoundaryCurve
from solver.boundaries.problem import Plane
from solver.contact.impact import domain_label, label_parts
from solver.continuation.continuation import EndReason, Event
from solver.model.checks import ParameterError, finite_number, instances_of, value_range
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.parameter_path import ParameterPath
from solver.regions.division import Division, divided
from solver.regions.labelling import Labeller, static_code
from solver.regions.slabs import RegionError, Slab

__all__ = ["Frontier", "LabelledSlab", "Occurrence", "RegionError", "Regions", "regions", "regions_of"]

# Relative to the range of p.
_JOINED = 1e-7
# Slope below which a boundary belongs to one row.
_LEVEL = 1e-6


@dataclass(frozen=True)
class LabelledSlab:
    """Rows between two critical values, all with the same labels.

    Parameters
    ----------
    slab : Slab
    labels : tuple of str
        From arc to arc, by ascending x.
    areas : (labels,) array
        Area of each in the (x, p) plane.
    """

    slab: Slab
    labels: tuple[str, ...]
    areas: np.ndarray


@dataclass(frozen=True)
class Frontier:
    """Two labels with a boundary between them.

    Parameters
    ----------
    labels : (str, str)
        The one with fewer stable solutions, or lower states, first.
    kind : Event
        FOLD, or the grazing that happens along it; NONE where a motion passes the amplitude ceiling.
    length : float
        Height in p over which the boundary parts the two.
    """

    labels: tuple[str, str]
    kind: Event
    length: float


@dataclass(frozen=True)
class Occurrence:
    """A range of the row parameter in which a label occurs.

    Parameters
    ----------
    label : str
    appears, disappears : float
        Values of p. At the border of the plane the label may go on.
    share : float
        Of the area of the plane (or window), within this range.
    """

    label: str
    appears: float
    disappears: float
    share: float


@dataclass(frozen=True, eq=False)
class Regions:
    """What the boundaries of a plane divide it into.

    Parameters
    ----------
    labels : tuple of str
        Every n/I label of the plane, in the order of their codes.
    shares : dict of str to float
        Share of the plane's area of each; they add up to 1.
    error : float
        Measured error of the shares' quadrature, summed over all.
    adjacency : tuple of Frontier
        Pairs of labels that share a boundary, by label. Boundaries along a row (at constant p) do not show here.
    slabs : tuple of LabelledSlab
        The plane, from its lowest row upwards.
    plane : Plane
    curves : tuple of BoundaryCurve
        Those given, and where branches pass the ceiling.
    amplitude_max : float
    """

    labels: tuple[str, ...]
    shares: dict[str, float]
    error: float
    adjacency: tuple[Frontier, ...]
    slabs: tuple[LabelledSlab, ...] = field(repr=False)
    plane: Plane = field(repr=False)
    curves: tuple[BoundaryCurve, ...] = field(repr=False)
    amplitude_max: float = 100.0
    _windows: dict = field(default_factory=dict, init=False, repr=False)

    def thresholds(self, label: str, x_window: tuple[float, float] | None = None) -> tuple[tuple[float, float], ...]:
        """The ranges (appears, disappears) of p in which a label occurs; takes and raises what `occurrences` does.

        In the plane of omega and b of the published gear, "2/0-2" gives ((0.047920441, 1.010829919),).
        """
        return tuple((found.appears, found.disappears) for found in self.occurrences(label, x_window))

    def occurrences(self, label: str, x_window: tuple[float, float] | None = None) -> tuple[Occurrence, ...]:
        """Where in p a label occurs.

        Parameters
        ----------
        label : str
        x_window : (low, high), optional
            Only this part of the swept axis counts, for example that of one resonance.

        Returns
        -------
        tuple of Occurrence
            Ascending, with gaps between; empty if the label occurs nowhere.

        Raises
        ------
        ParameterError
            If it is no label n/I, or the window is not inside the plane.
        """
        label_parts(label)
        if x_window is not None:
            return self.within(x_window).occurrences(label)
        return tuple(Occurrence(label, *found) for found in self.ranges((label,)))

    def ranges(self, labels: Collection[str]) -> tuple[tuple[float, float, float], ...]:
        """Where in p any of several labels occurs: unbroken ranges (appears, disappears, share of the plane's area).

        Raises
        ------
        ParameterError
            If one is no label n/I.
        """
        labels = instances_of("labels", labels, str)
        for label in labels:
            label_parts(label)
        merged: list[tuple[float, float, float]] = []
        (x_low, x_high), (p_low, p_high) = self.plane.x_range, self.plane.p_range
        for part in self.slabs:
            if not any(label in labels for label in part.labels):
                continue
            area = sum(float(size) for name, size in zip(part.labels, part.areas, strict=True) if name in labels)
            share = area / ((x_high - x_low) * (p_high - p_low))
            if merged and part.slab.low - merged[-1][1] <= _JOINED * (p_high - p_low):
                appears, _, before = merged.pop()
                merged.append((appears, part.slab.high, before + share))
            else:
                merged.append((part.slab.low, part.slab.high, share))
        return tuple(merged)

    def within(self, x_window: tuple[float, float], p_window: tuple[float, float] | None = None) -> "Regions":
        """The regions of a part of the plane.

        Raises
        ------
        ParameterError
            If the window is not inside the plane.
        """
        p_window = self.plane.p_range if p_window is None else p_window
        key = value_range("x_window", x_window), value_range("p_window", p_window)
        if key not in self._windows:
            for name, window, whole in zip(
                ("x_window", "p_window"), key, (self.plane.x_range, self.plane.p_range), strict=True
            ):
                if not whole[0] <= window[0] < window[1] <= whole[1]:
                    raise ParameterError(name, window, f"ascending and within {whole}")
            part = replace(self.plane, x_range=key[0], p_range=key[1])
            self._windows[key] = _divided(part, self.curves, self.amplitude_max)
        return self._windows[key]

    def neighbours(self, label: str) -> dict[str, tuple[Event, ...]]:
        """The labels next to one n/I, and the kinds of the boundaries between; raises ParameterError for other text."""
        label_parts(label)
        kinds: dict[str, tuple[Event, ...]] = {}
        for frontier in self.adjacency:
            if label in frontier.labels:
                other = frontier.labels[frontier.labels[0] == label]
                kinds[other] = (*kinds.get(other, ()), frontier.kind)
        return kinds


def regions(
    system: Model | ContactSystem,
    x_axis: str,
    p_axis: str | ParameterPath,
    x_range: tuple[float, float],
    p_range: tuple[float, float],
    curves: Sequence[BoundaryCurve],
    *,
    omega: float | None = None,
    amplitude_max: float = 100.0,
) -> Regions:
    """Divide a plane along its boundaries.

    Parameters
    ----------
    system : Model or ContactSystem
        Its own values of the two axes are not used; a path starts from it.
    x_axis : str
        One of `solver.model.packing.AXES`, or of `SYSTEM_AXES` for a ContactSystem: along rows.
    p_axis : str or ParameterPath
        Another one, or a path of models: from row to row.
    x_range, p_range : (low, high)
        The plane, or a part of the one for which the curves were traced.
    curves : sequence of BoundaryCurve
        All boundaries, from `boundary_curves`.
    omega : float, optional
        The frequency; needed unless it is an axis.
    amplitude_max : float
        Solutions of larger amplitude do not count; where a branch passes this ceiling is a boundary as well.

    Returns
    -------
    Regions

    Raises
    ------
    ParameterError
        If the plane or the ceiling is not allowed.
    RegionError
        If the boundaries do not divide the plane into regions of one label: one of them is missing or ends early, or
        solutions can nowhere be told apart.

    Notes
    -----
    Labels change only where a boundary crosses a row, and the order of crossings only at critical values of p
    (docs/physics.md, section 5.6).
    """
    plane = Plane(system, x_axis, p_axis, x_range, p_range, omega)
    curves = instances_of("curves", curves, BoundaryCurve)
    return _divided(plane, curves, finite_number("amplitude_max", amplitude_max, above=0.0))


def _divided(plane: Plane, curves: tuple[BoundaryCurve, ...], amplitude_max: float) -> Regions:
    _refuse_early_ends(plane, curves)
    return regions_of(divided(plane, curves, lambda met: Labeller(plane, met, amplitude_max)), amplitude_max)


def _refuse_early_ends(plane: Plane, curves: tuple[BoundaryCurve, ...]) -> None:
    """Raise if a boundary was not followed to its end, unless it is level there: it is a critical value anyway."""
    for curve in curves:
        for end, index in zip(curve.ends, (0, -1), strict=True):
            if end in (EndReason.STEP_TOO_SMALL, EndReason.ITERATION_LIMIT):
                along_x, along_p = np.abs(curve.slopes[index, 3:]) / [np.ptp(plane.x_range), np.ptp(plane.p_range)]
                if not along_p < _LEVEL * along_x:
                    x, p = (float(v) for v in curve.points[index, 3:])
                    raise RegionError(f"a {curve.kind.name} boundary ends early, at {(x, p)}: {end.sentence}")


def regions_of(division: Division, amplitude_max: float) -> Regions:
    """The regions of a divided plane; what its codes say besides n/I is left out."""
    plane, curves = division.plane, division.curves
    parts, borders = [], {}
    (x_low, x_high), (p_low, p_high) = plane.x_range, plane.p_range
    for part in division.slabs:
        merged = part.merged([static_code(code) for code in part.codes])
        tall = float(np.sum(merged.areas)) / (x_high - x_low)
        for arc, *pair in zip(merged.slab.arcs[1:-1], merged.codes[:-1], merged.codes[1:], strict=True):
            key = (*sorted(pair), curves[arc[0]].kind)
            borders[key] = borders.get(key, 0.0) + tall
        parts.append(LabelledSlab(merged.slab, tuple(map(domain_label, merged.codes)), merged.areas))
    shares: dict[int, float] = {}
    for code, share in division.shares().items():
        shares[static_code(code)] = shares.get(static_code(code), 0.0) + share
    return Regions(
        tuple(domain_label(code) for code in sorted(shares)),
        {domain_label(code): shares[code] for code in sorted(shares)},
        division.error / ((x_high - x_low) * (p_high - p_low)),
        tuple(
            Frontier((domain_label(a), domain_label(b)), kind, length)
            for (a, b, kind), length in sorted(borders.items())
        ),
        tuple(parts),
        plane,
        curves,
        amplitude_max,
    )
