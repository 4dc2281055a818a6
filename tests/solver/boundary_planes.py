"""Planes of four gears with their boundaries traced, once for all tests of a process."""

import functools

import numpy as np
import pytest

from solver import Continuation, Event, LinearSeeds, first_order_problem, sweep_row
from solver.boundaries import boundary_curves, row_events
from solver.harmonic.describing_function import evaluate
from tests.conftest import MODELS, consistent, slow_but

OMEGA = (0.05, 2.0)
GRID = np.linspace(*OMEGA, 100)
RANGES = {"b": (0.02, 1.5), "alpha": (0.0, 0.8), "f_e": (0.0, 0.5), "f_pm": (0.3, 1.2)}
ROWS = 81
GEARS = {**MODELS, "isola": lambda **changes: consistent(**{"rotation_coupling": np.cos(np.radians(20.0)), **changes})}
PLANES = [(gear, axis) for gear in GEARS for axis in RANGES]
# Every gear and every axis twice, and the two planes that have what others lack.
_ORDINARY = [
    ("published", "b"),
    ("published", "alpha"),
    ("published", "f_e"),
    ("published", "f_pm"),
    ("consistent", "b"),
    ("antiphase", "f_e"),
    ("antiphase", "f_pm"),
    ("isola", "alpha"),
]
published_planes = pytest.mark.parametrize("axis", list(RANGES))
all_planes = pytest.mark.parametrize(("gear", "axis"), slow_but(_ORDINARY, PLANES))


def sweep(gear, axis, value):
    """One row of a plane over the frequency."""
    return sweep_row(GEARS[gear](**{axis: value}), "omega", GRID, seeds=LinearSeeds())


@functools.cache
def starts_of(gear, axis):
    """Rows' parameters and all their events."""
    values = np.linspace(*RANGES[axis], ROWS)
    return values, [event for value in values for event in row_events(sweep(gear, axis, value).curves, value)]


@functools.cache
def curves_of(gear, axis):
    """Boundaries of a plane, started from the events of its rows."""
    return boundary_curves(GEARS[gear](), "omega", axis, OMEGA, RANGES[axis], starts_of(gear, axis)[1])


def specials(curves, code):
    """Points of one code on several curves, (n, 5)."""
    return np.concatenate([np.empty((0, 5)), *(curve.points[curve.special == code] for curve in curves)])


def folds(gear, axis):
    """Those boundaries of a plane that are folds."""
    return [curve for curve in curves_of(gear, axis) if curve.kind is Event.FOLD]


def distance(events, kind, point):
    """Distance from a point to the nearest of some (kind, point) pairs of the same kind, inf without one."""
    return min((np.max(np.abs(other - point)) for k, other in events if k == kind), default=np.inf)


def cusp_equations(gear, axis, unknowns, **others):
    """E, det dE/du and its derivative along the null vector, all from the plain balance by central differences."""
    model, omega, u = GEARS[gear](**{axis: unknowns[4], **others}), unknowns[3], np.asarray(unknowns[:3])
    residual, square = evaluate(model, omega, u)
    v = np.linalg.svd(square)[2][-1]
    v *= np.sign(v[np.argmax(np.abs(v))])
    ahead, behind = (np.linalg.det(evaluate(model, omega, u + h * v)[1]) for h in (1e-5, -1e-5))
    return np.array([*residual, np.linalg.det(square), (ahead - behind) / 2e-5])


def row_curve(gear, axis, point):
    """The branch of one row through a fold: it leaves along the null vector of dE/du."""
    model = GEARS[gear](**{axis: point[4]})
    problem = first_order_problem(model, "omega", *OMEGA)
    null = np.linalg.svd(evaluate(model, point[3], point[:3])[1])[2][-1]
    return Continuation().trace_both_ways(problem, point[:4], *OMEGA, heading=np.append(null, 0.0))
