"""Every first-order solution at a point: completeness, certificates, limits."""

import time

import numpy as np
import pytest

from solver import (
    Above,
    Continuation,
    Event,
    LinearSeeds,
    ParameterError,
    Proof,
    all_solutions,
    enumerate_row,
    first_order_problem,
    sweep_row,
)
from solver.continuation.on_curve import curve_crossings
from solver.enumeration.solutions import Solutions
from solver.harmonic.describing_function import evaluate, linear_solution
from solver.model.packing import axis_vectors
from tests.conftest import MODELS, antiphase, consistent, published, slow_but
from tests.solver.dense_search import dense_search


def unknowns(solutions: Solutions) -> np.ndarray:
    return np.column_stack([solutions.mean, solutions.cos, solutions.sin])


def isola_model(alpha: float = 0.44, **changes):
    return consistent(rotation_coupling=0.93969262, alpha=alpha, **changes)


def random_model(rng, name: str, **changes):
    values = dict(
        b=rng.uniform(0.1, 1.5),
        alpha=rng.uniform(0.0, 0.6),
        alpha_phase=rng.uniform(0.0, 2.0 * np.pi),
        f_e=rng.uniform(0.0, 0.6),
        f_pm=rng.uniform(-0.8, 0.8),
        f_pv=rng.uniform(-0.2, 0.2),
    )
    if rng.random() < 0.5:
        values["alpha_harmonics"] = [(rng.uniform(0.0, 0.4), rng.uniform(0.0, 2.0 * np.pi))]
    return MODELS[name](**{**values, **changes})


def degree(model, omega: float) -> float:
    theta, direction = axis_vectors(model, "omega")
    return np.sign(linear_solution(theta, direction, omega, np.empty(3)))


def test_reference_solutions(gear, reference):
    name, model = gear
    for omega, expected in reference[name]["solutions"].items():
        result = all_solutions(model, omega)
        assert result.proof is Proof.PROVEN and result.above is Above.EMPTY
        np.testing.assert_allclose(np.column_stack([result.mean, result.amplitude]), expected, rtol=0, atol=1e-8)
        assert result.stable.tolist() == [1, 0, 1][: len(expected)]


def test_isola():
    expected = [(1.609920, 0.361035, 1), (1.206839, 1.343213, 1), (1.445556, 1.420666, 0)]
    result = all_solutions(isola_model(), 0.55)
    np.testing.assert_allclose(
        np.column_stack([result.mean, result.amplitude, result.stable]), expected, rtol=0, atol=1e-6
    )
    grid = np.linspace(0.50, 0.60, 201)
    on_isola = (grid > 0.511643) & (grid < 0.580161)
    pair = (grid > 0.513399) & (grid < 0.521717)
    row = enumerate_row(isola_model(), "omega", grid)
    assert np.all(row.proof == Proof.PROVEN)
    np.testing.assert_array_equal(row.n_solutions, 1 + 2 * on_isola + 2 * pair)
    # Continuation from outside cannot know of it, and differs exactly there.
    outside = sweep_row(isola_model(), "omega", grid, seeds=LinearSeeds())
    np.testing.assert_array_equal(outside.n_solutions != row.n_solutions, on_isola)


def test_isola_is_born_between_the_documented_values():
    grid = np.linspace(0.51, 0.58, 141)
    assert np.all(enumerate_row(isola_model(0.40), "omega", grid).n_solutions == 1)
    assert np.any(enumerate_row(isola_model(0.41), "omega", grid).n_solutions == 3)


def test_five_solutions_between_the_two_folds():
    folds = 1.293183, 1.293594
    for omega in np.linspace(folds[0] + 2e-6, folds[1] - 2e-6, 9):
        result = all_solutions(antiphase(), omega)
        assert result.proof is Proof.PROVEN and result.stable.tolist() == [1, 0, 1, 0, 1]
    for omega in (folds[0] - 2e-6, folds[1] + 2e-6):
        assert len(all_solutions(antiphase(), omega).mean) == 3


