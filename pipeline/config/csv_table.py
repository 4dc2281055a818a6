"""A table of numbers from a CSV file as programs of several countries write it: header, rows, and nothing else.

Columns are separated by tabs, semicolons or commas; the decimal mark is a point, or a comma where columns are not
separated by commas; lines that begin with # are comments; the text is UTF-8 or Latin-1.
"""

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass

from pipeline.config.number_files import NumbersError, read_bytes

__all__ = ["Table", "read_table"]

_MOST_BYTES, _MOST_ROWS = 10_000_000, 100_000
_SEPARATORS = ("\t", ";", ",")
_LARGEST = 1e30
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


@dataclass(frozen=True)
class Table:
    """A header, and rows of as many finite numbers.

    Parameters
    ----------
    header : list of str
    lines : list of int
        Of the rows, in the file.
    rows : list of list of float
    """

    header: list[str]
    lines: list[int]
    rows: list[list[float]]


def read_table(path: str) -> Table:
    """Read a file.

    Parameters
    ----------
    path : str

    Raises
    ------
    NumbersError
        Naming the line, and what to write instead.
    """
    comments, entries = [], []
    for number, line in enumerate(_text(path).splitlines(), 1):
        if line.lstrip().startswith("#"):
            if not entries:
                comments.append((number, line.lstrip()[1:]))
        elif line.strip():
            entries.append((number, line))
    if not entries:
        raise NumbersError("it is empty")
    # Programs such as numpy.savetxt write the header as a comment.
    if comments and _of_numbers(entries[0][1]):
        entries.insert(0, comments[-1])
    if len(entries) > _MOST_ROWS + 1:
        raise NumbersError(f"it has {len(entries) - 1} rows, of which {_MOST_ROWS} are allowed")
    separator = next((one for one in _SEPARATORS if one in entries[0][1]), ",")
    (_, header), *rows = _split(entries, separator)
    for number, row in rows:
        if len(row) != len(header):
            hint = ": separate columns by ; where numbers have decimal commas" if separator == "," else ""
            raise NumbersError(f"line {number} has {len(row)} entries, the header has {len(header)}{hint}")
    texts = [text for _, row in rows for text in row]
    if separator != "," and any("," in text for text in texts):
        if any("." in text for text in texts):
            raise NumbersError("its numbers have both points and commas: write one of them, as decimal mark only")
        rows = [(number, [text.replace(",", ".") for text in row]) for number, row in rows]
    return Table(header, [number for number, _ in rows], [_numbers(header, *one) for one in rows])


def _text(path: str) -> str:
    data = read_bytes(path, _MOST_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    text = text.replace("\xa0", " ")
    if not all(c.isprintable() or c in "\t\r\n" for c in text):
        raise NumbersError("it must be a CSV file in UTF-8 or Latin-1")
    return text


def _split(entries: list[tuple[int, str]], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and entries of every line; none goes on in the next one."""
    for number, line in entries:
        try:
            (row,) = csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True)
        except (csv.Error, ValueError):
            raise NumbersError(f"line {number} is not of a CSV file") from None
        yield number, [text.strip() for text in row]


def _of_numbers(line: str) -> bool:
    """Whether a line begins with a number, so that it is no header."""
    return _NUMBER.match(line.strip().lstrip('"')) is not None


def _numbers(header: list[str], line: int, row: list[str]) -> list[float]:
    for name, text in zip(header, row, strict=True):
        if not _NUMBER.fullmatch(text) or abs(float(text)) > _LARGEST:
            raise NumbersError(f"line {line}: {name[:40]!r} = {text[:40]!r} must be a finite number")
    return [float(text) for text in row]
