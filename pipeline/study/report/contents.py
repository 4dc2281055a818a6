"""What the report says: every section made from stored planes, no number typed in."""

from collections.abc import Iterator, Sequence

from pipeline.errors import StoreError
from pipeline.plane.regions import stored_regions
from pipeline.plane.stored import read_stored
from pipeline.store import read_plan
from pipeline.study.numerals import percent
from pipeline.study.report.comparison import appendix, differences, numbers, summary, tables
from pipeline.study.report.document import Document, Grid, Heading, Listing, Paragraph, Picture
from pipeline.study.report.pictures import pictures_of
from pipeline.study.report.sources import COMPARED, STUDY_PLANES, Source
from pipeline.study.report.trust import dynamic_grid, integration, verified_grid
from pipeline.study.statements import STATEMENTS, Planes, evaluate
from pipeline.study.statements.quantities import RowFolds
from pipeline.study.tables.article import ARTICLE_TABLES
from pipeline.study.tables.table import build_table
from solver.regions import RegionError, Regions

__all__ = ["document_of"]

#: Rows whose curves the study discusses, and the words for what it says about them.
CURVES = {
    "omega_b": ((0.1, 0.6, 0.98), "small backlash, and the two at which the study sees the mesh resonance change"),
    "omega_fe": ((0.12, 0.21, 0.34), "the transmission errors at which the study sees new domains"),
    "omega_alpha": ((0.25, 0.4), "the ends of the study's two ranges"),
    "omega_fpm": ((0.5, 0.57, 0.75), "the ends of the study's two ranges"),
}
_TITLE = "Solution domains of a straight bevel gear pair: the published study recomputed"


def document_of(sources: Sequence[Source], again: str) -> Document:
    """The whole report.

    Parameters
    ----------
    sources : sequence of Source
        None of them missing.
    again : str
        The command that makes the page from them.
    """
    study = {source.plane: source for source in sources if source.gear == "published"}
    # Dividing a plane into regions takes seconds, and three sections need them.
    planes = Planes({plane: source.path for plane, source in study.items()})
    found = tuple(evaluate(statement, planes) for statement in STATEMENTS)
    made = [
        build_table(article, study[article.plane].path, _divided(study[article.plane], planes))
        for article in ARTICLE_TABLES
    ]
    blocks = [
        *summary(found),
        *numbers(found),
        *differences(found),
        *tables(made),
        *_maps(study),
        *_gears(sources, planes),
        *_trust(study),
        *appendix(made),
        *_making(sources, again),
    ]
    return Document(_TITLE, tuple(blocks))


def _maps(study: dict[str, Source]) -> Iterator:
    yield Heading("Maps and curves")
    for plane in STUDY_PLANES:
        values, words = CURVES[plane]
        plan = read_plan(study[plane].path)
        kept = [value for value in values if plan.parameter.low <= value <= plan.parameter.high]
        pictures = pictures_of(study[plane].path, ("map", "curves", "backbone"), kept)
        axes = f"{plan.sweep.name} × {plan.parameter.name}"
        yield Heading(f"Plane {axes}", 3)
        yield Picture(f"{plane}-map", f"Solution domains over {axes}.", pictures["map"])
        shown = ", ".join(f"{value:g}" for value in kept)
        yield Picture(
            f"{plane}-curves", f"Amplitude and mean at {plan.parameter.name} = {shown}: {words}.", pictures["curves"]
        )
        if plane == COMPARED and "backbone" in pictures:
            yield Picture(f"{plane}-backbone", "Backbones, and the peaks of the rows.", pictures["backbone"])


def _gears(sources: Sequence[Source], planes: Planes) -> Iterator:
    yield Heading("What other readings of the model change")
    yield Paragraph(
        "In the published set the stiffness varies in the translation rows only, and direction and coupling are free "
        "numbers. The set consistent takes both from the geometry and lets one mesh force drive all rows, as the "
        "physics wants it; antiphase turns the phase between stiffness and transmission error by half a turn. All "
        f"three over {COMPARED}:"
    )
    compared = [source for source in sources if source.plane == COMPARED]
    divided = [_divided(source, planes) for source in compared]
    shares = [found.shares if found else {} for found in divided]
    labels = sorted({label for found in shares for label in found})
    rows = [
        (f"share of {label}", *(percent(found[label]) if label in found else "–" for found in shares))
        for label in labels
    ]
    if not all(divided):
        rows.append(("", *("" if found else "its boundaries do not divide the plane" for found in divided)))
    rows.append(("folds at the default parameters", *(_folds(source.gear) for source in compared)))
    yield Grid(
        "Shares of the plane's area by label, from the boundary curves, and folds of the default row (Ω).",
        ("", *(source.gear for source in compared)),
        tuple(rows),
    )
    for source in compared:
        if source.gear != "published":
            picture = pictures_of(source.path, ("map",), None)["map"]
            yield Picture(f"{COMPARED}-{source.gear}-map", f"Solution domains of the set {source.gear}.", picture)


def _divided(source: Source, planes: Planes) -> Regions | None:
    """The regions of a plane; None where its boundaries do not divide it."""
    try:
        return planes.whole(source.plane) if source.gear == "published" else stored_regions(source.path)
    except (StoreError, RegionError):
        return None


def _folds(gear: str) -> str:
    return ", ".join(f"{omega:.6f}" for omega in RowFolds(gear).values(Planes({}))[::3]) or "none"


def _trust(study: dict[str, Source]) -> Iterator:
    yield Heading("How far first order can be trusted")
    yield Paragraph(
        "The study balances one harmonic and calls a motion stable that lies outside its folds. The monodromy matrix "
        "also sees period doubling and Neimark–Sacker bifurcations. Where it contradicts the folds, the order is too "
        "low: the first-order orbit is no true one there."
    )
    yield dynamic_grid({plane: source.path for plane, source in study.items()})
    for source in study.values():
        if source.verified:
            yield Paragraph(integration(source.path, source.plane))
            yield verified_grid(source.path)
            picture = pictures_of(source.path, ("verification",), None)["verification"]
            yield Picture(f"{source.plane}-verification", "Where the first-order map can be trusted.", picture)


def _making(sources: Sequence[Source], again: str) -> Iterator:
    yield Heading("How this page was made")
    commands = [*(source.command for source in sources), again]
    yield Paragraph("The commands, in this order; the last one with report.run=true runs those before it as needed:")
    yield Listing("\n".join(commands))
    rows, versions = [], {}
    for source in sources:
        attributes = read_stored(source.path).about
        rows.append((source.path.name, attributes["configuration_hash"], str(attributes["bevelmap_schema"])))
        versions.setdefault(tuple(sorted(attributes["versions"].items())), []).append(source.path.stem)
    yield Grid("Stores.", ("Store", "Configuration hash", "Schema"), tuple(rows))
    for held, names in versions.items():
        computed = "them" if len(versions) == 1 else ", ".join(names)
        yield Grid(f"Versions that computed {computed}.", ("Package", "Version"), held)
    yield Listing(sources[0].settings.yaml(), f"Configuration of {sources[0].plane}")
