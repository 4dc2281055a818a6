"""What a page tells in words, as HTML: nothing that comes from outside stands in it as markup."""

import html
from collections.abc import Sequence

from pipeline.analysis.margins.distances import Margin
from pipeline.analysis.margins.sheets import margin_cells
from pipeline.analysis.motion.motions import Motions
from pipeline.analysis.motion.wording import quantity_text
from pipeline.config.quantities import QUANTITIES
from pipeline.explorer.plain_text import plain
from pipeline.figures.naming import symbol, value_text
from pipeline.figures.palette import hex_colour, label_colour, text_colour
from pipeline.plan.plan import Plan
from pipeline.plane.motions import SolvedMotions
from solver import ImpactState, Scales
from solver.stability import Instability

__all__ = ["chip", "found_by_integration", "margin_table", "motion_table", "place_text", "table"]

#: Of the motions at a place.
_COLUMNS = ("amplitude", "mean", "rms", "dynamic_factor", "contact_loss", "impact_velocity")


def chip(label: str) -> str:
    """An n/I label in its colour on the map."""
    colour = label_colour(label)
    style = f"background:{hex_colour(colour)};color:{text_colour(colour)}"
    return f'<span class="chip" style="{style}">{html.escape(label.replace("/-", "/–")) or "?"}</span>'


def place_text(plan: Plan, place: tuple[float, float], scales: Scales | None) -> str:
    """A place: both parameters with their values."""
    names = (plan.sweep.name, plan.parameter.name)
    return ", ".join(plain(value_text(name, value, scales)) for name, value in zip(names, place, strict=True))


def found_by_integration(found: Motions) -> str:
    """The attractors at a place and how many random starts each of them drew, in one line."""
    parts = [f"{html.escape(one.label)} ({one.hits} of {found.starts} starts)" for one in found.attractors]
    for number, word in ((found.unsettled, "not settled"), (found.unbounded, "unbounded")):
        parts += [f"{number} {word}"] if number else []
    return f"Integration finds {', '.join(parts) or 'nothing that settles'}."


def motion_table(found: SolvedMotions, scales: Scales | None) -> str:
    """The motions of the map at a place with their stability and the quantities that are asked for first."""
    heads = ["", "stability", "teeth", *(QUANTITIES[name].label for name in _COLUMNS)]
    rows = []
    for i in range(len(found.amplitude)):
        values = [_quantity(name, found, i, scales) for name in _COLUMNS]
        rows.append([str(i + 1), _stability(found, i), _STATES[ImpactState(int(found.impact[i]))], *values])
    return table(heads, rows)


_STATES = {
    ImpactState.PERMANENT: "in contact",
    ImpactState.SINGLE_SIDED: "part",
    ImpactState.DOUBLE_SIDED: "part, backs struck",
    ImpactState.FREE: "never touch",
    ImpactState.MIRRORED_SINGLE_SIDED: "backs part",
    ImpactState.MIRRORED_PERMANENT: "backs in contact",
}
_GROWS = {
    Instability.PERIOD_DOUBLING: "doubles its period",
    Instability.NEIMARK_SACKER: "turns quasi-periodic",
    Instability.UNDECIDED: "undecided",
    Instability.CONTRADICTORY: "contradictory: the order is too low",
}


def _stability(found: SolvedMotions, i: int) -> str:
    if found.stable[i] != 1:
        return "unstable"
    return _GROWS.get(Instability(int(found.instability[i])), "stable")


def _quantity(name: str, found: SolvedMotions, i: int, scales: Scales | None) -> str:
    one = QUANTITIES[name]
    own = {"amplitude": found.amplitude}
    value = float(own[name][i] if name in own else found.quantities[i, one.slot])
    return quantity_text(one, value, scales)


def margin_table(margins: Sequence[Margin], plan: Plan, scales: Scales | None) -> str:
    """Distances to the nearest changes of label."""
    rows = []
    for one in margins:
        name, _, of, way, distance, kind, at, beyond = margin_cells(one, plan.sweep.name, scales)
        at = f"{kind} at {plain(symbol(plan.sweep.name))} = {at}" if kind else ""
        name = f"{plain(symbol(name))} {way}{' of the range' if of == 'range' else ''}"
        rows.append([html.escape(name), html.escape(distance), html.escape(at), chip(beyond) if beyond else ""])
    return table(["", "distance", "boundary", "beyond"], rows, escaped=True)


def table(heads: Sequence[str], rows: Sequence[Sequence[str]], escaped: bool = False) -> str:
    """A table; its cells are text, or markup of this module where `escaped` says so."""
    text = (lambda cell: cell) if escaped else html.escape
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in heads)
    body = "".join(f"<tr>{''.join(f'<td>{text(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class="wide"><table class="plain"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'
