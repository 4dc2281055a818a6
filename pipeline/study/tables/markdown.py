"""A table as Markdown: three pipe tables and a list of notes."""

from pipeline.run.sheets import escaped, pipes
from pipeline.study.tables.sheets import Sheet, class_sheet, label_sheet, measured_sheet, notes, title
from pipeline.study.tables.table import Table

__all__ = ["markdown"]


def markdown(table: Table) -> str:
    """The table's text."""
    parts = [
        f"# Table {table.article.number}: {escaped(title(table))}",
        "## Measured",
        _pipes(measured_sheet(table)),
        "## In words",
        _pipes(class_sheet(table)),
        "## Labels",
        _pipes(label_sheet(table)),
        "## Notes",
        "\n".join(f"- {escaped(note)}" for note in notes(table)),
    ]
    return "\n\n".join(parts) + "\n"


def _pipes(sheet: Sheet) -> str:
    return pipes(sheet.headings, sheet.rows)
