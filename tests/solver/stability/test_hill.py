"""Hill's exponents against Floquet's, the folds and period doublings of the balance, and its condensed matrix."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import Continuation, Event, sweep_row
from solver.harmonic.describing_function import evaluate
from solver.harmonic.galerkin import Galerkin
from solver.harmonic.layout import packed
from solver.harmonic.perturbation import contact_and_modulated, perturbation_matrix
from solver.stability import (
    Instability,
    Truncation,
    assess,
    centred_exponents,
    condensed_exponents,
    hill_multipliers,
    multipliers,
    system_row,
    truncation_of,
    window_exponents,
)
from solver.stability.floquet import contact_shares
from solver.stability.hill import apart
from tests.conftest import MODELS, antiphase, consistent, published
from tests.solver.stability.orbits import first_order, galerkin_motion, matched, padded, solved, unmerged
from tests.solver.strategies import frequencies, models, motions

FIRST = Truncation()


def curve(model, balance, high, low, step=0.004):
    """The Galerkin curve from one frequency down to another."""
    start = galerkin_motion(model, balance, high, first_order(model, high)[0][0])
    problem = balance.problem(model, "omega", low, high)
    return Continuation(parameter_step=step).trace(problem, np.append(start, high), low, high, -1)


@pytest.mark.parametrize("make, omega, choice", [(published, 0.6, 1), (antiphase, 1.3, 1), (consistent, 1.6, 0)])
def test_hill_approaches_floquet_on_the_same_orbit(make, omega, choice):
    """The error falls like H^-2 or faster: chi jumps, its coefficients fall like 1/H, and enter twice."""
    model = make()
    motion = galerkin_motion(model, Galerkin(5), omega, first_order(model, omega)[0][choice])
    row = system_row(model, "omega", [omega])
    assert 0.0 < contact_shares(row, motion[None])[0] < 1.0
    exact = multipliers(row, motion[None])[0]
    errors = []
    for order in (5, 11, 21):
        truncation = Truncation(order, truncated=False)
        errors.append(matched(hill_multipliers(row, padded(motion, order), truncation, exact[None])[0], exact))
    assert errors[0] < 0.1 and errors[2] < 2e-3
    assert errors[2] < errors[0] * (5 / 21) ** 1.7


#: docs/physics.md, section 7: Omega, lambda_m, lambda_a.
FOLDS = {
    "published": [
        (0.559374, 1.027736, 1.991212),
        (0.634641, 1.641558, 0.708424),
        (1.223810, 1.598606, 0.882513),
        (1.229708, 1.644933, 0.684089),
    ],
    "antiphase": [
        (0.488703, 1.000241, 2.032049),
        (0.517873, 0.793933, 1.937968),
        (0.531027, 0.728561, 2.780072),
        (0.542557, 1.620306, 0.740615),
        (1.256714, 0.962657, 1.983417),
        (1.378418, 1.618688, 0.742421),
        (1.293183, 0.813761, 2.022725),
        (1.293594, 0.803868, 2.131303),
    ],
}


@pytest.mark.parametrize("name", FOLDS)
def test_zero_exponent_at_the_folds_of_the_reference_table(name):
    model = MODELS[name]()
    curves = sweep_row(model, "omega", np.linspace(0.4, 1.6, 25)).curves
    folds = np.concatenate([curve.points[curve.event == Event.FOLD] for curve in curves])
    assert len(folds) == len(FOLDS[name])
    for omega, mean, amplitude in FOLDS[name]:
        motion = folds[np.argmin(np.abs(folds[:, 3] - omega))]
        np.testing.assert_allclose(
            [motion[3], motion[0], np.hypot(motion[1], motion[2])], [omega, mean, amplitude], rtol=0, atol=1e-6
        )
        exponents, centres = window_exponents(system_row(model, "omega", motion[3:]), motion[None, :3], FIRST)
        order = np.argsort(np.abs(exponents[0]))
        assert abs(exponents[0, order[0]]) < 1e-8 < 1e-2 < abs(exponents[0, order[1]])
        assert abs(centres[0, order[0]]) < 1e-9


@given(models(), frequencies, motions)
def test_static_stability_is_the_parity_of_growing_real_exponents(model, omega, motion):
    determinant = np.linalg.det(evaluate(model, omega, motion)[1])
    exponents, _ = window_exponents(system_row(model, "omega", [omega]), motion[None], FIRST)
    real = exponents[exponents.imag == 0.0].real
    if abs(determinant) > 1e-6 and (real.size == 0 or np.min(np.abs(real)) > 1e-6):
        assert (determinant > 0.0) == (np.sum(real > 0.0) % 2 == 0)


@given(models(), frequencies, st.lists(st.integers(-2000, 2000), min_size=7, max_size=7), st.booleans(), st.booleans())
@settings(max_examples=40)
def test_exponents_are_roots_of_the_condensed_matrix(model, omega, numbers, half, truncated):
    """Those of `solver.harmonic.perturbation`, which shares nothing with the matrix but the contact's spectrum."""
    motion, period = np.array(numbers) / 1000.0, 2
    row = system_row(model, "omega", [omega])
    found, _ = window_exponents(row, motion[None], Truncation(3, period, truncated), half)
    assert abs(np.sum(found).real + row.decay[0] * found.size / row.states) < 1e-10 * found.size
    theta, direction = packed(model, "omega", None, 1, period)
    size = 7 - half
    shifts = len(model.stiffness_harmonics()) * period
    chi, psi = np.empty(size + shifts, complex), np.empty(size, complex)
    contact_and_modulated(theta, direction, motion, omega, chi, psi)
    matrix = np.empty((size, size), complex)
    spare = np.array([-xi + 1j * np.sqrt(k - xi**2) for xi, k in zip(model.xi_support, model.k_support, strict=True)])
    for s in found[0] + (0.25j * omega if half else 0.0):
        shifted = s + 0.5j * omega * np.arange(-3, 4 - half)
        poles = np.min(np.abs(shifted[:, None] - np.concatenate([spare, np.conj(spare)])))
        perturbation_matrix(theta, direction, omega, s, -3, chi, psi, truncated, matrix)
        sizes = np.linalg.svd(matrix, compute_uv=False)
        # At a pole of the condensation the exponent is of a support that lambda does not feel.
        assert poles < 1e-4 or sizes[-1] < 1e-6 * max(1.0, sizes[0])


