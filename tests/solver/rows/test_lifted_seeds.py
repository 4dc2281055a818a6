"""Rows of order H: their branches against first order, shooting and integration; motions of two forcing periods."""

import numpy as np
import pytest

from solver import Continuation, EndReason, Event, ParameterError, domain_label, gear_system, sweep_row
from solver.harmonic.galerkin import Galerkin
from solver.rows.phases import equal_motions, shifted
from solver.rows.seeds import LiftedSeeds, LinearSeeds
from solver.timedomain import orbit_state, shoot
from tests.conftest import MODELS, antiphase, consistent, published, slow_but

GRID = np.linspace(0.05, 2.0, 118)


def row_of(model, order, period=1, grid=GRID, columns=60, **changes):
    return sweep_row(model, "omega", grid, balance=Galerkin(order, period), seeds=LiftedSeeds(columns), **changes)


@pytest.mark.parametrize("name", sorted(MODELS))
def test_every_solution_solves_the_balance_and_the_signs_add_up(name):
    row = row_of(MODELS[name](), 5)
    problem = row.balance.problem(MODELS[name](), "omega", 0.05, 2.0)
    for column, place in zip(*np.nonzero(row.stable >= 0), strict=True):
        y = np.append(row.motions[column, place], row.grid[column])
        residual, jacobian = np.empty(11), np.empty((11, 12))
        problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
        assert np.max(np.abs(residual)) < 1e-11
        assert (np.linalg.det(jacobian[:, :-1]) > 0.0) == (row.stable[column, place] == 1)
    assert not np.any(row.open)
    np.testing.assert_array_equal(2 * row.n_stable - row.n_solutions, 1)


def test_five_solutions_of_first_order_are_three_at_order_five():
    # docs/physics.md, section 8: order 5, collocation and integration do not have the folds at 1.2932 and 1.2936.
    grid = np.linspace(1.2, 1.4, 41)
    first, fifth = (row_of(antiphase(), order, grid=grid) for order in (1, 5))
    folds = [
        np.sort(np.concatenate([c.points[c.event == Event.FOLD][:, -1] for c in row.curves])) for row in (first, fifth)
    ]
    assert np.max(fifth.n_solutions) == 3 and folds[1].size == 2
    # Folds of first order are 2 to 4 % off.
    assert abs(folds[1][0] / 1.256714 - 1.0) == pytest.approx(0.024, abs=0.002)


@pytest.mark.parametrize(("omega", "which"), slow_but([(0.6, 2)], [(0.6, 0), (0.6, 2), (0.62, 0), (1.3, 0)]))
def test_high_orders_are_shooting_s_orbits(omega, which):
    model = published()
    grid = np.array([omega - 0.1, omega, omega + 0.1])
    system = gear_system(model)
    errors = []
    for order in (5, 15, 45):
        row = row_of(model, order, grid=grid)
        motion = row.motions[1, which]
        orbit = shoot(system, omega, orbit_state(system, omega, motion), order=2)
        found = np.concatenate([[motion[0]], motion[1:5:2] - 1j * motion[2:5:2]])
        errors.append(np.max(np.abs(found - orbit.harmonics[:3])))
    assert errors[2] < 1e-6 and errors[2] <= max(errors[0], 1e-9)


