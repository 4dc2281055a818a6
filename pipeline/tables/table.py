"""One table as data, whatever format it is written in: bands, what was measured in them, their classes, and notes."""

from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from pipeline.errors import StoreError
from pipeline.plan import Plan
from pipeline.regions import label_occurrences
from pipeline.store import read_plan
from pipeline.tables.article import ArticleTable, Band, band_rows
from pipeline.tables.bands import BandAtResonance, band_at_resonance
from pipeline.tables.classes import ASPECTS
from pipeline.tables.rows import Resonance, measure_rows, resonances

__all__ = ["LabelRange", "Line", "Table", "build_table"]


@dataclass(frozen=True)
class Line:
    """One band at one resonance.

    Parameters
    ----------
    band : Band
    resonance : Resonance
    measured : BandAtResonance or None
    gap : str
        Why nothing is measured, else empty.
    classes : tuple of str
        One per column of the study's table; empty where nothing is measured.
    """

    band: Band
    resonance: Resonance
    measured: BandAtResonance | None
    gap: str
    classes: tuple[str, ...]


@dataclass(frozen=True)
class LabelRange:
    """Where one n/I label exists, from the boundary curves.

    Parameters
    ----------
    label : str
    share : float
        Of the area of the plane.
    ranges : tuple of tuple of (float, float)
        For the mesh and the shaft resonance: the unbroken ranges of the row parameter, ascending.
    """

    label: str
    share: float
    ranges: tuple[tuple[tuple[float, float], ...], ...]


@dataclass(frozen=True)
class Table:
    """One table: what the study says, what the store shows, and where that comes from.

    Parameters
    ----------
    article : ArticleTable
    plan : Plan
        Of the store that was read.
    store, configuration_hash : str
    lines : tuple of Line
        Every band at the mesh and then at the shaft resonance.
    failed : int
        Rows of the whole plane that failed.
    labels : tuple of LabelRange
        Empty where the boundaries do not divide the plane; `undivided` says why.
    undivided : str
    """

    article: ArticleTable
    plan: Plan
    store: str
    configuration_hash: str
    lines: tuple[Line, ...]
    failed: int
    labels: tuple[LabelRange, ...]
    undivided: str


def build_table(article: ArticleTable, path: Path) -> Table:
    """Measure a stored plane and class it.

    Parameters
    ----------
    article : ArticleTable
    path : Path
        A complete store of the table's plane.
    """
    plan = read_plan(path)
    rows = list(measure_rows(path, plan))
    lines = []
    for band in article.bands:
        chosen = band_rows(band, plan.parameter)
        for number, resonance in enumerate(resonances(plan)):
            gap = _gap(article, band, plan, resonance, chosen)
            if not gap and all(rows[row] is None for row in chosen):
                gap = f"all {len(chosen)} rows of this band failed"
            if gap:
                lines.append(Line(band, resonance, None, gap, ()))
                continue
            at_resonance = [None if row is None else row[number] for row in rows]
            measured = band_at_resonance(resonance, plan.parameter.values, at_resonance, chosen)
            classes = tuple(
                "; ".join(ASPECTS[aspect](measured) for aspect in column.aspects) for column in article.columns
            )
            lines.append(Line(band, resonance, measured, "", classes))
    with xr.open_zarr(path, chunks=None) as plane:
        digest = plane.attrs["configuration_hash"]
    failed = sum(row is None for row in rows)
    return Table(article, plan, path.name, digest, tuple(lines), failed, *_labels(path, plan))


def _labels(path: Path, plan: Plan) -> tuple[tuple[LabelRange, ...], str]:
    """Where every label exists, or why that cannot be told."""
    halves = [(max(r.low, plan.sweep.low), min(r.high, plan.sweep.high)) for r in resonances(plan)]
    if any(low >= high for low, high in halves):
        return (), "the plane does not cover both resonances"
    try:
        whole, *parts = label_occurrences(path, [None, *halves])
    except StoreError as error:
        return (), str(error)
    return tuple(
        LabelRange(
            label,
            sum(found.share for found in occurrences),
            tuple(tuple((o.appears, o.disappears) for o in part.get(label, ())) for part in parts),
        )
        for label, occurrences in whole.items()
    ), ""


def _gap(article: ArticleTable, band: Band, plan: Plan, resonance: Resonance, chosen) -> str:
    """Why a band cannot be measured in a plane, empty if it can."""
    axis = plan.parameter
    if len(chosen) == 0:
        overlap = band.low <= axis.high and band.high >= axis.low and not (band.above and axis.high <= band.low)
        reason = "no row of this plane lies in the band" if overlap else "not covered by this plane"
        return f"{reason}: {article.sign} = {axis.low:g}–{axis.high:g}" + (f" in {axis.num} rows" if overlap else "")
    if not plan.sweep.low < resonance.natural < plan.sweep.high:
        return f"not covered by this plane: Ω = {plan.sweep.low:g}–{plan.sweep.high:g}"
    return ""
