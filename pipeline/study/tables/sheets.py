"""A table laid out for reading: the study's grid with ours beside it; in an appendix what was measured, and notes."""

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.errors import counted
from pipeline.study.agreement import THRESHOLD_AGREES
from pipeline.study.numerals import percent
from pipeline.study.tables import wording
from pipeline.study.tables.claims import READINGS
from pipeline.study.tables.classes import RULES
from pipeline.study.tables.table import Cell, Line, Table

__all__ = ["APPENDIX", "Sheet", "grid_sheet", "label_sheet", "measured_sheet", "notes", "tally", "title"]

#: Heading of what stands behind the grid.
APPENDIX = "Appendix: what was measured"


@dataclass(frozen=True)
class Sheet:
    """Plain text cells, of one or several lines, under headings; every row has as many cells as there are headings.

    Parameters
    ----------
    caption : str
    headings : tuple of str
    widths : tuple of float
        Share of the page's width that each column wants, together 1.
    rows : tuple of tuple of str
    grouped : bool
        Whether rows with the same first cell belong together.
    """

    caption: str
    headings: tuple[str, ...]
    widths: tuple[float, ...]
    rows: tuple[tuple[str, ...], ...]
    grouped: bool = True


def title(table: Table) -> str:
    """Heading of the whole table."""
    return f"Effect of the {table.article.words} {table.article.sign}"


def tally(tables: Sequence[Table]) -> str:
    """How many cells of one or several tables agree, differ and cannot be compared."""
    counts = {kind: sum(table.tally[kind] for table in tables) for kind in tables[0].tally}
    numbers = [str(table.article.number) for table in tables]
    which = f"Table {numbers[0]}" if len(numbers) == 1 else f"Tables {', '.join(numbers[:-1])} and {numbers[-1]}"
    agree, differ, open_ = counts.values()
    return f"{which}, {sum(counts.values())} cells: agrees {agree}, differs {differ}, cannot be compared {open_}."


def grid_sheet(table: Table) -> Sheet:
    """The study's own table: in every cell its words, ours, whether they agree, and why."""
    headings = (table.article.sign, *(column.heading for column in table.article.columns))
    rows = tuple((row.band.text, *map(_cell, row.cells)) for row in table.rows)
    return Sheet(title(table), headings, (0.08, *[0.92 / (len(headings) - 1)] * (len(headings) - 1)), rows)


def _cell(cell: Cell) -> str:
    if len(cell.ours) > 1 and len(set(cell.ours.values())) == 1:
        ours = [f"ours: {next(iter(cell.ours.values()))}"]
    else:
        ours = [f"ours, {name}: {text}" for name, text in cell.ours.items()]
    return "\n".join([f"“{cell.wording}”", *ours, f"{cell.verdict.kind}: {cell.verdict.reason}"])


def measured_sheet(table: Table) -> Sheet:
    """One row per band and resonance with what was measured."""
    sign = table.article.sign
    headings = (
        sign,
        "Resonance",
        "Jumps in Ω",
        "Widest jump",
        "Impact states I",
        "Labels n/I",
        "Peak shift",
        "Appears and ends",
    )
    rows = []
    for line in table.lines:
        if line.measured is None:
            cells = (line.gap, *["–"] * (len(headings) - 3))
        else:
            band = line.measured
            cells = (
                wording.jumps(band),
                wording.jump_size(band),
                wording.impact_states(band),
                wording.labels(band),
                wording.peak_shift(band),
                wording.changes(band, sign),
            )
        rows.append((_band(line), f"{line.resonance.name}, Ω = {line.resonance.natural:.4f}", *cells))
    widths = (0.09, 0.12, 0.17, 0.10, 0.10, 0.15, 0.10, 0.17)
    return Sheet(f"{title(table)}, as measured", headings, widths, tuple(rows))


