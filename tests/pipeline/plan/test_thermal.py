"""Temperature as the row parameter of a gear in physical units: configuration, store, boundaries, bad input."""

import json
import math

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline import store
from pipeline.__main__ import main
from pipeline.analysis import boundaries
from pipeline.analysis.boundaries.events import dead_zone_at
from pipeline.config.compose import compose
from pipeline.config.units import celsius, quantity
from pipeline.errors import ConfigurationError
from pipeline.figures.naming import axis_label, fixed_parameters, value_text
from pipeline.plan.numerics import model_at
from pipeline.plan.plan import plan_of
from pipeline.plan.planning import plan
from pipeline.plan.scales import gear_of
from pipeline.plane.boundaries import read_boundaries
from solver import Event, GearPair, ImpactState, Model, all_solutions
from solver.boundaries import SPECTRAL
from solver.model.contact_system import gear_system
from tests.pipeline.planes import contents, small_plan, small_store

MITER = ["plane=omega_temperature", "gear=miter"]


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    swept = small_plan(*MITER, "plane.parameter.min=-12", "plane.parameter.max=28", columns=60, rows=11)
    return small_store(tmp_path_factory.mktemp("thermal") / "plane.zarr", swept)


# Configuration -------------------------------------------------------------------------------------------------------


def test_laws_are_kept_in_si_units():
    swept = small_plan(*MITER)
    laws = swept.thermal
    assert plan_of(json.loads(json.dumps(swept.inputs))) == swept
    assert (laws["length"], laws["reference"], laws["housing_share"]) == (pytest.approx(50e-6), 40.0, 0.5)
    # To mid face: (56.57 mm - 8 mm) cos 45.
    middle = (80e-3 / math.sqrt(2.0) - 8e-3) / math.sqrt(2.0)
    assert laws["backlash"]["distances"] == pytest.approx([middle, middle], rel=1e-12)
    assert laws["backlash"]["cone_angles"] == [45.0, 45.0] and laws["backlash"]["pressure_angle"] == 20.0
    oil = {"law": "vogel", "constant": 1075.0, "offset": 95.0, "exponent": 1.0, "valid": [0.0, 120.0]}
    assert laws["damping"] == oil
    given = small_plan(*MITER, "gear.thermal.backlash.distances=[50 mm,2 inch]", "gear.thermal.reference=313.15 K")
    assert given.thermal["backlash"]["distances"] == [0.05, pytest.approx(0.0508)]
    assert given.thermal["reference"] == pytest.approx(40.0, abs=1e-10)


def test_units_of_temperature():
    assert celsius("k", "-20 degC") == -20.0 and celsius("k", "212 degF") == pytest.approx(100.0)
    assert quantity("k", "11.2e-6 1/K", "thermal coefficient") == 11.2e-6
    for value in ("40", 40, "40 K/s", "40 degC^2", "40 m"):
        with pytest.raises(ConfigurationError, match="^k = .* must be a temperature with its unit"):
            celsius("k", value)
    for value in ("20 degC", "20 m", 20):
        with pytest.raises(ConfigurationError, match="^k = .* such as '20 K'"):
            quantity("k", value, "temperature difference")


def test_a_table_replaces_a_law():
    swept = small_plan(
        *MITER,
        "gear.thermal.damping.law=table",
        "gear.thermal.damping.table=[[0 degC,3],[40 degC,2],[120 degC,1]]",
        "gear.thermal.stiffness.law=none",
        "gear.thermal.backlash.law=table",
        "gear.thermal.backlash.table=[[-10 K,60 um],[0 K,50 um],[30 K,20 um]]",
    )
    cold, base, hot = (model_at(swept, value, 1.0) for value in (-10.0, 0.0, 30.0))
    assert [model.b for model in (cold, base, hot)] == pytest.approx([1.2, 1.0, 0.4], rel=1e-12)
    # 30 K between gears and housing are 100 degrees in the gears.
    assert hot.xi_mesh == pytest.approx(0.05 * _parabola(100.0) / 2.0, rel=1e-12)
    assert hot.kappa == base.kappa


def _parabola(t):
    """Lagrange's form of the table of damping."""
    return 3.0 * (t - 40) * (t - 120) / 4800 + 2.0 * t * (t - 120) / (40 * -80) + t * (t - 40) / (120 * 80)


def test_the_other_axis_may_have_a_unit():
    swept = small_plan(*MITER, "plane.parameter.min=-5 K", "plane.parameter.max=20 K")
    assert (swept.parameter.low, swept.parameter.high) == (-5.0, 20.0)


