"""The dimensionless model: what it accepts, and what it is made of."""

import dataclasses
import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given

from solver import GEOMETRIC, SCALAR_PARAMETERS, Model, ParameterError
from tests.conftest import antiphase, consistent, published
from tests.solver.strategies import frequencies, models, numbers

NAN, INF = float("nan"), float("inf")

REFUSED = [
    *((name, bad, name, bad, "a finite number") for name in SCALAR_PARAMETERS for bad in (NAN, INF, -INF, True)),
    *((name, "0.5", name, "0.5", "number") for name in SCALAR_PARAMETERS),
    *((name, None, name, None, "number") for name in SCALAR_PARAMETERS),
    ("b", -1e-9, "b", -1e-9, "at least 0"),
    ("b", 1j, "b", 1j, "a finite number"),
    ("b", [1.0], "b", [1.0], "a finite number"),
    ("xi_mesh", -0.01, "xi_mesh", -0.01, "at least 0"),
    ("kappa", 0.0, "kappa", 0.0, "above 0"),
    ("kappa", -0.5, "kappa", -0.5, "above 0"),
    ("kappa", [0.5, 0.0], "kappa[1]", 0.0, "above 0"),
    ("kappa", [0.5], "kappa", [0.5], "one number or a list of 2"),
    ("kappa", [[0.5, 0.5], 0.5], "kappa[0]", [0.5, 0.5], "a finite number"),
    ("kappa", "ab", "kappa", "ab", "one number or a list of 2"),
    ("xi_translation", [0.1, -0.1], "xi_translation[1]", -0.1, "at least 0"),
    ("xi_translation", [0.1] * 3, "xi_translation", [0.1] * 3, "one number or a list of 2"),
    ("xi_support", [0.1] * 5, "xi_support", [0.1] * 5, "one number or a list of 6"),
    ("xi_support", [0.1] * 5 + [-1.0], "xi_support[5]", -1.0, "at least 0"),
    ("k_support", 0.0, "k_support", 0.0, "above 0"),
    ("k_support", [1.0, 1.0, NAN, 1.0, 1.0, 1.0], "k_support[2]", NAN, "a finite number"),
    ("pitch_cone_angle", -1.0, "pitch_cone_angle", -1.0, "an angle in degrees, at least 0 and below 180"),
    ("pitch_cone_angle", 180.0, "pitch_cone_angle", 180.0, "below 180"),
    ("pressure_angle", 90.0, "pressure_angle", 90.0, "at least 0 and below 90"),
    ("translation_coupling", -0.1, "translation_coupling", -0.1, "at least 0"),
    ("translation_coupling", "geometrical", "translation_coupling", "geometrical", "a number or the word geometric"),
    ("rotation_coupling", 0.0, "rotation_coupling", 0.0, "above 0"),
    ("rotation_coupling", "", "rotation_coupling", "", "a number or the word geometric"),
    *(
        (name, bad, name, bad, "a list of [amplitude, phase] pairs")
        for name in ("alpha_harmonics", "f_e_harmonics")
        for bad in (0.1, None, "0.1", [0.1], [[0.1]], [[0.1, 0.2, 0.3]], ["ab"])
    ),
    ("alpha_harmonics", [[0.1, NAN]], "alpha_harmonics", NAN, "a finite number"),
    ("f_e_harmonics", [["a", 0.0]], "f_e_harmonics", "a", "a finite number"),
]


@pytest.mark.parametrize("field, value, name, named, allowed", REFUSED)
def test_a_value_that_is_not_allowed_is_named_with_what_is(field, value, name, named, allowed):
    with pytest.raises(ParameterError) as caught:
        published(**{field: value})
    error = caught.value
    assert str(error).startswith(f"{name} = {named!r} is not allowed: it must be ")
    assert allowed in str(error)
    assert error.name == name and repr(error.value) == repr(named)


