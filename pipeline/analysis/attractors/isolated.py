"""Branches that rows of the map lack, from the stored attractors: isolas, and motions of several periods.

Group `isolated`. Every integrated row is solved at the order that `attractors.branches` asks for; an attractor that no
branch of it has leads to a branch of its own (`solver.timedomain.isolated_branches`).
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from pipeline import store
from pipeline.analysis.attractors.dataset import added_group, row_of_values, state_size
from pipeline.config.places import Place
from pipeline.config.quantities import AMPLITUDE, QUANTITIES
from pipeline.plan.kinds import kind_of
from pipeline.plan.numerics import continuation_of, model_at, row_of
from pipeline.plan.plan import Plan
from pipeline.run.job import Job, say_failures
from pipeline.run.kernels import kernels_for_isolated, ready_for_isolated
from pipeline.run.progress import Reporter, RowProgress
from pipeline.run.sheets import csv_text, write_files
from pipeline.run.warmup import warm_up_where
from pipeline.run.workforce import Workforce
from pipeline.store import groups
from pipeline.store.arrays import arrays_of
from solver import Event, LiftedSeeds
from solver.contact.impact import impact_of_range
from solver.harmonic.galerkin import Galerkin
from solver.harmonic.quantities import balance_quantities
from solver.model.packing import dead_zone_ends
from solver.stability import assess
from solver.timedomain import AttractorRow, IsolatedBranch, isolated_branches

if TYPE_CHECKING:
    import xarray

__all__ = ["GROUP", "Found", "isolated_near", "isolated_task", "read_isolated", "run_isolated"]

GROUP = "isolated"
#: What is kept of the points of a branch besides quantities: where the store of the map describes it.
_TOLD = {
    **{name: f"branches/{name}" for name in ("cos", "sin", "stable", "impact", "event")},
    "instability": "instability",
    "multiplier": "multiplier",
}


@dataclass(frozen=True, eq=False)
class Found:
    """Branches of one row, one after the other.

    Parameters
    ----------
    points : dict
        Name -> (point,) array: "position" on the sweep axis, "branch" from 0, "period", "closed", and what is stored.
    notes : tuple of str
        What could not be followed.
    """

    points: dict[str, np.ndarray]
    notes: tuple[str, ...]


def isolated_task(plan: Plan, value: float, x: np.ndarray, attractors: AttractorRow, order: int) -> Found:
    """What a worker does: the branches of one row, whatever other rows are integrated.

    Parameters
    ----------
    plan : Plan
    value : float
        Of the row parameter.
    x : (X,) array
        Of the sweep parameter, where attractors were sought.
    attractors : AttractorRow
    order : int
        Harmonics of the mesh frequency.
    """
    ready_for_isolated(kind_of(plan).name)
    settings, ends = continuation_of(plan.solver), np.array([plan.sweep.low, plan.sweep.high])
    row = row_of(plan, value, Galerkin(order), settings, LiftedSeeds(plan.solver["certify_columns"]), ends)
    omega = plan.frequency(value)
    found = isolated_branches(row, x, omega=omega, attractors=attractors, continuation=settings)
    parts = [_points(row, branch, number, omega) for number, branch in enumerate(found.branches)]
    points = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else {}
    return Found(points, found.notes)


def _points(row, branch: IsolatedBranch, number: int, omega: float | None) -> dict[str, np.ndarray]:
    """Name -> (point,) array of one branch."""
    curve, balance = branch.curve, branch.balance
    position, motions = curve.points[:, -1].copy(), curve.points[:, :-1].copy()
    stability = assess(row.system, row.axis, position, motions, omega=omega, balance=balance, static=curve.stable)
    numbers = balance_quantities(balance, row.system, row.axis, position, motions, omega)
    cos, sin = motions[:, balance.fundamental[0]], motions[:, balance.fundamental[1]]
    read = {name: numbers[:, one.slot] for name, one in QUANTITIES.items() if one.slot is not None}
    low, high = dead_zone_ends(row.system, row.axis, position)
    return {
        "position": position,
        "branch": np.full(position.size, number),
        "period": np.full(position.size, branch.period),
        "closed": np.full(position.size, int(branch.isolated)),
        **read,
        AMPLITUDE.name: np.hypot(cos, sin),
        "cos": cos,
        "sin": sin,
        "stable": curve.stable,
        "impact": impact_of_range(*balance.extremes(motions), low, high),
        "event": curve.event,
        "instability": stability.kind,
        "multiplier": stability.modulus,
    }


def run_isolated(job: Job, workforce: Workforce, reporter: Reporter, found: "xarray.Dataset") -> int:
    """The part of the stage that follows branches from attractors; an exit status.

    Parameters
    ----------
    job : Job
    workforce : Workforce
    reporter : Reporter
    found : xarray.Dataset
        The attractors.
    """
    path, plan, order, begin = job.store_path, job.plan, job.settings.config.attractors.branches, perf_counter()
    text = json.dumps({"attractors": found.attrs["made_from"], "order": order})
    origin = hashlib.sha256(text.encode()).hexdigest()[:16]
    stored = read_isolated(path)
    done = stored is not None and stored.attrs["made_from"] == origin
    if not done:
        warm_up_where(workforce, kernels_for_isolated(kind_of(plan).name), reporter)
        results = _compute(plan, found, order, workforce, reporter)
        groups.write_group(path, GROUP, _dataset(plan, found, results, order).assign_attrs(made_from=origin))
        stored = read_isolated(path)
    folder, name = job.settings.output_root / "attractors", f"{job.settings.store_name}-isolated"
    (sheet,) = write_files(folder, {f"{name}.csv": _csv(plan, stored)})
    rows = stored[f"isolated_row_{plan.parameter.name}"].values
    failed = np.flatnonzero(stored.failed.values)
    say_failures(
        [f"branches at {plan.parameter.name} = {rows[i]:g} failed: {stored.message.values[i]}" for i in failed],
        reporter,
    )
    lines = _branches(plan, stored)
    closed, several = sum(one[3] for one in lines), sum(one[2] > 1 for one in lines)
    end = f"are in {path} already, nothing to do" if done else f"into {path} ({perf_counter() - begin:.2f} s)"
    count = f"{len(lines)} branch{'' if len(lines) == 1 else 'es'}"
    reporter.line(
        f"attractors: {count} that rows lack at order {order}, {closed} closed and {several} of several periods, {end}"
    )
    reporter.line(f"attractors: {sheet.name} in {folder.resolve()}")
    return 1 if failed.size else 0


def _compute(plan: Plan, found: "xarray.Dataset", order: int, workforce, reporter) -> list[Found | BaseException]:
    """What came of every row, in their order."""
    x, values = found[plan.sweep.name].values, found[plan.parameter.name].values
    tasks, results = [], {}
    for i, value in enumerate(values.tolist()):
        here = found.isel({found[plan.parameter.name].dims[0]: i}).load()
        size = max(state_size(model_at(plan, value, column)) for column in (plan.sweep.low, plan.sweep.high))
        arrays = {str(name): array.values for name, array in here.variables.items()}
        tasks.append((plan, value, x, row_of_values(arrays, size), order))
    with RowProgress(reporter, len(tasks), what="branches") as bar:
        for task, result in workforce.run(isolated_task, tasks):
            results[task[1]] = result
            bar.advance(1, int(isinstance(result, BaseException)))
    return [results[value] for value in values.tolist()]


def _dataset(plan: Plan, found: "xarray.Dataset", results: list, order: int) -> "xarray.Dataset":
    import xarray

    failed = [isinstance(result, BaseException) for result in results]
    messages = [
        f"{type(one).__name__}: {' '.join(str(one).split())}" if bad else " ".join(one.notes)
        for one, bad in zip(results, failed, strict=True)
    ]
    values = found[plan.parameter.name].values
    parts, count = [], 0
    for value, result in zip(values.tolist(), results, strict=True):
        if isinstance(result, Found) and result.points:
            points = {**result.points, "row": np.full(result.points["branch"].size, value)}
            parts.append({**points, "branch": points["branch"] + count})
            count += int(points["branch"][-1]) + 1
    told = arrays_of(plan)
    names = {**{name: name for name in QUANTITIES}, **_TOLD}

    def column(name: str, dtype) -> np.ndarray:
        return np.concatenate([np.empty(0, dtype), *(part[name].astype(dtype) for part in parts)])

    flags = {"flag_values": [0, 1], "flag_meanings": "no yes"}
    point = "isolated_point"
    variables = {
        name: (point, column(name, told[source]["dtype"]), told[source]["attributes"]) for name, source in names.items()
    }
    variables |= {
        "branch": (point, column("branch", "int32"), {"long_name": "which branch the point belongs to"}),
        "period": (point, column("period", "int8"), {"long_name": "mesh periods of its motions", "units": "1"}),
        "closed": (point, column("closed", "int8"), {"long_name": "1: the branch is a closed curve", **flags}),
        "failed": ("isolated_row", np.array(failed, np.int8), {"long_name": "1: the row failed", **flags}),
        "message": (
            "isolated_row",
            np.array(messages, dtype=object),
            {"long_name": "why the row failed, or what could not be followed in it; else empty"},
        ),
    }
    sweep, parameter = plan.sweep.name, plan.parameter.name
    places = {
        f"isolated_{sweep}": (point, column("position", "float64"), store.axis_attributes(sweep)),
        f"isolated_{parameter}": (point, column("row", "float64"), store.axis_attributes(parameter)),
        f"isolated_row_{parameter}": ("isolated_row", values, store.axis_attributes(parameter)),
    }
    return xarray.Dataset(variables, places, {"configuration_hash": plan.fingerprint, "order": order})


def read_isolated(path: Place) -> "xarray.Dataset | None":
    """What is stored of branches that rows lack; None if nothing is."""
    found = added_group(path, GROUP)
    return None if found is None else found.load()


def isolated_near(stored: "xarray.Dataset", plan: Plan, value: float) -> "xarray.Dataset":
    """The branches of the row that is nearest to a value of the row parameter, along `isolated_point`.

    Parameters
    ----------
    stored : xarray.Dataset
        As `read_isolated` gives it.
    plan : Plan
    value : float
    """
    rows = stored[f"isolated_row_{plan.parameter.name}"].values
    row = rows[int(np.argmin(np.abs(rows - value)))]
    here = np.flatnonzero(stored[f"isolated_{plan.parameter.name}"].values == row)
    return stored.isel(isolated_point=here, isolated_row=[int(np.argmin(np.abs(rows - row)))])


def _branches(plan: Plan, stored: Mapping) -> list[tuple]:
    """Of every branch: row value, number, period, closed, both ends on the sweep axis, lowest and highest, folds."""
    place, rows = (stored[f"isolated_{axis.name}"].values for axis in (plan.sweep, plan.parameter))
    number, lines = stored["branch"].values, []
    for one in np.unique(number).tolist():
        here = np.flatnonzero(number == one)
        lowest, highest = (stored[name].values[here] for name in ("lowest", "highest"))
        folds = place[here[stored["event"].values[here] == Event.FOLD]]
        kind = (int(stored["period"].values[here[0]]), int(stored["closed"].values[here[0]]))
        ends = (place[here].min(), place[here].max(), np.nanmin(lowest), np.nanmax(highest))
        lines.append((rows[here[0]], one, *kind, *ends, " ".join(f"{fold:.9g}" for fold in np.sort(folds))))
    return lines


def _csv(plan: Plan, stored: "xarray.Dataset") -> str:
    sweep = plan.sweep.name
    head = [plan.parameter.name, "branch", "period", "closed", f"{sweep}_low", f"{sweep}_high", "lowest", "highest"]
    return csv_text([*head, "folds"], _branches(plan, stored))
