"""One table as data, whatever format it is written in: the study's cells beside ours, and what was measured."""

from dataclasses import dataclass

from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.plan.plan import Plan
from pipeline.plane.regions import stored_regions
from pipeline.plane.resonances import Resonance, common_resonances
from pipeline.plane.stored import read_stored
from pipeline.study.agreement import AGREES, DIFFERS, NOT_COMPARED
from pipeline.study.tables.article import ArticleTable, Band, Column, band_range, band_rows
from pipeline.study.tables.bands import BandAtResonance, band_at_resonance
from pipeline.study.tables.claims import Entry, Verdict, judge
from pipeline.study.tables.classes import ASPECTS
from pipeline.study.tables.lacking import lacking_in
from pipeline.study.tables.rows import RowPeak, row_peaks
from solver.regions import RegionError, Regions

__all__ = ["Cell", "LabelRange", "Line", "Row", "Table", "build_table"]


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
    """

    band: Band
    resonance: Resonance
    measured: BandAtResonance | None
    gap: str


@dataclass(frozen=True)
class Cell:
    """One cell of the study's table.

    Parameters
    ----------
    wording : str
        The study's.
    ours : dict of str to str
        What is measured at the resonances that the wording speaks of, in the words of `classes`.
    verdict : Verdict
    """

    wording: str
    ours: dict[str, str]
    verdict: Verdict


@dataclass(frozen=True)
class Row:
    """One row of the study's table: a band, its cells, and the measurements at either resonance behind them."""

    band: Band
    cells: tuple[Cell, ...]
    lines: tuple[Line, Line]


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
    rows : tuple of Row
        Of the study's table.
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
    rows: tuple[Row, ...]
    failed: int
    labels: tuple[LabelRange, ...]
    undivided: str

    @property
    def lines(self) -> tuple[Line, ...]:
        """Every band at the mesh and then at the shaft resonance."""
        return tuple(line for row in self.rows for line in row.lines)

    @property
    def tally(self) -> dict[str, int]:
        """How many cells agree, differ and cannot be compared."""
        kinds = [cell.verdict.kind for row in self.rows for cell in row.cells]
        return {kind: kinds.count(kind) for kind in (AGREES, DIFFERS, NOT_COMPARED)}


def build_table(article: ArticleTable, path: Place, whole: Regions | None = None) -> Table:
    """Measure a stored plane and class it.

    Parameters
    ----------
    article : ArticleTable
    path : Place
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
    rows: list[Row] = []
    before: dict[str, BandAtResonance] = {}
    for band in article.bands:
        numbers = band_rows(band, plan.parameter)
        peaks = row_peaks(plane, numbers)
        here, lines = {}, []
        for number, resonance in enumerate(pair):
            gap = _gap(article, band, plan, resonance) or undivided
            if not gap:
                chosen: list[RowPeak] = [pair_of_row[number] for pair_of_row in peaks.values()]
                ends = band_range(band, plan.parameter)
                window = resonance.window(plan.sweep.low, plan.sweep.high)
                here[resonance.name] = band_at_resonance(
                    parts[resonance.name],
                    resonance,
                    *ends,
                    chosen,
                    lacking_in(plane, window, ends),
                    numbers.size - len(peaks),
                    article.sign,
                )
            lines.append(Line(band, resonance, here.get(resonance.name), gap))
        cells = tuple(
            Cell(entry.wording, _ours(column, entry, lines), judge(entry, here, before))
            for column, entry in zip(article.columns, band.entries, strict=True)
        )
        rows.append(Row(band, cells, tuple(lines)))
        before = here
    failed = int((~plane.complete).sum())
    labels = _labels(whole, [parts.get(one.name) for one in pair]) if whole else ()
    return Table(article, plan, path.name, plane.about["configuration_hash"], tuple(rows), failed, labels, undivided)


def _ours(column: Column, entry: Entry, lines: list[Line]) -> dict[str, str]:
    """What is measured at the resonances that an entry speaks of."""
    named = {name for claim in entry.claims for name in claim.resonances} or {line.resonance.name for line in lines}
    return {
        line.resonance.name: "; ".join(ASPECTS[aspect](line.measured) for aspect in column.aspects)
        if line.measured
        else line.gap
        for line in lines
        if line.resonance.name in named
    }


def _parts(path: Place, plan: Plan, pair, whole: Regions | None) -> tuple[dict[str, Regions], Regions | None, str]:
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