@pytest.mark.parametrize(
    "changes",
    [
        {"b": 0.0},
        {"b": 0},
        {"b": np.float64(0.5)},
        {"b": Fraction(1, 3)},
        {"xi_mesh": 0.0},
        {"xi_support": 0.0},
        {"xi_translation": 0.0},
        {"alpha": -0.4},
        {"alpha": 3.0},
        {"f_pm": -0.5},
        {"f_pm": 0.0},
        {"f_e": 0.0},
        {"translation_coupling": 0.0},
        {"pitch_cone_angle": 0.0},
        {"pressure_angle": 0.0},
        {"pitch_cone_angle": 179.9},
        {"k_support": np.full(6, 2.0)},
        {"kappa": np.array([0.5, 0.6])},
        {"alpha_harmonics": np.array([[0.1, 0.2]])},
        {"f_e_harmonics": []},
    ],
)
def test_values_at_the_edge_and_numpy_numbers_are_accepted(changes):
    model = published(**changes)
    for field in dataclasses.fields(model):
        value = getattr(model, field.name)
        assert type(value) in (float, tuple, str)
    assert hash(model) == hash(pickle.loads(pickle.dumps(model)))


def test_errors_survive_pickling():
    error = ParameterError("b", -1.0, "a finite number at least 0")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is ParameterError and str(again) == str(error) and isinstance(again, ValueError)
    assert (again.name, again.value, again.allowed) == ("b", -1.0, "a finite number at least 0")


def test_one_number_stands_for_all_gears_and_axes():
    model = published(kappa=[0.4, 0.6], xi_support=[0.01, 0.02, 0.03, 0.04, 0.05, 0.06])
    assert model.kappa == (0.4, 0.6) and model.xi_support[3] == 0.04
    assert model.xi_translation == (0.0125, 0.0125) and model.k_support == (1.0,) * 6
    changed = model.replace(kappa=0.5, b=0.3)
    assert changed.kappa == (0.5, 0.5) and changed.b == 0.3 and model.b == 1.0
    assert published() == Model(**dataclasses.asdict(published()))


def test_every_scalar_parameter_is_a_field():
    fields = {field.name for field in dataclasses.fields(Model)}
    assert set(SCALAR_PARAMETERS) < fields
    assert fields - set(SCALAR_PARAMETERS) == {"alpha_harmonics", "f_e_harmonics"}


def test_directions_of_the_three_sets():
    # docs/physics.md, section 7.
    expected = [0.1362, -0.1362, -0.5293, -0.1362, 0.1362, 0.5293]
    np.testing.assert_allclose(published().direction, expected, rtol=0, atol=5e-5)
    assert published().rotation == 0.7719
    for model in (consistent(), antiphase()):
        assert model.rotation == pytest.approx(0.88302222, abs=5e-9)
        assert model.sigma == 1.0


@given(models(translation_coupling=GEOMETRIC, rotation_coupling=GEOMETRIC))
def test_the_geometric_direction_is_the_contact_normal_of_both_gears(model):
    cone, pressure = np.radians(model.pitch_cone_angle), np.radians(model.pressure_angle)
    a1, a2, a3 = np.cos(cone) * np.sin(pressure), np.sin(cone) * np.sin(pressure), np.cos(pressure)
    assert a1**2 + a2**2 + a3**2 == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(model.direction, [a1, -a2, -a3, -a1, a2, a3], rtol=0, atol=1e-15)
    assert model.rotation == pytest.approx(a3**2, abs=1e-15)


@given(models())
def test_direction_has_the_length_that_the_translation_coupling_asks_for(model):
    for half in model.direction.reshape(2, 3):
        assert half @ half == pytest.approx(model.sigma, abs=1e-14)


