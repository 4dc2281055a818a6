"""A table laid out for reading: a sheet of measurements, a sheet of classes beside the study's words, and notes."""

from dataclasses import dataclass

from pipeline.tables import wording
from pipeline.tables.classes import RULES, percent
from pipeline.tables.peaks import REGION_LEVEL
from pipeline.tables.table import Line, Table

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
    """

    caption: str
    headings: tuple[str, ...]
    widths: tuple[float, ...]
    rows: tuple[tuple[str, ...], ...]


def title(table: Table) -> str:
    """Heading of the whole table."""
    return f"Effect of the {table.article.words} {table.article.sign}"


def measured_sheet(table: Table) -> Sheet:
    """One row per band and resonance with what was measured."""
    sign = table.article.sign
    headings = (
        sign, "Resonance", "Jumps in Ω", "Rows with a jump; widest", "Impact states I", "Labels n/I", "Peak shift",
        "Appears and ends",
    )  # fmt: skip
    rows = []
    for line in table.lines:
        if line.measured is None:
            cells = (line.gap, *["–"] * (len(headings) - 3))
        else:
            band = line.measured
            cells = (
                wording.jumps(band), wording.jump_size(band), wording.impact_states(band), wording.labels(band),
                wording.peak_shift(band), wording.changes(band, sign),
            )  # fmt: skip
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
    return Sheet(caption, headings, (0.15, 0.2, 0.325, 0.325), tuple(rows))


def class_sheet(table: Table) -> Sheet:
    """One row per band and column of the study, with its wording and our class at either resonance."""
    rows = []
    for mesh, shaft in zip(table.lines[::2], table.lines[1::2], strict=True):
        for i, column in enumerate(table.article.columns):
            ours = (line.classes[i] if line.classes else line.gap for line in (mesh, shaft))
            rows.append((mesh.band.text, column.heading, f"“{mesh.band.wording[i]}”", *ours))
    headings = (table.article.sign, "Column", "Article's wording", "Mesh resonance", "Shaft resonance")
    return Sheet(f"{title(table)}, in words", headings, (0.10, 0.15, 0.20, 0.275, 0.275), tuple(rows))


def _band(line: Line) -> str:
    """The band's heading with the rows that it was read from."""
    band = line.measured
    if band is None:
        return line.band.text
    if line.band.single:
        return f"{line.band.text} (nearest row {band.values[0]:.4g})"
    failed = f", {band.failed} more failed" if band.failed else ""
    count = f"{len(band.rows)} row{'s' if len(band.rows) > 1 else ''}"
    return f"{line.band.text} ({count}, {band.values[0]:.4g}–{band.values[-1]:.4g}{failed})"


def notes(table: Table) -> tuple[str, ...]:
    """Source, definitions and rules."""
    plan, sign = table.plan, table.article.sign
    mesh, shaft = table.lines[0].resonance, table.lines[1].resonance
    gear = ", ".join(f"{name} = {_plain(value)}" for name, value in sorted(plan.gear.items()))
    failed = f"; {table.failed} of {plan.parameter.num} rows failed and are left out" if table.failed else ""
    unbounded = sum(line.measured.open for line in table.lines if line.measured)
    aspects = dict.fromkeys(aspect for column in table.article.columns for aspect in column.aspects)
    return (
        f"Source: store {table.store}, configuration_hash {table.configuration_hash}, "
        f"{plan.parameter.num} rows {sign} = {plan.parameter.low:g}–{plan.parameter.high:g} x {plan.sweep.num} "
        f"columns Ω = {plan.sweep.low:g}–{plan.sweep.high:g}{failed}. First-order balance, static stability.",
        f"Gear: {gear}.",
        f"Resonances: mesh (lower) and shaft (upper) by the linear natural frequencies Ω = {mesh.natural:.4f} and "
        f"{shaft.natural:.4f}; the Ω axis is split between them at their geometric mean, {mesh.high:.4f}.",
        "Jumps: intervals of Ω with more than one solution, stable or not, from the folds located on the branches; "
        "from the first to the last row of the band. Widths in brackets are relative to the linear natural frequency.",
        "Peak: the largest stable λ_a at the resonance, provided that the largest stable λ_a falls below 1/√2 of it on "
        "both sides; shift relative to the linear natural frequency.",
        "Region of a row: the cells around the peak in which the largest stable λ_a is at least "
        f"{percent(REGION_LEVEL)} of it, and on to the resonance's jumps; rows without peak and jump have none. Shares "
        "are of the region's cells, all rows of the band together; a state counts in every cell in which a stable "
        "motion has it, so that states may add up to more than 100 %.",
        f"Appears and ends: middle ± half the distance of the two rows between which it happens, in {sign}; within the "
        "band, or else nearest to it on either side. Contact loss and double-sided impact: of stable motions "
        "anywhere in the resonance's part of the Ω axis.",
        f"Labels: values of {sign} at which a label appears and disappears in the resonance's part of the Ω axis, and its "
        "share of the whole plane's area, from the boundary curves (fold and grazing, continued in two parameters) and the "
        "enumeration of all solutions between them, not from the raster. At the ends of the plane a label may go on.",
        *(RULES[aspect] for aspect in aspects),
        *([f"Solutions above the amplitude ceiling are not excluded in {unbounded} cells."] if unbounded else []),
    )


def _plain(value) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_plain(entry) for entry in value)}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
