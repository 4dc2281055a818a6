"""Single places, thoroughly: attractors from many random states, and a slice of their basins. Group `places`.

The slice is of initial states in lambda and its speed at tau = 0, all other coordinates at rest; each has the colour of
the attractor that it ends on. With `attractors.box` random states are drawn in that plane too.
"""

import dataclasses
import hashlib
import json
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from pipeline import store
from pipeline.analysis.attractors.dataset import NUMBERS, added_group, slot_attributes
from pipeline.analysis.attractors.grid import Grid
from pipeline.analysis.attractors.options import search_of
from pipeline.analysis.attractors.queries import wilson
from pipeline.analysis.attractors.tasks import map_motions
from pipeline.analysis.attractors.wording import attractor_name, bound
from pipeline.config.places import Place
from pipeline.config.schema import Attractors
from pipeline.errors import counted
from pipeline.plan.numerics import System, point_of
from pipeline.plan.plan import Plan
from pipeline.plan.row_blocks import Block
from pipeline.plan.traits import contact_system
from pipeline.run.job import Job, say_failures
from pipeline.run.kernels import ready_for_attractors
from pipeline.run.progress import Reporter, RowProgress
from pipeline.run.sheets import csv_text, write_files
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce
from pipeline.store import groups
from solver.model.contact_system import reduced
from solver.timedomain import AttractorKind, AttractorRow, AttractorSearch, find_attractors, settle
from solver.timedomain.row_systems import row_systems

if TYPE_CHECKING:
    import xarray

__all__ = [
    "GROUP",
    "IntegratedPlace",
    "place_of",
    "place_task",
    "read_places",
    "run_places",
    "search_place",
    "states_at_rest",
]

GROUP = "places"
#: Attractors that are told apart at a place.
_ROOM = 16
_SLOTS = (*NUMBERS, "kind", "impact", "hits", "seen")


@dataclasses.dataclass(frozen=True, eq=False)
class IntegratedPlace:
    """What was found at one place.

    Parameters
    ----------
    row : AttractorRow
        Of one cell; `hits` and `starts` are of the random states.
    slots : (n, n) int8 array
        Attractor that each state of the slice ends on; -1 where that is not known.
    displacement, speed : (n,) arrays
        Of the states of the slice.
    """

    row: AttractorRow
    slots: np.ndarray
    displacement: np.ndarray
    speed: np.ndarray


def place_task(path: str, plan: Plan, x: float, p: float, options: Attractors) -> IntegratedPlace:
    """What a worker does: attractors at one place, whatever other places are asked for."""
    ready_for_attractors()
    model, omega = point_of(plan, p, x)
    return place_of(model, omega, _nearest_motions(path, plan, x, p), int(plan.solver["period"]), options)


def place_of(model: System, omega: float, motions: np.ndarray, period: int, options: Attractors) -> IntegratedPlace:
    """Attractors at one place and a slice of their basins; parameters as of `search_place`."""
    row = search_place(model, omega, motions, period, options)
    given = options.box is not None
    ends = np.array(options.box, dtype=float) if given else row.box[0][:, None] * (-1.0, 1.0)
    displacement, speed = (np.linspace(low, high, options.slice) for low, high in ends)
    states = np.stack(np.meshgrid(displacement, speed), axis=-1).reshape(-1, 2)
    slots = np.empty(0, np.int8)
    if len(states):
        found, slots = settle(model, omega, states_at_rest(model, omega, states), known=row, search=_search(options))
        row = dataclasses.replace(found, hits=row.hits, starts=row.starts)
    return IntegratedPlace(row, slots.reshape(options.slice, options.slice), displacement, speed)


def search_place(model: System, omega: float, motions: np.ndarray, period: int, options: Attractors) -> AttractorRow:
    """Attractors at one place, thoroughly.

    Parameters
    ----------
    model : Model or ContactSystem
    omega : float
    motions : (1, S, 2 H + 1) array
        Stable motions of the map to start from, nan where there is none.
    period : int
        Forcing periods of these motions.
    options : Attractors
        Settings of the search; with `box` random states are drawn there.

    Returns
    -------
    AttractorRow
        Of one cell.
    """
    search, drawn = _search(options), options.box is not None
    row = find_attractors(
        model,
        "omega",
        [omega],
        motions=motions,
        period=period,
        keys=np.random.SeedSequence(options.seed).generate_state(1, np.uint64),
        search=dataclasses.replace(search, starts=0) if drawn else search,
    )
    if drawn and options.starts:
        unit = np.random.default_rng(options.seed).random((options.starts, 2))
        low, high = np.array(options.box, dtype=float).T
        row, slots = settle(
            model, omega, states_at_rest(model, omega, low + (high - low) * unit), known=row, search=search
        )
        hits = np.bincount(slots[slots >= 0], minlength=row.kind.shape[1]).astype(np.int32)[None]
        row = dataclasses.replace(row, hits=hits, starts=np.array([np.sum(slots >= 0)], np.int32))
    return row


