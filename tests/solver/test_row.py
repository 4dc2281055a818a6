"""Rows: branches and raster of one line of a plane, their limits, symmetries and failures."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import (
    Continuation, EndReason, Event, ImpactState, LinearSeeds, ParameterError, ProvenSeeds, RowError, domain_label,
    impact_state, sweep_row, uncondensed_balance,
)  # fmt: skip
from solver.condensation import AXES
from solver.harmonic.first_order import evaluate
from tests.conftest import MODELS, antiphase, consistent, published, slow_but
from tests.solver.exhaustive import all_solutions
from tests.solver.independent import linear_response
from tests.solver.strategies import numbers, random_model

LOW, HIGH = 0.05, 2.0
COS_20 = 0.93969262


def grid(columns):
    return np.linspace(LOW, HIGH, columns)


def solutions(row, column):
    """(k, 3) solutions of one column."""
    count = row.n_solutions[column]
    return np.column_stack([row.mean[column], row.cos[column], row.sin[column]])[:count]


def assert_same_columns(row, columns, other, others, atol=1e-10, same_axis=True):
    """Counts, stability, states and values agree at two sets of columns; what is open beside them is the axis's matter."""
    np.testing.assert_array_equal(row.n_solutions[columns], other.n_solutions[others])
    np.testing.assert_array_equal(row.domain[columns], other.domain[others])
    if same_axis:
        np.testing.assert_array_equal(row.open[columns], other.open[others])
    for i, j in zip(np.arange(len(row.grid))[columns], np.arange(len(other.grid))[others], strict=True):
        count = row.n_solutions[i]
        np.testing.assert_allclose(solutions(row, i), solutions(other, j), rtol=0, atol=atol)
        np.testing.assert_array_equal(row.stable[i, :count], other.stable[j, :count])
        np.testing.assert_array_equal(row.impact[i, :count], other.impact[j, :count])


def fold_places(row):
    """p of every fold, and by how much the number of solutions grows there with growing p."""
    places = []
    for curve in row.curves:
        for i in np.flatnonzero(curve.event == Event.FOLD):
            # Both sides of a fold lie below it (two solutions end there) or above it.
            places.append((curve.points[i, 3], 2 if curve.points[i - 1, 3] > curve.points[i, 3] else -2))
    return places


VARIANTS = [dict(), dict(f_e=0.4), dict(b=0.3), dict(alpha=0.5), dict(f_pm=0.35)]


# Raster ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("changes", VARIANTS)
def test_the_number_of_columns_does_not_matter(gear, changes):
    _, model = gear
    model = model.replace(**changes)
    coarse, middle, fine = (sweep_row(model, "omega", grid(columns)) for columns in (81, 161, 321))
    np.testing.assert_allclose(fine.grid[::4], coarse.grid, rtol=0, atol=1e-15)
    assert_same_columns(coarse, slice(None), middle, slice(None, None, 2))
    assert_same_columns(coarse, slice(None), fine, slice(None, None, 4))


