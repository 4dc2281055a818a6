"""Rows of gears that are the same but for scale, for the sign of the load or for a shift in time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import Continuation, sweep_row
from tests.conftest import MODELS
from tests.solver.reference_rows import VARIANTS, grid
from tests.solver.strategies import numbers

MIRROR = np.array([5, 4, 2, 3, 1, 0])


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
        alpha_phase=model.alpha_phase + shift,
        f_e_phase=model.f_e_phase + shift,
        alpha_harmonics=[[0.1, 0.4 + 2 * shift]],
    )
    row, turned = sweep_row(model, "omega", grid(79)), sweep_row(later, "omega", grid(79))
    np.testing.assert_array_equal(row.stable, turned.stable)
    np.testing.assert_allclose(turned.mean, row.mean, rtol=0, atol=1e-9)
    fundamental = (row.cos - 1j * row.sin) * np.exp(1j * shift)
    np.testing.assert_allclose(turned.cos - 1j * turned.sin, fundamental, rtol=0, atol=1e-9)
