"""A table as Markdown: the study's grid, then an appendix of pipe tables and a list of notes."""

import re

from pipeline.run.sheets import escaped, pipes
from pipeline.study.agreement import AGREES, DIFFERS, NOT_COMPARED
from pipeline.study.tables.sheets import APPENDIX, Sheet, grid_sheet, label_sheet, measured_sheet, notes, tally, title
from pipeline.study.tables.table import Table

__all__ = ["markdown"]

_VERDICT = re.compile(f"<br>({AGREES}|{DIFFERS}|{NOT_COMPARED}):")


def markdown(table: Table) -> str:
    """The table's text."""
    parts = [
        f"# Table {table.article.number}: {escaped(title(table))}",
        escaped(tally([table])),
        _VERDICT.sub(r"<br>**\1**:", _pipes(grid_sheet(table))),
        f"## {APPENDIX}",
        _pipes(measured_sheet(table)),
        _pipes(label_sheet(table)),
        "## Notes",
        "\n".join(f"- {escaped(note)}" for note in notes(table)),
    ]
    return "\n\n".join(parts) + "\n"


def _pipes(sheet: Sheet) -> str:
    return pipes(sheet.headings, sheet.rows)