@pytest.mark.parametrize("changes", VARIANTS)
def test_the_number_of_solutions_changes_across_folds_only(gear, changes):
    _, model = gear
    row = sweep_row(model.replace(**changes), "omega", grid(321))
    assert not np.any(row.open)
    expected = np.full(321, row.n_solutions[0])
    for place, change in fold_places(row):
        expected[row.grid > place] += change
    np.testing.assert_array_equal(row.n_solutions, expected)
    np.testing.assert_array_equal(row.n_stable, (row.n_solutions + 1) // 2)


@pytest.mark.parametrize("changes", VARIANTS)
def test_every_solution_is_one_and_is_described_truly(gear, changes):
    _, model = gear
    model = model.replace(**changes)
    row = sweep_row(model, "omega", grid(157))
    for i, omega in enumerate(row.grid):
        found = solutions(row, i)
        assert len(found) == row.n_solutions[i] == np.sum(np.isfinite(row.mean[i]))
        amplitudes = np.hypot(found[:, 1], found[:, 2])
        assert np.all(np.diff(amplitudes) > 0.0)
        for s, (solution, amplitude) in enumerate(zip(found, amplitudes, strict=True)):
            residual, jacobian = evaluate(model, omega, solution)
            assert np.max(np.abs(residual)) < 1e-12 * max(1.0, np.max(np.abs(solution)))
            assert row.stable[i, s] == (np.linalg.det(jacobian) > 0.0)
            assert row.impact[i, s] == impact_state(solution[0] - amplitude, solution[0] + amplitude, model.b)
            assert row.amplitude[i, s] == amplitude
            motion = row.amplitude[i, s] * np.exp(1j * row.phase[i, s])
            assert motion == pytest.approx(complex(solution[1], -solution[2]), abs=1e-14)
        states = sorted({int(row.impact[i, s]) for s in range(len(found)) if row.stable[i, s] == 1})
        label = f"{np.sum(row.stable[i] == 1)}/{'-'.join(ImpactState(k).symbol for k in states)}"
        assert domain_label(row.domain[i]) == label
        assert np.all(row.stable[i, len(found) :] == -1) and np.all(row.impact[i, len(found) :] == -1)


@pytest.mark.parametrize("name", MODELS)
def test_a_column_exactly_on_an_event_is_computed(name):
    model = MODELS[name]()
    curve = sweep_row(model, "omega", grid(3)).curves[0]
    events = np.unique(curve.points[(curve.event > 0), 3])
    near = np.unique(np.concatenate([[LOW, HIGH], events, events - 1e-7, events + 1e-7]))
    row = sweep_row(model, "omega", near)
    for i, omega in enumerate(near):
        for solution in solutions(row, i):
            assert np.max(np.abs(evaluate(model, omega, solution)[0])) < 1e-11
        if omega not in events:
            assert row.n_solutions[i] % 2 == 1 and not row.open[i]


def test_columns_that_are_points_of_the_curve_are_met_once():
    """A column may coincide with a computed point, an end of the curve included."""
    curve = sweep_row(published(), "omega", grid(3)).curves[0]
    places = np.unique(curve.points[curve.event == 0, 3])
    row = sweep_row(published(), "omega", places)
    expected = np.full(len(places), 1)
    for place, change in fold_places(row):
        expected[places > place] += change
    np.testing.assert_array_equal(row.n_solutions, expected)


@pytest.mark.parametrize("name, omega", [("published", 0.6), ("published", 1.2265), ("antiphase", 1.2934)])
def test_solutions_do_not_depend_on_the_other_columns(name, omega):
    full = sweep_row(MODELS[name](), "omega", np.union1d(grid(81), omega))
    alone = sweep_row(MODELS[name](), "omega", [LOW, omega, HIGH])
    assert_same_columns(full, [int(np.searchsorted(full.grid, omega))], alone, [1], atol=1e-11)
    assert alone.n_solutions[1] >= 3


# Completeness ----------------------------------------------------------------------------------------------------------

PLANES = {"b": (0.02, 1.5), "alpha": (0.0, 0.8), "f_e": (0.0, 0.5), "f_pm": (0.3, 1.2)}


@pytest.mark.parametrize(("name", "parameter"), slow_but(
    [("published", "b"), ("consistent", "alpha"), ("antiphase", "f_e"), ("published", "f_pm")],
    [(name, parameter) for name in MODELS for parameter in PLANES],
))  # fmt: skip
def test_no_solution_is_missing_anywhere_in_the_reference_planes(name, parameter):
    """Against Newton's method from very many starts, which knows nothing of branches."""
    model = MODELS[name]()
    columns, missing = np.linspace(LOW, HIGH, 53), []
    for value in np.linspace(*PLANES[parameter], 17):
        changed = model.replace(**{parameter: value})
        row = sweep_row(changed, "omega", columns)
        for i, omega in enumerate(columns):
            known = solutions(row, i)
            for found in all_solutions(changed, omega, 100):
                if not row.open[i] and np.min(np.max(np.abs(known - found), axis=1), initial=np.inf) > 1e-6:
                    missing.append((round(float(value), 4), round(float(omega), 4), float(np.hypot(*found[1:]))))
    assert missing == []


@pytest.mark.parametrize("low, high", [(0.57, 0.62), (0.05, 0.6), (0.6, 2.0), (1.225, 1.229), (0.62, 1.225)])
def test_the_range_of_the_sweep_does_not_matter(low, high):
    """A user who looks at a resonance closely sees the same solutions as one who sweeps everything."""
    columns = np.linspace(low, high, 11)
    close = sweep_row(published(), "omega", columns)
    whole = sweep_row(published(), "omega", np.union1d(columns, [LOW, HIGH]))
    places = np.searchsorted(whole.grid, columns)
    assert_same_columns(close, slice(None), whole, places, atol=1e-9)


# Limits ----------------------------------------------------------------------------------------------------------------


def assert_linear(row, model, shift):
    np.testing.assert_array_equal(row.n_solutions, 1)
    for i, omega in enumerate(row.grid):
        expected, _ = linear_response(model, omega)
        size = max(1.0, np.max(np.abs(expected)))
        np.testing.assert_allclose(solutions(row, i)[0], expected + [shift, 0, 0], rtol=0, atol=1e-10 * size)


def test_without_gap_the_solution_is_linear(gear):
    _, model = gear
    row = sweep_row(model.replace(b=0.0), "omega", grid(79))
    assert_linear(row, model, 0.0)
    assert np.all(row.stable == 1) and not np.any(row.open)


@settings(max_examples=25)
@given(st.integers(0, 10**9), numbers(0.1, 1.0))
def test_without_gap_every_gear_is_linear(seed, f_pm):
    model = random_model(seed, b=0.0, f_pm=f_pm)
    row = sweep_row(model, "omega", grid(9))
    for i, omega in enumerate(row.grid):
        if row.n_solutions[i]:
            assert row.n_solutions[i] == 1
            expected, determinant = linear_response(model, omega)
            size = max(1.0, np.max(np.abs(expected)))
            np.testing.assert_allclose(solutions(row, i)[0], expected, rtol=0, atol=1e-9 * size)
            assert row.stable[i, 0] == (determinant > 0.0)
        else:
            assert row.open[i]


@pytest.mark.parametrize("f_pm", [10.0, -10.0])
def test_without_contact_loss_the_solution_is_linear_and_shifted_by_the_gap(gear, f_pm):
    """A large load alone is not enough: varying stiffness makes vibration of load, in proportion to it."""
    _, model = gear
    model = model.replace(f_pm=f_pm, alpha=0.02)
    row = sweep_row(model, "omega", grid(79))
    assert_linear(row, model, np.sign(f_pm) * model.b)
    state = ImpactState.PERMANENT if f_pm > 0 else ImpactState.MIRRORED_PERMANENT
    assert np.all(row.impact == state) and {domain_label(code) for code in row.domain} == {f"1/{state.symbol}"}


def test_permanent_contact_at_default_load_is_linear_too(gear):
    _, model = gear
    row = sweep_row(model, "omega", grid(79))
    counted = 0
    for i, omega in enumerate(row.grid):
        for s in np.flatnonzero(row.impact[i] == ImpactState.PERMANENT):
            expected, _ = linear_response(model, omega)
            np.testing.assert_allclose(solutions(row, i)[s], expected + [model.b, 0, 0], rtol=0, atol=1e-10)
            counted += 1
    assert counted > 40


# Symmetries ------------------------------------------------------------------------------------------------------------


@settings(max_examples=20)
@given(numbers(-2.0, 2.0), st.sampled_from(sorted(MODELS)), st.sampled_from(VARIANTS))
def test_scaling_load_error_and_gap_scales_the_motion(exponent, name, changes):
    s = 10.0**exponent
    model = MODELS[name](f_pv=0.05, **changes)
    scaled = model.replace(b=s * model.b, f_pm=s * model.f_pm, f_e=s * model.f_e, f_pv=s * model.f_pv)
    row = sweep_row(model, "omega", grid(79))
    larger = sweep_row(scaled, "omega", grid(79), continuation=Continuation(amplitude_max=100.0 * s))
    for field in ("n_solutions", "stable", "impact", "domain", "open"):
        np.testing.assert_array_equal(getattr(row, field), getattr(larger, field))
    for field in ("mean", "cos", "sin"):
        np.testing.assert_allclose(getattr(larger, field), s * getattr(row, field), rtol=0, atol=1e-9 * s)
    assert [len(curve.points) for curve in row.curves] == [len(curve.points) for curve in larger.curves]


MIRROR = np.array([5, 4, 2, 3, 1, 0])


@pytest.mark.parametrize("changes", [dict(), dict(f_e=0.4), dict(alpha_harmonics=[[0.1, 0.4]])])
def test_a_negative_load_mirrors_the_motion(gear, changes):
    """f is odd: -lambda solves the pair with -f_pm and -f_e, that is with the excitation's phase shifted by pi."""
    _, model = gear
    model = model.replace(**changes)
    row = sweep_row(model, "omega", grid(157))
    mirrored = sweep_row(model.replace(f_pm=-model.f_pm, f_e_phase=model.f_e_phase + np.pi), "omega", grid(157))
    for field in ("mean", "cos", "sin"):
        np.testing.assert_allclose(getattr(mirrored, field), -getattr(row, field), rtol=0, atol=1e-9)
    np.testing.assert_array_equal(mirrored.stable, row.stable)
    np.testing.assert_array_equal(mirrored.impact, np.where(row.impact >= 0, MIRROR[row.impact], -1))
    assert row.n_solutions.max() > 1 or model.alpha_phase == 0.0


def test_a_negative_load_and_half_a_period_keep_the_fundamental(gear):
    """Shifted by half a mesh period and mirrored: f_e as it was, alpha turned round, lambda_m mirrored alone."""
    _, model = gear
    row = sweep_row(model, "omega", grid(157))
    turned = sweep_row(model.replace(f_pm=-model.f_pm, alpha_phase=model.alpha_phase + np.pi), "omega", grid(157))
    np.testing.assert_allclose(turned.mean, -row.mean, rtol=0, atol=1e-9)
    np.testing.assert_allclose(turned.cos, row.cos, rtol=0, atol=1e-9)
    np.testing.assert_allclose(turned.sin, row.sin, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(turned.impact, np.where(row.impact >= 0, MIRROR[row.impact], -1))


@pytest.mark.parametrize("shift", [0.7, -2.0])
def test_a_shift_in_time_turns_the_phase_only(gear, shift):
    _, model = gear
    model = model.replace(alpha_harmonics=[[0.1, 0.4]])
    later = model.replace(
        alpha_phase=model.alpha_phase + shift, f_e_phase=model.f_e_phase + shift, alpha_harmonics=[[0.1, 0.4 + 2 * shift]]
    )
    row, turned = sweep_row(model, "omega", grid(79)), sweep_row(later, "omega", grid(79))
    np.testing.assert_array_equal(row.stable, turned.stable)
    np.testing.assert_allclose(turned.mean, row.mean, rtol=0, atol=1e-9)
    fundamental = (row.cos - 1j * row.sin) * np.exp(1j * shift)
    np.testing.assert_allclose(turned.cos - 1j * turned.sin, fundamental, rtol=0, atol=1e-9)


# Without load ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name, b", [(name, b) for name in MODELS for b in (0.02, 0.05)] + [("published", 0.1)])
def test_without_load_motions_that_reach_both_flanks_are_found(name, b):
    """The free pair would move by f_e = 0.2, more than the gap."""
    model = MODELS[name](f_pm=0.0, b=b)
    row = sweep_row(model, "omega", grid(79))
    np.testing.assert_array_equal(row.n_solutions, 1)
    assert {domain_label(code) for code in row.domain} == {"1/2"} and not np.any(row.open)
    for i, omega in enumerate(row.grid):
        assert np.max(np.abs(evaluate(model, omega, solutions(row, i)[0])[0])) < 1e-12


def test_without_load_and_gap_the_pair_is_linear(gear):
    _, model = gear
    assert_linear(sweep_row(model.replace(f_pm=0.0, b=0.0), "omega", grid(79)), model.replace(f_pm=0.0), 0.0)


def test_without_excitation_the_pair_rests_on_the_drive_flank(gear):
    _, model = gear
    row = sweep_row(model.replace(f_e=0.0, alpha=0.0), "omega", grid(79))
    np.testing.assert_array_equal(row.n_solutions, 1)
    np.testing.assert_allclose(row.mean[:, 0], 1.0 + 0.5 / model.rotation, rtol=0, atol=1e-12)
    np.testing.assert_allclose(row.amplitude[:, 0], 0.0, rtol=0, atol=1e-12)


# Degree and open ends ---------------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(st.integers(0, 10**9), numbers(0.1, 1.0), numbers(0.05, 2.0))
def test_signs_of_the_determinant_add_up_to_the_linear_one(seed, f_pm, b):
    """The linear sign is taken from the 21 unknowns, whose determinant has the sign of the condensed one."""
    model = random_model(seed, f_pm=f_pm, b=b)
    row = sweep_row(model, "omega", grid(14))
    for i, omega in enumerate(row.grid):
        signs = sum(int(np.sign(np.linalg.det(evaluate(model, omega, u)[1]))) for u in solutions(row, i))
        linear = np.sign(np.linalg.slogdet(uncondensed_balance(model.replace(b=0.0), omega, np.zeros(21))[1])[0])
        if not row.open[i]:
            assert signs == linear
            assert 2 * row.n_stable[i] - row.n_solutions[i] == linear


@pytest.mark.parametrize("alpha", [0.4595, 0.47, 0.5])
def test_an_unbounded_branch_is_open_and_says_why(alpha):
    model = consistent(rotation_coupling=COS_20, variation_translation=0.0, alpha=alpha)
    row = sweep_row(model, "omega", grid(391))
    ends = {end for curve in row.curves for end in curve.ends}
    assert ends == {EndReason.RANGE_LEFT, EndReason.AMPLITUDE_CEILING}
    assert "amplitude ceiling" in EndReason.AMPLITUDE_CEILING.sentence
    flagged = np.flatnonzero(row.open)
    exits = [c.points[k, 3] for c in row.curves for k in (0, -1) if c.ends[k] is EndReason.AMPLITUDE_CEILING]
    beside = np.unique([np.searchsorted(row.grid, place) + side for place in exits for side in (-1, 0)])
    assert len(exits) and set(beside) <= set(flagged) <= set(range(beside[0], beside[-1] + 1))
    assert np.all(np.abs(row.grid[flagged] - 0.5918) < 0.03)
    assert np.nanmax(row.amplitude) <= 100.0


@pytest.mark.parametrize("columns", [4, 7, 14])
def test_a_coarse_raster_says_too_that_a_branch_left(columns):
    """No column need lie where the solutions are: those beside are marked."""
    model = consistent(rotation_coupling=COS_20, variation_translation=0.0, alpha=0.4595)
    row = sweep_row(model, "omega", grid(columns))
    right = int(np.searchsorted(row.grid, 0.5918))
    assert row.open[right - 1] and row.open[right] and np.sum(row.open) <= 3


@pytest.mark.parametrize("seeds", [ProvenSeeds(), LinearSeeds()], ids=["proven", "linear"])
@pytest.mark.parametrize("seed, f_pm, b", [(1791, -1.103, 0.025), (14, -0.403, 0.722), (87, 0.465, 1.567)])
def test_a_branch_that_touches_neither_end_of_the_range_is_found(seed, f_pm, b, seeds):
    """Between two unbounded branches lies a third that comes down from above the ceiling and leaves through it again.

    Proven seeds know it is there; to linear ones only the degree says that something is missing.
    """
    model = random_model(seed, f_pm=f_pm, b=b)
    row = sweep_row(model, "omega", grid(79), seeds=seeds)
    left, up = EndReason.RANGE_LEFT, EndReason.AMPLITUDE_CEILING
    assert [curve.ends for curve in row.curves] == [(left, up), (left, up), (up, up)]
    for i, omega in enumerate(row.grid):
        expected = [u for u in all_solutions(model, omega, 400) if np.hypot(u[1], u[2]) < 100.0]
        np.testing.assert_allclose(solutions(row, i), expected, rtol=0, atol=1e-7)


def test_below_the_threshold_the_branch_is_bounded_and_nothing_is_open():
    model = consistent(rotation_coupling=COS_20, variation_translation=0.0, alpha=0.45)
    row = sweep_row(model, "omega", grid(391))
    assert not np.any(row.open)
    assert 36.0 < max(np.max(curve.amplitude) for curve in row.curves) <= 37.0


def test_a_low_ceiling_opens_the_columns_between_the_places_where_branches_left():
    full = sweep_row(published(), "omega", grid(391))
    cut = sweep_row(published(), "omega", grid(391), continuation=Continuation(amplitude_max=1.5))
    exits = [
        curve.points[place, 3]
        for curve in cut.curves
        for end, place in zip(curve.ends, (0, -1), strict=True)
        if end is EndReason.AMPLITUDE_CEILING
    ]
    assert len(exits) == 2
    between = (cut.grid > min(exits)) & (cut.grid < max(exits))
    np.testing.assert_array_equal(cut.open[between], 1)
    assert 0 < np.sum(cut.open) <= np.sum(between) + 2
    assert np.nanmax(cut.amplitude) < 1.5 < np.nanmax(full.amplitude)
    for i in range(391):
        kept = solutions(full, i)[full.amplitude[i][: full.n_solutions[i]] < 1.5]
        np.testing.assert_allclose(solutions(cut, i), kept, rtol=0, atol=1e-10)


# Other axes ------------------------------------------------------------------------------------------------------------

RANGES = {
    "b": (0.0, 1.5), "alpha": (0.0, 0.6), "alpha_phase": (-3.0, 3.0), "f_e": (0.0, 0.5), "f_e_phase": (-3.0, 3.0),
    "f_pm": (0.3, 1.2), "f_pv": (-0.3, 0.3), "kappa": (0.2, 1.0), "xi_mesh": (0.01, 0.2), "xi_translation": (0.0, 0.1),
    "xi_support": (0.01, 0.1), "k_support": (0.5, 2.0), "pitch_cone_angle": (10.0, 80.0),
    "pressure_angle": (14.5, 28.0), "translation_coupling": (0.1, 1.0), "rotation_coupling": (0.5, 1.2),
    "variation_translation": (0.0, 1.5), "variation_rotation": (0.0, 1.0),
}  # fmt: skip


@pytest.mark.parametrize(("name", "omega"), slow_but(
    [("published", 0.6), ("antiphase", 1.3)], [(name, omega) for name in MODELS for omega in (0.6, 1.3)],
))  # fmt: skip
def test_a_row_over_another_axis_has_the_solutions_of_the_frequency_sweeps(name, omega):
    model = MODELS[name]()
    wrong = []
    for axis, ends in RANGES.items():
        row = sweep_row(model, axis, np.linspace(*ends, 9), omega=omega)
        for i, value in enumerate(row.grid):
            other = sweep_row(model.replace(**{axis: value}), "omega", [LOW, omega, HIGH])
            if row.n_solutions[i] != other.n_solutions[1]:
                wrong.append((axis, round(float(value), 4), int(row.n_solutions[i]), int(other.n_solutions[1])))
            else:
                assert_same_columns(row, [i], other, [1], atol=1e-9, same_axis=False)
    assert wrong == []


@pytest.mark.parametrize("axis, omega", [("f_e", 0.6), ("b", 1.3), ("f_pm", 1.3), ("f_e", 0.8), ("alpha", 1.2265)])
def test_a_row_over_another_axis_starts_at_its_first_column(axis, omega):
    """Axes that begin at 0, where a rounding error is as good as a miss."""
    columns = np.linspace(0.5 if axis == "f_pm" else 0.0, RANGES[axis][1], 9)
    row = sweep_row(published(), axis, columns, omega=omega)
    assert row.n_solutions[0] == 1 and not np.any(row.open)
    assert len(row.curves) == 1 and row.curves[0].points[0, 3] == columns[0]
    for i, value in enumerate(columns):
        assert len(solutions(row, i)) == len(all_solutions(published(**{axis: value}), omega))


def test_every_axis_is_covered():
    assert {"omega", *RANGES} == set(AXES)


def test_the_gap_as_axis_gives_states_of_its_own_values():
    row = sweep_row(published(), "b", np.linspace(0.0, 1.5, 31), omega=0.6)
    np.testing.assert_array_equal(row.b, row.grid)
    for curve in row.curves:
        extremes = curve.points[:, 0] - curve.amplitude, curve.points[:, 0] + curve.amplitude
        np.testing.assert_array_equal(row.branch_impact(curve), impact_state(*extremes, curve.points[:, 3]))
    for i, b in enumerate(row.grid):
        for s in range(row.n_solutions[i]):
            mean, amplitude = row.mean[i, s], row.amplitude[i, s]
            assert row.impact[i, s] == impact_state(mean - amplitude, mean + amplitude, b)


def test_states_along_a_branch_over_frequency():
    row = sweep_row(published(), "omega", grid(5))
    (curve,) = row.curves
    extremes = curve.points[:, 0] - curve.amplitude, curve.points[:, 0] + curve.amplitude
    np.testing.assert_array_equal(row.branch_impact(curve), impact_state(*extremes, 1.0))
    assert set(row.branch_impact(curve)) == {0, 1, 2}


# Failures --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", [[], [0.5], [0.5, 0.5], [0.6, 0.5], [0.5, np.nan], [0.5, np.inf], [[0.5, 0.6]]])
def test_a_grid_that_is_not_ascending_is_refused(bad):
    with pytest.raises(ParameterError, match="grid = .* must be at least two finite ascending values"):
        sweep_row(published(), "omega", bad)


@pytest.mark.parametrize("low", [0.0, -0.1])
def test_frequencies_must_be_positive(low):
    with pytest.raises(ParameterError, match="omega = .* must be a finite number above 0"):
        sweep_row(published(), "omega", [low, 1.0])


@pytest.mark.parametrize("omega", [None, 0.0, -1.0, np.nan, np.inf])
def test_another_axis_needs_a_frequency(omega):
    with pytest.raises(ParameterError, match="omega = .* must be a finite number above 0"):
        sweep_row(published(), "b", [0.1, 1.0], omega=omega)


def test_an_unknown_axis_is_refused():
    with pytest.raises(ParameterError, match="axis = 'backlash' is not allowed: it must be one of omega, b"):
        sweep_row(published(), "backlash", [0.1, 1.0], omega=0.5)


@pytest.mark.parametrize("axis, low", [("b", -0.5), ("kappa", 0.0), ("k_support", -1.0), ("rotation_coupling", 0.0)])
def test_axis_values_that_the_model_refuses_are_refused(axis, low):
    with pytest.raises(ParameterError, match=axis):
        sweep_row(published(), axis, [low, 0.5, 1.0], omega=0.6)


def test_a_row_that_lacks_room_says_so_and_where():
    with pytest.raises(RowError) as caught:
        sweep_row(published(), "omega", grid(81), continuation=Continuation(max_points=120))
    assert EndReason.ITERATION_LIMIT.sentence in str(caught.value)
    assert "It happened at omega = " in str(caught.value) and "with mean " in str(caught.value)


def test_a_row_whose_steps_become_too_small_says_so():
    stiff = dataclasses.replace(Continuation(), smallest_step=0.02, first_step=0.05)
    with pytest.raises(RowError, match="refused every step down to the smallest one") as caught:
        sweep_row(antiphase(), "omega", grid(81), continuation=stiff)
    assert isinstance(caught.value, ArithmeticError)


def test_equal_rows_are_bitwise_equal():
    first, again = (sweep_row(antiphase(), "omega", grid(157)) for _ in range(2))
    for field in ("mean", "cos", "sin", "stable", "impact", "open"):
        np.testing.assert_array_equal(getattr(first, field), getattr(again, field))
    for curve, other in zip(first.curves, again.curves, strict=True):
        np.testing.assert_array_equal(curve.points, other.points)