# Numbers -------------------------------------------------------------------------------------------------------------


def test_the_reference_row_is_the_plane_without_temperature(tmp_path, stored):
    """Same bits as the row of a plane over another parameter at the gear's own value of it."""
    swept = store.read_plan(stored)
    (row,) = np.flatnonzero(np.isclose(swept.parameter.values, 0.0, atol=1e-12))
    assert swept.parameter.values[row] == 0.0
    load = model_at(swept, 0.0, 1.0).f_pm
    axis = ["plane.parameter.name=f_pm", f"plane.parameter.min={load!r}", f"plane.parameter.max={2.0 * load!r}"]
    other = small_store(tmp_path / "load.zarr", small_plan("gear=miter", *axis, columns=60, rows=2))
    ours, its = contents(stored), contents(other)
    raster = [name for name in ours if ours[name].shape[:2] == (swept.parameter.num, swept.sweep.num) and name in its]
    assert {"mean", "amplitude", "phase", "stable", "impact", "domain", "multiplier", "n_solutions"} <= set(raster)
    for name in raster:
        np.testing.assert_array_equal(ours[name][row], its[name][0])
    assert np.max(its["n_solutions"][0]) > 1


@pytest.mark.parametrize("difference", [-10.0, 13.0, 30.0])
def test_models_are_those_of_the_pair_in_si_at_that_temperature(difference):
    """Stiffness, damping and backlash of the hot gear put into the SI pair, which is normalised on its own scales."""
    swept = small_plan(*MITER)
    pair, rise = gear_of(swept), 2.0 * difference
    mu, nu = 1.0 - 3.35e-4 * rise, math.exp(1075.0 / (135.0 + rise) - 1075.0 / 135.0)
    shift = swept.thermal["backlash"]["distances"][0] * (11.2e-6 * rise - 10.8e-6 * difference)
    half = 50e-6 - 2.0 * shift * math.sin(math.radians(45.0)) * math.sin(math.radians(20.0))
    hot = GearPair(
        **{
            **swept.physical["gear"],
            "mesh_stiffness": pair.mesh_stiffness * mu,
            "half_backlash": half,
            "mesh_stiffness_harmonics": [(a * mu, p) for a, p in pair.mesh_stiffness_harmonics],
            "mesh_damping_ratio": pair.mesh_damping_ratio * nu / math.sqrt(mu),
        }
    )
    assert hot.mesh_damping == pytest.approx(pair.mesh_damping * nu, rel=1e-12)
    frequency, length = hot.frequency_unit / pair.frequency_unit, hot.length_unit / pair.length_unit
    several = 0
    for omega in np.linspace(0.4, 1.4, 41):
        ours = all_solutions(model_at(swept, difference, omega), omega)
        its = all_solutions(hot.model(), omega / frequency)
        np.testing.assert_allclose(ours.mean, length * its.mean, rtol=0, atol=1e-10)
        np.testing.assert_allclose(ours.amplitude, length * its.amplitude, rtol=0, atol=1e-10)
        several += len(ours.mean) > 1
    assert several >= (difference > 0.0)


def test_every_stage_reads_the_gear_of_its_row(stored):
    """The impact states of the store are those of the row's own backlash."""
    swept = store.read_plan(stored)
    plane = xr.open_zarr(stored)
    assert plane.temperature.attrs == {"long_name": "temperature difference between gears and housing", "units": "K"}
    for row, value in enumerate(swept.parameter.values):
        model = model_at(swept, value, 1.0)
        here = plane.isel(temperature=row)
        free = here.impact.values == ImpactState.PERMANENT
        lowest = (here["mean"] - here.amplitude).values
        assert np.all(lowest[free] > model.b)
        assert np.all(lowest[here.impact.values == ImpactState.SINGLE_SIDED] <= model.b)
        assert dead_zone_at(swept, np.array([0.7]), np.array([value]))[1][0] == model.b
        assert gear_system(model).front_gap == model.b


@pytest.mark.costly
def test_boundaries_and_thresholds(stored):
    swept = store.read_plan(stored)
    summary = boundaries.trace(stored, swept)
    assert summary.curves["fold"] == 2 and not summary.cut_short
    curves = read_boundaries(stored, swept).curves
    for curve in curves:
        if curve.kind in SPECTRAL:
            continue
        assert curve.side != 0
        if curve.kind is Event.MIN_AT_DRIVE:
            for point in curve.points[::9]:
                b = model_at(swept, point[4], point[3]).b
                assert point[0] - np.hypot(point[1], point[2]) == pytest.approx(b, abs=1e-11)
    cusps = sorted(float(np.min(curve.points[:, 4])) for curve in curves if curve.kind is Event.FOLD)
    assert cusps == pytest.approx([-4.105, 1.43], abs=0.2)
    found = pipeline.thresholds(stored)
    assert sum(one.share for one in found) == pytest.approx(1.0, abs=1e-12)
    two = min(one.appears for one in found if one.label.startswith("2/"))
    assert two == pytest.approx(cusps[0], abs=1e-6)


