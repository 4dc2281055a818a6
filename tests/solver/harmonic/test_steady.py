"""One motion from a guess: corrected from far away, or refused with the reason."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import solver
from solver import ContactSystem, ParameterError, SolveStatus, all_solutions, solve, uncondensed_balance
from solver.continuation.on_curve import curve_crossings
from solver.harmonic.galerkin import Galerkin
from solver.harmonic.uncondensed import translations
from tests.conftest import antiphase, published
from tests.solver.continuation.test_stiff_contact import NATURAL, chain, free_start, swept

GRID = np.linspace(0.3, 1.9, 15)
#: Frequencies at which the chain hits its stop hard, in units of its natural one.
HITS = np.array([0.95, 0.98, 1.0, 1.02, 1.05])


def residual_of(system, balance, omega, motion):
    residual, jacobian = balance.problem(system, "omega", 0.5 * omega, 1.5 * omega).evaluated(np.append(motion, omega))
    return np.max(np.abs(residual)), jacobian[:, :-1]


@pytest.mark.parametrize("make", [published, antiphase])
def test_solutions_are_found_again_from_beside_them(make):
    model = make(f_e=0.3)
    for omega in GRID:
        known = all_solutions(model, omega)
        for motion, stable in zip(np.transpose([known.mean, known.cos, known.sin]), known.stable, strict=True):
            found = solve(model, motion + [1e-3, -2e-3, 1e-3], omega)
            assert found.status is SolveStatus.CONVERGED and found.stable == stable
            np.testing.assert_allclose(found.motion, motion, rtol=0, atol=1e-11)
            assert 1e-3 < found.distance < 3e-3


@given(st.integers(0, 2**32 - 1))
def test_from_anywhere_it_is_a_solution_or_a_refusal(seed):
    """A solution solves all 21 equations and is one of those that enumeration proves to be all."""
    draw = np.random.default_rng(seed)
    model, omega = (published, antiphase)[seed % 2](f_e=draw.uniform(0.05, 0.5)), draw.uniform(0.3, 1.9)
    found = solve(model, draw.normal(scale=10.0 ** draw.uniform(-1.0, 2.0), size=3), omega)
    if found.status is not SolveStatus.CONVERGED:
        assert found.status.sentence and np.all(np.isnan(found.motion)) and np.isnan(found.distance)
        assert not found.stable
        return
    unknowns = np.hstack([translations(model, omega, found.motion), found.motion[:, None]]).ravel()
    assert np.max(np.abs(uncondensed_balance(model, omega, unknowns)[0])) < 1e-10
    known = all_solutions(model, omega)
    gaps = np.max(np.abs(np.transpose([known.mean, known.cos, known.sin]) - found.motion), axis=1)
    assert np.min(gaps) < 1e-9 and found.stable == known.stable[np.argmin(gaps)]


def test_bad_starts_lead_to_solutions_more_often_than_full_steps():
    """Guesses in contact for a moment at least, several times as large as the motion."""
    draw, counts = np.random.default_rng(7), np.zeros(3, np.int64)
    for make in (published, antiphase):
        model, balance = make(f_e=0.3), Galerkin(5)
        problem = balance.problem(model, "omega", 0.3, 1.9)
        for omega in draw.uniform(0.3, 1.9, 60):
            guess = draw.normal(scale=4.0, size=11) / (1.0 + np.arange(11) // 2) ** 2
            if np.max(np.abs(balance.extremes(guess[None]))) < model.b:
                continue
            found = solve(model, guess, omega)
            plain = problem.corrected(np.append(guess, omega), solver.Newton(), max_iterations=50)
            counts += 1, found.status is SolveStatus.CONVERGED, plain is not None
            if found.status is SolveStatus.CONVERGED:
                assert residual_of(model, balance, omega, found.motion)[0] < 1e-10
    assert counts[1] > 1.15 * counts[2] and counts[1] > 0.5 * counts[0], counts


@pytest.mark.parametrize("stiffness", [10.0, 1e3, 1e5])
def test_motions_that_hit_a_stiff_stop(stiffness):
    """Guesses off by a thousandth, which is up to a hundred times as much as the stop gives way."""
    system, balance, draw = chain(stiffness), Galerkin(15), np.random.default_rng(1)
    _, curve = swept(system, 15, 0.8 * NATURAL, 1.3 * NATURAL)
    _, high = balance.extremes(curve.points[:, :-1])
    hits = curve.points[(high > system.front_gap + 1e-9) & (curve.event == solver.Event.NONE)][::9]
    solved = 0
    for y in hits:
        guess = y[:-1] + 1e-3 * draw.normal(size=31) / (1.0 + np.arange(31) // 2) ** 2
        found = solve(system, guess, y[-1], balance=balance)
        if found.status is SolveStatus.CONVERGED:
            residual, jacobian = residual_of(system, balance, y[-1], found.motion)
            assert residual < 1e-9 * np.max(np.abs(jacobian)) and found.stable == (np.linalg.det(jacobian) > 0.0)
            solved += 1
    assert len(hits) >= 10 and solved == len(hits)


@pytest.mark.costly
@pytest.mark.parametrize("stiffness", [1e2, 1e3, 1e4, 1e5])
def test_the_motion_without_the_stop_leads_to_the_one_that_hits_it(stiffness):
    """It goes up to three times as far, and Newton's method alone does not settle; against the traced curve."""
    system, balance = chain(stiffness), Galerkin(15)
    problem, curve = swept(system, 15, 0.8 * NATURAL, 1.3 * NATURAL)
    free = [free_start(system, balance, share * NATURAL)[:-1] for share in HITS]
    assert np.all(balance.extremes(np.array(free))[1] > 1.05 * system.front_gap)
    met = curve_crossings(problem, curve, HITS * NATURAL, solver.Continuation())
    for k, guess in enumerate(free):
        found = solve(system, guess, HITS[k] * NATURAL, balance=balance)
        assert found.status is SolveStatus.CONVERGED and found.distance == np.max(np.abs(found.motion - guess))
        known = np.max(np.abs(met.unknowns[met.column == k] - found.motion), axis=1)
        assert np.min(known) < 1e-7 and found.stable == met.stable[met.column == k][np.argmin(known)]


