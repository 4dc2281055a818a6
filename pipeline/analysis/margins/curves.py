"""Boundaries of a plane as cubic arcs, for a stored plane and for one that is traced on the spot."""

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.analysis.boundaries.tracing import curves_through, to_store
from pipeline.analysis.margins.lines import swept
from pipeline.plan.axes import Axis
from pipeline.plan.numerics import balance_of, row_axis
from pipeline.plan.plan import Plan
from pipeline.plane.arcs import Arcs
from solver import Event
from solver.boundaries import BIFURCATIONS, FOLDS_AND_GRAZINGS, BoundaryCurve

__all__ = ["BIFURCATIONS", "Boundaries", "boundaries_of", "crossed", "part_of", "traced"]

#: Rows between which boundaries of a column are sought that cannot be swept itself.
_ROWS = 9

#: x and p among the components of a boundary's points.
X, P = 3, 4
_ENDS = ("start", "end", "leave", "arrive")


@dataclass(frozen=True)
class Boundaries:
    """Arcs of a plane on whose two sides something differs.

    Parameters
    ----------
    arcs : Arcs
        m of them.
    kinds : (m,) int array
    """

    arcs: Arcs
    kinds: np.ndarray

    def along(self, axis: int, value: float) -> tuple[np.ndarray, np.ndarray]:
        """Where the line on which component `axis` (3: x, 4: p) has a value is crossed, and the kinds."""
        found = self.arcs.crossings(axis, np.array([value]))
        return found.points[:, X + P - axis], self.kinds[found.arc]

    @staticmethod
    def joined(*parts: "Boundaries") -> "Boundaries":
        """All arcs of several."""
        arcs = Arcs(*(np.concatenate([getattr(part.arcs, name) for part in parts]) for name in _ENDS))
        return Boundaries(arcs, np.concatenate([part.kinds for part in parts]))

    def kinds_in(self, x: tuple[float, float], p: tuple[float, float]) -> set[Event]:
        """Of the arcs with a point in a closed rectangle, as far as five points an arc show."""
        inside = np.zeros(self.kinds.size, bool)
        for t in np.linspace(0.0, 1.0, 5):
            at = self.arcs.at(slice(None), np.full(self.kinds.size, t))
            inside |= (x[0] <= at[:, X]) & (at[:, X] <= x[1]) & (p[0] <= at[:, P]) & (at[:, P] <= p[1])
        return {Event(int(kind)) for kind in np.unique(self.kinds[inside])}

    @cached_property
    def marked(self) -> tuple[np.ndarray, np.ndarray]:
        """Ends of arcs and where they turn round in x or p: places (k, 2), and the kinds (k,).

        Between two of these an arc is monotonic in both.
        """
        places, kinds = [self.arcs.start[:, X:], self.arcs.end[:, X:]], [self.kinds, self.kinds]
        for axis in (X, P):
            turns = self.arcs.turns(axis)
            number, which = np.nonzero(turns)
            places.append(self.arcs.at(number, turns[number, which])[:, X:])
            kinds.append(self.kinds[number])
        return np.concatenate(places), np.concatenate(kinds)


def boundaries_of(curves, kinds=FOLDS_AND_GRAZINGS) -> Boundaries:
    """The arcs of curves (`StoredCurve`) of some kinds.

    Folds and grazings part labels; bifurcations leave n and I alone, and part what is dynamically stable. Where a
    motion is statically unstable, none of them counts but the fold.
    """
    shown = [curve for curve in curves if curve.kind in kinds and len(curve.points) > 1]
    flags = np.concatenate([np.empty(0, bool), *(curve.arc_shows for curve in shown)])
    arcs = Arcs(
        *(np.concatenate([np.empty((0, 5)), *(getattr(curve.arcs, name) for curve in shown)])[flags] for name in _ENDS)
    )
    numbers = np.concatenate([np.empty(0, int), *(np.full(len(curve.points) - 1, curve.kind) for curve in shown)])
    return Boundaries(arcs, numbers[flags])


def part_of(plan: Plan, x: tuple[float, float], p: tuple[float, float], rows: int = 2) -> Plan:
    """A part of a plane with so many rows and columns."""
    sweep, parameter = Axis(plan.sweep.name, *x, rows), Axis(plan.parameter.name, *p, rows)
    return dataclasses.replace(plan, sweep=sweep, parameter=parameter)


def traced(
    plan: Plan, x: tuple[float, float], p: tuple[float, float], rows: int
) -> tuple[Plan, tuple[BoundaryCurve, ...]]:
    """A part of a plane, and its boundaries followed on the spot from what some of its rows and columns meet.

    Parameters
    ----------
    plan : Plan
        Its gear and axes; how many rows and columns it has does not matter.
    x, p : (low, high)
    rows : int
        Rows and columns that are swept, both borders among them; where the row parameter is a path, rows alone.

    Returns
    -------
    Plan
        Of the part.
    tuple of BoundaryCurve
    """
    window, starts = part_of(plan, x, p, rows), []
    for value in window.parameter.values:
        points, kinds = swept(window, window.sweep.name, x, x[0], float(value))
        starts += [(Event(int(kind)), np.append(point, value)) for kind, point in zip(kinds, points, strict=True)]
    # Nothing is swept along a path: its columns add nothing.
    for value in window.sweep.values if isinstance(row_axis(plan), str) else ():
        points, kinds = swept(window, window.parameter.name, p, float(value), p[0])
        along = np.column_stack([points[:, :-1], np.full(len(points), value), points[:, -1]])
        starts += [(Event(int(kind)), point) for kind, point in zip(kinds, along, strict=True)]
    return window, curves_through(window, starts, balance_of(plan.solver))


def crossed(plan: Plan, axis: str, ends: tuple[float, float], x: float, p: float) -> tuple[np.ndarray, np.ndarray]:
    """Where one of the plane's axes meets boundaries on its way through a place, and their kinds."""
    if axis == plan.sweep.name or isinstance(row_axis(plan), str):
        points, kinds = swept(plan, axis, ends, x, p)
        return points[:, -1], kinds
    _, curves = traced(plan, (plan.sweep.low, plan.sweep.high), ends, _ROWS)
    return boundaries_of([to_store(curve) for curve in curves]).along(X, x)
