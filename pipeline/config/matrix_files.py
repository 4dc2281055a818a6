"""Matrices and vectors of a system from files: CSV files of numbers, or arrays of an NPZ file.

What is read comes from someone else's program: nothing is unpickled, and no file or array is read that is larger than
a system of the largest size needs.
"""

import csv
import zipfile

import numpy as np

from pipeline.config.number_files import NumbersError, read_bytes

__all__ = ["MOST_DEGREES", "numbers_of", "read_matrix", "read_npz"]

#: Coordinates of a system.
MOST_DEGREES = 40
#: Bytes of a file, and of an array in it.
_MOST_BYTES = 2_000_000
_LARGEST = 1e30


def read_matrix(path: str) -> np.ndarray:
    """A matrix or a vector from a CSV file without a header.

    Numbers are separated by commas, semicolons, tabs or spaces; complex ones are written 0.1-0.2j; lines that begin
    with # are comments. One column or one row is a vector.

    Parameters
    ----------
    path : str

    Raises
    ------
    NumbersError
        Saying what is wrong, with the line.
    """
    rows = []
    for number, line in enumerate(read_bytes(path, _MOST_BYTES).decode("utf-8-sig", errors="replace").splitlines(), 1):
        text = line.partition("#")[0].strip()
        if text:
            row = next(csv.reader([text.replace(";", ",").replace("\t", ",")]))
            words = row if len(row) > 1 else text.split()
            rows.append([_number(word, f"line {number}") for word in words])
            if len(rows[-1]) != len(rows[0]):
                raise NumbersError(f"line {number} has {len(rows[-1])} numbers, the first one has {len(rows[0])}")
    if not rows:
        raise NumbersError("it is empty")
    array = np.array(rows)
    return array.ravel() if 1 in array.shape else array


def read_npz(path: str) -> dict[str, np.ndarray]:
    """All arrays of an NPZ file, by name.

    Parameters
    ----------
    path : str

    Raises
    ------
    NumbersError
        If it is none, an array holds no numbers, or is too large.
    """
    read_bytes(path, _MOST_BYTES)
    try:
        with zipfile.ZipFile(path) as archive:
            for entry in archive.infolist():
                if entry.file_size > _MOST_BYTES:
                    raise NumbersError(f"{entry.filename[:40]!r} in it is larger than {_MOST_BYTES / 1e6:g} MB")
        with np.load(path, allow_pickle=False) as found:
            return {name: numbers_of(found[name], infinite=name == "back_gap") for name in found.files}
    except (OSError, ValueError, zipfile.BadZipFile, KeyError, EOFError) as error:
        raise NumbersError(f"it must be an NPZ file of numbers ({' '.join(str(error).split())[:80]})") from None


def numbers_of(value, infinite: bool = False) -> np.ndarray:
    """Finite real or complex numbers of an array or of nested lists; texts in these are complex numbers.

    Parameters
    ----------
    value : array or list
    infinite : bool
        Whether numbers may be infinite.

    Raises
    ------
    NumbersError
        If it is nothing of the kind.
    """
    try:
        array = np.array(_parsed(value))
    except ValueError:
        raise NumbersError("its rows must be of one length") from None
    if (
        array.dtype.kind not in "iufc"
        or array.size == 0
        or not np.all((np.abs(array) < _LARGEST) | (infinite & np.isinf(array)))
    ):
        raise NumbersError("it must hold finite numbers")
    return array


def _parsed(value):
    if isinstance(value, list):
        return [_parsed(one) for one in value]
    return _number(value, "an entry") if isinstance(value, str) else value


def _number(text: str, where: str) -> complex | float:
    try:
        number = complex(text.strip().replace(" ", ""))
    except ValueError:
        raise NumbersError(f"{where}: {text[:40]!r} must be a number") from None
    if not abs(number) < _LARGEST:
        raise NumbersError(f"{where}: {text[:40]!r} must be a finite number")
    return number if number.imag else number.real