def test_a_contact_that_must_be_stiff_is_not_softened():
    """An inverted pendulum that leans on its stop: a tenth of that stiffness would not hold it."""
    system = ContactSystem([[1.0]], [[0.1]], [[-1.0]], [1.0], [10.0], 0.0, 0.0, load=[[0.1], [2.0]])
    found = solve(system, [30.0, 1e3, -1e4], 0.9, max_iterations=1)
    assert found.status is not SolveStatus.CONVERGED and found.status.sentence


def test_reasons():
    # Between the flanks nothing holds the mean.
    assert solve(published(), [0.2, 0.1, 0.0], 0.7).status is SolveStatus.SINGULAR
    found = solve(published(f_e=0.3), [1.6, 0.8, 0.1], 0.6, max_iterations=1)
    assert found.status is SolveStatus.NOT_SETTLED and np.all(np.isnan(found.motion))
    # A pull on a contact that only pushes: the balance has no solution.
    spring = ContactSystem([[1.0]], [[0.1]], [[0.0]], [1.0], [1.0], 0.5, load=[[-0.3], [0.4]])
    for guess in ([1.0, 0.5, 0.0], [-0.2, 2.0, 0.3], [0.6, 0.3, 0.3]):
        assert solve(spring, guess, 0.8).status is not SolveStatus.CONVERGED


def test_balances_that_are_meant():
    model = published()
    (motion,) = np.transpose([getattr(all_solutions(model, 1.0), name) for name in ("mean", "cos", "sin")])
    np.testing.assert_allclose(solve(model, motion, 1.0).motion, motion, rtol=0, atol=1e-12)
    third = solve(model, motion, 1.0, balance=Galerkin(3))
    assert third.motion.size == 7 and residual_of(model, Galerkin(3), 1.0, third.motion)[0] < 1e-12
    np.testing.assert_allclose(solve(model, third.motion, 1.0).motion, third.motion, rtol=0, atol=1e-14)
    halves = solve(model, motion, 1.0, balance=Galerkin(1, 2))
    np.testing.assert_allclose(halves.motion[[0, 3, 4]], solve(model, motion, 1.0, balance=Galerkin(1)).motion)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (([1.0, 2.0], 0.6), "guess"),
        (([1.0, np.nan, 0.0], 0.6), "guess"),
        (([[1.0, 0.0, 0.0]], 0.6), "guess"),
        (([1.0, 0.0, 0.0], 0.0), "omega"),
        (([1.0, 0.0, 0.0], np.inf), "omega"),
    ],
)
def test_what_is_not_allowed(arguments, name):
    with pytest.raises(ParameterError) as error:
        solve(published(), *arguments)
    assert error.value.name == name


def test_what_is_not_allowed_of_the_balance():
    with pytest.raises(ParameterError) as error:
        solve(published(), np.ones(5), 0.6, balance=Galerkin(3))
    assert error.value.name == "guess"
    with pytest.raises(ParameterError) as error:
        solve(published(), np.ones(3), 0.6, max_iterations=0)
    assert error.value.name == "max_iterations"
