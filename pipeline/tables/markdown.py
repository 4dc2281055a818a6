"""A table as Markdown: three pipe tables and a list of notes."""

import re

from pipeline.tables.sheets import Sheet, class_sheet, label_sheet, measured_sheet, notes, title
from pipeline.tables.table import Table

__all__ = ["markdown"]

_MARKUP = re.compile(r"[\\|*`]|<(?=[A-Za-z/!?])")


def markdown(table: Table) -> str:
    """The table's text."""
    parts = [
        f"# Table {table.article.number}: {_escape(title(table))}",
        "## Measured",
        _pipes(measured_sheet(table)),
        "## In words",
        _pipes(class_sheet(table)),
        "## Labels",
        _pipes(label_sheet(table)),
        "## Notes",
        "\n".join(f"- {_escape(note)}" for note in notes(table)),
    ]
    return "\n\n".join(parts) + "\n"


def _pipes(sheet: Sheet) -> str:
    rows = [sheet.headings, ("---",) * len(sheet.headings), *sheet.rows]
    lines = ["| " + " | ".join(cells) + " |" for cells in ([_escape(cell) for cell in row] for row in rows)]
    return "\n".join(lines)


def _escape(text: str) -> str:
    """Text that no reader of Markdown takes for markup; underscores inside words are safe."""
    return _MARKUP.sub(lambda match: f"\\{match[0]}", text)