@pytest.mark.parametrize("make", [published, antiphase])
def test_roots_one_by_one_are_those_all_at_once(make):
    balance = Galerkin(5)
    points = curve(make(), balance, 1.5, 0.4, 0.02).points
    row, truncation = system_row(make(), "omega", points[:, -1]), truncation_of(balance)
    orbits, time = points[:, :-1].copy(), 2.0 * np.pi / points[:, -1:]
    starts = np.log(multipliers(row, orbits)) / time
    found, complete = condensed_exponents(row, orbits, truncation, starts)
    assert np.mean(complete) > 0.9
    dense = np.exp(centred_exponents(row, orbits, truncation) * time)
    one_by_one = np.exp(found * time)
    both = hill_multipliers(row, orbits, truncation, np.exp(starts * time))
    for i in range(len(points)):
        # The windows are two approximations, and each method may take another one for exponents halfway between them.
        assert matched(both[i], dense[i]) < 0.1
        if complete[i]:
            np.testing.assert_allclose(both[i], one_by_one[i], rtol=0, atol=1e-9)
    window, _ = window_exponents(row, orbits, truncation)
    half, _ = window_exponents(row, orbits, truncation, half=True)
    images = np.concatenate([window, half + 0.5j * points[:, -1:]], axis=1)
    for i in np.flatnonzero(complete):
        for s in found[i]:
            assert min(np.min(np.abs(images[i] - s)), np.min(np.abs(np.conj(images[i]) - s))) < 1e-7


def test_incomplete_sets_are_found_all_at_once():
    """Supports that the contact does not drive keep their exponents, which the condensed matrix cannot have."""
    model, omega = published(translation_coupling=0.0, alpha=0.3), 0.7
    balance = Galerkin(3)
    motion = galerkin_motion(model, balance, omega, first_order(model, omega)[0][0])[None]
    row, truncation = system_row(model, "omega", [omega]), truncation_of(balance)
    floquet = multipliers(row, motion)
    _, complete = condensed_exponents(row, motion, truncation, np.log(floquet) * omega / (2.0 * np.pi))
    assert not complete[0]
    found = hill_multipliers(row, motion, truncation, floquet)
    alone = np.exp((-0.01 + 1j * np.sqrt(1.0 - 1e-4)) * 2.0 * np.pi / omega)
    assert np.min(np.abs(found[0] - alone)) < 1e-10
    assert matched(found[0], floquet[0]) < 1e-2


