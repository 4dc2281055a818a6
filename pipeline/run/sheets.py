"""Results as files of text: CSV, and tables in Markdown. A file appears under its name only when it is whole."""

import csv
import io
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

__all__ = ["csv_text", "escaped", "exact_text", "number_text", "pipes", "sentence", "write_files"]

_MARKUP = re.compile(r"[\\|*`]|<(?=[A-Za-z/!?])")


def write_files(folder: Path, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Write files into a folder, in place of what was there.

    Parameters
    ----------
    folder : Path
        Made if it does not exist.
    contents : mapping
        Name, which may have a folder in it -> text, written as UTF-8, or bytes.

    Returns
    -------
    list of Path
        In the same order.
    """
    paths = []
    for name, content in contents.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        draft = path.with_name(f".{path.name}.draft")
        draft.write_bytes(content.encode() if isinstance(content, str) else content)
        draft.replace(path)
        paths.append(path)
    return paths


def csv_text(header: Sequence, lines: Iterable[Sequence]) -> str:
    """Lines under a header as CSV.

    Examples
    --------
    >>> csv_text(["omega", "label"], [[0.5, "2/0-1"]])
    'omega,label\\n0.5,2/0-1\\n'
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(lines)
    return stream.getvalue()


def exact_text(value) -> str:
    """A cell of CSV: numbers to ten digits, nothing for one that there is not.

    Examples
    --------
    >>> exact_text(1.0 / 3.0), exact_text(float("nan")), exact_text(7), exact_text("2/0-1")
    ('0.3333333333', '', '7', '2/0-1')
    """
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.10g}"
    return str(value)


def number_text(value: float, digits: int = 3) -> str:
    """A number to so many digits, as people write it.

    Examples
    --------
    >>> number_text(14400.0), number_text(-0.0312), number_text(2.5e7), number_text(1.25e-6)
    ('14400', '−0.0312', '2.5e+07', '1.25e−06')
    """
    text = f"{value:.{digits}g}"
    if "e+" in text and abs(value) < 1e6:
        text = f"{float(text):.0f}"
    return text.replace("-", "\N{MINUS SIGN}")


def sentence(text: str) -> str:
    """A text as a sentence of its own.

    Examples
    --------
    >>> sentence("regions are drawn as cells"), sentence("Nothing.")
    ('Regions are drawn as cells.', 'Nothing.')
    """
    return f"{text[0].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"


def escaped(text: str) -> str:
    """Text that no reader of Markdown takes for markup; underscores inside words are none."""
    return _MARKUP.sub(lambda match: f"\\{match[0]}", text)


def _cell(text: str) -> str:
    return escaped(text).replace("\n", "<br>")


def pipes(headings: Sequence[str], rows: Iterable[Sequence[str]], numbers_from: int | None = None) -> str:
    """A pipe table of plain text; lines of a cell are kept.

    Parameters
    ----------
    headings : sequence of str
    rows : iterable of sequence of str
    numbers_from : int, optional
        The first of the columns that are aligned to the right.

    Examples
    --------
    >>> print(pipes(["label", "cells"], [["2/0-1", "7"]], numbers_from=1))
    | label | cells |
    | --- | ---: |
    | 2/0-1 | 7 |
    """
    left = len(headings) if numbers_from is None else numbers_from
    ruler = ["---"] * left + ["---:"] * (len(headings) - left)
    lines = [map(escaped, headings), ruler, *(map(_cell, cells) for cells in rows)]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)
