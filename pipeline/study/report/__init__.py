"""The reproduction report: one HTML page that needs nothing else, and the same as Markdown with figures beside it."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.run.sheets import write_files
from pipeline.study.report.contents import document_of
from pipeline.study.report.document import Picture
from pipeline.study.report.html import html
from pipeline.study.report.markdown import FIGURES, markdown
from pipeline.study.report.sources import Source, missing, sources_of

__all__ = ["missing", "sources_of", "write"]


def write(sources: Sequence[Source], folder: Path, again: str) -> list[Path]:
    """Write `report.html`, `report.md` and the figures of the latter; the same bytes from the same stores.

    Parameters
    ----------
    sources : sequence of Source
        None of them missing.
    folder : Path
        Made if it does not exist.
    again : str
        The command that makes the page from these sources, for the reader.
    """
    document = document_of(sources, again)
    pictures = [block for block in document.blocks if isinstance(block, Picture)]
    texts = {"report.html": html(document), "report.md": markdown(document)}
    return write_files(folder, texts | {f"{FIGURES}/{picture.name}.png": picture.png for picture in pictures})