@pytest.mark.parametrize("make, changes", [(published, {"f_e": 0.4}), (antiphase, {})])
@pytest.mark.parametrize("order", [3, 5])
def test_hill_of_the_same_order_never_calls_a_statically_unstable_motion_stable(make, changes, order):
    """Along whole curves: an odd number of real exponents grows wherever det J < 0, and one passes 0 at each fold."""
    model, balance = make(**changes), Galerkin(order)
    traced = curve(model, balance, 2.0, 0.3)
    found = assess(model, "omega", traced.points[:, -1], traced.points[:, :-1], balance=balance, static=traced.stable)
    regular = traced.event != Event.FOLD
    unstable = regular & (traced.stable == 0)
    assert np.sum(unstable) > 20 and np.sum(~regular) >= 4
    assert not np.any(found.hill_kind[unstable] == Instability.NONE)
    assert not np.any(found.hill_kind[regular & (traced.stable == 1)] == Instability.FOLD)
    folds = traced.points[~regular]
    row, orbits = system_row(model, "omega", folds[:, -1]), folds[:, :-1].copy()
    at_folds = hill_multipliers(row, orbits, truncation_of(balance), multipliers(row, orbits))
    assert np.all(np.min(np.abs(at_folds - 1.0), axis=1) < 1e-5)
    assert np.mean(found.kind == Instability.DISPUTED) < 0.1


def test_half_odd_window_is_singular_where_the_doubled_balance_branches():
    """Along the 1T curve of order 3: sigma = 0 is where the Jacobian on the doubled period changes its sign."""
    model = consistent(rotation_coupling=0.93969262, variation_translation=0.0)
    once, twice = Galerkin(3), Galerkin(3, 2)
    once_problem, twice_problem = (b.problem(model, "omega", 1.0, 1.4) for b in (once, twice))

    def at(omega, guess):
        motion = solved(once_problem, guess, omega)
        n = twice.unknowns
        y, residual, jacobian = np.zeros(n + 1), np.empty(n), np.empty((n, n + 1))
        y[[0, *[s for k in range(1, 4) for s in (4 * k - 1, 4 * k)]]], y[-1] = motion, omega
        twice_problem.balance(twice_problem.theta, twice_problem.direction, y, residual, jacobian)
        assert np.max(np.abs(residual)) < 1e-10
        determinant = np.linalg.det(jacobian[:, :-1])
        row = system_row(model, "omega", [omega])
        exponents, _ = window_exponents(row, motion[None], truncation_of(once), half=True)
        return motion, determinant, exponents[0]

    omega, guess = 1.2, galerkin_motion(model, once, 1.2, first_order(model, 1.2)[0][0])
    motion, inside, _ = at(omega, guess)
    low, high = 1.2, 1.45
    for _ in range(45):
        middle = 0.5 * (low + high)
        motion, determinant, exponents = at(middle, motion)
        low, high = (middle, high) if determinant * inside > 0.0 else (low, middle)
    assert 1.21 < low < 1.4
    assert np.min(np.abs(exponents)) < 1e-9


def test_merged_and_unmerged_pairs_have_the_same_exponents():
    model, omega = antiphase(), 0.53
    motion = first_order(model, omega)[0][:1]
    few, _ = window_exponents(system_row(model, "omega", [omega]), motion, FIRST)
    many, _ = window_exponents(system_row(unmerged(model), "omega", [omega]), motion, FIRST)
    assert many.size == 42
    assert max(np.min(np.abs(many - s)) for s in few[0]) < 1e-9


@pytest.mark.parametrize("omega", [0.05, 0.3, 0.9, 1.7])
def test_linear_motions_have_the_exponents_of_the_closed_system(omega):
    model = published(alpha=0.0)
    motion = np.array([[3.0, 0.1, 0.2]])
    row = system_row(model, "omega", [omega])
    found = centred_exponents(row, motion, FIRST)[0]
    matrix = np.zeros((4, 4))
    matrix[:2, 2:], matrix[2:, 2:] = np.eye(2), -row.damping[0]
    matrix[2:, :2] = -row.stiffness[0] - np.outer(row.force[0], row.contact[0])
    assert matched(found, np.linalg.eigvals(matrix)) < 1e-12
    starts = multipliers(row, motion)
    one_by_one, complete = condensed_exponents(row, motion, FIRST, np.log(starts) * omega / (2.0 * np.pi))
    assert complete[0] and matched(one_by_one[0], found) < 1e-9


def test_exponents_that_newton_ran_away_with_are_apart_from_nothing():
    """Without a warning: such a motion is left to the dense problem."""
    runaway = np.array([complex(np.inf, 1.0), complex(1.0, np.inf), complex(np.nan, 0.0)])
    assert not np.any(apart(runaway, runaway, 1.0) > 0.0)
    assert apart(np.array([0.25 + 3.5j]), np.array([-0.25 + 1.5j]), 1.0) == 0.5
