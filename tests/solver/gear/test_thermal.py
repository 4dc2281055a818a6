"""Laws of temperature against hand-worked numbers; the pair on the reference's scales against one normalised anew."""

import dataclasses
import math

import numpy as np
import pytest

from solver import Model, ParameterError, all_solutions, sweep_row
from solver.gear.thermal import ThermalPair
from solver.gear.thermal_laws import (
    LAWS,
    BacklashTable,
    Expansion,
    LinearModulus,
    NoChange,
    RatioTable,
    Temperatures,
    Unchanged,
    VogelViscosity,
    law_of,
)
from solver.harmonic.condensed import coefficients
from solver.model.packing import axis_vectors
from solver.model.parameter_path import add_path, place_on, plane_vectors
from tests.conftest import consistent, published
from tests.solver.strategies import random_model

STEEL = Expansion(
    gears=(11.5e-6, 11.5e-6),
    housing=10.5e-6,
    distances=(0.045, 0.045),
    cone_angles=(45.0, 45.0),
    pressure_angle=20.0,
    valid=(-30.0, 160.0),
)
MODULUS = LinearModulus(slope=3.35e-4, valid=(-30.0, 200.0))
OIL = VogelViscosity(constant=1075.0, offset=95.0, exponent=1.0, valid=(0.0, 150.0))
PAIR = ThermalPair(length=50e-6, reference=40.0, housing_share=0.5, backlash=STEEL, stiffness=MODULUS, damping=OIL)


def at(gears, housing=40.0):
    return Temperatures(gears, housing, 40.0)


# The laws ------------------------------------------------------------------------------------------------------------


def test_expansion_worked_by_hand():
    """Both gears rise by 60 K, the housing by 30 K; each gear is shifted into its mate by 16.875 um."""
    shift = 0.045 * (11.5e-6 * 60.0 - 10.5e-6 * 30.0)
    assert shift == pytest.approx(16.875e-6, rel=1e-12)
    normal = 0.7071067811865476 * 0.3420201433256687
    assert STEEL.value(at(100.0, 70.0)) == pytest.approx(-2.0 * normal * 16.875e-6, rel=1e-12)
    assert STEEL.value(at(100.0, 70.0)) == pytest.approx(-8.16226e-6, rel=1e-5)


def test_axial_shift_is_that_of_the_contact_normal():
    """What 1 m of shift of one gear takes from the gap is d Lambda_n/dY of the model with a geometric normal."""
    model = consistent(pitch_cone_angle=30.0, pressure_angle=25.0)
    one = dataclasses.replace(
        STEEL, gears=(1.0, 0.0), housing=0.0, distances=(1.0, 1.0), pressure_angle=25.0, cone_angles=(30.0, 60.0)
    )
    assert one.value(at(41.0)) == pytest.approx(-abs(model.direction[1]), rel=1e-14)


def test_a_housing_that_expands_like_the_gears_keeps_the_backlash():
    same = dataclasses.replace(STEEL, housing=11.5e-6)
    assert same.value(at(90.0, 90.0)) == 0.0
    assert STEEL.value(at(90.0, 90.0)) < 0.0 < dataclasses.replace(STEEL, housing=23e-6).value(at(90.0, 90.0))


def test_modulus_is_the_table_of_asme():
    """ASME B31.3, table C-6, carbon steel with C > 0.3 %, GPa."""
    for temperature, modulus in ((-73.0, 206.8), (21.0, 202.0), (93.0, 197.2), (204.0, 189.6), (260.0, 186.8)):
        law = LinearModulus(3.35e-4, (-80.0, 300.0))
        assert law.value(Temperatures(temperature, 0.0, 21.0)) == pytest.approx(modulus / 202.0, rel=8e-3)
    assert MODULUS.value(at(140.0)) == pytest.approx(0.9665, rel=1e-14)


