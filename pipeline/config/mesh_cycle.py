"""Mesh stiffness and transmission error over one mesh cycle, from the CSV file of a tooth-contact program."""

import csv
import math
import re
from dataclasses import asdict, dataclass
from pathlib import Path

from pipeline.config.units import unit_size
from pipeline.errors import ConfigurationError
from solver import CycleFit, ParameterError, fit_cycle

__all__ = ["MeshCycle", "read_mesh_cycle"]

KEY = "gear.physical.mesh_cycle"

#: Column -> kind of its unit.
COLUMNS = {"angle": "angle", "stiffness": "stiffness", "error": "length"}
_HEADER = re.compile(r"\s*(\w+)\s*\(([^()]*)\)\s*")
_MOST_BYTES = 10_000_000


@dataclass(frozen=True)
class MeshCycle:
    """Fits in SI units of what a file holds.

    Parameters
    ----------
    points : int
    stiffness : CycleFit or None
        N/m.
    error : CycleFit or None
        m; its mean, a rigid rotation, has no effect.
    """

    points: int
    stiffness: CycleFit | None
    error: CycleFit | None

    def report(self) -> dict:
        """As plain data."""
        return asdict(self)


def read_mesh_cycle(path: str, count: int) -> MeshCycle:
    """Read a file and fit `count` harmonics.

    Parameters
    ----------
    path : str
        CSV with a header such as `angle (deg), stiffness (N/um), error (um)`: the angle within one mesh cycle, of
        360 deg or 1 cycle, and one or both of the other columns, in any order.
    count : int

    Raises
    ------
    ConfigurationError
        One line that names the file, the line and what is allowed.
    """
    header, rows = _read(path)
    columns = _columns(path, header)
    values = {name: [] for name in columns}
    for number, row in rows:
        if len(row) != len(header):
            raise _wrong(path, f"line {number} has {len(row)} entries, the header has {len(header)}")
        for name, (place, size) in columns.items():
            values[name].append(_number(path, number, name, row[place]) * size)
    for (number, _), angle in zip(rows, values["angle"], strict=True):
        if not 0.0 <= angle < 2.0 * math.pi:
            raise _wrong(path, f"line {number}: the angle must be at least 0 and below one mesh cycle, 360 deg")
    for (number, _), stiffness in zip(rows, values.get("stiffness", []), strict="stiffness" in values):
        if stiffness < 0.0:
            raise _wrong(path, f"line {number}: the stiffness must be at least 0 all cycle")
    fits = {name: _fit(path, values["angle"], values[name], count) for name in columns if name != "angle"}
    return MeshCycle(len(rows), fits.get("stiffness"), fits.get("error"))


def _wrong(path: str, why: str) -> ConfigurationError:
    return ConfigurationError(f"{KEY} = {path!r} is not allowed: {why}")


def _read(path: str) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Header, and line number and entries of every line that is not empty."""
    try:
        # A pipe or a device has no size, and no end.
        if Path(path).stat().st_size > _MOST_BYTES or Path(path).is_fifo() or Path(path).is_char_device():
            raise _wrong(path, f"it must be a file of at most {_MOST_BYTES / 1e6:g} MB")
        text = Path(path).read_text(encoding="utf-8-sig")
        lines = csv.reader(text.splitlines(), strict=True)
        table = [(lines.line_num, row) for row in lines if any(entry.strip() for entry in row)]
    except OSError as error:
        raise _wrong(path, f"it cannot be read ({error.strerror})") from None
    except (UnicodeDecodeError, csv.Error, ValueError):
        raise _wrong(path, "it must be a CSV file in UTF-8") from None
    if not table:
        raise _wrong(path, "it is empty")
    return table[0][1], table[1:]


def _columns(path: str, header: list[str]) -> dict[str, tuple[int, float]]:
    """Column -> its place and the SI size of its unit."""
    found = {}
    for place, text in enumerate(header):
        match = _HEADER.fullmatch(text)
        name = match and {"phase": "angle"}.get(match[1].lower(), match[1].lower())
        if name not in COLUMNS or name in found:
            raise _wrong(
                path,
                f"its header has {text.strip()[:40]!r}, where each of angle (deg), stiffness (N/um), "
                "error (um) may stand once",
            )
        found[name] = place, unit_size(f"{KEY}, unit of {name}", match[2].strip(), COLUMNS[name])
    if "angle" not in found or len(found) < 2:
        raise _wrong(path, "its header must name angle (deg) and one or both of stiffness (N/um) and error (um)")
    return found


def _number(path: str, line: int, name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _wrong(path, f"line {line}: the {name} {text.strip()[:40]!r} must be a finite number")
    return value


def _fit(path: str, angles: list[float], values: list[float], count: int) -> CycleFit:
    try:
        return fit_cycle(angles, values, count)
    except ParameterError as error:
        if error.name == "count":
            raise ConfigurationError(str(error).replace("count", "gear.physical.mesh_cycle_harmonics", 1)) from None
        degrees = math.degrees(error.value)
        raise _wrong(path, f"the angle {degrees:.6g} deg must be {error.allowed}") from None
