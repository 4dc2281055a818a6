"""Enumeration of systems that are no gear pair: held by springs or free, with two flanks or one, damped in any way."""

import numpy as np
import pytest

from solver import ContactSystem, Newton, ParameterError, Proof, all_solutions, enumerate_row, gear_system
from solver.enumeration.condensed import condensed_over
from solver.enumeration.contact_law import contact_law
from solver.enumeration.enclosed import MEAN_GAIN, MEAN_LOAD, SHIFT
from solver.enumeration.gain_bounds import gain_over, gain_slopes
from solver.harmonic.describing_function import evaluate, first_order_problem
from tests.conftest import MODELS

_RATIOS = (0.4, 2.5)
_OPTIONS = [(held, sided, varied) for held in (True, False) for sided in (2, 1) for varied in (True, False)]


def random_system(rng, held: bool, flanks: int, varied: bool, ratio: float = 1.0) -> ContactSystem:
    """Positive stiffness and a general damping matrix; free to move along a rigid motion unless springs hold it."""
    n = int(rng.integers(1 if held else 2, 5))
    root = rng.normal(size=(n, n))
    stiffness = root @ root.T / n + 0.2 * np.eye(n)
    contact = rng.normal(size=n)
    if not held:
        # Springs between neighbours alone: the sum of all is free.
        ends = np.diff(np.eye(n), axis=0)
        stiffness = ends.T @ np.diag(rng.integers(1, 8, n - 1) / 4.0) @ ends
        contact[0] += 6.0
    root = rng.normal(size=(n, n))
    harmonics = ((rng.uniform(0.1, 0.5), rng.uniform(0.0, 6.0)), (rng.uniform(0.0, 0.3), 1.0)) if varied else ()
    # What holds lambda by springs may vary in the second harmonic alone.
    if held and varied:
        harmonics = ((0.0, 0.0), harmonics[1])
    force = rng.uniform(0.5, 5.0) * contact
    mean = np.zeros(n)
    mean[0] = np.sign(np.sum(contact)) * rng.uniform(0.2, 1.5)
    if flanks == 2:
        mean *= rng.choice([-1.0, 1.0])
    return ContactSystem(
        mass=np.diag(rng.uniform(0.5, 2.0, n)),
        damping=0.003 * (root @ root.T) + 0.002 * np.eye(n),
        stiffness=stiffness,
        contact=contact,
        force=force,
        front_gap=rng.uniform(0.1, 1.0),
        back_gap=rng.uniform(0.1, 1.0) if flanks == 2 else np.inf,
        back_stiffness=ratio,
        varying_force=force * rng.uniform(0.5, 1.0),
        stiffness_harmonics=harmonics,
        load=np.array([mean, rng.uniform(-1.0, 1.0, n) + 1j * rng.uniform(-1.0, 1.0, n)]),
        inertial_load=np.array([np.zeros(n), 0.2 * rng.normal(size=n)]),
    )


def by_newton(system: ContactSystem, omega: float, rng, starts: int) -> np.ndarray:
    """Distinct solutions (k, 3) that Newton's method reaches from many starts."""
    problem, found = first_order_problem(system, "omega", 0.5 * omega, 1.5 * omega), []
    size = system.motion_size + np.max(np.abs(system.load)) * 5.0
    for _ in range(starts):
        y = np.append(rng.uniform(-1.0, 1.0, 3) * size * 10.0 ** rng.uniform(-1.0, 0.5), omega)
        y = problem.corrected(y, Newton(), max_iterations=30)
        if y is None or np.hypot(y[1], y[2]) > 99.0:
            continue
        if all(np.max(np.abs(y[:3] - other)) > 1e-6 for other in found):
            found.append(y[:3])
    return np.array(found).reshape(-1, 3)


@pytest.mark.parametrize(
    ("held", "flanks", "varied", "ratio"),
    [(*option, 1.0) for option in _OPTIONS]
    + [(*option, ratio) for option in _OPTIONS if option[1] == 2 for ratio in _RATIOS],
)
def test_newton_finds_no_solution_that_is_not_listed(held, flanks, varied, ratio):
    rng, several = np.random.default_rng(8 * held + 4 * varied + flanks), 0
    for _ in range(60 if ratio == 1.0 else 30):
        system = random_system(rng, held, flanks, varied, ratio)
        closed = np.linalg.solve(system.mass, system.stiffness + np.outer(system.force, system.contact))
        omega = rng.uniform(0.45, 1.0) * np.sqrt(np.max(np.linalg.eigvals(closed).real))
        found = all_solutions(system, omega)
        assert found.proof is Proof.PROVEN
        listed = np.column_stack([found.mean, found.cos, found.sin])
        several += len(listed) > 1
        for motion, stable in zip(listed, found.stable, strict=True):
            residual, jacobian = evaluate(system, omega, motion)
            assert np.max(np.abs(np.linalg.solve(jacobian, residual))) < 1e-8 * (1.0 + np.max(np.abs(motion)))
            assert (np.linalg.det(jacobian) > 0.0) == stable
        for motion in by_newton(system, omega, rng, 8):
            assert np.min(np.max(np.abs(listed - motion), axis=1)) < 1e-5
    assert several > 0 or flanks == 1


