"""All answers about a design point of a stored plane."""

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.margins.box import Box, largest_box
from pipeline.analysis.margins.curves import Boundaries, P, X, boundaries_of
from pipeline.analysis.margins.distances import Margin, margins_of_axis, margins_of_further, nearest_over_range
from pipeline.analysis.margins.lines import Line, codes_along, divided
from pipeline.analysis.margins.options import Design
from pipeline.analysis.margins.worst import Corner, corners
from pipeline.errors import StoreError
from pipeline.plan.plan import Plan
from pipeline.plane.regions import stored_curves
from pipeline.plane.stored import StoredPlane
from solver import domain_label

__all__ = ["SAFE", "Answer", "answer", "line_through"]

#: One motion, whose teeth never part.
SAFE = "1/0"
#: In so many rows and columns a safe box is looked at once more.
_CHECKED = 15


@dataclass(frozen=True)
class Answer:
    """What is known about a design point.

    Parameters
    ----------
    plan : Plan
    design : Design
    label : str
        n/I at the point; empty where labels cannot be had.
    row : Line
        The swept axis at the point's p.
    margins : tuple of Margin
    box : Box or None
        The largest safe box around the operating range, or around the point alone where the range is not safe.
    boxed : Design
        What the box was asked to hold.
    corners : tuple of Corner
        Labels within the tolerances.
    notes : tuple of str
        What these answers do and do not say.
    """

    plan: Plan
    design: Design
    label: str
    row: Line
    margins: tuple[Margin, ...]
    box: Box | None
    boxed: Design
    corners: tuple[Corner, ...]
    notes: tuple[str, ...]


def answer(path: Path, plan: Plan, design: Design) -> Answer:
    """Ask a stored plane about a design point.

    Parameters
    ----------
    path : Path
        The store, its boundaries traced.
    plan : Plan
        The store's own.
    design : Design

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
    first_order = plan.solver["balance"] == "describing_function"
    row = line_through(boundaries, plan, design, P, first_order)
    column = line_through(boundaries, plan, design, X, first_order)
    label = domain_label(row.within(design.x, design.x)[0].code)
    margins = margins_of_axis(row, column, plan, design)
    if design.low < design.high:
        margins += nearest_over_range(boundaries, plan, design, design.p)
    notes, found = [], []
    if first_order:
        for name in design.further:
            margins += margins_of_further(plan, design, name)
        found = corners(plan, design, stored_curves(plane))
        if len(found) > 1:
            notes.append(
                "Further parameters are looked at with all of them at the ends of their tolerances; between "
                "those nothing is proven."
            )
    else:
        order = plan.solver["order"]
        notes.append(
            f"At order {order} solutions cannot be enumerated: "
            "distances to the stored folds and grazings and the largest box free of them are given, "
            "without labels, tolerances or parameters that are no axis of the plane."
        )
    box, boxed, said = _box(boundaries, plan, design, row, label, first_order)
    return Answer(plan, design, label, row, tuple(margins), box, boxed, tuple(found), (*said, *notes))


def line_through(boundaries: Boundaries, plan: Plan, design: Design, held: int, labelled: bool) -> Line:
    """The line through the point along which the other axis than `held` (3: x, 4: p) changes."""
    axis, value = (plan.parameter, design.x) if held == X else (plan.sweep, design.p)
    ends = axis.low, axis.high
    codes = codes_along(plan, axis.name, ends, design.x, design.p) if labelled else None
    return divided(*boundaries.along(held, value), ends, codes)


def _box(boundaries, plan, design, row, label, labelled) -> tuple[Box | None, Design, list[str]]:
    """The largest box, what it holds, and what is to be said of it."""
    boxed, said = design, []
    name = plan.sweep.name
    if labelled and label != SAFE:
        return None, design, [f"There is no safe box: the design point's label is {label or 'not decided'}."]
    if len(row.within(design.low, design.high)) > 1:
        boxed = dataclasses.replace(design, low=design.x, high=design.x)
        said.append(
            f"No safe box holds the operating range {name} = {design.low:g} ... {design.high:g}, which "
            "boundaries cross; the box is the largest around the design point."
        )
    box = largest_box(boundaries, plan, boxed)
    if not box.area > 0.0:
        return None, boxed, ["There is no safe box: the design point lies on a boundary."]
    if labelled and (unlike := _unlike(plan, box)):
        # Where a motion passes the amplitude ceiling no boundary is stored.
        return None, boxed, [f"The largest box free of boundaries is not all {SAFE}: {unlike}."]
    return box, boxed, said


def _unlike(plan: Plan, box: Box) -> str:
    """Where a box has another label than the safe one, as far as rows and columns show; empty if nowhere."""
    inside = (np.arange(_CHECKED) + 0.5) / _CHECKED
    columns = box.x[0] + (box.x[1] - box.x[0]) * inside
    ends = plan.sweep.low, plan.sweep.high
    for p in box.p[0] + (box.p[1] - box.p[0]) * inside:
        codes = codes_along(plan, plan.sweep.name, ends, float(columns[0]), float(p))(columns)
        for x, code in zip(columns, codes.tolist(), strict=True):
            if code and domain_label(code) != SAFE:
                return f"{domain_label(code)} at {plan.sweep.name} = {x:.6g}, {plan.parameter.name} = {p:.6g}"
    return ""
