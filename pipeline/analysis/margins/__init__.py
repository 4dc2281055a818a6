"""Margins: what a stored plane says of a design point with its operating range and tolerances."""

from pathlib import Path

from pipeline.analysis.margins.answer import Answer, answer
from pipeline.analysis.margins.options import Design, design_of
from pipeline.analysis.margins.sheets import lines, markdown, tidy

__all__ = ["Answer", "Design", "answer", "design_of", "lines", "write_sheets"]


def write_sheets(found: Answer, folder: Path, name: str) -> list[Path]:
    """Write `<name>.md` and `<name>.csv`; the same bytes from the same store."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = {folder / f"{name}.md": markdown(found, name), folder / f"{name}.csv": tidy(found)}
    for path, text in texts.items():
        draft = path.with_name(f".{path.name}.draft")
        draft.write_text(text, encoding="utf-8", newline="\n")
        draft.replace(path)
    return list(texts)
