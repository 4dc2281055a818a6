"""Margins: what a stored plane says of a design point with its operating range and tolerances."""

from pathlib import Path

from pipeline.analysis.margins.answer import Answer, answer
from pipeline.analysis.margins.options import Design, design_of
from pipeline.analysis.margins.sheets import lines, markdown, tidy
from pipeline.run.sheets import write_files

__all__ = ["Answer", "Design", "answer", "design_of", "lines", "write_sheets"]


def write_sheets(found: Answer, folder: Path, name: str) -> list[Path]:
    """Write `<name>.md` and `<name>.csv`; the same bytes from the same store."""
    return write_files(folder, {f"{name}.md": markdown(found, name), f"{name}.csv": tidy(found)})
