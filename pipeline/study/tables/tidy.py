"""A table as CSV: its cells, one a row; and what was measured, a band and resonance a row, nan where nothing is."""

import numpy as np

from pipeline.run.sheets import csv_text
from pipeline.study.tables.bands import BandAtResonance
from pipeline.study.tables.edges import nearest_edge
from pipeline.study.tables.table import Line as TableLine
from pipeline.study.tables.table import Table
from solver import ImpactState
from solver.regions.bands import Line

__all__ = ["cells", "tidy"]

_STATE_NAMES = tuple(f"share_{state.name.lower()}" for state in ImpactState)


def cells(table: Table) -> str:
    """The study's cells with ours."""
    header = ("table", table.article.parameter, "column", "article", "ours_mesh", "ours_shaft", "verdict", "reason")
    lines = (
        (
            table.article.number,
            row.band.text,
            column.heading,
            cell.wording,
            *(cell.ours.get(name, "") for name in ("mesh", "shaft")),
            cell.verdict.kind,
            cell.verdict.reason,
        )
        for row in table.rows
        for column, cell in zip(table.article.columns, row.cells, strict=True)
    )
    return csv_text(header, lines)


def tidy(table: Table) -> str:
    """What was measured, numbers at full precision."""
    records = [_record(table, line) for line in table.lines]
    return csv_text(list(records[0]), (list(record.values()) for record in records))


def _record(table: Table, line: TableLine) -> dict[str, str]:
    record: dict[str, object] = {
        "table": table.article.number,
        "store": table.store,
        "configuration_hash": table.configuration_hash,
        "parameter": table.article.parameter,
        "band": line.band.text.replace("–", "-"),
        "resonance": line.resonance.name,
        "gap": line.gap.replace("–", "-").replace("Ω", "omega").replace("α", "alpha"),
        "natural_frequency": line.resonance.natural,
    }
    numbers = _numbers(line.measured) if line.measured else {}
    record.update((name, numbers.get(name, np.nan)) for name in _NUMBERS)
    shares = line.measured.region.shares if line.measured else {}
    record["labels"] = " ".join(shares)
    record["label_shares"] = " ".join(f"{share:.9g}" for share in shares.values())
    return {name: _text(value) for name, value in record.items()}


def _text(value) -> str:
    # Ten digits are more than the events' accuracy of 1e-9, and the same text on every machine.
    return f"{value:.10g}" if isinstance(value, float) else str(value)


_NUMBERS = (
    "low",
    "high",
    "rows",
    "failed_rows",
    "jump_height",
    "intervals_per_line",
    "jump_low",
    "jump_high",
    "jump_first_low",
    "jump_first_high",
    "jump_last_low",
    "jump_last_high",
    "widest",
    "widest_relative",
    "first_width_relative",
    "last_width_relative",
    *(f"{what}_{kind}" for what in ("jump", "contact_loss", "double_sided_impact") for kind in ("appears", "ends")),
    "peak_rows",
    "peak_omega_first",
    "peak_omega_last",
    "peak_amplitude_first",
    "peak_amplitude_last",
    "shift_percent_first",
    "shift_percent_last",
    "shift_percent_min",
    "shift_percent_max",
    *_STATE_NAMES,
    "share_several_stable",
    "share_without_stable_1T",
    "share_error",
    "open_rows",
)


def _numbers(band: BandAtResonance) -> dict[str, object]:
    """Every number of `_NUMBERS`; shares and relative widths as fractions, of 1 and of the natural frequency."""
    peaks, shifts = [row.peak for row in band.with_peak], [100.0 * row.shift for row in band.with_peak]
    numbers = {
        "low": band.region.low,
        "high": band.region.high,
        "rows": len(band.peaks),
        "failed_rows": band.failed,
        "jump_height": band.jump_height,
        "intervals_per_line": band.intervals_per_line,
        "widest_relative": max(band.widths),
        "widest": max(band.widths) * band.resonance.natural,
        "first_width_relative": band.widths[0],
        "last_width_relative": band.widths[-1],
        "peak_rows": len(peaks),
        "open_rows": sum(row.open for row in band.peaks),
        "share_several_stable": band.several,
        "share_without_stable_1T": band.lacking.share,
        "share_error": band.region.error,
        **{name: band.state_share(state) for name, state in zip(_STATE_NAMES, ImpactState, strict=True)},
    }
    intervals = {"jump": band.envelope, "jump_first": _ends(band, band.first), "jump_last": _ends(band, band.last)}
    for name, ends in intervals.items():
        numbers[f"{name}_low"], numbers[f"{name}_high"] = ends
    for trait, found in band.edges.items():
        for kind, appears in (("appears", True), ("ends", False)):
            edge = nearest_edge(found, appears, band.region.low, band.region.high)
            if edge:
                numbers[f"{trait.replace(' ', '_').replace('-', '_')}_{kind}"] = edge.value
    if peaks:
        numbers |= {
            "peak_omega_first": peaks[0].omega,
            "peak_omega_last": peaks[-1].omega,
            "peak_amplitude_first": peaks[0].amplitude,
            "peak_amplitude_last": peaks[-1].amplitude,
            "shift_percent_first": shifts[0],
            "shift_percent_last": shifts[-1],
            "shift_percent_min": min(shifts),
            "shift_percent_max": max(shifts),
        }
    return numbers


def _ends(band: BandAtResonance, line: Line) -> tuple[float, float]:
    """Lowest and highest frequency of a line's intervals, nan without one."""
    intervals = band.jumps(line)
    return (intervals[0][0], intervals[-1][1]) if intervals else (np.nan, np.nan)
