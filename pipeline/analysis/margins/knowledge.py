"""What is known of a design point and of its box, with its source, and what keeps a label from being verified."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.analysis.margins.curves import Boundaries
from pipeline.analysis.margins.integration import Integrated, cells_in
from pipeline.analysis.margins.options import Design
from pipeline.errors import counted
from pipeline.plan.plan import Block, Plan
from pipeline.plan.unfelt import unfelt_harmonics
from pipeline.plane.stored import StoredPlane
from solver import Event, label_parts
from solver.stability import Instability

__all__ = ["Known", "doubts_of", "order_words"]

#: What runs by within this share of both axes is beside a design point.
_BESIDE = 0.02
_BIFURCATIONS = {Event.PERIOD_DOUBLING: "a period doubling", Event.NEIMARK_SACKER: "a Neimark-Sacker bifurcation"}


def order_words(plan: Plan) -> str:
    """By what a plane's labels are known: "first order" or "order 5"."""
    return "first order" if plan.is_first_order else f"order {plan.solver['order']}"


@dataclass(frozen=True)
class Known:
    """What is known of a place or of a box.

    Parameters
    ----------
    source : str
        Of the label: "first order", "order 5".
    label : str
    found : Integrated or None
        None where the store has no attractors.
    of_box : bool
    """

    source: str
    label: str
    found: Integrated | None
    of_box: bool

    @property
    def integrated(self) -> bool:
        """Whether all cells that it is about were integrated, one at least."""
        return self.found is not None and 0 < self.found.cells == self.found.looked_at

    @property
    def confirmed(self) -> bool:
        """Whether integration found the motions of the label in all of these cells, and no other."""
        return self.integrated and all(_are_of(motions, self.label) for motions in self.found.motions)

    def sentence(self, how: str = "") -> str:
        """In words; `how` is the command that integrates, left out where it has been said."""
        parts = [
            f"{self.source}: {self.label or 'not decided'} {'throughout the box' if self.of_box else 'at the point'}"
        ]
        found = self.found
        if found is not None and found.looked_at:
            together = [motions if " + " in motions else f"{motions} alone" for motions in found.motions]
            if self.of_box:
                counts = (f"{text} in {cells}" for text, cells in zip(together, found.motions.values(), strict=True))
                parts.append(f"integration: {', '.join(counts)} of {found.cells} cells of the box")
            else:
                parts.append(f"integration: {together[0]} in the nearest cell")
        if not self.integrated:
            parts.append(self._missing() + (f": run {how}" if how else ""))
        return "; ".join(parts)

    def _missing(self) -> str:
        if self.found is not None and self.found.cells == 0:
            return "no cell of the plane lies in the box; not integrated"
        if self.found is None or not self.found.looked_at:
            return "not integrated"
        return f"{self.found.cells - self.found.looked_at} cells are not integrated"


def _are_of(motions: str, label: str) -> bool:
    """Whether "1T/0 + 1T/1" are the motions that "2/0-1" counts."""
    parts = motions.split(" + ")
    n, states = label_parts(label)
    return len(parts) == n and set(parts) == {f"1T/{state.symbol}" for state in states}


def doubts_of(
    plane: StoredPlane, design: Design, known: tuple[Known, ...], bifurcations: Boundaries, boxes: tuple
) -> tuple[str, ...]:
    """What keeps the label of a design point, and of its box, from being verified; empty if nothing does.

    Parameters
    ----------
    plane : StoredPlane
    design : Design
    known : tuple of Known
        Of the point, and of the box if there is one.
    bifurcations : Boundaries
        Of statically stable motions.
    boxes : tuple of ((low, high), (low, high))
        The box, if there is one, in both axes.
    """
    plan, found = plane.plan, []
    if not all(one.integrated for one in known):
        found.append(f"it is known from {order_words(plan)} alone")
        if (unfelt := unfelt_harmonics(plan)) is not None:
            found.append(f"{order_words(plan)} does not feel {unfelt.words}")
    for one in known:
        if one.integrated and not one.confirmed:
            found.append(f"integration found other motions {'in the box' if one.of_box else 'in the nearest cell'}")
    around = [_around(plan, design), *boxes]
    beside = {kind for ends in around for kind in bifurcations.kinds_in(*ends)}
    # The box ends where a bifurcation runs: what is beside it then is said by its sides.
    found += [f"{words} runs beside it" for kind, words in _BIFURCATIONS.items() if kind in beside]
    contradictory, undecided = _cells_in_doubt(plane, around)
    for cells, words in (
        (contradictory, "static and dynamic stability contradict each other"),
        (undecided, "it is not known whether a motion is dynamically stable"),
    ):
        if cells:
            found.append(f"{words} in {counted(cells, 'cell')} of it or beside it")
    return tuple(found)


def _around(plan: Plan, design: Design) -> tuple[tuple[float, float], tuple[float, float]]:
    """Operating range and tolerance with what is beside them."""
    wide, high = (_BESIDE * (axis.high - axis.low) for axis in (plan.sweep, plan.parameter))
    p = design.p - design.tolerance - high, design.p + design.tolerance + high
    return (design.low - wide, design.high + wide), p


def _cells_in_doubt(plane: StoredPlane, rectangles) -> tuple[int, int]:
    """Cells of some rectangles in which a statically stable motion is contradictory, or undecided."""
    plan, counts = plane.plan, np.zeros(2, dtype=int)
    seen: set[tuple[int, int]] = set()
    for x, p in rectangles:
        columns, rows = cells_in(plan.sweep, *x), cells_in(plan.parameter, *p)
        if not (rows.size and columns.size):
            continue
        part = replace(plane, block=Block(int(rows[0]), int(rows[-1]) + 1))
        for number, kind in enumerate((Instability.CONTRADICTORY, Instability.UNDECIDED)):
            flags = np.any((part.stable == 1) & (part.instability == kind), axis=-1)[:, columns]
            places = {(number, *cell) for cell in (np.argwhere(flags) + [rows[0], columns[0]]).tolist()}
            counts[number] += len(places - seen)
            seen |= places
    return int(counts[0]), int(counts[1])
