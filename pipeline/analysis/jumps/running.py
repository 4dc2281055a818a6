"""The stage `jumps`: attractors followed along rows, upwards and downwards, and where the two ways differ."""

import dataclasses
import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline import store
from pipeline.analysis.attractor_flags import attractor_code, attractor_flags, attractor_label
from pipeline.analysis.verification.verdicts import settling_of
from pipeline.config.schema import Jumps
from pipeline.plan.numerics import point_of
from pipeline.plan.plan import Plan
from pipeline.run.sheets import csv_text, write_files
from pipeline.store import groups
from solver import gear_system

__all__ = ["StoredJumps", "follow", "hysteresis_intervals", "jump_task", "read_jumps", "rows_of", "write_sheets"]

GROUP = "jumps"

_WAYS = ("up", "down")
_FOLLOWED = {"sweep": "int16", "mean": "float64", "amplitude": "float64"}


@dataclass(frozen=True, eq=False)
class StoredJumps:
    """Jumps as plain arrays.

    Parameters
    ----------
    rows : (r,) int array
        Indices of the rows.
    followed : dict
        sweep_up, sweep_down (codes of `pipeline.analysis.attractor_flags`), mean_up, ... -> (r, X) array.
    hysteresis : (r, X) int8 array
        1 where the two ways ended on different motions.
    intervals : (r, i, 2) array
        Ends of the stretches where they do, nan beyond their number; jumps lie halfway between two columns.
    messages : (r,) array of str
        Why a row failed, else empty.
    made_from : str
        Digest of the configuration and settings.
    """

    rows: np.ndarray
    followed: dict[str, np.ndarray]
    hysteresis: np.ndarray
    intervals: np.ndarray
    messages: np.ndarray
    made_from: str

    @property
    def widths(self) -> np.ndarray:
        """Total width of the stretches of every row, (r,)."""
        return np.nansum(self.intervals[..., 1] - self.intervals[..., 0], axis=1)


def jump_task(plan: Plan, row: int, max_periods: int) -> dict[str, np.ndarray]:
    """Both ways along one row; what a worker does."""
    from solver.timedomain import sweep_attractors

    value = float(plan.parameter.values[row])

    def system_at(x: float):
        model, omega = point_of(plan, value, x)
        return gear_system(model), omega

    swept = sweep_attractors(system_at, plan.sweep.values, settling=settling_of(max_periods))
    found = {"hysteresis": swept.hysteresis.astype(np.int8)}
    for way, attractors in zip(_WAYS, (swept.up, swept.down), strict=True):
        found[f"sweep_{way}"] = np.array([attractor_code(one) for one in attractors], dtype=np.int16)
        found[f"mean_{way}"] = np.array([one.mean for one in attractors])
        found[f"amplitude_{way}"] = np.array([one.amplitude for one in attractors])
    return found


def hysteresis_intervals(x: np.ndarray, differs: np.ndarray) -> np.ndarray:
    """Ends (i, 2) of the stretches of columns where the two ways differ, halfway to the neighbours outside.

    Examples
    --------
    >>> hysteresis_intervals(np.arange(6.0), np.array([0, 1, 1, 0, 0, 1])).tolist()
    [[0.5, 2.5], [4.5, 5.0]]
    """
    change = np.diff(np.concatenate([[0], differs, [0]]).astype(np.int8))
    middles = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    return np.column_stack([middles[change == 1], middles[change == -1]])


def rows_of(plan: Plan, options: Jumps) -> np.ndarray:
    """Indices of the rows that are followed, ascending."""
    if options.values is None:
        return np.unique(np.linspace(0, plan.parameter.num - 1, options.rows).round().astype(int))
    gaps = np.abs(plan.parameter.values[None, :] - np.array(options.values, dtype=float)[:, None])
    return np.unique(np.argmin(gaps, axis=1))


