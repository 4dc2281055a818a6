"""Tracing the boundaries of a stored plane; what came of it, in numbers."""

import dataclasses
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.boundaries.contradictions import contradiction_starts
from pipeline.analysis.boundaries.events import RowEvents, read_events
from pipeline.analysis.boundaries.group import write_boundaries
from pipeline.plan.numerics import balance_of, continuation_of, frame_of
from pipeline.plan.plan import Plan
from pipeline.plane.boundaries import StoredBoundaries, StoredCurve, read_boundaries, special_places
from solver import Continuation, EndReason, Event
from solver.boundaries import BIFURCATIONS, FOLDS_AND_GRAZINGS, SPECTRAL, BoundaryCurve, SpecialPoint, boundary_curves
from solver.continuation.problem import Balance
from solver.kernels.threads import side_by_side

__all__ = ["Summary", "curves_through", "layer_boundaries", "stored_summary", "summary_of", "to_store", "trace"]

# Steps so short that a cubic between two points is exact for every purpose; the default ones would do to 1e-5.
_LARGEST_ANGLE, _LARGEST_STEP, _MOST_POINTS = 0.02, 0.05, 2**17
_WORDS = {
    Event.FOLD: "fold",
    Event.PERIOD_DOUBLING: "period doubling",
    Event.NEIMARK_SACKER: "Neimark-Sacker",
    Event.UNIT_MULTIPLIER: "multiplier +1",
}


@dataclass(frozen=True)
class Summary:
    """What a plane's boundaries are: numbers by kind, and which curves end where they should not."""

    curves: dict[str, int]
    special: dict[str, int]
    points: int
    cut_short: tuple[str, ...]
    found_done: bool


def trace(path: Path, plan: Plan, get_ready: Callable[[], None] = lambda: None) -> Summary:
    """Trace the boundaries of a stored plane into its group `boundaries`, unless they are there already.

    Parameters
    ----------
    path : Path
        The store. Only its complete rows count.
    plan : Plan
        The store's own.
    get_ready : callable
        Called before curves are traced, if they are not there already.

    Returns
    -------
    Summary

    Raises
    ------
    ArithmeticError, ValueError
        If boundaries cannot be followed. What the store held before is kept.
    """
    events = read_events(path, plan)
    stored = read_boundaries(path, plan)
    if stored is not None and stored.digest == events.digest:
        return summary_of(plan, stored, True)
    get_ready()
    fresh = _boundaries_of(plan, events)
    write_boundaries(path, plan, fresh)
    return summary_of(plan, fresh, False)


def layer_boundaries(path: Path, volume: Plan, layer: int) -> StoredBoundaries:
    """Trace the boundaries of one layer of a stored volume.

    Parameters
    ----------
    path : Path
        The store. Only its complete rows count.
    volume : Plan
        The store's own.
    layer : int
    """
    return _boundaries_of(volume.layer(layer), read_events(path, volume, layer))


def _boundaries_of(plan: Plan, events: RowEvents) -> StoredBoundaries:
    balance = balance_of(plan.solver)
    traced = curves_through(plan, events.starts(FOLDS_AND_GRAZINGS), balance)
    bifurcations, starts = side_by_side(
        lambda search: search(),
        (
            lambda: curves_through(plan, events.starts(BIFURCATIONS), balance),
            lambda: contradiction_starts(plan, events.contradictory, traced),
        ),
    )
    starts += contradiction_starts(plan, events.contradictory[:0], bifurcations)
    contradictions = curves_through(plan, starts, balance)
    # What is sought may be no boundary.
    traced += (*bifurcations, *(curve for curve in contradictions if len(curve.points) > 1))
    curves = [to_store(curve, _side(curve, plan, events)) for curve in traced]
    return StoredBoundaries(tuple(curves), events.digest)


def stored_summary(path: Path, plan: Plan) -> Summary | None:
    """What the boundaries of a stored plane are; None where they have to be traced."""
    stored = read_boundaries(path, plan)
    if stored is None or stored.digest != read_events(path, plan).digest:
        return None
    return summary_of(plan, stored, True)


def curves_through(plan: Plan, starts, balance: Balance | None = None) -> tuple[BoundaryCurve, ...]:
    """The boundaries through these starts, of the describing function unless a balance is given, in short steps."""
    omega = None if "omega" in (plan.sweep.name, plan.parameter.name) else plan.omega
    return boundary_curves(*frame_of(plan), starts, omega=omega, balance=balance, continuation=_short_steps(plan))


def _short_steps(plan: Plan) -> Continuation:
    continuation = continuation_of(plan.solver)
    return dataclasses.replace(
        continuation,
        largest_angle=min(continuation.largest_angle, _LARGEST_ANGLE),
        largest_step=min(continuation.largest_step, _LARGEST_STEP),
        max_points=_MOST_POINTS,
    )


def to_store(curve: BoundaryCurve, side: int = 0) -> StoredCurve:
    """A traced boundary as it is stored; its side is 0 where it is not known."""
    return StoredCurve(
        curve.kind, curve.ends, side, curve.points, curve.slopes, curve.arclength, curve.stable, curve.special
    )


def _side(curve: BoundaryCurve, plan: Plan, events: RowEvents) -> int:
    """The side of a curve, from the row event at which the curve crosses its row most steeply; 0 where it is not told.

    One number does for the whole curve. A fold's pair lies on the same side of it on either side of a cusp, where the
    direction of the curve reverses along with the pair's; likewise the margin of a grazing, except that on the unstable
    sheet beyond a fold the picture is mirrored, which `RowEvents.ahead` allows for.
    """
    if curve.kind in SPECTRAL or not balance_of(plan.solver).truncated:
        return 0
    here = events.kind == curve.kind
    points, ahead = events.points[here], events.ahead[here]
    near = curve.meets(points, _short_steps(plan)) & (ahead != 0.0)
    if not np.any(near):
        return 0
    points, ahead = points[near], ahead[near]
    scale = curve.scale
    # A grazing curve crosses itself nowhere in all five components, so that the nearest point is its own.
    vertex = np.array([np.argmin(np.max(np.abs(curve.points - point) / scale, axis=1)) for point in points])
    steep = np.argmax(np.abs(curve.slopes[vertex, 4]))
    return int(-np.sign(curve.slopes[vertex[steep], 4]) * ahead[steep])


def summary_of(plan: Plan, boundaries: StoredBoundaries, found_done: bool) -> Summary:
    """Boundaries of a plane in numbers."""
    curves = Counter(_WORDS.get(curve.kind, "grazing") for curve in boundaries.curves)
    first_order = balance_of(plan.solver).truncated
    special: Counter[str] = Counter()
    cut_short = []
    for curve in boundaries.curves:
        special.update(SpecialPoint(curve.special[place]).name.lower() for place in special_places(curve))
        for end, place in zip(curve.ends, (0, -1), strict=True):
            # Curves of any order may stop at a corner, where a motion begins to touch a flank; that is no failure.
            known = first_order and curve.kind in FOLDS_AND_GRAZINGS
            if known and end in (EndReason.STEP_TOO_SMALL, EndReason.ITERATION_LIMIT):
                x, p = curve.points[place, 3:]
                where = f"{plan.sweep.name} = {x:.9g}, {plan.parameter.name} = {p:.9g}"
                cut_short.append(f"{curve.kind.name.lower()} boundary stops at {where}: {end.sentence}")
    points = sum(len(curve.points) for curve in boundaries.curves)
    # A start that leads nowhere would say so for both of its ends.
    return Summary(dict(curves), dict(special), points, tuple(dict.fromkeys(cut_short)), found_done)