def test_motions_of_two_forcing_periods():
    # docs/physics.md, section 8, order 5: half-order amplitude 0.7888 and first 0.106 at Omega = 1.2; 2T from 1.05 on.
    model = consistent(rotation_coupling=0.93969262, variation_translation=0.0)
    row = row_of(model, 5, 2, grid=np.linspace(0.9, 1.4, 51), columns=41)
    column = int(np.argmin(np.abs(row.grid - 1.2)))
    half = np.hypot(row.motions[column, :, 1], row.motions[column, :, 2])
    assert row.stable[column].tolist()[:3] == [0, 1, 0] and half[0] < 1e-12
    assert half[1] == pytest.approx(0.7888, abs=2e-4) and row.amplitude[column, 1] == pytest.approx(0.106, abs=5e-4)
    assert domain_label(row.domain[column]) == "1/1"
    doubled = next(c for c in row.curves if EndReason.JOINED in c.ends)
    assert np.min(doubled.points[:, -1]) == pytest.approx(1.046, abs=0.002)
    # It is born on the motion of one period, at the two places where that loses its stability.
    main = next(c for c in row.curves if np.max(np.abs(c.points[:, 1])) < 1e-9)
    births = main.points[main.event == Event.BRANCH_POINT][:, -1]
    np.testing.assert_allclose(np.sort(doubled.points[[0, -1], -1]), births, rtol=0, atol=1e-4)
    # And it is what integration finds: half of it one period later is the same motion.
    system = gear_system(model)
    orbit = shoot(system, 1.2, orbit_state(system, 1.2, row.motions[column, 1], 2), 2)
    assert orbit.minimal_period == 2 and orbit.stable
    # Multiplicity: no motion is counted with its own shift.
    for motions, stable in zip(row.motions, row.stable, strict=True):
        here = motions[stable >= 0]
        for i in range(len(here)):
            assert not any(equal_motions(here[i], here[j], 1.0, 2) for j in range(i))


def test_a_period_that_nothing_repeats_after_adds_nothing():
    model = consistent(rotation_coupling=0.93969262, variation_translation=0.0)
    grid = np.linspace(0.9, 1.04, 15)
    single, triple = row_of(model, 3, 1, grid=grid), row_of(model, 3, 3, grid=grid)
    np.testing.assert_array_equal(single.n_solutions, triple.n_solutions)
    np.testing.assert_allclose(single.amplitude, triple.amplitude, rtol=0, atol=1e-10)
    np.testing.assert_allclose(single.quantities, triple.quantities, rtol=0, atol=1e-9)


def test_shifts_are_a_group():
    motion = np.random.default_rng(3).normal(size=13)
    for period in (2, 3):
        np.testing.assert_allclose(shifted(shifted(motion, 1, period), period - 1, period), motion, rtol=0, atol=1e-12)
        balance = Galerkin(6 // period, period)
        at = np.linspace(0.0, 2.0 * np.pi, 50)
        later = balance.displacement(motion, at + 2.0 * np.pi / period)
        np.testing.assert_allclose(balance.displacement(shifted(motion, 1, period), at), later, rtol=0, atol=1e-13)


def test_more_seeds_find_nothing_new_at_the_reference_points():
    model, grid = published(f_e=0.3), np.linspace(0.4, 0.75, 36)
    few, many = row_of(model, 5, grid=grid, columns=15), row_of(model, 5, grid=grid, columns=400)
    np.testing.assert_array_equal(few.n_solutions, many.n_solutions)
    np.testing.assert_allclose(few.amplitude, many.amplitude, rtol=0, atol=1e-9)
    alone = sweep_row(model, "omega", grid, balance=Galerkin(5), seeds=LinearSeeds(), continuation=Continuation())
    assert np.all(alone.n_solutions <= many.n_solutions)


def test_any_parameter_may_be_swept():
    row = sweep_row(published(), "b", np.linspace(0.2, 1.2, 21), omega=0.6, balance=Galerkin(3), seeds=LiftedSeeds(21))
    other = row_of(published(b=0.7), 3, grid=np.array([0.55, 0.6, 0.65]))
    column = int(np.argmin(np.abs(row.grid - 0.7)))
    np.testing.assert_allclose(row.amplitude[column], other.amplitude[1], rtol=0, atol=1e-9)


def test_bad_numbers_of_columns_are_refused():
    with pytest.raises(ParameterError, match="certify_columns = 1 is not allowed"):
        LiftedSeeds(1)


@pytest.mark.parametrize("period", [1, 2])
def test_a_row_without_a_solution_below_the_ceiling(period):
    row = row_of(published(), 3, period, np.linspace(0.5, 0.8, 9), 9, continuation=Continuation(amplitude_max=1e-6))
    assert row.curves == () and not np.any(row.n_solutions) and np.all(row.open == 1)
