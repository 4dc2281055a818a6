"""The backbone: free vibration of the undamped pair under load."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver import ParameterError, backbone, translations, uncondensed_balance
from tests.conftest import consistent, published
from tests.solver.independent import force_harmonics
from tests.solver.strategies import numbers, random_model


def conservative(model):
    """The same pair without damping, excitation and variation."""
    return model.replace(
        xi_mesh=0.0, xi_translation=0.0, xi_support=0.0, alpha=0.0, alpha_harmonics=(), f_e=0.0, f_pv=0.0
    )


@given(st.integers(0, 10**9), numbers(0.1, 1.5), numbers(0.01, 4.0), st.sampled_from([1.0, -1.0]))
def test_free_vibration_satisfies_the_undamped_balance_of_all_degrees_of_freedom(seed, f_pm, amplitude, sign):
    model = conservative(random_model(seed, f_pm=sign * f_pm))
    result = backbone(model, [amplitude])
    mean = result.mean[0]
    for omega in (result.lower[0], result.upper[0]):
        assert omega > 0.0
        mesh = np.array([mean, amplitude, 0.0])
        if min(abs(omega**2 - k) for k in model.k_support) < 1e-6:
            continue  # a support that does not feel the mesh vibrates by itself
        unknowns = np.column_stack([translations(model, omega, mesh), mesh]).ravel()
        residual, _ = uncondensed_balance(model, omega, unknowns)
        assert np.max(np.abs(residual)) < 1e-7 * max(1.0, np.max(np.abs(unknowns)))


@pytest.mark.parametrize("make", [published, consistent])
def test_small_vibrations_have_the_linear_frequencies(make):
    result = backbone(make(), [0.0, 1e-9, 0.1, 0.5])
    # Contact is kept up to an amplitude of f_pm/c, so that nothing changes at all.
    lower, upper = make().mesh_modes()
    np.testing.assert_allclose(result.lower, lower, rtol=0, atol=1e-12)
    np.testing.assert_allclose(result.upper, upper, rtol=0, atol=1e-12)
    np.testing.assert_allclose(result.mean, 1.0 + 0.5 / make().rotation, rtol=0, atol=1e-12)


def test_the_pair_softens_as_soon_as_contact_is_lost():
    model = published()
    grazing = model.f_pm / model.rotation
    result = backbone(model, np.linspace(0.0, 3.0, 301))
    kept = result.amplitude <= grazing
    assert 0 < np.sum(kept) < 300
    for mode in (result.lower, result.upper):
        np.testing.assert_allclose(np.diff(mode[kept]), 0.0, rtol=0, atol=1e-12)
        single = ~kept & (result.mean - result.amplitude > -model.b)
        assert np.all(np.diff(mode[single]) < 0.0)
    assert np.all(result.lower <= model.mesh_modes()[0] + 1e-12)


def test_the_pair_hardens_again_at_the_back_flank_and_forgets_the_gap_at_large_amplitude():
    model = published()
    result = backbone(model, np.linspace(1.0, 12.0, 111))
    lowest = int(np.argmin(result.lower))
    assert 0 < lowest < 110
    assert np.all(np.diff(result.lower[lowest + 1 :]) > 0.0)
    far = backbone(model, [1e4])
    assert far.lower[0] == pytest.approx(model.mesh_modes()[0], abs=1e-3)


def test_mean_carries_the_load():
    model = published()
    result = backbone(model, np.linspace(0.1, 4.0, 14))
    for amplitude, mean in zip(result.amplitude, result.mean, strict=True):
        force, _ = force_harmonics(mean, complex(amplitude), model.b)
        assert model.rotation * force == pytest.approx(model.f_pm, abs=1e-7)


def test_a_mirrored_load_mirrors_the_mean_only():
    amplitudes = np.linspace(0.0, 4.0, 41)
    plus, minus = backbone(published(), amplitudes), backbone(published(f_pm=-0.5), amplitudes)
    np.testing.assert_allclose(plus.mean, -minus.mean, rtol=0, atol=1e-12)
    np.testing.assert_allclose(plus.lower, minus.lower, rtol=0, atol=1e-12)
    np.testing.assert_allclose(plus.upper, minus.upper, rtol=0, atol=1e-12)


def test_without_gap_nothing_depends_on_amplitude():
    result = backbone(published(b=0.0), [0.0, 0.5, 2.0, 50.0])
    np.testing.assert_allclose(result.lower, published().mesh_modes()[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(result.mean, 0.5 / 0.7719, rtol=0, atol=1e-12)


def test_no_load_is_refused():
    with pytest.raises(ParameterError, match="f_pm = 0.0 is not allowed: it must be other than 0 for a backbone"):
        backbone(published(f_pm=0.0), [0.1])