def follow(
    path: Path, plan: Plan, options: Jumps, run: Callable, advance: Callable[[int, int], None]
) -> tuple[StoredJumps, bool]:
    """Follow attractors into the store's group `jumps`, unless that is there already.

    Returns
    -------
    StoredJumps
    bool
        Whether it was there.
    """
    text = json.dumps({"numbers": plan.digest, **dataclasses.asdict(options)}, sort_keys=True)
    made_from = hashlib.sha256(text.encode()).hexdigest()[:16]
    stored = read_jumps(path)
    if stored is not None and stored.made_from == made_from:
        return stored, True
    rows = rows_of(plan, options)
    shape = (rows.size, plan.sweep.num)
    followed = {
        f"{name}_{way}": np.zeros(shape, kind) if kind == "int16" else np.full(shape, np.nan)
        for name, kind in _FOLLOWED.items()
        for way in _WAYS
    }
    hysteresis, messages = np.zeros(shape, np.int8), np.full(rows.size, "", dtype=object)
    for (_, row, _), result in run(jump_task, [(plan, row, options.max_periods) for row in rows.tolist()]):
        place, failed = int(np.searchsorted(rows, row)), isinstance(result, BaseException)
        if failed:
            messages[place] = f"{type(result).__name__}: {' '.join(str(result).split())}"
        else:
            hysteresis[place] = result["hysteresis"]
            for name, values in followed.items():
                values[place] = result[name]
        advance(1, int(failed))
    parts = [hysteresis_intervals(plan.sweep.values, differs) for differs in hysteresis]
    intervals = np.full((rows.size, max(map(len, parts), default=0), 2), np.nan)
    for place, part in enumerate(parts):
        intervals[place, : len(part)] = part
    fresh = StoredJumps(rows, followed, hysteresis, intervals, messages, made_from)
    _write(path, plan, fresh, options)
    return fresh, False


def _write(path: Path, plan: Plan, found: StoredJumps, options: Jumps) -> None:
    import xarray as xr

    x, p = plan.sweep, plan.parameter
    words = {
        "sweep": "attractor",
        "mean": "mean of the attractor",
        "amplitude": "amplitude of the fundamental of the attractor",
    }
    ways = {"up": "upwards", "down": "downwards"}
    rows, cells, of_x = "jump_row", ("jump_row", x.name), store.axis_attributes(x.name)
    places = {
        x.name: (x.name, x.values, of_x),
        f"row_{p.name}": (rows, p.values[found.rows], store.axis_attributes(p.name)),
    }
    variables = {"row": (rows, np.asarray(found.rows, "int32"), {"long_name": "index of the row"})}
    for name, kind in _FOLLOWED.items():
        for way, said in ways.items():
            attributes = {
                "long_name": f"{words[name]} on the way {said}",
                **(attractor_flags() if name == "sweep" else {"units": "1"}),
            }
            variables[f"{name}_{way}"] = (cells, np.asarray(found.followed[f"{name}_{way}"], kind), attributes)
    flagged = {"flag_values": [0, 1], "flag_meanings": "same different"}
    variables["hysteresis"] = (
        cells,
        np.asarray(found.hysteresis, "int8"),
        {"long_name": "1: the two ways ended on different motions", **flagged},
    )
    ends = {**of_x, "long_name": "ends of a stretch of hysteresis"}
    variables["hysteresis_interval"] = ((rows, "interval", "end"), found.intervals, ends)
    width = {**of_x, "long_name": "total width of the hysteresis"}
    variables["hysteresis_width"] = (rows, found.widths, width)
    variables["message"] = (rows, found.messages, {"long_name": "why it failed, else empty"})
    settings = {key: value for key, value in dataclasses.asdict(options).items() if value is not None}
    attributes = {"configuration_hash": plan.digest, "made_from": found.made_from, **settings}
    groups.write_group(path, GROUP, xr.Dataset(variables, places, attributes))


def read_jumps(path: Path) -> StoredJumps | None:
    """What is stored; None if nothing is."""
    group = groups.open_group(path, GROUP)
    if group is None:
        return None
    followed = {f"{name}_{way}": group[f"{name}_{way}"][...] for name in _FOLLOWED for way in _WAYS}
    return StoredJumps(
        group["row"][...],
        followed,
        group["hysteresis"][...],
        group["hysteresis_interval"][...],
        group["message"][...],
        group.attrs["made_from"],
    )


def write_sheets(found: StoredJumps, plan: Plan, folder: Path, name: str) -> list[Path]:
    """Write `<name>.csv`, one line per row and column, and `<name>-hysteresis.csv`, one per stretch."""
    x, p = plan.sweep, plan.parameter
    values = p.values[found.rows].tolist()
    lines = []
    for place, value in enumerate(values):
        for column in range(x.num if not found.messages[place] else 0):
            both = [found.followed[f"{name}_{way}"][place, column].item() for way in _WAYS for name in _FOLLOWED]
            both[0], both[3] = attractor_label(both[0]), attractor_label(both[3])
            lines.append([value, x.values[column].item(), *both, int(found.hysteresis[place, column])])
    stretches = [
        [value, low, high, high - low]
        for value, part in zip(values, found.intervals.tolist(), strict=True)
        for low, high in part
        if not np.isnan(low)
    ]
    heads = [f"{name}_{way}" for way in _WAYS for name in _FOLLOWED]
    return write_files(
        folder,
        {
            f"{name}.csv": csv_text([p.name, x.name, *heads, "hysteresis"], lines),
            f"{name}-hysteresis.csv": csv_text([p.name, f"{x.name}_low", f"{x.name}_high", "width"], stretches),
        },
    )
