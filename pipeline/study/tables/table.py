"""One table as data, whatever format it is written in: bands, what was measured in them, classes, verdicts, labels."""

from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import StoreError
from pipeline.plan.plan import Plan
from pipeline.plane.regions import stored_regions
from pipeline.plane.resonances import Resonance, common_resonances
from pipeline.plane.stored import read_stored
from pipeline.study.tables.article import ArticleTable, Band, band_range, band_rows
from pipeline.study.tables.bands import BandAtResonance, band_at_resonance
from pipeline.study.tables.claims import Verdict, judge
from pipeline.study.tables.classes import ASPECTS
from pipeline.study.tables.rows import RowPeak, row_peaks
from solver.regions import RegionError, Regions

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
    verdicts : tuple of Verdict
        One per column: the study's entry against both resonances of the band.
    """

    band: Band
    resonance: Resonance
    measured: BandAtResonance | None
    gap: str
    classes: tuple[str, ...]
    verdicts: tuple[Verdict, ...]


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


def build_table(article: ArticleTable, path: Path, whole: Regions | None = None) -> Table:
    """Measure a stored plane and class it.

    Parameters
    ----------
    article : ArticleTable
    path : Path
        A complete store of the table's plane.
    whole : Regions, optional
        Of the store, where the caller has divided the plane already.

    Raises
    ------
    StoreError
        If the natural frequencies move with the row parameter: the axis has no one split then.
    """
    plane = read_stored(path)
    plan = plane.plan
    pair = common_resonances(plan)
    if pair is None:
        raise StoreError(f"{path}: the natural frequencies move with {plan.parameter.name}, no one split serves")
    parts, whole, undivided = _parts(path, plan, pair, whole)
    rows = {band: band_rows(band, plan.parameter) for band in article.bands}
    lines: list[Line] = []
    before: dict[str, BandAtResonance] = {}
    for band in article.bands:
        peaks = row_peaks(plane, rows[band])
        here, gaps = {}, {}
        for number, resonance in enumerate(pair):
            gaps[resonance.name] = _gap(article, band, plan, resonance) or undivided
            if not gaps[resonance.name]:
                chosen: list[RowPeak] = [pair_of_row[number] for pair_of_row in peaks.values()]
                low, high = band_range(band, plan.parameter)
                here[resonance.name] = band_at_resonance(
                    parts[resonance.name], resonance, low, high, chosen, len(rows[band]) - len(peaks)
                )
        verdicts = tuple(judge(entry, here, before) for entry in band.entries)
        for resonance in pair:
            measured = here.get(resonance.name)
            classes = tuple(
                "; ".join(ASPECTS[aspect](measured) for aspect in column.aspects)
                for column in (article.columns if measured else ())
            )
            lines.append(Line(band, resonance, measured, gaps[resonance.name], classes, verdicts))
        before = here
    failed = int((~plane.complete).sum())
    labels = _labels(whole, [parts.get(one.name) for one in pair]) if whole else ()
    return Table(article, plan, path.name, plane.about["configuration_hash"], tuple(lines), failed, labels, undivided)


def _parts(path: Path, plan: Plan, pair, whole: Regions | None) -> tuple[dict[str, Regions], Regions | None, str]:
    """Regions of either resonance that the plane covers and of the whole plane, or why there are none."""
    axis = plan.sweep
    covered = [one for one in pair if axis.low < one.natural < axis.high]
    try:
        whole = stored_regions(path) if whole is None else whole
        return {one.name: whole.within(one.window(axis.low, axis.high)) for one in covered}, whole, ""
    except (RegionError, StoreError) as error:
        return {}, None, f"no regions of one label: {error}"


def _labels(whole: Regions, parts: list[Regions | None]) -> tuple[LabelRange, ...]:
    """Where every label exists."""
    return tuple(
        LabelRange(
            label,
            whole.shares[label],
            tuple(tuple((low, high) for low, high, _ in part.ranges((label,))) if part else () for part in parts),
        )
        for label in whole.labels
    )


def _gap(article: ArticleTable, band: Band, plan: Plan, resonance: Resonance) -> str:
    """Why a band cannot be measured in a plane, empty if it can."""
    axis = plan.parameter
    if band_range(band, axis) is None:
        return f"not covered by this plane: {article.sign} = {axis.low:g}–{axis.high:g}"
    if not plan.sweep.low < resonance.natural < plan.sweep.high:
        return f"not covered by this plane: Ω = {plan.sweep.low:g}–{plan.sweep.high:g}"
    return ""