@pytest.mark.parametrize("name", sorted(MODELS))
def test_a_gear_pair_as_a_system_has_the_same_solutions(name):
    model = MODELS[name](alpha_harmonics=[(0.1, 0.3)], f_pv=0.05)
    grid = np.linspace(0.3, 1.7, 60)
    mine, theirs = enumerate_row(model, "omega", grid), enumerate_row(gear_system(model), "omega", grid)
    assert np.all(theirs.proof == Proof.PROVEN)
    np.testing.assert_array_equal(mine.stable, theirs.stable)
    np.testing.assert_allclose(mine.motions, theirs.motions, rtol=0, atol=1e-9)


def test_receptances_are_enclosed():
    """By those of the same matrices in extended precision: with M = I and one damper the inverse is known."""
    k, c, w = 0.3, 0.04, 0.85
    system = ContactSystem([[1.0]], [[c]], [[k]], [1.0], [2.0], 0.4, 0.1, load=[[0.7], [0.3 - 0.2j]])
    enclosed = condensed_over(system, "omega", np.array([w]), None)[0]
    exact = np.clongdouble(np.longdouble(k) - np.longdouble(w) ** 2 + 1j * np.longdouble(w) * np.longdouble(c))
    for row, value in ((2, 2.0 / exact), (8, (0.3 - 0.2j) / exact)):
        for part, number in ((0, value.real), (1, value.imag)):
            low, high = enclosed[row + part]
            assert low <= number <= high and high - low < 1e-13 * abs(value)
    assert enclosed[MEAN_GAIN, 0] <= 2.0 / np.longdouble(k) <= enclosed[MEAN_GAIN, 1]
    # Seen from the middle of the gap.
    assert enclosed[SHIFT, 0] <= 0.5 * (np.longdouble(0.4) - np.longdouble(0.1)) <= enclosed[SHIFT, 1]
    mean = np.longdouble(0.7) / np.longdouble(k) - 0.5 * (np.longdouble(0.4) - np.longdouble(0.1))
    assert enclosed[MEAN_LOAD, 0] <= mean <= enclosed[MEAN_LOAD, 1]


def _law(nu, beta, kappa, far):
    """phi and N of a motion of amplitude 1, by quadrature; `far` is the stiffness of the far flank."""
    angle = (np.arange(40_000) + 0.5) * (np.pi / 40_000)
    place = nu + np.cos(angle)
    force = np.maximum(place - beta, 0.0) - far * np.maximum(-place - beta, 0.0)
    return np.mean(force) + kappa * nu, 2.0 * np.mean(force * np.cos(angle))


@pytest.mark.parametrize("flanks", [2, 1])
@pytest.mark.parametrize("kappa", [1e-3, 0.2, 5.0])
def test_law_of_a_held_contact(kappa, flanks):
    rng, law = np.random.default_rng(5), (kappa, 1e-16, float(flanks - 1))
    for _ in range(150):
        beta = rng.uniform(0.0, 1.5) if flanks == 2 else 0.0
        nu = rng.uniform(0.0 if flanks == 2 else -2.0, 3.0)
        phi, gain = _law(nu, beta, kappa, flanks - 1)
        found = contact_law(beta - nu, beta, law)
        np.testing.assert_allclose(found[:2], (phi, gain), rtol=0, atol=2e-7)
        gains, cosines = gain_over((found[0], found[0]), (beta, beta), law, np.nan, 0.0)
        assert gains[0] <= found[1] <= gains[1] and gains[1] - gains[0] < 1e-9
        assert cosines[0] <= beta - nu <= cosines[1]
        # Over a rectangle, and the slopes by differences.
        width = 10.0 ** rng.uniform(-4, -0.5)
        phis, betas = (found[0] - width, found[0] + width), (beta, beta + (width if flanks == 2 else 0.0))
        phis = (max(phis[0], 0.0), phis[1]) if flanks == 2 else phis
        gains, cosines = gain_over(phis, betas, law, np.nan, 0.0)
        by_force, by_gap = gain_slopes(phis, betas, cosines, law, 0.0)
        assert gains[0] <= found[1] <= gains[1] and by_force[0] >= 0.0 and by_gap[1] <= 0.0
        step = 1e-6
        (f_0, n_0), (f_1, n_1) = (contact_law(beta - nu + s, beta, law)[:2] for s in (-step, step))
        slope = (n_1 - n_0) / (f_1 - f_0)
        assert by_force[0] - 1e-4 <= slope <= by_force[1] + 1e-4
        if flanks == 2 and beta > step:
            (f_2, n_2), (f_3, n_3) = (contact_law(beta - nu, beta + s, law)[:2] for s in (-step, step))
            by = ((n_3 - n_2) - slope * (f_3 - f_2)) / (2.0 * step)
            assert by_gap[0] - 1e-4 <= by <= by_gap[1] + 1e-4


