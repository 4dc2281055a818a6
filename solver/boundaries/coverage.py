"""What the boundaries of a plane tell its rows: branches that a row has not traced."""

from collections.abc import Iterable

import numpy as np

from solver.boundaries.curve import BoundaryCurve
from solver.boundaries.problem import SAME, checked_events
from solver.continuation.continuation import Continuation, Event
from solver.model.checks import ascending_grid, instances_of

__all__ = ["missed_events"]


def missed_events(
    curves: Iterable[BoundaryCurve],
    starts: Iterable[tuple[Event, np.ndarray]],
    parameters,
    continuation: Continuation | None = None,
) -> list[tuple[Event, np.ndarray]]:
    """Where boundaries cross rows that have no such event: the row misses a branch there, most often an isola.

    Parameters
    ----------
    curves : iterable of BoundaryCurve
    starts : iterable of (Event, (5,) array)
        All events of the rows, as for `boundary_curves`.
    parameters : (v,) array_like
        Ascending values of p, the rows.
    continuation : Continuation, optional
        Whose corrector is used.

    Returns
    -------
    list of (Event, (5,) array)
        Kind and lambda_m, lambda_c, lambda_s, x, p: solutions to start from in those rows. By kind, p and x.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    curves, parameters = instances_of("curves", curves, BoundaryCurve), ascending_grid("parameters", parameters)
    known: dict[tuple[int, float], list[np.ndarray]] = {}
    for kind, point in zip(*checked_events("starts", starts, 5), strict=True):
        known.setdefault((int(kind), float(point[4])), []).append(point[:4])
    missed = []
    for curve in curves:
        if not curve.stretches:
            continue
        scale = curve.scale[:-1]
        for point in curve.crossings(parameters, continuation)[1]:
            events = known.get((int(curve.kind), float(point[4])), [])
            if not events or np.min(np.max(np.abs(np.array(events) - point[:4]) / scale, axis=1)) > SAME:
                missed.append((curve.kind, point))
    return sorted(missed, key=lambda event: (event[0], *event[1][[4, 3]]))