def test_viscosity_is_that_of_the_grade():
    """220 mm2/s at 40 and 19 at 100 degrees Celsius."""
    assert 220.0 * OIL.value(at(100.0)) == pytest.approx(19.0, rel=2e-3)
    half = dataclasses.replace(OIL, exponent=0.5)
    assert half.value(at(100.0)) == pytest.approx(math.sqrt(OIL.value(at(100.0))), rel=1e-14)
    # d ln nu/dT = -B/(T + C)^2, by differences.
    slope = (math.log(OIL.value(at(60.01))) - math.log(OIL.value(at(59.99)))) / 0.02
    assert slope == pytest.approx(-1075.0 / 155.0**2, rel=1e-7)


def test_tables_pass_through_their_points():
    law = RatioTable([[20.0, 2.0], [40.0, 1.6], [80.0, 1.0]])
    assert law.value(at(80.0)) == pytest.approx(1.0 / 1.6, rel=1e-14)
    # Newton's form of the parabola through the three points, at 60: divided differences -1/50 and 1/12000.
    assert law.value(at(60.0)) == pytest.approx((2.0 - 40.0 / 50.0 + 40.0 * 20.0 / 12000.0) / 1.6, rel=1e-14)
    gap = BacklashTable([[-20.0, 60e-6], [0.0, 50e-6], [40.0, 30e-6]])
    assert gap.value(at(80.0, 40.0)) == pytest.approx(-20e-6, rel=1e-12)
    assert Unchanged().value(at(99.0)) == 1.0 and NoChange().value(at(99.0)) == 0.0


@pytest.mark.parametrize(
    ("role", "law", "parameters", "message"),
    [
        ("stiffness", "cubic", {}, "stiffness.law = 'cubic' is not allowed: it must be one of linear, table, none"),
        ("stiffness", "linear", {"slope": 0.01, "valid": (0.0, 200.0)}, "stiffness.slope = 0.01"),
        ("stiffness", "linear", {"slope": "x", "valid": (0.0, 200.0)}, "stiffness.slope = 'x'"),
        ("stiffness", "table", {"table": [[20.0, 1.0]]}, "stiffness.table = .* at least 2"),
        ("stiffness", "table", {"table": [[20.0, 1.0], [20.0, 2.0]]}, "ascending temperatures"),
        ("damping", "table", {"table": [[20.0, 1.0], [30.0, -1.0]]}, "above 0"),
        ("damping", "table", {"table": [[20.0, 1.0], [30.0]]}, "damping.table = \\[30.0\\]"),
        ("damping", "vogel", {**dataclasses.asdict(OIL), "valid": (-100.0, 0.0)}, "damping.valid"),
        ("damping", "vogel", {**dataclasses.asdict(OIL), "exponent": -1.0}, "at least 0"),
        ("damping", "vogel", {**dataclasses.asdict(OIL), "valid": (9.0, 9.0)}, "damping.valid"),
        ("backlash", "expansion", {**dataclasses.asdict(STEEL), "gears": 1e-5}, "backlash.gears = 1e-05"),
    ],
)
def test_laws_refuse_what_makes_no_sense(role, law, parameters, message):
    with pytest.raises(ParameterError, match=message):
        law_of(role, law, **parameters)


def test_every_law_can_be_named():
    assert law_of("damping", "vogel", **dataclasses.asdict(OIL)) == OIL
    assert {role: sorted(names) for role, names in LAWS.items()} == {
        "backlash": ["expansion", "none", "table"],
        "stiffness": ["linear", "none", "table"],
        "damping": ["none", "table", "vogel"],
    }


# The pair ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("reference", [40.0, 23.7])
@pytest.mark.parametrize("make", [published, consistent, lambda: random_model(11)])
def test_the_reference_is_the_base_case_to_the_bit(make, reference):
    pair = dataclasses.replace(
        PAIR,
        reference=reference,
        damping=RatioTable([[0.0, 3.1], [50.0, 1.7], [140.0, 0.3]]),
        backlash=BacklashTable([[-9.0, 61e-6], [3.0, 47e-6], [40.0, 31e-6]]),
    )
    for thermal in (PAIR, pair):
        model, _ = place_on(thermal.path, 0.0, make())
        base = make()
        for field in dataclasses.fields(Model):
            if field.name != "rotation_coupling":
                assert getattr(model, field.name) == getattr(base, field.name), field.name
        ours, its = (coefficients(*axis_vectors(m, "omega"), 0.7) for m in (model, base))
        assert ours == its


