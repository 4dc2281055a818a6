"""Boundaries over a path of models: derivatives, folds against fresh rows, labels, bifurcations of any order."""

import functools

import numpy as np
import pytest

from solver import EndReason, Event, ParameterError, sweep_row
from solver.boundaries import boundary_curves, row_events
from solver.boundaries.first_order import FirstOrderProblem
from solver.boundaries.harmonic import HarmonicProblem
from solver.boundaries.problem import Plane
from solver.harmonic.describing_function import DescribingFunction, evaluate
from solver.harmonic.galerkin import Galerkin
from solver.model.parameter_path import ParameterPath, place_on
from solver.regions.regions import regions
from tests.conftest import published
from tests.solver.gear.test_thermal import PAIR, TABLES

OMEGA, RANGE, ROWS = (0.3, 1.4), (-8.0, 28.0), 13
GRID = np.linspace(*OMEGA, 60)
BASE = published(alpha_harmonics=((0.1, 0.4),))
PATHS = {"laws": PAIR.path, "tables": TABLES.path}
#: A path that shares nothing with temperature, along which phases turn.
TURNING = ParameterPath(
    "turn",
    lambda model, p: {"alpha_phase": np.sin(p), "f_e": 0.2 + 0.05 * p * p, "f_pv": 0.1 * p, "b": np.exp(-p)},
    ("alpha_phase", "f_e", "f_pv", "b"),
)
paths = pytest.mark.parametrize("name", list(PATHS))


def row_at(name, value):
    return sweep_row(place_on(PATHS[name], value, BASE)[0], "omega", GRID)


@functools.cache
def curves_of(name):
    starts = [event for value in np.linspace(*RANGE, ROWS) for event in row_events(row_at(name, value).curves, value)]
    return boundary_curves(BASE, "omega", PATHS[name], OMEGA, RANGE, starts)


def differences(problem, y, columns):
    residual, other, scratch = (
        np.empty(problem.unknowns),
        np.empty(problem.unknowns),
        np.empty((problem.unknowns, y.size)),
    )
    for j in columns:
        step = np.eye(y.size)[j] * 1e-6
        problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y + step, residual, scratch)
        problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y - step, other, scratch)
        yield j, (residual - other) / 2e-6


def test_the_balance_over_a_path_is_that_of_its_models():
    plane = FirstOrderProblem(Plane(BASE, "omega", TURNING, OMEGA, (0.0, 1.0)))
    rng = np.random.default_rng(5)
    for _ in range(40):
        point = np.concatenate([rng.uniform(-1.8, 1.8, 3), [rng.uniform(*OMEGA), rng.uniform(0.1, 0.9)]])
        (zones,) = plane.zones(Event.FOLD, point)
        problem, y = plane.problem(Event.FOLD, zones), plane.lift(Event.FOLD, zones, point)
        residual, jacobian = np.empty(6), np.empty((6, 7))
        problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
        force, square = evaluate(place_on(TURNING, point[4], BASE)[0], point[3], point[:3])
        np.testing.assert_allclose(residual, [*force, 0.0, 0.0, np.linalg.det(square)], rtol=1e-11, atol=1e-12)
        for j, slope in differences(problem, y, (5, 6)):
            np.testing.assert_allclose(jacobian[:, j], slope, rtol=0, atol=1e-7 * (1.0 + np.max(np.abs(jacobian))))


@pytest.mark.parametrize("kind", [Event.FOLD, Event.MAX_AT_DRIVE, Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER])
@pytest.mark.parametrize("balance", [DescribingFunction(), Galerkin(3)], ids=["first", "higher"])
def test_boundaries_of_any_order_feel_a_path(balance, kind):
    """Rows over the path are those of its model at that place, and their derivatives those of differences."""

    def boundary(model, p_axis, p_range):
        plane = Plane(model, "omega", p_axis, OMEGA, p_range)
        return FirstOrderProblem(plane) if balance.truncated else HarmonicProblem(plane, balance)

    over_path = boundary(BASE, TURNING, (0.0, 1.0))
    plain = boundary(place_on(TURNING, 0.4, BASE)[0], "kappa", (0.4, 0.6))
    rng = np.random.default_rng(5)
    for _ in range(8):
        u = rng.normal(size=balance.unknowns) / (1.0 + np.arange(balance.unknowns) // 2)
        point = np.array([*u, 0.9, 0.4])
        contact = over_path.zones(kind, point)[0] if balance.truncated else None

        def lifted(problem, point=point, contact=contact):
            y = problem.lift(kind, contact, point) if balance.truncated else point
            return np.insert(y, -2, 0.3) if kind is Event.NEIMARK_SACKER else y

        y = lifted(over_path)
        problem, other = over_path.problem(kind, contact), plain.problem(kind, contact)
        residual, jacobian = np.empty(problem.unknowns), np.empty((problem.unknowns, y.size))
        expected, scratch = np.empty(problem.unknowns), np.empty((problem.unknowns, y.size))
        problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
        # How far a flank is away is measured with the size of lambda in the middle of each plane.
        there = np.append(lifted(plain)[:-1], 0.5)
        other.residual_and_jacobian(other.parameters, other.parameter_slope, there, expected, scratch)
        np.testing.assert_allclose(residual, expected, rtol=0, atol=1e-11)
        size = 1.0 + np.max(np.abs(jacobian), axis=1)
        for j, slope in differences(problem, y, (y.size - 2, y.size - 1)):
            assert np.max(np.abs(jacobian[:, j] - slope) / size) < 1e-5


@paths
def test_folds_on_curves_are_those_of_fresh_rows(name):
    """Rows that gave no start: their events lie on the curves, and the curves cross them nowhere else."""
    curves, seen = curves_of(name), 0
    for curve in curves:
        assert not {EndReason.STEP_TOO_SMALL, EndReason.ITERATION_LIMIT} & set(curve.ends)
    for value in (-6.3, 1.7, 13.1, 22.9):
        events = row_events(row_at(name, value).curves, value)
        for kind in {kind for kind, _ in events}:
            points = np.array([point for other, point in events if other == kind])
            mine = [curve for curve in curves if curve.kind == kind]
            crossed = np.concatenate([curve.crossings(np.array([value]))[1] for curve in mine])
            assert len(crossed) == len(points)
            for point in points:
                assert np.min(np.max(np.abs(crossed - point), axis=1)) < 1e-8
                seen += 1
    assert seen >= 12


@paths
def test_a_plane_over_a_path_divides_into_labels(name):
    whole = regions(BASE, "omega", PATHS[name], OMEGA, RANGE, curves_of(name))
    assert sum(whole.shares.values()) == pytest.approx(1.0, abs=1e-12)
    # Several motions exist above a temperature at which two folds are born, and the curves say where that is.
    births = [float(np.min(curve.points[:, 4])) for curve in curves_of(name) if curve.kind is Event.FOLD]
    first = min(found.appears for label in whole.labels if label.startswith("2/") for found in whole.occurrences(label))
    assert first == pytest.approx(min(births), abs=1e-7)


def test_the_other_axis_may_not_belong_to_the_path():
    for make in (FirstOrderProblem, lambda plane: HarmonicProblem(plane, DescribingFunction())):
        with pytest.raises(ParameterError, match="x_axis = 'kappa'"):
            make(Plane(BASE, "kappa", PAIR.path, (0.1, 0.2), RANGE, 1.0))
    with pytest.raises(ParameterError, match="x_axis = .* one of omega"):
        Plane(BASE, PAIR.path, "omega", RANGE, OMEGA)
