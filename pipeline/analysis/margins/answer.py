"""All answers about a design point of a stored plane."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from pipeline.analysis.margins.box import Box, largest_box
from pipeline.analysis.margins.curves import BIFURCATIONS, Boundaries, P, X, boundaries_of
from pipeline.analysis.margins.distances import (
    Margin,
    losses_of_axis,
    margins_of_axis,
    margins_of_further,
    nearest_over_range,
)
from pipeline.analysis.margins.integration import integrated
from pipeline.analysis.margins.knowledge import Known, doubts_of, order_words
from pipeline.analysis.margins.lines import Line, codes_along, divided, row_along
from pipeline.analysis.margins.options import Design
from pipeline.analysis.margins.resonances import Resonance, resonances_in
from pipeline.analysis.margins.worst import Corner, corners
from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.plan.numerics import model_at
from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane
from solver import domain_label
from solver.stability import Instability

__all__ = ["IN_CONTACT", "Answer", "answer", "line_through"]

#: One motion, whose teeth never part.
IN_CONTACT = "1/0"
#: In so many rows and columns a box is looked at once more.
_CHECKED = 15
_UNSTABLE = {Instability.PERIOD_DOUBLING: "period doubling", Instability.NEIMARK_SACKER: "Neimark-Sacker"}


@dataclass(frozen=True)
class Answer:
    """What is known about a design point.

    Parameters
    ----------
    plan : Plan
    design : Design
    label : str
        n/I at the point, of the plane's own order; empty where it is not decided.
    row : Line
        The swept axis at the point's p.
    margins : tuple of Margin
        To the nearest changes of label.
    losses : tuple of Margin
        To the nearest bifurcations of statically stable motions in both axes, as far as there are any.
    box : Box or None
        The largest box of `IN_CONTACT` around the operating range, or around the point alone where the range is not.
    resonances : tuple of Resonance
        Linear ones over which the box lies, ascending.
    corners : tuple of Corner
        Labels within the tolerances.
    known : tuple of Known
        Of the point; of the box, if there is one.
    doubts : tuple of str
        What keeps the label from being verified; none where integration found its motions, and no other, in all cells.
    how : str
        The command that integrates.
    notes : tuple of str
        What else these answers do and do not say.
    """

    plan: Plan
    design: Design
    label: str
    row: Line
    margins: tuple[Margin, ...]
    losses: tuple[Margin, ...]
    box: Box | None
    resonances: tuple[Resonance, ...]
    corners: tuple[Corner, ...]
    known: tuple[Known, ...]
    doubts: tuple[str, ...]
    how: str
    notes: tuple[str, ...]

    @property
    def sentences(self) -> list[str]:
        """What is known of the point and of the box, the command where something was not integrated, once."""
        gaps = [one for one in self.known if not one.integrated]
        return [one.sentence(self.how if gaps[:1] == [one] else "") for one in self.known]


def answer(path: Place, plan: Plan, design: Design, how: str = "stages=[attractors]") -> Answer:
    """Ask a stored plane about a design point.

    Parameters
    ----------
    path : Place
        The store, its boundaries traced.
    plan : Plan
        The store's own.
    design : Design
    how : str
        The command that integrates this plane, for the reader.

    Raises
    ------
    StoreError
        If there are no boundaries.
    ArithmeticError, ValueError
        If boundaries of planes that are traced on the spot cannot be followed.
    """
    plane = StoredPlane(path, plan)
    if plane.boundaries is None:
        raise StoreError(f"{path} has no boundaries: run stages=[boundaries] first")
    boundaries = boundaries_of(plane.boundaries.curves)
    bifurcations = boundaries_of(plane.boundaries.curves, BIFURCATIONS)
    row, column = (line_through(boundaries, plan, design, held) for held in (P, X))
    label = domain_label(row.within(design.x, design.x)[0].code)
    margins = margins_of_axis(row, column, plan, design)
    if design.low < design.high:
        margins += nearest_over_range(boundaries, plan, design, design.p)
    for name in design.further:
        margins += margins_of_further(plan, design, name)
    found = corners(plan, design, plane)
    unstable = _instability(plan, design)
    box, notes = _box(Boundaries.joined(boundaries, bifurcations), plan, design, label, unstable)
    rectangles = () if box is None else ((box.x, box.p),)
    known = tuple(
        Known(order_words(plan), label, integrated(path, plan, *ends), of_box)
        for of_box, ends in (
            (False, ((design.x, design.x), (design.p, design.p))),
            *((True, one) for one in rectangles),
        )
    )
    doubts = doubts_of(plane, design, known, bifurcations, rectangles)
    return Answer(
        plan,
        design,
        label,
        row,
        tuple(margins),
        tuple(losses_of_axis(bifurcations, plan, design)),
        box,
        _resonances(plan, box),
        tuple(found),
        known,
        (*([f"a motion is dynamically unstable ({unstable})"] if unstable else []), *doubts),
        how,
        (*notes, *_limits(plan, found)),
    )


def line_through(boundaries: Boundaries, plan: Plan, design: Design, held: int) -> Line:
    """The line through the point along which the other axis than `held` (3: x, 4: p) changes."""
    axis, value = (plan.parameter, design.x) if held == X else (plan.sweep, design.p)
    ends = axis.low, axis.high
    return divided(*boundaries.along(held, value), ends, codes_along(plan, axis.name, ends, design.x, design.p))


def _limits(plan: Plan, found: list[Corner]) -> list[str]:
    """What these answers do not say."""
    notes = []
    if len(found) > 1:
        notes.append(
            "Further parameters are looked at with all of them at the ends of their tolerances; between those nothing "
            "is proven."
        )
    if not plan.is_first_order:
        notes.append(
            f"At order {plan.solver['order']} the motions are those of the branches that were found along lines of the "
            "plane, and labels within the tolerances those of some of its rows: this is a search, not a proof."
        )
    return notes


def _box(arcs, plan, design, label, unstable) -> tuple[Box | None, list[str]]:
    """The largest box, and what is to be said of it."""
    boxed, said = design, []
    name = plan.sweep.name
    none = f"There is no box of {IN_CONTACT}: "
    if label != IN_CONTACT:
        return None, [f"{none}the label of the design point is {label or 'not decided'}."]
    if unstable:
        return None, [f"{none}the motion of the design point is dynamically unstable ({unstable})."]
    crossed, _ = arcs.along(P, design.p)
    if np.any((crossed > design.low) & (crossed < design.high)):
        boxed = dataclasses.replace(design, low=design.x, high=design.x)
        said.append(
            f"No box of {IN_CONTACT} holds the operating range {name} = {design.low:g} ... {design.high:g}, which "
            "boundaries cross; the box is the largest around the design point."
        )
    box = largest_box(arcs, plan, boxed)
    if not box.area > 0.0:
        return None, [f"{none}the design point lies on a boundary."]
    if unlike := _unlike(plan, box):
        # Where a motion passes the amplitude ceiling, or a curve could not be followed, no boundary is stored.
        return None, [f"The largest box free of stored boundaries is not all {IN_CONTACT}: {unlike}."]
    return box, said


def _instability(plan: Plan, design: Design) -> str:
    """How a statically stable motion of the design point is dynamically unstable; empty if none is."""
    sweep = plan.sweep
    row = row_along(plan, sweep.name, np.unique([sweep.low, design.x, sweep.high]), design.x, design.p)
    here = np.searchsorted(row.grid, design.x)
    kinds = row.instability[here][row.stable[here] == 1].tolist()
    return ", ".join(words for kind, words in _UNSTABLE.items() if kind in kinds)


def _resonances(plan: Plan, box: Box | None) -> tuple[Resonance, ...]:
    """The linear resonances over which a box lies, of the gear in its middle row."""
    if box is None or plan.sweep.name != "omega":
        return ()
    return tuple(resonances_in(model_at(plan, 0.5 * sum(box.p), box.x[0]), *box.x))


def _unlike(plan: Plan, box: Box) -> str:
    """Where a box has another label than it should, as far as rows and columns show; empty if nowhere."""
    inside = (np.arange(_CHECKED) + 0.5) / _CHECKED
    columns = box.x[0] + (box.x[1] - box.x[0]) * inside
    ends = plan.sweep.low, plan.sweep.high
    for p in box.p[0] + (box.p[1] - box.p[0]) * inside:
        codes = codes_along(plan, plan.sweep.name, ends, float(columns[0]), float(p))(columns)
        for x, code in zip(columns, codes.tolist(), strict=True):
            if code and domain_label(code) != IN_CONTACT:
                return f"{domain_label(code)} at {plan.sweep.name} = {x:.6g}, {plan.parameter.name} = {p:.6g}"
    return ""