def test_the_reference_row_is_the_base_row_to_rounding():
    """A geometric coupling is enclosed a little wider than its number: the last bit of a proven root may differ."""
    grid = np.linspace(0.3, 1.4, 30)
    base, row = (sweep_row(m, "omega", grid) for m in (consistent(alpha=0.3), PAIR_AT(0.0, consistent(alpha=0.3))))
    for name in ("mean", "amplitude", "phase", "multiplier"):
        np.testing.assert_allclose(getattr(row, name), getattr(base, name), rtol=1e-12, err_msg=name)
    for name in ("stable", "impact", "domain", "instability"):
        np.testing.assert_array_equal(getattr(row, name), getattr(base, name), err_msg=name)


def PAIR_AT(difference, model):
    return place_on(PAIR.path, difference, model)[0]


def normalised_anew(model, difference):
    """The model from SI at T, on scales of T itself: Omega_n(T) and b_h(T), all masses and torques as they were.

    With m_e = 1 kg and k_m(T_0) = 1 N/m, Omega_n(T_0) = 1 rad/s and b_c = PAIR.length.
    """
    rise = 2.0 * difference
    modulus, viscosity = 1.0 - 3.35e-4 * rise, math.exp(1075.0 / (135.0 + rise) - 1075.0 / 135.0)
    frequency = math.sqrt(modulus)
    shift = 0.045 * (11.5e-6 * rise - 10.5e-6 * 0.5 * rise)
    half_backlash = model.b * 50e-6 - 2.0 * shift * math.sin(math.pi / 4) * math.sin(math.radians(20.0))
    length = half_backlash / 50e-6
    damping = np.array(model.xi_translation) * viscosity / frequency
    again = model.replace(
        b=1.0,
        f_e=model.f_e / length,
        f_pm=model.f_pm / (modulus * length),
        f_pv=model.f_pv / (modulus * length),
        xi_mesh=model.xi_mesh * viscosity / frequency,
        xi_translation=tuple(damping),
        xi_support=tuple(np.array(model.xi_support) / frequency),
        k_support=tuple(np.array(model.k_support) / modulus),
    )
    return again, frequency, length


@pytest.mark.parametrize("difference", [-12.0, 8.0, 25.0])
@pytest.mark.parametrize("make", [published, lambda: consistent(alpha=0.45, f_pv=0.1, alpha_harmonics=((0.1, 0.4),))])
def test_solutions_are_those_of_the_pair_normalised_anew(make, difference):
    """Dimensional identity: lambda b_c is the same motion whatever the scales, at Omega Omega_n = omega' Omega_n(T)."""
    model = make()
    hot = PAIR_AT(difference, model)
    again, frequency, length = normalised_anew(model, difference)
    several = 0
    for omega in np.linspace(0.35, 1.4, 40):
        ours, its = all_solutions(hot, omega), all_solutions(again, omega / frequency)
        assert len(ours.mean) == len(its.mean)
        several += len(ours.mean) > 1
        for name in ("mean", "amplitude"):
            np.testing.assert_allclose(getattr(ours, name), length * getattr(its, name), rtol=0, atol=1e-10)
    assert several >= (difference > 0.0)


def test_what_the_pair_refuses():
    base = consistent()
    refused = "temperature = 60.0 .* law of damping holds: it is for 0 to 150, not for 160"
    with pytest.raises(ParameterError, match=refused):
        PAIR.changes(base, 60.0)
    thin = base.replace(b=0.1)
    with pytest.raises(ParameterError, match=r"temperature = 30.0 .* below 18\.3\d* K, where .* the gears jam"):
        PAIR.changes(thin, 30.0)
    # Half the backlash of 5 um is used up where 2 x 0.045 (11.5 - 5.25) 1e-6 x 2 D sin 45 sin 20 = 5 um.
    jam = 5e-6 / (4.0 * 0.045 * 6.25e-6 * math.sin(math.pi / 4) * math.sin(math.radians(20.0)))
    assert PAIR.changes(thin, jam - 1e-9)["b"] >= 0.0
    with pytest.raises(ParameterError, match=f"below {jam:.6g} K"):
        PAIR.changes(thin, jam + 1e-6)
    for change in ({"housing_share": 1.0}, {"length": 0.0}, {"reference": math.nan}, {"reference": 170.0}):
        with pytest.raises(ParameterError, match=next(iter(change))):
            dataclasses.replace(PAIR, **change)


