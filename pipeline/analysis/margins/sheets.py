"""Answers about a design point as CSV, Markdown and plain lines; the same text from the same store."""

from pipeline.analysis.margins.answer import IN_CONTACT, Answer
from pipeline.analysis.margins.distances import Margin
from pipeline.analysis.margins.integration import Largest
from pipeline.analysis.margins.worst import severity
from pipeline.plan.scales import scales_of
from pipeline.run.sheets import csv_text, exact_text, pipes, sentence
from pipeline.store import axis_attributes
from solver import Event, Scales, domain_label

__all__ = ["lines", "margin_cells", "markdown", "tidy"]

#: What happens on a boundary, in words.
KINDS = {
    Event.FOLD: "fold",
    Event.MIN_AT_DRIVE: "grazing, drive flanks begin to part",
    Event.MIN_AT_BACK: "grazing, back flanks begin to touch",
    Event.MAX_AT_DRIVE: "grazing, drive flanks begin to touch",
    Event.MAX_AT_BACK: "grazing, back flanks begin to part",
    Event.PERIOD_DOUBLING: "period doubling",
    Event.NEIMARK_SACKER: "Neimark-Sacker",
    # Where a motion passes the amplitude ceiling, and at higher orders where a curve could not be followed.
    Event.NONE: "no stored boundary",
}
#: What CSV gives in physical units besides, where the gear has them.
_MEASURED = ("value", "low", "high", "distance")
_MARGIN_HEADINGS = ("parameter", "unit", "of", "direction", "distance", "boundary")
_FIELDS = (
    "item",
    "parameter",
    "unit",
    "of",
    "direction",
    "value",
    "low",
    "high",
    "distance",
    "boundary",
    "at",
    "label",
    "labels",
    "share",
    "text",
    "physical_unit",
    *(f"physical_{name}" for name in _MEASURED),
)


def tidy(answer: Answer) -> str:
    """One line per answer, numbers to ten digits."""
    scales = scales_of(answer.plan)
    records = (_with_physical(record, scales) for record in _records(answer))
    return csv_text(_FIELDS, ([exact_text(record.get(field, "")) for field in _FIELDS] for record in records))


def _with_physical(record: dict, scales: Scales | None) -> dict:
    """A record of CSV with its numbers in the unit of the gear as well."""
    name = record.get("parameter")
    if scales is None or name not in scales:
        return record
    measured = {f"physical_{key}": record[key] * scales[name].shown for key in _MEASURED if key in record}
    return {**record, "physical_unit": scales[name].unit, **measured}


def _shown(name: str, value: float, scales: Scales | None) -> str:
    """A value or a distance to six digits with its unit, and in that of the gear where it has one: "0.9 (2650 rpm)"."""
    if scales is None or name not in scales:
        return f"{value:.6g}" if _unit(name) == "1" else f"{value:.6g} {_unit(name)}"
    return f"{value:.6g} ({value * scales[name].shown:.5g} {scales[name].unit})"


