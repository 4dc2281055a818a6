"""The reproduction report: one HTML page that needs nothing else, and the same as Markdown with figures beside it."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.study.report.contents import document_of
from pipeline.study.report.document import Picture
from pipeline.study.report.html import html
from pipeline.study.report.markdown import FIGURES, markdown
from pipeline.study.report.sources import Source, missing, sources_of

__all__ = ["missing", "sources_of", "write"]


def write(sources: Sequence[Source], folder: Path) -> list[Path]:
    """Write `report.html`, `report.md` and the figures of the latter; the same bytes from the same stores.

    Parameters
    ----------
    sources : sequence of Source
        None of them missing.
    folder : Path
        Made if it does not exist.
    """
    document = document_of(sources)
    pictures = [block for block in document.blocks if isinstance(block, Picture)]
    figures = folder / FIGURES
    figures.mkdir(parents=True, exist_ok=True)
    contents = {folder / "report.html": html(document).encode(), folder / "report.md": markdown(document).encode()}
    contents |= {figures / f"{picture.name}.png": picture.png for picture in pictures}
    for path, content in contents.items():
        draft = path.with_name(f".{path.name}.draft")
        draft.write_bytes(content)
        draft.replace(path)
    return list(contents)
