"""A table as CSV for machines: one row per band and resonance, numbers at full precision, nan where nothing exists."""

import csv
import io
from collections.abc import Sequence

import numpy as np

from pipeline.tables.bands import BandAtResonance
from pipeline.tables.edges import Edge, nearest_edge
from pipeline.tables.rows import RowAtResonance
from pipeline.tables.table import Line, Table
from solver import ImpactState

__all__ = ["tidy"]

_STATE_NAMES = tuple(f"share_{state.name.lower()}" for state in ImpactState)


def tidy(table: Table) -> str:
    """The table's text."""
    text = io.StringIO()
    records = [_record(table, line) for line in table.lines]
    writer = csv.DictWriter(text, fieldnames=list(records[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(records)
    return text.getvalue()


def _record(table: Table, line: Line) -> dict[str, str]:
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
    record["labels"] = " ".join(label for label, _ in line.measured.labels) if line.measured else ""
    record["label_shares"] = (
        " ".join(f"{line.measured.share(count):.6g}" for _, count in line.measured.labels) if line.measured else ""
    )
    for i, column in enumerate(table.article.columns):
        name = column.heading.lower().replace(" ", "_")
        record[f"class_{name}"] = line.classes[i] if line.classes else ""
        record[f"article_{name}"] = line.band.wording[i]
    return {name: _text(value) for name, value in record.items()}


def _text(value) -> str:
    # Ten digits are more than the events' accuracy of 1e-9, and the same text on every machine.
    return f"{value:.10g}" if isinstance(value, float) else str(value)


_NUMBERS = (
    "rows", "failed_rows", "first_value", "last_value",
    "jump_rows", "intervals_per_row", "jump_low", "jump_high", "jump_first_low", "jump_first_high", "jump_last_low",
    "jump_last_high", "widest", "widest_relative", "first_width_relative", "last_width_relative",
    *(f"{what}_{kind}_{end}" for what in ("jump", "contact_loss", "double_sided")
      for kind in ("appears", "ends") for end in ("low", "high")),
    "peak_rows", "peak_omega_first", "peak_omega_last", "peak_amplitude_first", "peak_amplitude_last",
    "shift_percent_first", "shift_percent_last", "shift_percent_min", "shift_percent_max",
    "cells", *_STATE_NAMES, "share_unstable", "share_without_stable", "open_cells",
)  # fmt: skip


def _numbers(band: BandAtResonance) -> dict[str, object]:
    """Every number of `_NUMBERS`; shares and relative widths as fractions, of 1 and of the natural frequency."""
    peaks, shifts = [row.peak for row in band.peak_rows], [100.0 * shift for shift in band.shifts]
    numbers = {
        "rows": len(band.rows), "failed_rows": band.failed,
        "first_value": band.values[0], "last_value": band.values[-1],
        "jump_rows": band.jump_rows, "intervals_per_row": band.intervals_per_row,
        "widest_relative": max(band.widths), "widest": max(band.widths) * band.resonance.natural,
        "first_width_relative": band.widths[0], "last_width_relative": band.widths[-1],
        "peak_rows": len(peaks), "cells": band.cells, "open_cells": band.open,
        "share_unstable": band.share(band.unstable), "share_without_stable": band.share(band.without_stable),
        **{name: band.share(count) for name, count in zip(_STATE_NAMES, band.states, strict=True)},
    }  # fmt: skip
    intervals = {"jump": band.envelope, "jump_first": _ends(band.rows[0]), "jump_last": _ends(band.rows[-1])}
    for name, ends in intervals.items():
        numbers[f"{name}_low"], numbers[f"{name}_high"] = ends
    for what, found in (
        ("jump", band.jump_edges),
        ("contact_loss", band.contact_loss_edges),
        ("double_sided", band.double_sided_edges),
    ):
        numbers.update(_edge_numbers(what, found, band.values[0], band.values[-1]))
    if peaks:
        numbers |= {
            "peak_omega_first": peaks[0].omega, "peak_omega_last": peaks[-1].omega,
            "peak_amplitude_first": peaks[0].amplitude, "peak_amplitude_last": peaks[-1].amplitude,
            "shift_percent_first": shifts[0], "shift_percent_last": shifts[-1],
            "shift_percent_min": min(shifts), "shift_percent_max": max(shifts),
        }  # fmt: skip
    return numbers


def _ends(row: RowAtResonance) -> tuple[float, float]:
    """Lowest and highest frequency of a row's intervals, nan without one."""
    return (row.intervals[0][0], row.intervals[-1][1]) if row.intervals else (np.nan, np.nan)


def _edge_numbers(what: str, found: Sequence[Edge], first: float, last: float) -> dict[str, float]:
    numbers = {}
    for kind, appears in (("appears", True), ("ends", False)):
        edge = nearest_edge(found, appears, first, last)
        if edge:
            numbers[f"{what}_{kind}_low"], numbers[f"{what}_{kind}_high"] = edge.low, edge.high
    return numbers
