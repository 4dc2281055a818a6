"""The stage `basins`: shares of random initial states that reach each of several coexisting motions.

Initial states are uniform in `solver.timedomain.basin_box`, from the same seed at every place, so that a single
place can be recomputed with `solver.timedomain.basin_shares` alone.
"""

import dataclasses
import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline import store
from pipeline.analysis.attractor_flags import attractor_code, attractor_flags, attractor_label
from pipeline.analysis.verification.sampling import strata_sample
from pipeline.analysis.verification.verdicts import settling_of
from pipeline.config.schema import Basins
from pipeline.plan.numerics import point_of
from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane
from pipeline.run.sheets import csv_text, write_files
from pipeline.store import groups
from solver import domain_parts, gear_system

__all__ = ["StoredBasins", "basin_task", "measure", "read_basins", "write_sheet"]

GROUP = "basins"

_PLACES = {"row": "int32", "column": "int32", "x": "float64", "p": "float64", "n_attractors": "int32"}
_FOUND = {
    "attractor_code": "int16",
    "count": "int32",
    "share": "float64",
    "share_low": "float64",
    "share_high": "float64",
    "period": "int32",
    "mean": "float64",
    "amplitude": "float64",
    "lyapunov": "float64",
}


@dataclass(frozen=True, eq=False)
class StoredBasins:
    """Basins as plain arrays.

    Parameters
    ----------
    places : dict
        Name -> (k,) array: row and column (-1 for points that the user gave), x, p, n_attractors.
    found : dict
        Name -> (k, a) array, the largest share first: attractor_code (0 beyond their number), count, share, share_low,
        share_high, period, mean, amplitude, lyapunov.
    messages : (k,) array of str
        Why a place failed, else empty.
    made_from : str
        Digest of the rows and settings.
    """

    places: dict[str, np.ndarray]
    found: dict[str, np.ndarray]
    messages: np.ndarray
    made_from: str


def basin_task(plan: Plan, x: float, p: float, options: Basins) -> list[dict]:
    """Attractors at one place, the largest share first; what a worker does."""
    from solver.timedomain import basin_shares

    model, omega = point_of(plan, p, x)
    shares = basin_shares(
        gear_system(model), omega, options.starts, options.seed, settling=settling_of(options.max_periods)
    )
    return [
        {
            "attractor_code": attractor_code(one.attractor),
            "count": one.count,
            "share": one.share,
            "share_low": one.low,
            "share_high": one.high,
            "period": one.attractor.period,
            "mean": one.attractor.mean,
            "amplitude": one.attractor.amplitude,
            "lyapunov": one.attractor.lyapunov,
        }
        for one in shares
    ]


def measure(
    path: Path, plan: Plan, options: Basins, run: Callable, advance: Callable[[int, int], None]
) -> tuple[StoredBasins, bool]:
    """Measure basins into the store's group `basins`, unless they are there already.

    Returns
    -------
    StoredBasins
    bool
        Whether they were there.
    """
    plane = StoredPlane(path, plan)
    text = json.dumps({"numbers": plan.digest, **dataclasses.asdict(options)}, sort_keys=True)
    made_from = hashlib.sha256(text.encode() + plane.domain.astype("<u2").tobytes()).hexdigest()[:16]
    stored = read_basins(path, plan)
    if stored is not None and stored.made_from == made_from:
        return stored, True
    places = places_of(plane, options)
    spots = list(zip(places["x"].tolist(), places["p"].tolist(), strict=True))
    results: dict[tuple[float, float], list[dict]] = {}
    reasons: dict[tuple[float, float], str] = {}
    for (_, x, p, _), result in run(basin_task, [(plan, x, p, options) for x, p in dict.fromkeys(spots)]):
        failed = isinstance(result, BaseException)
        reasons[x, p] = f"{type(result).__name__}: {' '.join(str(result).split())}" if failed else ""
        results[x, p] = [] if failed else result
        advance(1, int(failed))
    rows = [results[spot] for spot in spots]
    places["n_attractors"] = np.array([len(row) for row in rows], dtype=np.int32)
    most = max(map(len, rows), default=0)
    found = {
        name: np.zeros((len(rows), most), kind) if kind.startswith("int") else np.full((len(rows), most), np.nan)
        for name, kind in _FOUND.items()
    }
    for i, row in enumerate(rows):
        for j, one in enumerate(row):
            for name, values in found.items():
                values[i, j] = one[name]
    messages = np.array([reasons[spot] for spot in spots], dtype=object)
    fresh = StoredBasins(places, found, messages, made_from)
    _write(path, plan, fresh, options)
    return fresh, False