def _search(options: Attractors) -> AttractorSearch:
    return dataclasses.replace(search_of(options), room=_ROOM)


def states_at_rest(system: System, omega: float, states: np.ndarray) -> np.ndarray:
    """States (k, m) with these lambda and lambda' (k, 2), all that lambda does not see at rest under the mean load."""
    rest = row_systems(system, "omega", np.array([omega]), None).rest[0]
    contact = reduced(contact_system(system)).contact
    along, n = contact / (contact @ contact), contact.size
    full = np.tile(rest, (len(states), 1))
    for part, wanted in ((slice(n), states[:, 0]), (slice(n, None), states[:, 1])):
        # Where lambda is a coordinate of its own it is set to the last digit.
        full[:, part] *= along != 1.0
        full[:, part] += np.outer(wanted - full[:, part] @ contact, along)
    return full


def _nearest_motions(path: Place, plan: Plan, x: float, p: float) -> np.ndarray:
    """Stable motions of the map in the nearest cell, (1, S, 2 H + 1)."""
    row, column = (
        int(np.argmin(np.abs(axis.values - value))) for axis, value in ((plan.parameter, p), (plan.sweep, x))
    )
    return map_motions(path, Grid(plan, (row,), (column,), _ROOM), Block(0, 1))[0]


def run_places(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """The stage, where places are given; an exit status."""
    path, plan, options, begin = job.store_path, job.plan, job.settings.config.attractors, perf_counter()
    text = json.dumps({"numbers": plan.fingerprint, **_settings(options)}, sort_keys=True)
    origin = hashlib.sha256(text.encode() + store.statuses(path).tobytes()).hexdigest()[:16]
    found = read_places(path)
    done = found is not None and found.attrs["made_from"] == origin
    if not done:
        warm_up_for(job, reporter, workforce)
        places, reasons = {}, {}
        with RowProgress(reporter, len(options.points), what="attractors", unit="places") as bar:
            tasks = [(path, plan, *map(float, point), options) for point in dict.fromkeys(map(tuple, options.points))]
            for (_, _, x, p, _), result in workforce.run(place_task, tasks):
                failed = isinstance(result, BaseException)
                reasons[x, p] = f"{type(result).__name__}: {' '.join(str(result).split())}" if failed else ""
                places[x, p] = None if failed else result
                bar.advance(1, int(failed))
        order = [task[2:4] for task in tasks]
        dataset = _dataset(plan, options, order, [places[at] for at in order], [reasons[at] for at in order])
        groups.write_group(path, GROUP, dataset.assign_attrs(made_from=origin))
        found = read_places(path)
    folder, name = job.settings.output_root / "attractors", f"{job.settings.store_name}-places"
    (sheet,) = write_files(folder, {f"{name}.csv": _csv(plan, found)})
    axes = (plan.sweep.name, plan.parameter.name)
    where = [
        ", ".join(f"{axis} = {value:.6g}" for axis, value in zip(axes, at, strict=True)) for at in _at(plan, found)
    ]
    say_failures([f"{at} failed: {why}" for at, why in zip(where, found.message.values, strict=True) if why], reporter)
    for i, at in enumerate(where):
        reporter.line(f"attractors: {at}: {', '.join(_said(found.isel(place=i))) or 'nothing found'}")
    reporter.line(f"attractors: {found.attrs['bound']}")
    end = f"are in {path} already, nothing to do" if done else f"into {path} ({perf_counter() - begin:.2f} s)"
    reporter.line(f"attractors: {counted(len(where), 'place')} with {options.starts} random starts each {end}")
    reporter.line(f"attractors: {sheet.name} in {folder.resolve()}")
    return 1 if np.any(found.message.values != "") else 0


def _settings(options: Attractors) -> dict:
    told = dataclasses.asdict(options)
    return {name: told[name] for name in ("points", "starts", "seed", "max_periods", "box", "slice")}


def _said(place: "xarray.Dataset") -> list[str]:
    """Attractors of a place with their shares, the largest first."""
    filled = np.flatnonzero(place.kind.values)
    order = filled[np.argsort(-place.hits.values[filled], kind="stable")]
    values = zip(
        *(place[name].values[order] for name in ("kind", "impact", "share", "share_low", "share_high")), strict=True
    )
    return [
        f"{attractor_name(int(kind), int(impact))} {100 * share:.1f} % ({100 * low:.1f} to {100 * high:.1f})"
        for kind, impact, share, low, high in values
    ]


def _dataset(plan: Plan, options: Attractors, points, places: list, messages: list[str]) -> "xarray.Dataset":
    import xarray

    slot, count = ("place", "attractor"), len(places)
    told = slot_attributes()
    values = {name: np.full((count, _ROOM), fill, dtype) for name, (dtype, fill, _) in told.items() if name in _SLOTS}
    starts, box = np.zeros(count, np.int32), np.full((count, 2, 2), np.nan)
    cut = np.full((count, options.slice, options.slice), -1, np.int8)
    sides = np.full((2, count, options.slice), np.nan)
    for i, place in enumerate(places):
        if place is None:
            continue
        for name in _SLOTS:
            values[name][i] = getattr(place.row, name)[0]
        starts[i], cut[i] = place.row.starts[0], place.slots
        sides[0, i], sides[1, i] = place.displacement, place.speed
        box[i] = np.array(options.box) if options.box is not None else place.row.box[0][:, None] * (-1.0, 1.0)
    known = (values["kind"] != AttractorKind.NONE) & (starts > 0)[:, None]
    share = np.where(known, values["hits"] / np.maximum(starts, 1)[:, None], np.nan)
    ends = [np.where(known, end, np.nan) for end in wilson(values["hits"], np.tile(starts[:, None], (1, _ROOM)))]
    variables = {name: (slot, array, told[name][2]) for name, array in values.items()}
    for name, array, text in (
        ("share", share, "share of the random starts that reached it"),
        ("share_low", ends[0], "lower end of the share's 95 % interval"),
        ("share_high", ends[1], "upper end of the share's 95 % interval"),
    ):
        variables[name] = (slot, array, {"long_name": text, "units": "1"})
    variables["starts"] = ("place", starts, {"long_name": "random starts", "units": "1"})
    words = "random starts lie between these: of lambda and its speed"
    words += ", all else at rest" if options.box is not None else "; of every coordinate as of lambda"
    variables["box"] = (("place", "of", "end"), box, {"long_name": words, "units": "1"})
    if options.slice:
        words = "attractor that a state of the slice ends on; -1: not known"
        variables["slice"] = (("place", "slice_row", "slice_column"), cut, {"long_name": words})
        for name, dim, array in (("displacement", "column", sides[0]), ("speed", "row", sides[1])):
            words = f"mesh displacement{'' if name == 'displacement' else ' speed'} of the states of the slice"
            variables[f"slice_{name}"] = (("place", f"slice_{dim}"), array, {"long_name": words, "units": "1"})
    variables["message"] = ("place", np.array(messages, dtype=object), {"long_name": "why it failed, else empty"})
    # They carry other names than the plane's axes, which are coordinates of other dimensions.
    coordinates = {
        f"place_{axis.name}": ("place", np.array([point[i] for point in points]), store.axis_attributes(axis.name))
        for i, axis in enumerate((plan.sweep, plan.parameter))
    }
    settings = {key: value for key, value in _settings(options).items() if value is not None and key != "points"}
    attributes = {"configuration_hash": plan.fingerprint, "bound": bound(options.starts), **settings}
    return xarray.Dataset(variables, coordinates, attributes)


def read_places(path: Place) -> "xarray.Dataset | None":
    """What is stored of places; None if nothing is."""
    found = added_group(path, GROUP)
    return None if found is None else found.load()


def _at(plan: Plan, found: "xarray.Dataset") -> list[tuple[float, float]]:
    return list(
        zip(*(found[f"place_{axis.name}"].values.tolist() for axis in (plan.sweep, plan.parameter)), strict=True)
    )


def _csv(plan: Plan, found: "xarray.Dataset") -> str:
    names = ("share", "share_low", "share_high", "hits", *NUMBERS)
    lines = []
    for i, at in enumerate(_at(plan, found)):
        place = found.isel(place=i)
        for slot in np.flatnonzero(place.kind.values).tolist():
            name = attractor_name(int(place.kind[slot]), int(place.impact[slot]))
            numbers = (place[name].values[slot].item() for name in names)
            lines.append([*at, name, *("" if number != number else number for number in numbers), ""])
        if place.message.item():
            lines.append([*at, *[""] * (len(names) + 1), place.message.item()])
    return csv_text([plan.sweep.name, plan.parameter.name, "attractor", *names, "message"], lines)
