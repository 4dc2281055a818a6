"""Labels along a line of a plane: which boundaries cross it, and what its motions are between two of them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.plan.numerics import balance_of, continuation_of, frame_of, row_axis, seeds_of, system_along
from pipeline.plan.plan import Plan
from solver import Event, Row, sweep_row
from solver.boundaries import FOLDS_AND_GRAZINGS, row_events
from solver.boundaries.problem import Plane
from solver.regions.labelling import row_codes

__all__ = ["Line", "Stretch", "codes_along", "divided", "row_along", "swept"]

#: Where between two crossings labels are asked for: one place would do, the others show whether a boundary is missing.
_PLACES = np.array([0.02, 0.1, 0.5, 0.9, 0.98])
#: Crossings this close, relative to the line, are one.
_SAME = 1e-9
_HALVINGS = 50


@dataclass(frozen=True)
class Stretch:
    """A part of a line with one label; `code` is 0 where labels cannot be had."""

    low: float
    high: float
    code: int


@dataclass(frozen=True)
class Line:
    """A line of the plane, cut where its label changes.

    Parameters
    ----------
    stretches : tuple of Stretch
        Ascending, without gaps.
    kinds : tuple of Event
        What happens between two neighbouring ones; NONE where a motion passes the amplitude ceiling.
    """

    stretches: tuple[Stretch, ...]
    kinds: tuple[Event, ...]

    def within(self, low: float, high: float) -> tuple[Stretch, ...]:
        """The stretches of a part of the line, which may be one place."""
        return tuple(
            Stretch(max(one.low, low), min(one.high, high), one.code)
            for one in self.stretches
            if one.low < high and one.high > low or one.low <= low == high <= one.high
        )

    def beyond(self, place: float, upward: bool) -> tuple[float, Event, int] | None:
        """The nearest change of label from a place on: where, what happens and the label beyond; None without one."""
        changes = zip(self.stretches[:-1], self.kinds, self.stretches[1:], strict=True)
        found = [(below.high, kind, above.code if upward else below.code) for below, kind, above in changes]
        if upward:
            return next((change for change in found if change[0] >= place), None)
        return next((change for change in reversed(found) if change[0] <= place), None)


def codes_along(
    plan: Plan, axis: str, ends: tuple[float, float], x: float, p: float
) -> Callable[[np.ndarray], np.ndarray]:
    """A function that gives the codes of the labels at values of one parameter, all others being those at (x, p).

    At first order the solutions are enumerated, and the code is 0 where they are not proven to be all. At higher orders
    they are those of the branches along the line.
    """
    if not plan.is_first_order:
        return _swept_codes(plan, axis, ends, x, p)
    ceiling = float(plan.solver["amplitude_max"])
    if axis in (plan.sweep.name, plan.parameter.name):
        plane = Plane(*frame_of(plan), plan.omega)
        if axis == plan.sweep.name:
            return lambda places: row_codes(plane, p, np.asarray(places, dtype=float), ceiling)
        return lambda places: np.concatenate([row_codes(plane, float(p), np.array([x]), ceiling) for p in places])
    omega = None if "omega" in (axis, plan.sweep.name) else _frequency(plan, x, p)
    start = system_along(plan, p, x, axis, plan.sweep.name)
    plane = Plane(*start, ends, (plan.sweep.low, plan.sweep.high), omega)
    return lambda places: row_codes(plane, x, np.asarray(places, dtype=float), ceiling)


def _swept_codes(plan: Plan, axis: str, ends: tuple[float, float], x: float, p: float):
    """`codes_along` from the branches along the line, which are traced over all of it."""
    if axis == plan.parameter.name and not isinstance(row_axis(plan), str):
        # A path cannot be swept: every one of its values is a row of its own.
        across = plan.sweep.name, (plan.sweep.low, plan.sweep.high)
        return lambda places: np.concatenate([_swept_codes(plan, *across, x, float(p))([x]) for p in places])

    def codes(places) -> np.ndarray:
        places = np.asarray(places, dtype=float)
        row = row_along(plan, axis, np.unique([*ends, *places]), x, p)
        return row.domain[np.searchsorted(row.grid, places)]

    return codes


def _frequency(plan: Plan, x: float, p: float) -> float:
    return {plan.sweep.name: x, plan.parameter.name: p}.get("omega", plan.omega)


def divided(places, kinds, ends: tuple[float, float], codes: Callable[[np.ndarray], np.ndarray] | None) -> Line:
    """The line between two ends.

    Parameters
    ----------
    places, kinds : (k,) arrays
        Where boundaries cross it, and their kinds.
    ends : (low, high)
    codes : callable or None
        Labels anywhere, see `codes_along`; without it every crossing counts as a change.
    """
    order = np.argsort(places, kind="stable")
    cuts = [(float(places[i]), Event(int(kinds[i]))) for i in order if ends[0] < places[i] < ends[1]]
    stretches: list[Stretch] = []
    events: list[Event] = []
    before, kind = ends[0], Event.NONE
    for edge, after in [*cuts, (ends[1], Event.NONE)]:
        wide = edge - before > _SAME * (ends[1] - ends[0])
        parts = _labelled(before, edge, codes) if wide else []
        if not parts:
            # Of several boundaries at one place the fold says most.
            kind = after if kind is not Event.FOLD else kind
            continue
        for part in parts:
            if stretches and codes is not None and stretches[-1].code == part.code:
                part = Stretch(stretches.pop().low, part.high, part.code)
            elif stretches:
                events.append(kind)
            stretches.append(part)
            kind = Event.NONE
        before, kind = edge, after
    stretches[0] = Stretch(ends[0], stretches[0].high, stretches[0].code)
    stretches[-1] = Stretch(stretches[-1].low, ends[1], stretches[-1].code)
    return Line(tuple(stretches), tuple(events))


def _labelled(low: float, high: float, codes) -> list[Stretch]:
    """Parts with one label between two crossings: one, unless a motion passes the ceiling; none if too narrow."""
    if codes is None:
        return [Stretch(low, high, 0)]
    places = low + (high - low) * _PLACES
    found = codes(places)
    known = np.flatnonzero(found)
    if known.size == 0:
        return []
    places, found = places[known], found[known]
    parts, begin = [], low
    for i in np.flatnonzero(found[1:] != found[:-1]):
        left, right = places[i], places[i + 1]
        for _ in range(_HALVINGS):
            middle = 0.5 * (left + right)
            left, right = (middle, right) if codes([middle])[0] == found[i] else (left, middle)
        parts.append(Stretch(begin, float(left), int(found[i])))
        begin = float(left)
    return [*parts, Stretch(begin, high, int(found[-1]))]


def row_along(plan: Plan, axis: str, grid: np.ndarray, x: float, p: float) -> Row:
    """The branches along one parameter through a place of the plane, and the motions at ascending values of it."""
    return sweep_row(
        *system_along(plan, p, x, axis),
        grid,
        omega=None if axis == "omega" else _frequency(plan, x, p),
        continuation=continuation_of(plan.solver),
        seeds=seeds_of(plan.solver),
        balance=balance_of(plan.solver),
    )


def swept(plan: Plan, axis: str, ends: tuple[float, float], x: float, p: float) -> tuple[np.ndarray, np.ndarray]:
    """Folds and grazings met when one parameter alone is swept through a place of the plane.

    Returns
    -------
    points : (k, n + 1) array
        The n unknowns of the balance and the parameter.
    kinds : (k,) int array
    """
    row = row_along(plan, axis, np.array(ends), x, p)
    events = row_events(row.curves, 0.0, FOLDS_AND_GRAZINGS)
    points = np.array([point[:-1] for _, point in events]).reshape(len(events), row.motions.shape[-1] + 1)
    return points, np.array([kind for kind, _ in events], dtype=int)
