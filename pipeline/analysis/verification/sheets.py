"""In how many cells the map is right, per label: as CSV and as Markdown."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.verification.credibility import Credibility
from pipeline.analysis.verification.group import StoredVerification
from pipeline.analysis.verification.verdicts import Verdict
from pipeline.config.schema import Verify
from pipeline.plan.plan import Plan
from pipeline.run.sheets import csv_text, pipes, write_files
from solver import domain_label
from solver.timedomain import wilson_interval

__all__ = ["Line", "write_sheets", "region_lines"]


@dataclass(frozen=True)
class Line:
    """One region, or the whole plane.

    Parameters
    ----------
    label : str
        "all" for the whole plane.
    cells : int
    samples, confirmed : int
        Cells drawn for their label and integrated to an end; those in which every stable solution was confirmed.
    share, low, high : float
        Share of confirmed ones with its 95 % interval; nan without samples.
    classes : dict
        Credibility -> share of the cells.
    """

    label: str
    cells: int
    samples: int
    confirmed: int
    share: float
    low: float
    high: float
    classes: dict[Credibility, float]


def region_lines(domain: np.ndarray, found: StoredVerification) -> list[Line]:
    """One line per label, the largest region first, and one for the whole plane.

    Only cells that were drawn for their label count as samples: those beside boundaries are the hard ones. The share of
    the plane weighs the labels by their cells; its interval combines theirs by the square root of summed squares
    (G. Y. Zou, A. Donner, Statistics in Medicine 27 (2008) 1693-1702).
    """
    samples, judged = found.samples, found.layers["credibility"]
    cell = samples["row"].astype(np.int64) * domain.shape[1] + samples["column"]
    fair = samples["stratified"] == 1
    right: dict[int, bool] = {}
    for place, verdict in zip(cell[fair].tolist(), samples["verdict"][fair].tolist(), strict=True):
        right[place] = right.get(place, True) and verdict == Verdict.CONFIRMED
    # A cell with a solution of which nothing is known tells nothing.
    for place in cell[fair & np.isin(samples["verdict"], (Verdict.UNSETTLED, Verdict.FAILED))].tolist():
        right.pop(place, None)
    codes, sizes = np.unique(domain[domain != 0], return_counts=True)
    lines = []
    for i in np.argsort(-sizes, kind="stable"):
        here = [value for place, value in right.items() if domain.flat[place] == codes[i]]
        share = (sum(here) / len(here), *wilson_interval(sum(here), len(here))) if here else (math.nan,) * 3
        classes = _shares(judged[domain == codes[i]])
        lines.append(Line(domain_label(int(codes[i])), int(sizes[i]), len(here), sum(here), *share, classes))
    return [*lines, _total(lines, judged[domain != 0])]


def _shares(judged: np.ndarray) -> dict[Credibility, float]:
    return {kind: float(np.mean(judged == kind)) if judged.size else math.nan for kind in Credibility}


def _total(lines: list[Line], judged: np.ndarray) -> Line:
    sampled = [line for line in lines if line.samples]
    cells = sum(line.cells for line in sampled)
    share = low = high = math.nan
    if cells:
        weights = [line.cells / cells for line in sampled]
        share = sum(w * line.share for w, line in zip(weights, sampled, strict=True))
        down = math.sqrt(sum((w * (line.share - line.low)) ** 2 for w, line in zip(weights, sampled, strict=True)))
        up = math.sqrt(sum((w * (line.high - line.share)) ** 2 for w, line in zip(weights, sampled, strict=True)))
        low, high = max(share - down, 0.0), min(share + up, 1.0)
    totals = [sum(getattr(line, name) for line in lines) for name in ("cells", "samples", "confirmed")]
    return Line("all", *totals, share, low, high, _shares(judged))


def write_sheets(
    domain: np.ndarray, found: StoredVerification, plan: Plan, settings: Verify, folder: Path, name: str
) -> list[Path]:
    """Write `<name>.csv` and `<name>.md`; the same bytes from the same store."""
    lines = region_lines(domain, found)
    return write_files(
        folder, {f"{name}.csv": _csv(lines), f"{name}.md": _markdown(lines, found, plan, settings, name)}
    )


def _csv(lines: list[Line]) -> str:
    confirmed = ("confirmed_samples", "confirmed_share", "confirmed_low", "confirmed_high")
    header = ["label", "cells", "samples", *confirmed, *(kind.name.lower() for kind in Credibility)]
    rows = (
        [
            line.label,
            line.cells,
            line.samples,
            line.confirmed,
            *map(_number, (line.share, line.low, line.high, *line.classes.values())),
        ]
        for line in lines
    )
    return csv_text(header, rows)


def _number(value: float) -> str:
    return "" if math.isnan(value) else repr(value)


def _percent(value: float) -> str:
    return "–" if math.isnan(value) else f"{100.0 * value:.1f} %"


def _markdown(lines: list[Line], found: StoredVerification, plan: Plan, settings: Verify, name: str) -> str:
    classes = [kind.words.capitalize() for kind in Credibility]
    head = ["Label n/I", "Cells", "Samples", "Confirmed by integration", *classes]
    rows = []
    for line in lines:
        share = _percent(line.share)
        if line.samples:
            share += f" ({_percent(line.low)[:-2]}–{_percent(line.high)})"
        rows.append([line.label, str(line.cells), str(line.samples), share, *map(_percent, line.classes.values())])
    table = pipes(head, rows, numbers_from=1)
    orders = " and ".join(map(str, found.orders)) if found.orders else "none: the map's own order is too high"
    x, p = plan.sweep, plan.parameter
    verdicts = [f"{np.sum(found.samples['verdict'] == kind)} {kind.name.lower().replace('_', ' ')}" for kind in Verdict]
    failed_rows = int(np.sum(found.row_messages != ""))
    notes = [
        f"Plane: {x.name} = {x.low:g}–{x.high:g} ({x.num} columns), {p.name} = {p.low:g}–{p.high:g} ({p.num} rows); "
        f"configuration_hash {plan.digest}; balance {plan.solver['balance'].replace('_', ' ')}, "
        f"order {plan.solver['order']}.",
        f"Confirmed by integration: of the cells drawn for their label (seed {settings.seed}), those in which a motion "
        "started on every stable solution settles on a motion that repeats as the map says, with mean and amplitude "
        f"within {settings.tolerance:g} of gap + static deflection and the same impact state; Wilson 95 % interval. "
        "Cells with an unsettled or failed integration are left out. The last line weighs labels by their cells.",
        f"Integrated at most {settings.max_periods} forcing periods. All {found.samples['verdict'].size} integrations, "
        f"those beside boundaries included: {', '.join(verdicts)}.",
        f"The other columns are shares of all cells of the label. Orders compared: {orders}; rows that could not be "
        f"swept at them: {failed_rows}. Shifted: the map's label occurs at the higher order within {settings.delta:g} "
        "of the length of either axis. Not a period-1 motion: a solution counted by the label is dynamically unstable "
        "at the higher order, or integration from it ended on another kind of motion.",
        *(f"{kind.name.capitalize().replace('_', ' ')}: {kind.sentence}" for kind in Verdict),
    ]
    text = [f"# Verification of {name}", table, "\n".join(f"- {note}" for note in notes)]
    return "\n\n".join(text) + "\n"