def places_of(plane: StoredPlane, options: Basins) -> dict[str, np.ndarray]:
    """Where basins are measured: row and column (-1 for a given point), x and p."""
    if options.points is not None:
        x, p = np.array(options.points, dtype=float).T
        return {"row": np.full(x.size, -1), "column": np.full(x.size, -1), "x": x, "p": p}
    plan, domain = plane.plan, plane.domain
    several = np.flatnonzero(plane.usable & (domain_parts(domain)[0] >= 2))
    drawn = several[strata_sample(domain.ravel()[several], options.cells, np.random.default_rng(options.seed))]
    row, column = np.unravel_index(drawn, domain.shape)
    return {"row": row, "column": column, "x": plan.sweep.values[column], "p": plan.parameter.values[row]}


def _write(path: Path, plan: Plan, found: StoredBasins, options: Basins) -> None:
    import xarray as xr

    x, p = plan.sweep.name, plan.parameter.name
    described = {
        "row": {"long_name": "index of the row; -1: a point that was given"},
        "column": {"long_name": "index of the column; -1: a point that was given"},
        "x": store.axis_attributes(x),
        "p": store.axis_attributes(p),
        "n_attractors": {"long_name": "number of attractors reached", "units": "1"},
        "attractor_code": {"long_name": "kind and impact state of the attractor; 0: none", **attractor_flags()},
        "count": {"long_name": "initial states that reached the attractor", "units": "1"},
        "share": {"long_name": "share of the initial states", "units": "1"},
        "share_low": {"long_name": "lower end of the share's 95 % Wilson interval", "units": "1"},
        "share_high": {"long_name": "upper end of the share's 95 % Wilson interval", "units": "1"},
        "period": {"long_name": "forcing periods after which the attractor repeats; 0 if it does not", "units": "1"},
        "mean": {"long_name": "mean of the attractor", "units": "1"},
        "amplitude": {"long_name": "amplitude of the fundamental of the attractor", "units": "1"},
        "lyapunov": {"long_name": "largest Lyapunov exponent per unit of time", "units": "1"},
    }
    # Places are coordinates, and carry other names than the plane's axes, which are coordinates of other dimensions.
    variables = {
        name: ("cell", np.asarray(found.places[name], kind), described[name]) for name, kind in _PLACES.items()
    }
    variables |= {
        name: (("cell", "attractor"), np.asarray(found.found[name], kind), described[name])
        for name, kind in _FOUND.items()
    }
    variables["message"] = ("cell", found.messages, {"long_name": "why it failed, else empty"})
    places = {f"cell_{x}": variables.pop("x"), f"cell_{p}": variables.pop("p")}
    settings = {key: value for key, value in dataclasses.asdict(options).items() if value is not None}
    attributes = {"configuration_hash": plan.digest, "made_from": found.made_from, **settings}
    groups.write_group(path, GROUP, xr.Dataset(variables, places, attributes))


def read_basins(path: Path, plan: Plan) -> StoredBasins | None:
    """What is stored; None if nothing is."""
    group = groups.open_group(path, GROUP)
    if group is None:
        return None
    stored = {"x": f"cell_{plan.sweep.name}", "p": f"cell_{plan.parameter.name}"}
    return StoredBasins(
        {name: group[stored.get(name, name)][...] for name in _PLACES},
        {name: group[name][...] for name in _FOUND},
        group["message"][...],
        group.attrs["made_from"],
    )


def write_sheet(found: StoredBasins, plan: Plan, folder: Path, name: str) -> Path:
    """One line per place and attractor as `<name>.csv`; the same bytes from the same store."""
    columns, lines = [name for name in _FOUND if name != "attractor_code"], []
    for i, message in enumerate(found.messages.tolist()):
        place = [i, float(found.places["x"][i]), float(found.places["p"][i])]
        for j in range(int(found.places["n_attractors"][i])):
            label = attractor_label(int(found.found["attractor_code"][i, j]))
            lines.append([*place, label, *(found.found[name][i, j].item() for name in columns), ""])
        if message:
            lines.append([*place, "", *[""] * len(columns), message])
    header = ["cell", plan.sweep.name, plan.parameter.name, "attractor", *columns, "message"]
    (path,) = write_files(folder, {f"{name}.csv": csv_text(header, lines)})
    return path