def _records(answer: Answer):
    design, sweep, parameter = answer.design, answer.plan.sweep.name, answer.plan.parameter.name
    for name, value in ((sweep, design.x), (parameter, design.p)):
        yield {"item": "point", "parameter": name, "unit": _unit(name), "value": value, "label": answer.label}
    for stretch in answer.row.within(design.low, design.high) if design.low < design.high else ():
        yield {
            "item": "label in range",
            "parameter": sweep,
            "unit": _unit(sweep),
            "low": stretch.low,
            "high": stretch.high,
            "label": domain_label(stretch.code),
        }
    yield from ({"item": "known", "label": answer.label, "text": text} for text in answer.sentences)
    yield {"item": "verified", "label": answer.label, "text": "; ".join(answer.doubts) or "yes"}
    for item, margin in (*(("margin", one) for one in answer.margins), *(("stability", one) for one in answer.losses)):
        record = {
            "item": item,
            "parameter": margin.name,
            "unit": _unit(margin.name),
            "of": _of(margin),
            "direction": "up" if margin.upward else "down",
        }
        if margin.place is None:
            yield {**record, "high" if margin.upward else "low": margin.limit, "boundary": "none"}
        else:
            yield {
                **record,
                "value": margin.place,
                "distance": margin.distance,
                "boundary": KINDS[margin.kind],
                "at": margin.at,
                "label": domain_label(margin.beyond),
            }
    if answer.box is not None:
        for name, (low, high) in ((sweep, answer.box.x), (parameter, answer.box.p)):
            yield {
                "item": "box",
                "parameter": name,
                "unit": _unit(name),
                "low": low,
                "high": high,
                "share": answer.box.area,
                "label": answer.label,
            }
    for one in answer.resonances:
        yield {"item": "resonance in box", "parameter": sweep, "unit": _unit(sweep), "value": one.omega}
    for one in _largest(answer):
        place = {"item": f"largest in box: {one.name}", "value": one.value}
        yield {**place, "at": one.x, "low": one.p, "high": one.p}
    for corner in answer.corners:
        shown = " ".join(f"{name}={value:.10g}" for name, value in corner.values.items())
        yield {"item": "tolerances", "parameter": shown, "label": corner.labels[0], "labels": " ".join(corner.labels)}
    if answer.corners:
        yield {"item": "worst", "label": _worst(answer)}


def _largest(answer: Answer) -> tuple[Largest, ...]:
    """The largest values of the motions that integration found in the box."""
    return next((one.found.largest for one in answer.known if one.of_box and one.found is not None), ())


def _largest_sentence(answer: Answer) -> str:
    """What was largest in the box; empty without a box or attractors in it."""
    parts = [
        f"{one.name} {100.0 * one.value:.3g} %" if one.unit == "%" else f"{one.name} {one.value:.4g}"
        for one in _largest(answer)
    ]
    return f"largest in the box, of all motions that integration found: {', '.join(parts)}" if parts else ""


def _resonance_sentence(answer: Answer) -> str:
    """Over which resonances the box lies; empty if over none."""
    if not answer.resonances:
        return ""
    return f"the box lies over resonances of the linear pair: {', '.join(one.words for one in answer.resonances)}"


def _verdict(answer: Answer) -> str:
    """Whether the label is verified, and if not, why and how it can be."""
    if answer.doubts:
        return f"Not verified: {'; '.join(answer.doubts)}."
    return f"Verified by integration in these cells, not between them. {answer.known[0].found.bound}"


def _unit(name: str) -> str:
    return axis_attributes(name)["units"]


def _of(margin: Margin) -> str:
    return "range" if margin.of_range else "point"


def _worst(answer: Answer) -> str:
    labels = {label for corner in answer.corners for label in corner.labels}
    return max(labels, key=lambda label: (severity(label), label))


def markdown(answer: Answer, name: str) -> str:
    """The answers for a reader, numbers to six digits."""
    design, sweep, parameter = answer.design, answer.plan.sweep.name, answer.plan.parameter.name
    scales = scales_of(answer.plan)
    x, p = _shown(sweep, design.x, scales), _shown(parameter, design.p, scales)
    parts = [f"# Margins of {sweep} = {x}, {parameter} = {p} in {name}"]
    parts.append(f"Label at the design point: **{answer.label or 'not decided'}**. {_verdict(answer)}")
    parts.append(_bullets(f"{text[0].upper()}{text[1:]}" for text in answer.sentences))
    if design.low < design.high:
        rows = [
            [_shown(sweep, one.low, scales), _shown(sweep, one.high, scales), domain_label(one.code) or "-"]
            for one in answer.row.within(design.low, design.high)
        ]
        parts += [
            f"## Labels of the operating range, at {parameter} = {p}",
            pipes([f"{sweep} from", "to", "label"], rows),
        ]
    rows = [margin_cells(margin, sweep, scales) for margin in answer.margins]
    parts += ["## Distance to the nearest change of label", pipes([*_MARGIN_HEADINGS, f"at {sweep}", "beyond"], rows)]
    if answer.losses:
        rows = [margin_cells(margin, sweep, scales)[:-1] for margin in answer.losses]
        parts += ["## Distance to where a motion loses stability", pipes([*_MARGIN_HEADINGS, f"at {sweep}"], rows)]
    if answer.box is not None:
        sides = ((sweep, answer.box.x), (parameter, answer.box.p))
        rows = [[name, _shown(name, low, scales), _shown(name, high, scales)] for name, (low, high) in sides]
        title = f"Largest box of {IN_CONTACT} at {answer.known[0].source}, {100.0 * answer.box.area:.4g} % of the plane"
        parts += [f"## {title}", pipes(["parameter", "from", "to"], rows)]
        said = [text for text in (_largest_sentence(answer), _resonance_sentence(answer)) if text]
        parts += [_bullets(map(sentence, said))] if said else []
    if answer.corners:
        rows = [
            [
                ", ".join(f"{key} = {_shown(key, value, scales)}" for key, value in one.values.items()) or "nominal",
                ", ".join(one.labels),
            ]
            for one in answer.corners
        ]
        where = f"{sweep} = {_shown(sweep, design.low, scales)} ... {_shown(sweep, design.high, scales)}, "
        where += f"{parameter} = {p} ± {_shown(parameter, design.tolerance, scales)}"
        parts += [
            f"## Labels over {where}, the worst first",
            pipes(["further parameters", "labels"], rows),
            f"Worst label within the tolerances, {answer.known[0].source}: **{_worst(answer)}**.",
        ]
    if answer.notes:
        parts += ["## Notes", _bullets(answer.notes)]
    return "\n\n".join(parts) + "\n"