def label_sheet(table: Table) -> Sheet:
    """One row per n/I label with its share of the plane and where it appears and disappears at either resonance."""
    mesh, shaft = table.lines[0].resonance, table.lines[1].resonance
    ranges = (f"{table.article.sign} at the {resonance.name} resonance" for resonance in (mesh, shaft))
    headings = ("Label n/I", "Share of the plane", *ranges)
    rows = [
        (entry.label, percent(entry.share), *(wording.ranges(part) for part in entry.ranges)) for entry in table.labels
    ] or [("–", "–", table.undivided, "–")]
    caption = f"{title(table)}: labels n/I from the boundary curves, in {table.article.sign}"
    return Sheet(caption, headings, (0.15, 0.2, 0.325, 0.325), tuple(rows), False)


def _band(line: Line) -> str:
    """The band's heading with the rows whose peaks were read."""
    band = line.measured
    if band is None:
        return line.band.text
    rows = [row.value for row in band.peaks]
    if line.band.single:
        return f"{line.band.text} (peak: {'nearest row ' + format(rows[0], '.4g') if rows else 'no row'})"
    failed = f", {band.failed} more failed" if band.failed else ""
    return f"{line.band.text} (up to {band.region.high:g}; {counted(len(rows), 'row')}{failed})"


def _readings(table: Table) -> tuple[str, ...]:
    """How the study's wordings are read, entry by entry."""
    found = {}
    for band in table.article.bands:
        for entry in band.entries:
            claims: dict[str, list[str]] = {}
            for claim in entry.claims:
                claims.setdefault(READINGS[claim.rule], []).append(" or ".join(claim.resonances))
            parts = [f"{reading} ({' and '.join(dict.fromkeys(where))})" for reading, where in claims.items()]
            text = "; ".join(parts) or "not compared"
            found[f"“{entry.wording}”"] = f"{text}; {entry.unclear}" if entry.unclear else text
    return tuple(f"{wording} is read as: {text}." for wording, text in found.items())


def notes(table: Table) -> tuple[str, ...]:
    """How the wordings are read, rules, definitions and source."""
    plan, sign = table.plan, table.article.sign
    mesh, shaft = table.lines[0].resonance, table.lines[1].resonance
    gear = ", ".join(f"{name} = {_plain(value)}" for name, value in sorted(plan.gear.items()))
    failed = f"; {table.failed} of {plan.parameter.num} rows failed and are left out" if table.failed else ""
    unbounded = sum(row.open for line in table.lines if line.measured for row in line.measured.peaks)
    aspects = dict.fromkeys(aspect for column in table.article.columns for aspect in column.aspects)
    return (
        "A cell agrees if all that its words are taken to say holds, at one of the resonances named; a threshold "
        f"within {percent(THRESHOLD_AGREES)} of the article's. Of a cell that differs, what does not hold is given.",
        *_readings(table),
        *(RULES[aspect] for aspect in aspects),
        f"Resonances: mesh (lower) and shaft (upper) are the article's words for the linear natural frequencies Ω = "
        f"{mesh.natural:.4f} and {shaft.natural:.4f}; the Ω axis is split at their geometric mean, {mesh.high:.4f}. "
        "All percentages of frequencies are of the linear natural frequency.",
        "Shares are of the area of the band in the resonance's part of the Ω axis, of a single value of its length; a "
        "state counts wherever a stable motion has it, so that states may add up to more than 100 %.",
        "Jumps are intervals of Ω in which several motions are statically stable, at the first and the last value of "
        "the band; the widest is sought there and in the plane's rows. A peak is the largest stable λ_a, provided that "
        "it falls below 1/√2 of it on both sides, in the plane's rows.",
        "Jumps, impact and labels follow from the boundary curves and the enumeration of all first-order motions "
        "between them, which no raster enters. Thresholds are given to four digits; the CSV has ten.",
        f"Source: store {table.store}, configuration_hash {table.configuration_hash}, {plan.parameter.num} rows "
        f"{sign} = {plan.parameter.low:g}–{plan.parameter.high:g} x {plan.sweep.num} columns Ω = "
        f"{plan.sweep.low:g}–{plan.sweep.high:g}{failed}.",
        f"Gear: {gear}.",
        *(
            [f"In {unbounded} rows a branch leaves through the amplitude ceiling; what lies above is not excluded."]
            if unbounded
            else []
        ),
    )


def _plain(value) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_plain(entry) for entry in value)}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