@pytest.mark.parametrize("far", [0.05, 0.5, 0.98])
@pytest.mark.parametrize("kappa", [0.0, 1e-3, 0.7])
def test_law_of_unlike_flanks(kappa, far):
    """Bounds over rectangles hold everywhere in them; N falls with phi and then grows."""
    rng, law, signs = np.random.default_rng(6), (kappa, 1e-16 * kappa, far), set()
    for _ in range(60):
        beta, width = rng.uniform(0.0, 1.5) * rng.choice([1.0, 3.0]), 10.0 ** rng.uniform(-5, -0.3)
        nu = rng.uniform(-1.0, 1.0) * (1.0 + beta)
        found = contact_law(beta - nu, beta, law)
        np.testing.assert_allclose(found[:2], _law(nu, beta, kappa, far), rtol=0, atol=2e-7)
        gains, cosines = gain_over((found[0], found[0]), (beta, beta), law, np.nan, 0.0)
        # The mean is free inside the gap where no spring holds it.
        if kappa > 0.0 or abs(nu) > beta - 0.99:
            assert gains[0] <= found[1] <= gains[1]
            assert gains[1] - gains[0] < 1e-9
            assert cosines[0] <= beta - nu <= cosines[1]
        phis, betas = (found[0] - width, found[0] + 0.5 * width), (beta, beta + width)
        gains, cosines = gain_over(phis, betas, law, np.nan, 0.1 * width)
        by_force, by_gap = gain_slopes(phis, betas, cosines, law, 0.1 * width)
        assert gains[1] - gains[0] < 8.0 * width + 1e-9
        for other_beta in np.linspace(*betas, 4):
            for other_nu in nu + width * np.linspace(-4.0, 4.0, 17):
                phi, gain, _, _, angles = contact_law(other_beta - other_nu, other_beta, law)
                if not phis[0] <= phi <= phis[1] or (
                    kappa == 0.0 and (angles == 0.0 or abs(other_nu) > 1.0 + other_beta)
                ):
                    continue
                assert gains[0] <= gain <= gains[1]
                step = 1e-6
                (f_0, n_0), (f_1, n_1) = (
                    contact_law(other_beta - other_nu + s, other_beta, law)[:2] for s in (-step, step)
                )
                if abs(f_1 - f_0) < 1e-9:
                    continue
                slope = (n_1 - n_0) / (f_1 - f_0)
                signs.add(np.sign(slope))
                assert by_force[0] - 2e-3 <= slope <= by_force[1] + 2e-3
                (f_2, n_2), (f_3, n_3) = (
                    contact_law(other_beta - other_nu, other_beta + s, law)[:2] for s in (-step, step)
                )
                by = ((n_3 - n_2) - slope * (f_3 - f_2)) / (2.0 * step)
                assert by_gap[0] - 2e-3 <= by <= by_gap[1] + 2e-3
    assert signs >= {-1.0, 1.0}


def stop(**changes):
    parts = dict(mass=[[1.0]], damping=[[0.05]], stiffness=[[1.0]], contact=[1.0], force=[10.0], front_gap=1.0)
    return ContactSystem(**{**parts, "load": [[0.0], [0.1]], **changes})


@pytest.mark.parametrize(
    ("system", "name"),
    [
        (stop(varying_force=[1.0], stiffness_harmonics=[(0.1, 0.0)]), "stiffness_harmonics"),
        (stop(force=[-0.5]), "stiffness"),
        (stop(stiffness=[[0.0]], load=[[-0.1], [0.1]]), "load"),
    ],
)
def test_of_what_nothing_can_be_proven(system, name):
    with pytest.raises(ParameterError) as error:
        all_solutions(system, 0.8)
    assert error.value.name == name


def test_without_contact_and_in_permanent_contact():
    free = all_solutions(stop(), 0.5)
    assert free.proof is Proof.PROVEN and free.gain.tolist()[0][0] == 0.0
    expected = 0.1 / (1.0 - 0.25 + 0.025j)
    np.testing.assert_allclose(
        [free.mean[0], free.cos[0], -free.sin[0]], [0.0, expected.real, expected.imag], atol=1e-12
    )
    pressed = all_solutions(stop(load=[[30.0], [0.1]]), 0.5)
    # lambda_m + 10 (lambda_m - 1) = 30.
    assert pressed.proof is Proof.PROVEN and pressed.mean[0] == pytest.approx(40.0 / 11.0, abs=1e-12)


def test_no_damping_at_all():
    system = stop(damping=[[0.0]], back_gap=1.0)
    row = enumerate_row(system, "omega", np.linspace(0.5, 1.9, 50))
    assert np.all(row.proof == Proof.PROVEN) and row.n_solutions.max() == 3