def _bullets(texts) -> str:
    return "\n".join(f"- {text}" for text in texts)


def margin_cells(margin: Margin, sweep: str, scales: Scales | None) -> list[str]:
    cells = [margin.name, _unit(margin.name), _of(margin), "up" if margin.upward else "down"]
    if margin.place is None:
        limit = _shown(margin.name, margin.limit, scales)
        return [*cells, f"none {'up' if margin.upward else 'down'} to {limit}", "", "", ""]
    beyond = domain_label(margin.beyond) or "-"
    distance, at = _shown(margin.name, margin.distance, scales), _shown(sweep, margin.at, scales)
    return [*cells, distance, KINDS[margin.kind], at, beyond]


def lines(answer: Answer) -> list[str]:
    """The answers as aligned lines for the terminal."""
    design, sweep, parameter = answer.design, answer.plan.sweep.name, answer.plan.parameter.name
    scales = scales_of(answer.plan)
    x, p = _shown(sweep, design.x, scales), _shown(parameter, design.p, scales)
    found = [f"  label at {sweep} = {x}, {parameter} = {p}: {answer.label or 'not decided'}"]
    found += [f"  {text}" for text in (*answer.sentences, _verdict(answer))]
    if design.low < design.high and answer.label:
        parts = answer.row.within(design.low, design.high)
        ends = [[_shown(sweep, end, scales) for end in (one.low, one.high)] for one in parts]
        told = ", ".join(f"{domain_label(one.code)} {' ... '.join(end)}" for one, end in zip(parts, ends, strict=True))
        found.append(f"  labels of the range: {told}")
    table = [
        [name, of, f"{direction}:", distance, kind and f"{kind} at {sweep} = {at}", beyond and f"beyond: {beyond}"]
        for name, _, of, direction, distance, kind, at, beyond in (
            margin_cells(margin, sweep, scales) for margin in (*answer.margins, *answer.losses)
        )
    ]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for row in table:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        found.append(f"  {'  '.join(cells).rstrip()}")
    if answer.box is not None:
        left, right = (_shown(sweep, end, scales) for end in answer.box.x)
        low, high = (_shown(parameter, end, scales) for end in answer.box.p)
        found.append(
            f"  largest box of {IN_CONTACT} at {answer.known[0].source}: {sweep} = {left} ... {right}, "
            f"{parameter} = {low} ... {high}"
        )
        found += [f"  {text}" for text in (_largest_sentence(answer), _resonance_sentence(answer)) if text]
    if answer.corners:
        found.append(f"  worst label within the tolerances, {answer.known[0].source}: {_worst(answer)}")
    return [*found, *(f"  note: {note}" for note in answer.notes)]