def test_matrices_of_a_pair_whose_numbers_all_differ():
    model = published(
        kappa=[0.4, 0.6],
        xi_translation=[0.01, 0.02],
        xi_support=[0.01, 0.02, 0.03, 0.04, 0.05, 0.06],
        k_support=[1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        pitch_cone_angle=30.0,
        translation_coupling=0.5,
    )
    mass, damping, stiffness = model.matrices()
    translation, rotation = model.mesh_vectors()
    d = np.sqrt(0.5) * np.array(
        [
            np.cos(np.pi / 6) * np.sin(np.pi / 9),
            -0.5 * np.sin(np.pi / 9),
            -np.cos(np.pi / 9),
            -np.cos(np.pi / 6) * np.sin(np.pi / 9),
            0.5 * np.sin(np.pi / 9),
            np.cos(np.pi / 9),
        ]
    )
    expected_mass = np.eye(7)
    expected_mass[6, :6] = -d
    expected_damping = np.diag([0.02, 0.04, 0.06, 0.08, 0.10, 0.12, 2.0 * 0.7719 * 0.05])
    expected_damping[:6, 6] = 2.0 * d * [0.01, 0.01, 0.01, 0.02, 0.02, 0.02]
    np.testing.assert_allclose(mass, expected_mass, rtol=0, atol=1e-15)
    np.testing.assert_allclose(damping, expected_damping, rtol=0, atol=1e-15)
    np.testing.assert_allclose(stiffness, np.diag([1, 2, 3, 4, 5, 6, 0]), rtol=0, atol=0)
    np.testing.assert_allclose(translation, [*(d * [0.4, 0.4, 0.4, 0.6, 0.6, 0.6]), 0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(rotation, [0, 0, 0, 0, 0, 0, 0.7719], rtol=0, atol=0)


def test_load_harmonics_count_all_terms():
    model = published(f_pm=0.4, f_pv=0.1, f_e=0.2, f_e_phase=0.3, f_e_harmonics=[[0.05, -0.2], [0.01, 1.0]])
    omega, tau = 0.8, np.linspace(0.0, 20.0, 57)
    load = model.load_harmonics(omega, 4)
    series = sum((load[k] * np.exp(1j * k * omega * tau)).real for k in range(5))
    error = [(0.2, 0.3), (0.05, -0.2), (0.01, 1.0)]
    expected = 0.4 + 0.1 * np.cos(omega * tau)
    for k, (amplitude, phase) in enumerate(error, start=1):
        expected = expected + amplitude * (k * omega) ** 2 * np.cos(k * omega * tau + phase)
    np.testing.assert_allclose(series, expected, rtol=0, atol=1e-14)
    for order in (0, 1, 2):
        np.testing.assert_array_equal(model.load_harmonics(omega, order), load[: order + 1])


def test_stiffness_variation_counts_all_terms():
    model = published(alpha=0.3, alpha_phase=0.4, alpha_harmonics=[[0.1, 1.0], [0.05, -2.0]], variation_rotation=0.5)
    angle = np.linspace(0.0, 7.0, 23).reshape(1, 23)
    expected = 0.3 * np.cos(angle + 0.4) + 0.1 * np.cos(2 * angle + 1.0) + 0.05 * np.cos(3 * angle - 2.0)
    np.testing.assert_allclose(model.stiffness_variation(angle), expected, rtol=0, atol=1e-15)
    assert model.stiffness_variation(0.0) == pytest.approx(expected[0, 0])


@pytest.mark.parametrize(
    "alpha, rotation, lowest", [(0.2, 0.0, 0.8), (1.5, 0.5, -0.5), (0.5, 2.0, 0.0), (-0.3, 1.0, 0.7)]
)
def test_lowest_stiffness(alpha, rotation, lowest):
    assert published(alpha=alpha, variation_rotation=rotation).lowest_stiffness() == pytest.approx(lowest, abs=1e-12)


@given(numbers(0.1, 1.0), numbers(0.3, 3.0), numbers(0.0, 1.0), numbers(0.3, 1.0), numbers(0.0, 1.0))
def test_natural_frequencies_of_alike_supports_are_those_of_the_formula(kappa, k, sigma, c, gain):
    model = published(kappa=kappa, k_support=k, translation_coupling=sigma, rotation_coupling=c)
    total = k + c * gain + 2.0 * sigma * kappa * gain
    root = np.sqrt(total**2 - 4.0 * c * gain * k)
    modes = np.sqrt([max(0.5 * (total - root), 0.0), 0.5 * (total + root)])
    np.testing.assert_allclose(model.linear_frequencies(gain), np.sort([*modes, *[np.sqrt(k)] * 5]), rtol=0, atol=3e-7)
    np.testing.assert_allclose(model.mesh_modes(gain), modes, rtol=0, atol=3e-7)
    assert model.mesh_modes() == model.mesh_modes(1.0)


@given(models(), frequencies)
def test_natural_frequencies_make_the_undamped_dynamic_stiffness_singular(model, gain):
    mass, _, stiffness = model.matrices()
    translation, rotation = model.mesh_vectors()
    stiffness[:, 6] += gain * (translation + rotation)
    for frequency in model.linear_frequencies(gain):
        values = np.linalg.svd(stiffness - frequency**2 * mass, compute_uv=False)
        assert values[-1] < 1e-6 * values[0]