# The path ------------------------------------------------------------------------------------------------------------

TABLES = dataclasses.replace(
    PAIR,
    damping=RatioTable([[0.0, 3.1], [30.0, 1.9], [50.0, 1.6], [90.0, 0.7], [140.0, 0.3]]),
    backlash=BacklashTable([[-20.0, 61e-6], [-3.0, 55e-6], [3.0, 47e-6], [20.0, 44e-6], [60.0, 31e-6]]),
)


@pytest.mark.parametrize("pair", [PAIR, TABLES], ids=["laws", "tables"])
def test_kernels_read_the_path_and_its_slope(pair):
    base, low, high = consistent(), -15.0, 40.0

    def vectors(axis, p):
        return axis_vectors(place_on(pair.path, p, base)[0], axis)

    read = plane_vectors(vectors, "omega", pair.path, (low, high))
    for p in np.linspace(low, high, 101):
        numbers, slopes = read.base.copy(), read.along_p.copy()
        add_path(read.bent, 0, p, numbers, slopes)
        np.testing.assert_allclose(numbers, vectors("omega", p)[0], rtol=2e-14, atol=2e-15)
        if low < p < high and not np.any(np.abs(np.array(pair.path.knots) - p) < 2e-4):
            step = 1e-4
            slope = (vectors("omega", p + step)[0] - vectors("omega", p - step)[0]) / (2.0 * step)
            np.testing.assert_allclose(slopes, slope, rtol=0, atol=2e-10)
    assert np.count_nonzero(read.base != numbers) == 7


def test_slopes_of_the_laws_in_closed_form():
    """Against the derivative of each law by hand, at the reference and away from it."""
    base = consistent()

    def vectors(axis, p):
        return axis_vectors(place_on(PAIR.path, p, base)[0], axis)

    read = plane_vectors(vectors, "omega", PAIR.path, (-15.0, 40.0))
    for p in (0.0, 13.0, 39.0):
        numbers, slopes = read.base.copy(), np.zeros_like(read.base)
        add_path(read.bent, 0, p, numbers, slopes)
        d_mu, d_log_nu = -3.35e-4 * 2.0, -1075.0 / (135.0 + 2.0 * p) ** 2 * 2.0
        mu = 1.0 + d_mu * p
        normal = math.sin(math.pi / 4) * math.sin(math.radians(20.0))
        assert slopes[1] == pytest.approx(-2.0 * 0.045 * 2.0 * (11.5e-6 - 5.25e-6) * normal / 50e-6, rel=1e-11)
        assert slopes[11] == pytest.approx(base.kappa[0] * d_mu, rel=1e-11)
        assert slopes[10] == pytest.approx(numbers[10] * (d_log_nu - d_mu / mu), rel=1e-11)
        assert slopes[13] == pytest.approx(numbers[13] * d_log_nu, rel=1e-11)


def test_what_a_path_may_not_be():
    with pytest.raises(ParameterError, match="x_axis = 'b' .* than b, kappa, .* which temperature sets"):
        plane_vectors(lambda axis, p: axis_vectors(consistent(), axis), "b", PAIR.path, (0.0, 1.0))
    steps = dataclasses.replace(PAIR.path, changes=lambda model, p: {"b": 1.0 + (p > 0.3)}, knots=())
    with pytest.raises(ParameterError, match="p_axis = 'temperature' .* smooth between its knots"):
        plane_vectors(
            lambda axis, p: axis_vectors(place_on(steps, p, consistent())[0], axis), "omega", steps, (0.0, 1.0)
        )