def test_figures_name_the_axis(stored):
    swept = store.read_plan(stored)
    assert axis_label("temperature", store.axis_attributes("temperature")).endswith(r"$\Delta T$ (K)")
    assert value_text("temperature", -3.0) == r"$\Delta T$ = −3 K"
    assert fixed_parameters(swept).startswith(r"at $\Delta T$ = 0 K:  $b$ = 1,")
    assert isinstance(model_at(swept, 3.0, 1.0), Model)


# Bad input -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["gear=published"], "plane.parameter.name = 'temperature' is not allowed: it needs a gear in physical units"),
        (["gear.thermal=null"], "gear.thermal, the laws of temperature, has no value"),
        (["plane.parameter.max=50"], "plane.parameter.max = 50.0 .* must be such that the law of damping"),
        (["plane.parameter.min=-30"], "plane.parameter.min = -30.0 is not allowed: .* it is for 0 to 120, not for -20"),
        (
            ["gear.physical.half_backlash=5 um", "gear.physical.reference_length=50 um"],
            r"parameter.max = 30.0 .* must be below 25.9\d+ K, where the backlash is used up and the gears jam",
        ),
        (
            [
                "gear.physical.half_backlash=5 um",
                "gear.thermal.backlash.law=table",
                "gear.thermal.backlash.table=[[-10 K,60 um],[0 K,50 um],[10 K,40 um],[30 K,50 um]]",
            ],
            r"temperature = \d.\d+ is not allowed: .* the gears jam",
        ),
        (["gear.thermal.stiffness.law=cubic"], "gear.thermal.stiffness.law = 'cubic' .* one of linear, table, none"),
        (["gear.thermal.stiffness.slope=3e-4"], "gear.thermal.stiffness.slope = 0.0003 .* unit of thermal coefficient"),
        (["gear.thermal.damping.exponent=x"], "gear.thermal.damping.exponent = 'x' .* must be a number"),
        (["gear.thermal.damping.exponent=-1"], "gear.thermal.damping.exponent = -1.0 .* at least 0"),
        (["gear.thermal.reference=40"], "gear.thermal.reference = 40 .* must be a temperature with its unit"),
        (["gear.thermal.reference=140 degC"], "gear.thermal.reference = 140.0 .* law of damping holds"),
        (["gear.thermal.housing_share=1"], "gear.thermal.housing_share = 1.0 .* below 1"),
        (["gear.thermal.damping.law=table"], "gear.thermal.damping.table = .* at least 2"),
        (["gear.thermal.damping.law=table", "gear.thermal.damping.table=[1]"], "list of .temperature, value. pairs"),
        (["gear.thermal.backlash.gears=11e-6 1/K"], "gear.thermal.backlash.gears = 1.1e-05 .* list of 2"),
        (["plane.sweep.name=b", "plane.sweep.min=0", "plane.omega=1"], "plane.sweep.name = 'b' .* over temperature"),
        (["plane.sweep.name=temperature", "plane.parameter.name=omega"], "temperature .* plane.parameter.name only"),
        (["plane.parameter.max=30 degC"], "plane.parameter.max = '30 degC' .* unit of temperature difference"),
    ],
)
def test_mistakes_are_one_line(overrides, message):
    with pytest.raises(ConfigurationError, match=message) as caught:
        plan(compose([*MITER, *overrides]))
    assert "\n" not in str(caught.value)


def test_nothing_is_written_for_a_mistake(tmp_path, capsys):
    assert main([*MITER, "plane.parameter.max=50", f"output.root={tmp_path / 'out'}"]) == 2
    assert "plane.parameter.max = 50.0" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_other_planes_do_not_feel_the_laws():
    """Neither numbers nor digest of a plane that is not over temperature depend on gear.thermal."""
    one = plan(compose(["plane=omega_fe", "gear=miter"]))
    assert one.thermal is None and "thermal" not in one.inputs
    assert (
        plan(compose(["plane=omega_fe", "gear=miter", "gear.thermal.reference=20 degC"])).fingerprint == one.fingerprint
    )
