"""The article against what is computed here: summary, numbers with their criteria, what differs and why, tables."""

from collections.abc import Iterator, Sequence

from pipeline.config.compose import compose
from pipeline.study.agreement import AGREES, NOT_COMPARED
from pipeline.study.report.document import Bullets, Grid, Heading, Listing, Paragraph
from pipeline.study.report.reasons import reason_of
from pipeline.study.statements import Evaluated
from pipeline.study.statements.planes import default_model, default_value
from pipeline.study.tables.sheets import APPENDIX, grid_sheet, label_sheet, measured_sheet, notes, tally, title
from pipeline.study.tables.table import Table

__all__ = ["appendix", "differences", "numbers", "summary", "tables"]


def summary(found: Sequence[Evaluated]) -> Iterator:
    """How many statements agree, on what grounds, and which of them cannot all hold."""
    ours = [one for one in found if one.statement.source == "article"]
    digits = [one for one in found if one.statement.source == "reference"]
    agree, exact = (sum(one.verdict == AGREES for one in part) for part in (ours, digits))
    gear = compose(["gear=published"]).config.gear
    yield Paragraph(
        f"Of the {len(ours)} statements of the article {agree} agree with what is computed here, each by the criterion "
        f"in its line. Two numbers of the model were calibrated on these {len(ours)}: the squared length of the "
        f"direction of the mesh force, σ = {gear.translation_coupling:g}, and the rotation coupling, c = "
        f"{gear.rotation_coupling:g}. {_conflicts(ours)}"
    )
    yield Paragraph(
        f"Of {len(digits)} sets of reference digits, on which two independent programs agree, {exact} are met to their "
        "last printed digit. The numbers in the columns here were computed from the stored planes when this page was "
        "made. n/I means n statically stable motions in the impact states I (0 the teeth never part, 1 they strike the "
        "drive flank, 2 they strike both); it is the article's sense of stable, and the balance is of first order."
    )


def _conflicts(ours: Sequence[Evaluated]) -> str:
    """Which statements no choice of numbers meets together; docs/physics.md, section 7.3."""
    by_key = {one.statement.key: one for one in ours}
    error, load = (by_key[key].article[0] for key in ("fe_shaft_1_1", "fpm_shaft_contact"))
    at_load, at_error = default_value("f_pm"), default_value("f_e")
    (lower, upper), geometric = (default_model(gear).mesh_modes() for gear in ("published", "consistent"))
    return (
        "Not all of them can hold at once: (a) as long as contact is never lost the system is linear, so that contact "
        "loss at the shaft resonance depends on f_e/f_pm alone, whatever the geometry; "
        f"f_e = {error:g} at f_pm = {at_load:g} (ratio {error / at_load:.3f}) contradicts f_pm = {load:g} at f_e = "
        f"{at_error:g} (ratio {at_error / load:.3f}). (b) With k = 1 the two resonances, where they are here, fix "
        f"σ = (1 − ω_1²)(ω_2² − 1) = {(1.0 - lower**2) * (upper**2 - 1.0):.2f}; consistent geometry has σ = 1 and its "
        f"upper resonance at Ω = {geometric[1]:.2f}. (c) Bilateral impact at the shaft resonance is out of reach at "
        f"the default load: the severest state here is I = {_here(by_key['bilateral_shaft'])}."
    )


def numbers(found: Sequence[Evaluated]) -> Iterator:
    """Article, here and reference side by side, with verdict and criterion."""
    yield Heading("The numbers: article, here, reference")
    rows = [(one.statement, _here(one), f"{one.verdict}: {one.reason}") for one in found]
    yield Grid(
        "The article's statements. Here: from boundary curves, which no raster enters. Reference: docs/physics.md, "
        "section 7, first order with the calibrated numbers.",
        ("Statement", "Article", "Here", "Reference", "Verdict"),
        tuple(
            (one.text, one.quantity.shown(one.article), here, one.reference or "–", verdict)
            for one, here, verdict in rows
            if one.source == "article"
        ),
    )
    yield Grid(
        "Reference digits: folds as Ω, λ_m, λ_a; solutions as λ_m, λ_a.",
        ("Statement", "Here", "Reference", "Verdict"),
        tuple(
            (one.text, here, one.quantity.shown(one.article), verdict)
            for one, here, verdict in rows
            if one.source == "reference"
        ),
    )
    how = "\n".join(f"{one.statement.text}: {one.statement.quantity.how}" for one in found)
    yield Listing(how, "How each number is computed")


def _here(one: Evaluated) -> str:
    return "–" if one.verdict == NOT_COMPARED else one.statement.quantity.shown(one.ours)


def differences(found: Sequence[Evaluated]) -> Iterator:
    """Every statement that does not agree, and why."""
    yield Heading("What differs, and why")
    yield Bullets(
        tuple(
            f"{one.statement.text}: article {one.statement.quantity.shown(one.statement.article)}, here {_here(one)}. "
            f"{reason_of(one)}"
            for one in found
            if one.verdict != AGREES
        )
    )


def tables(made: Sequence[Table]) -> Iterator:
    """The article's tables with ours in every cell."""
    yield Heading("Tables 1 to 3")
    yield Paragraph(tally(made))
    for table in made:
        yield Heading(f"Table {table.article.number}: {title(table)}", 3)
        sheet = grid_sheet(table)
        yield Grid(tally([table]), sheet.headings, sheet.rows)


def appendix(made: Sequence[Table]) -> Iterator:
    """What the tables were made of."""
    yield Heading(APPENDIX)
    for table in made:
        for sheet in (measured_sheet(table), label_sheet(table)):
            yield Grid(sheet.caption, sheet.headings, sheet.rows)
        yield Listing("\n".join(notes(table)), f"Notes to table {table.article.number}")