@pytest.mark.costly
@pytest.mark.parametrize(("name",), slow_but([("antiphase",)], [(name,) for name in sorted(MODELS)]))
def test_agrees_with_a_dense_search(name):
    rng = np.random.default_rng(sum(map(ord, name)))
    for _ in range(15):
        model = random_model(rng, name)
        omega = rng.choice([rng.uniform(0.3, 0.8), rng.uniform(1.0, 1.6), rng.uniform(0.05, 2.2)])
        result = all_solutions(model, omega, amplitude_max=8.0)
        assert result.proof is Proof.PROVEN
        expected = dense_search(model, omega, 8.0)
        assert len(result.mean) == len(expected)
        np.testing.assert_allclose(unknowns(result), expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", sorted(MODELS))
def test_certificates_at_random_points(name):
    rng = np.random.default_rng(7 + sum(map(ord, name)))
    for _ in range(400):
        model, omega = random_model(rng, name), rng.uniform(0.05, 2.2)
        result = all_solutions(model, omega)
        assert result.proof is Proof.PROVEN
        if result.above is Above.EMPTY:
            assert len(result.mean) % 2 == 1
            assert np.sum(2 * result.stable - 1) == degree(model, omega)
        assert np.all(np.diff(result.amplitude) >= 0.0)
        boxes = result.boxes
        assert np.all(np.ptp(boxes, axis=2) < 1e-7)
        for i, y in enumerate(unknowns(result)):
            residual, jacobian = evaluate(model, omega, y)
            assert (np.linalg.det(jacobian) > 0.0) == result.stable[i]
            # Newton's correction from the middle stays in the box, but for its own rounding.
            correction = np.linalg.solve(jacobian, residual)
            assert np.all(np.abs(correction) <= 0.5 * np.ptp(boxes[i], axis=1) + 1e-12 * (1.0 + np.max(np.abs(y))))
            others = np.delete(boxes, i, axis=0)
            apart = (others[:, :, 0] > boxes[i, :, 1]) | (others[:, :, 1] < boxes[i, :, 0])
            assert np.all(np.any(apart, axis=1))


# Random rows, among them some with isolas and with branches that run through the ceiling.
ROWS = {"published": (0, 1, 35, 45, 56), "consistent": (2, 3, 20, 57), "antiphase": (4, 5, 17, 45)}


def _distances(left, right):
    """Largest difference of each pair of solutions, with an infinite last column for "none"."""
    pairs = np.max(np.abs(left[:, None] - right[None]), axis=2)
    return np.column_stack([pairs, np.full(len(left), np.inf)])


@pytest.mark.parametrize(("name", "seed"), [(name, seed) for name in ROWS for seed in ROWS[name]])
def test_contains_what_continuation_finds(name, seed):
    """What continuation lacks lies on branches of their own: followed from there, they meet none of the others."""
    model, grid = random_model(np.random.default_rng(seed), name), np.linspace(0.3, 1.7, 113)
    continuation, problem = Continuation(), first_order_problem(model, "omega", grid[0], grid[-1])
    row = sweep_row(model, "omega", grid, continuation=continuation, seeds=LinearSeeds())
    result = enumerate_row(model, "omega", grid)
    assert np.all(result.proof == Proof.PROVEN)
    triples = np.stack([result.mean, result.cos, result.sin], axis=2)
    proven = [triples[k, :n] for k, n in enumerate(result.n_solutions)]
    triples = np.stack([row.mean, row.cos, row.sin], axis=2)
    swept = [triples[k, :n] for k, n in enumerate(row.n_solutions)]
    lacking = {}
    for k in range(grid.size):
        distance = _distances(proven[k], swept[k])
        assert np.all(np.min(distance[:, :-1], axis=0) < 1e-7)
        new = np.flatnonzero(np.min(distance, axis=1) > 1e-7)
        assert len(new) == len(proven[k]) - len(swept[k])
        for i in new:
            lacking[k, i] = proven[k][i]
    assert bool(lacking) == (seed >= 17)
    while lacking:
        (k, i), start = next(iter(lacking.items()))
        curve = continuation.trace_both_ways(problem, np.append(start, grid[k]), grid[0], grid[-1])
        column, points, stable, *_ = curve_crossings(problem, curve, grid, continuation)
        before = len(lacking)
        for at, point, state in zip(column, points, stable, strict=True):
            assert np.min(_distances(point[None], swept[at])) > 1e-7
            place = int(np.argmin(_distances(point[None], proven[at])[0, :-1]))
            assert np.max(np.abs(point - proven[at][place])) < 1e-7 and result.stable[at, place] == state
            lacking.pop((at, place), None)
        assert len(lacking) < before


def test_row_over_another_parameter_equals_single_points():
    grid = np.linspace(0.0, 1.5, 31)
    row = enumerate_row(published(), "b", grid, omega=0.6)
    for k, b in enumerate(grid):
        single, n = all_solutions(published(b=b), 0.6), row.n_solutions[k]
        assert n == len(single.mean) and row.proof[k] == single.proof and row.above[k] == single.above
        np.testing.assert_array_equal(row.mean[k, :n], single.mean)
        np.testing.assert_array_equal(row.stable[k], [*single.stable, *[-1] * (row.stable.shape[1] - n)])
        np.testing.assert_array_equal(row.amplitude[k, :n], single.amplitude)
        assert np.all(row.radius[k, :n, None] >= 0.5 * np.ptp(single.boxes, axis=2))
        assert np.all(np.isnan(row.mean[k, n:]))


@pytest.mark.parametrize("factor", [0.125, 8.0, 3.7, 1e-4])
def test_scaling(factor):
    """lambda scales with b, f_pm, f_pv and f_e together."""
    for model, omega in ((published(f_pv=0.1), 0.6), (antiphase(), 1.2934)):
        scaled = model.replace(**{name: factor * getattr(model, name) for name in ("b", "f_pm", "f_pv", "f_e")})
        one, other = all_solutions(model, omega), all_solutions(scaled, omega)
        assert one.stable.tolist() == other.stable.tolist()
        np.testing.assert_allclose(unknowns(other), factor * unknowns(one), rtol=1e-10, atol=1e-12 * factor)


def test_mirrored_loads_give_mirrored_solutions():
    for model, omega in ((published(f_pv=0.1), 0.6), (antiphase(), 1.2934)):
        mirrored = model.replace(f_pm=-model.f_pm, f_pv=-model.f_pv, f_e=-model.f_e)
        one, other = all_solutions(model, omega), all_solutions(mirrored, omega)
        np.testing.assert_allclose(unknowns(other), -unknowns(one), rtol=0, atol=1e-12)
        assert one.stable.tolist() == other.stable.tolist()


def _folds(name):
    row = sweep_row(MODELS[name](), "omega", np.linspace(0.05, 2.0, 40))
    return [curve.points[i, 3] for curve in row.curves for i in np.flatnonzero(curve.event == Event.FOLD)]


@pytest.mark.parametrize("name", ["published", "antiphase"])
def test_undecided_at_folds_and_decided_beside_them(name):
    model = MODELS[name]()
    for fold in _folds(name):
        near = [all_solutions(model, fold + d) for d in np.linspace(-1e-13, 1e-13, 41)]
        undecided = [result for result in near if result.proof is Proof.UNDECIDED]
        assert undecided
        for result in undecided:
            assert len(result.undecided) > 0 and np.all(np.ptp(result.undecided[:, 1:], axis=2) < 1e-4)
        counts = {}
        for distance in (-1e-6, -1e-9, 1e-9, 1e-6):
            result = all_solutions(model, fold + distance)
            assert result.proof is Proof.PROVEN and len(result.undecided) == 0
            counts[distance] = len(result.mean)
        assert counts[-1e-6] == counts[-1e-9] and counts[1e-6] == counts[1e-9]
        assert abs(counts[1e-6] - counts[-1e-6]) == 2
        # Close to the fold either the count is right or nothing is claimed.
        for result in near:
            if result.proof is Proof.PROVEN:
                assert len(result.mean) in counts.values()


def test_no_backlash_is_the_linear_solution():
    rng = np.random.default_rng(3)
    for name in sorted(MODELS):
        model, omega = random_model(rng, name, b=0.0), rng.uniform(0.1, 2.0)
        result = all_solutions(model, omega)
        expected = np.empty(3)
        linear_solution(*axis_vectors(model, "omega"), omega, expected)
        assert result.proof is Proof.PROVEN and result.above is Above.EMPTY
        np.testing.assert_allclose(unknowns(result)[0], expected, rtol=0, atol=1e-12)
    tiny = all_solutions(published(b=1e-14), 0.6)
    np.testing.assert_allclose(unknowns(tiny), unknowns(all_solutions(published(b=0.0), 0.6)), rtol=0, atol=1e-12)


def test_zero_amplitude_is_a_regular_point():
    result = all_solutions(published(alpha=0.0, f_e=0.0), 0.7)
    assert result.proof is Proof.PROVEN and result.stable.tolist() == [1]
    np.testing.assert_allclose(result.mean, [1.0 + 0.5 / 0.7719], rtol=0, atol=1e-12)
    assert result.amplitude[0] < 1e-200
    for f_e in (1e-12, 1e-6):
        assert 0.0 < all_solutions(published(alpha=0.0, f_e=f_e), 0.7).amplitude[0] < 10.0 * f_e


def test_without_mean_load_the_gap_holds_a_continuum():
    for name, model in MODELS.items():
        result = all_solutions(model(f_pm=0.0), 0.7)
        assert result.proof is Proof.CONTINUUM and len(result.mean) == 0, name
    # A large excitation reaches both flanks: the motion is symmetric, and the gap holds none.
    result = all_solutions(published(f_pm=0.0, f_e=1.0, b=0.2), 1.5)
    assert result.proof is Proof.PROVEN and len(result.mean) == 1
    assert abs(result.mean[0]) < 1e-12 and result.amplitude[0] > 0.2
    # Without any excitation every position in the gap is at rest; that is not sorted out, but not hidden either.
    assert all_solutions(published(f_pm=0.0, f_e=0.0), 0.7).proof is Proof.UNDECIDED
    # A load that is small but not 0 leaves one mean.
    small = all_solutions(published(f_pm=1e-9), 0.7)
    assert small.proof is Proof.PROVEN and small.mean[0] > 0.0


def test_parametric_resonance_runs_above_any_ceiling():
    model = isola_model(variation_translation=0.0)
    low, high = model.replace(alpha=0.45), model.replace(alpha=0.46)
    assert all_solutions(low, 0.5918).above is Above.EMPTY
    result = all_solutions(high, 0.592)
    assert result.proof is Proof.PROVEN and result.above is Above.OCCUPIED
    assert result.stable.tolist() == [1, 0] and (degree(low, 0.592), degree(high, 0.592)) == (1.0, -1.0)
    higher = all_solutions(high, 0.592, amplitude_max=1e6)
    assert higher.above is Above.EMPTY and higher.stable.tolist() == [1, 0, 0] and higher.amplitude[2] > 100.0
    inside = all_solutions(model.replace(alpha=0.5), 0.592)
    assert inside.above is Above.EMPTY and inside.stable.tolist() == [1, 0, 0] and inside.amplitude[2] < 40.0


def test_singular_linear_system_is_open_above():
    model = isola_model(variation_translation=0.0)
    low, high = 0.45, 0.5
    for _ in range(60):
        middle = 0.5 * (low + high)
        if degree(model.replace(alpha=middle), 0.592) > 0.0:
            low = middle
        else:
            high = middle
    result = all_solutions(model.replace(alpha=low), 0.592)
    assert result.above is Above.OPEN and "nearly singular" in result.sentence
    assert result.proof is Proof.PROVEN and len(result.mean) == 2


UNDAMPED = dict(xi_mesh=0.0, xi_translation=0.0, xi_support=0.0, variation_rotation=0.0)


@pytest.mark.parametrize(("seed",), slow_but([(seed,) for seed in range(6)], [(seed,) for seed in range(12)]))
def test_undamped_gears_are_proven(seed):
    """D + t A' is real and a common factor: 0/0 at one gain, unless it is left out."""
    rng = np.random.default_rng(seed)
    changes = {**UNDAMPED, "alpha_harmonics": [], "f_pm": rng.uniform(0.2, 0.8), "k_support": rng.uniform(0.3, 3.0, 6)}
    if seed % 3 == 0:
        # Without translations their damping does not matter.
        changes |= {
            "translation_coupling": 0.0,
            "xi_support": 0.01,
            "xi_translation": 0.02,
            "alpha_harmonics": [(0.2, 1.0)],
        }
    model, omega = random_model(rng, sorted(MODELS)[seed % 2], **changes), rng.uniform(0.2, 2.2)
    result, expected = all_solutions(model, omega, amplitude_max=8.0), dense_search(model, omega, 8.0, 120)
    assert result.proof is Proof.PROVEN and len(result.mean) == len(expected)
    np.testing.assert_allclose(unknowns(result), expected, rtol=0, atol=1e-6)
    for y, stable in zip(unknowns(result), result.stable, strict=True):
        assert (np.linalg.det(evaluate(model, omega, y)[1]) > 0.0) == stable
    # A little damping, and the factor is none: the same solutions nearly.
    damped = all_solutions(model.replace(xi_mesh=1e-9), omega, amplitude_max=8.0)
    assert damped.proof is Proof.PROVEN and damped.stable.tolist() == result.stable.tolist()
    np.testing.assert_allclose(unknowns(damped), unknowns(result), rtol=0, atol=1e-5)


def test_undamped_support_in_resonance_is_undecided():
    result = all_solutions(published(xi_support=0.0), 1.0)
    assert result.proof is Proof.UNDECIDED and result.above is Above.OPEN and len(result.undecided) == 1


def test_ceiling_only_selects():
    model = antiphase()
    everything = all_solutions(model, 1.2934)
    some = all_solutions(model, 1.2934, amplitude_max=2.0)
    assert some.proof is Proof.PROVEN and some.above is Above.OCCUPIED
    np.testing.assert_array_equal(unknowns(some), unknowns(everything)[:3])


def test_refused_arguments():
    for omega in (0.0, -1.0, np.inf, np.nan, None):
        with pytest.raises(ParameterError, match="omega"):
            all_solutions(published(), omega)
    with pytest.raises(ParameterError, match="amplitude_max"):
        all_solutions(published(), 1.0, amplitude_max=0.0)
    with pytest.raises(ParameterError, match="omega"):
        enumerate_row(published(), "b", [0.5, 1.0])
    with pytest.raises(ParameterError, match="axis"):
        enumerate_row(published(), "nonsense", [0.5, 1.0], omega=1.0)


def test_speed():
    """At most 2 ms in the median are promised; measured is a hundredth of that (benchmarks.enumeration)."""
    for model in MODELS.values():
        times = []
        for omega in np.linspace(0.05, 2.0, 101):
            start = time.perf_counter()
            all_solutions(model(), omega)
            times.append(time.perf_counter() - start)
        assert np.median(times) < 2e-3
