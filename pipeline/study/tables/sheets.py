"""A table laid out for reading: a sheet of measurements, a sheet of classes beside the study's words, and notes."""

from dataclasses import dataclass

from pipeline.study.agreement import THRESHOLD_AGREES
from pipeline.study.numerals import percent
from pipeline.study.tables import wording
from pipeline.study.tables.claims import READINGS
from pipeline.study.tables.classes import RULES
from pipeline.study.tables.table import Line, Table

__all__ = ["Sheet", "class_sheet", "label_sheet", "measured_sheet", "notes", "title"]


@dataclass(frozen=True)
class Sheet:
    """Plain text cells under headings; every row has as many cells as there are headings.

    Parameters
    ----------
    caption : str
    headings : tuple of str
    widths : tuple of float
        Share of the page's width that each column wants, together 1.
    rows : tuple of tuple of str
    spanner : (str, int, int), optional
        A heading over the columns start ... stop - 1.
    grouped : bool
        Whether rows with the same first cell belong together.
    """

    caption: str
    headings: tuple[str, ...]
    widths: tuple[float, ...]
    rows: tuple[tuple[str, ...], ...]
    spanner: tuple[str, int, int] | None = None
    grouped: bool = True


def title(table: Table) -> str:
    """Heading of the whole table."""
    return f"Effect of the {table.article.words} {table.article.sign}"


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
    headings = ("Label n/I", "Share of the plane", *(f"{r.name.capitalize()} resonance" for r in (mesh, shaft)))
    rows = [
        (entry.label, f"{100.0 * entry.share:.4f} %", *(wording.ranges(part) for part in entry.ranges))
        for entry in table.labels
    ] or [("–", "–", table.undivided, "–")]
    caption = f"{title(table)}: labels n/I from the boundary curves, in {table.article.sign}"
    return Sheet(caption, headings, (0.15, 0.2, 0.325, 0.325), tuple(rows), ("Range", 2, 4), False)


def class_sheet(table: Table) -> Sheet:
    """One row per band and column of the study, with its wording, our class at either resonance and the verdict."""
    rows = []
    for mesh, shaft in zip(table.lines[::2], table.lines[1::2], strict=True):
        for i, column in enumerate(table.article.columns):
            ours = (line.classes[i] if line.classes else line.gap for line in (mesh, shaft))
            wording = f"“{mesh.band.entries[i].wording}”"
            rows.append((mesh.band.text, column.heading, wording, *ours, mesh.verdicts[i].text))
    headings = (
        table.article.sign,
        "Column",
        "Article's wording",
        "Mesh resonance",
        "Shaft resonance",
        "Against the article",
    )
    widths = (0.08, 0.12, 0.15, 0.20, 0.20, 0.25)
    return Sheet(f"{title(table)}, in words", headings, widths, tuple(rows), ("Ours", 3, 5))


def _band(line: Line) -> str:
    """The band's heading with the rows whose peaks were read."""
    band = line.measured
    if band is None:
        return line.band.text
    rows = [row.value for row in band.peaks]
    if line.band.single:
        return f"{line.band.text} (peak: {'nearest row ' + format(rows[0], '.4g') if rows else 'no row'})"
    failed = f", {band.failed} more failed" if band.failed else ""
    count = f"{len(rows)} row{'' if len(rows) == 1 else 's'}"
    return f"{line.band.text} (up to {band.region.high:g}; {count}{failed})"


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
    return tuple(f"Reading of {wording}: {text}." for wording, text in found.items())


def notes(table: Table) -> tuple[str, ...]:
    """Source, definitions and rules."""
    plan, sign = table.plan, table.article.sign
    mesh, shaft = table.lines[0].resonance, table.lines[1].resonance
    gear = ", ".join(f"{name} = {_plain(value)}" for name, value in sorted(plan.gear.items()))
    failed = f"; {table.failed} of {plan.parameter.num} rows failed and are left out" if table.failed else ""
    unbounded = sum(row.open for line in table.lines if line.measured for row in line.measured.peaks)
    aspects = dict.fromkeys(aspect for column in table.article.columns for aspect in column.aspects)
    return (
        f"Source: store {table.store}, configuration_hash {table.configuration_hash}, "
        f"{plan.parameter.num} rows {sign} = {plan.parameter.low:g}–{plan.parameter.high:g} x {plan.sweep.num} "
        f"columns Ω = {plan.sweep.low:g}–{plan.sweep.high:g}{failed}. First-order balance, static stability.",
        f"Gear: {gear}.",
        f"Resonances: mesh (lower) and shaft (upper) by the linear natural frequencies Ω = {mesh.natural:.4f} and "
        f"{shaft.natural:.4f}; the Ω axis is split between them at their geometric mean, {mesh.high:.4f}.",
        "Everything but the peaks follows from the boundary curves (folds and grazings, continued in two parameters) "
        "and the enumeration of all solutions between them; the raster and its resolution do not enter.",
        "Jumps: intervals of Ω in which several motions are stable, with the unstable ones between; at the first and "
        "the last value of the band. Widths in brackets are relative to the linear natural frequency; the widest is "
        "sought at the band's ends and the plane's rows.",
        "Peak: the largest stable λ_a at the resonance, provided that the largest stable λ_a falls below 1/√2 of it on "
        "both sides; of the plane's rows in the band; shift relative to the linear natural frequency.",
        "Shares are of the area of the band in the resonance's part of the Ω axis, of a single value of its length; a "
        "state counts wherever a stable motion has it, so that states may add up to more than 100 %.",
        f"Appears and ends: values of {sign} in the band, or else nearest to it on either side. Contact loss and "
        "double-sided impact: of stable motions anywhere in the resonance's part of the Ω axis.",
        f"Labels: values of {sign} at which a label appears and disappears in the resonance's part of the Ω axis, and "
        "its share of the whole plane's area. At the ends of the plane a label may go on.",
        *(RULES[aspect] for aspect in aspects),
        f"Against the article: an entry agrees if all that it is taken to say holds, at one of the resonances named; a "
        f"threshold within {percent(THRESHOLD_AGREES)} of the article's.",
        *_readings(table),
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
