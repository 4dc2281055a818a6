"""Units, gears in physical units, and what a plan and a store keep of them."""

import json
import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline import scales_of, store
from pipeline.__main__ import main
from pipeline.config.compose import compose
from pipeline.config.units import KINDS, quantities, quantity, speed, unit_size
from pipeline.errors import ConfigurationError
from pipeline.plan.numerics import model_at
from pipeline.plan.plan import plan_of
from pipeline.plan.planning import plan, warnings
from pipeline.plan.scales import gear_of
from pipeline.plan.unfelt import unfelt_harmonics
from tests.pipeline.planes import small_plan, small_store

EXAMPLES = ("miter", "differential")


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("45 N*m", "torque", 45.0),
        ("-45N*m", "torque", -45.0),
        ("45 N·m", "torque", 45.0),
        ("4.5e1 N m", "torque", 45.0),
        ("1 lbf*ft", "torque", 1.3558179483314),
        ("12 um", "length", 12e-6),
        ("12 µm", "length", 12e-6),
        ("1 inch", "length", 0.0254),
        ("20 deg", "angle", math.pi / 9),
        ("1 rad", "angle", 1.0),
        ("300 N/um", "stiffness", 3e8),
        ("2 kg*m^2", "inertia", 2.0),
        ("2 kg*m**2", "inertia", 2.0),
        ("2 kg m²", "inertia", 2.0),
        ("7.85 g/cm^3", "density", 7850.0),
        ("8 1/inch", "diametral pitch", 8 / 0.0254),
        ("8/inch", "diametral pitch", 8 / 0.0254),
        ("81/inch", "diametral pitch", 81 / 0.0254),
        ("900 N*s/m", "damping", 900.0),
        ("700 g", "mass", 0.7),
    ],
)
def test_quantities(text, kind, value):
    assert quantity("k", text, kind) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("45", "torque"),
        (45, "torque"),
        (45.0, "torque"),
        (None, "torque"),
        (True, "torque"),
        (["45 N*m"], "torque"),
        ("", "torque"),
        ("N*m", "torque"),
        ("45 N", "torque"),
        ("45 Nm m", "torque"),
        ("45 NM", "torque"),
        ("45 N*m*deg", "torque"),
        ("nan N*m", "torque"),
        ("inf N*m", "torque"),
        ("1e999 N*m", "torque"),
        ("4,5 N*m", "torque"),
        ("4 5 N*m", "torque"),
        ("9**9**9 m", "length"),
        ("9**9**9**9 m", "length"),
        ("1 m**9**9**9", "length"),
        ("1 m^99", "length"),
        ("1 __import__('os')", "length"),
        ("1 m.__class__", "length"),
        ("1 m if 1 else 2", "length"),
        ("1 " + "m*" * 500 + "m", "length"),
        ("1 (m)", "length"),
        ("1 [length]", "length"),
        ("20 degC", "angle"),
        ("20 degC*m", "length"),
        ("1 m/m", "angle"),
        ("3 percent*m", "length"),
        ("20 deg^2", "angle"),
        ("10 Hz", "angle"),
        ("1 1 m", "length"),
        ("11 1/inch 1/m", "diametral pitch"),
    ],
)
def test_what_is_no_quantity(text, kind):
    with pytest.raises(ConfigurationError) as error:
        quantity("gear.physical.x", text, kind)
    said = str(error.value)
    assert said.startswith("gear.physical.x = ") and "\n" not in said and len(said) < 400
    assert f"a number with a unit of {kind}, such as {KINDS[kind][0]!r}" in said


@given(st.text(alphabet="0123456789eE.+-*/^()[]{}_ abmNkgHzrpsdegµ'\"\\\n", max_size=70))
def test_any_text_is_a_finite_number_or_one_line(text):
    try:
        assert math.isfinite(quantity("k", text, "length"))
    except ConfigurationError as error:
        assert "\n" not in str(error)


def test_lists_of_quantities_and_units_alone():
    assert quantities("k", "2 kg", "mass", 2) == [2.0, 2.0]
    assert quantities("k", ["2 kg", "500 g"], "mass", 2) == [2.0, 0.5]
    with pytest.raises(ConfigurationError, match="or a list of 2"):
        quantities("k", ["2 kg"], "mass", 2)
    with pytest.raises(ConfigurationError, match=r"k\[1\] = 3 is"):
        quantities("k", ["2 kg", 3], "mass", 2)
    assert unit_size("k", "N/um", "stiffness") == pytest.approx(1e6)
    for text in ("um", "", "9**9**9", "xyz"):
        with pytest.raises(ConfigurationError, match="must be a unit of stiffness"):
            unit_size("k", text, "stiffness")


@pytest.mark.parametrize(
    ("text", "name", "value"),
    [
        ("1500 rpm", "omega", 50 * math.pi),
        ("25 turn/s", "omega", 50 * math.pi),
        ("10 rad/s", "omega", 10.0),
        ("1.2 kHz", "mesh_frequency", 1200.0),
        ("50 Hz", "mesh_frequency", 50.0),
    ],
)
def test_speeds(text, name, value):
    found, number = speed("k", text)
    assert found == name and number == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("text", ["10 1/s", "10 m/s", "10", 10, "10 rpm*Hz", "10 Hz*rad", "10 deg"])
def test_what_is_no_speed(text):
    with pytest.raises(ConfigurationError, match="pinion speed or mesh frequency"):
        speed("k", text)


# Gears


@pytest.mark.parametrize("gear", EXAMPLES)
def test_examples(gear, capsys):
    found = small_plan(f"gear={gear}")
    assert model_at(found, 0.2, 1.0) == gear_of(found).model().replace(f_e=0.2)
    model = gear_of(found).model()
    assert model.b == 1.0 and 0.1 < model.f_pm < 1.0 and 0.1 < model.f_e < 0.5
    assert 0.05 < model.mesh_modes()[0] < model.mesh_modes()[1] < 2.0
    unfelt = unfelt_harmonics(found)
    assert warnings(found) == ([unfelt.sentence] if unfelt else [])
    assert main(["--cfg", f"gear={gear}"]) == 0
    assert "half_backlash" in capsys.readouterr().out


def test_miter_is_what_its_drawing_says():
    """Round pitch cones of 45 degrees, and the blank's mass by its own formula."""
    gear = gear_of(small_plan("gear=miter", "gear.physical.torque='60 N*m'"))
    assert gear.cone_angles == pytest.approx((45.0, 45.0))
    assert gear.mean_radii == pytest.approx([0.04 - 0.008 * math.sqrt(0.5)] * 2)
    frustum = math.pi / 3 * 0.026 * (0.04**2 + 0.04 * 0.0287 + 0.0287**2) - math.pi * 0.01**2 * 0.026
    assert gear.mass == pytest.approx([7850 * frustum] * 2)
    assert gear.torque == 60.0
    pitch = small_plan("gear=miter", "gear.physical.module=null", "gear.physical.diametral_pitch=6.35/inch")
    assert gear_of(pitch).module == pytest.approx(0.004, rel=1e-12)


def test_axes_and_frequency_with_units():
    scales = scales_of(small_plan("gear=miter"))
    found = small_plan("gear=miter", "plane.sweep.min=500 rpm", "plane.sweep.max=8 kHz", "plane.parameter.max='20 um'")
    assert found.sweep.low == pytest.approx(500 / scales["omega"].shown)
    assert found.sweep.high == pytest.approx(8000 / scales["mesh_frequency"].shown)
    assert (found.parameter.low, found.parameter.high) == pytest.approx((0.0, 0.4))
    torque = small_plan("gear=miter", "plane=omega_fpm", "plane.parameter.min='80 N*m'", "plane.parameter.max=1")
    assert scales.physical("f_pm", torque.parameter.low) == pytest.approx(80.0)
    single = small_plan(
        "gear=miter",
        "plane.sweep.name=f_e",
        "plane.sweep.min=0",
        "plane.sweep.max=0.5",
        "plane.omega=9000 rpm",
        "plane.parameter.name=b",
        "plane.parameter.min=5 um",
        "plane.parameter.max=60 um",
    )
    assert single.omega == pytest.approx(9000 / scales["omega"].shown) and single.parameter.low == pytest.approx(0.1)


def test_a_store_keeps_the_physical_gear(tmp_path):
    found = small_plan("gear=differential", columns=11, rows=2)
    path = small_store(tmp_path / "plane.zarr", found, blocks=[])
    read = store.read_plan(path)
    assert read == found and scales_of(read) == scales_of(found) and store.check(path, found)
    assert plan_of(json.loads(json.dumps(found.inputs))).fingerprint == found.fingerprint
    other = small_plan("gear=differential", "gear.physical.torque=121 N*m", columns=11, rows=2)
    with pytest.raises(ConfigurationError, match="gear.physical.torque: stored 120.0, asked 121.0"):
        store.check(path, other)


def test_dimensionless_plans_know_nothing_of_units():
    found = small_plan()
    assert found.physical is None and "physical" not in found.inputs and scales_of(found) is None
    code = (
        "import sys; from pipeline.config.compose import compose; from pipeline.plan.planning import plan, warnings; "
    )
    code += "warnings(plan(compose([]))); assert 'pint' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


MISTAKES = [
    ("gear.b=0.5", "gear.b = 0.5 is not allowed: it must be null, because it follows from gear.physical"),
    ("gear.physical.torque=60", "gear.physical.torque = 60 is not allowed: it must be a number with a unit of torque"),
    ("gear.physical.torque=60 N", "gear.physical.torque = '60 N'"),
    ("gear.physical.torque=60 Nmm", "'Nmm' is not a known unit"),
    ("gear.physical.torque=null", "gear.physical.torque has no value"),
    ("gear.physical.teeth=[20,20.5]", "gear.physical.teeth[1] = 20.5 is not allowed"),
    ("gear.physical.shaft_angle=180 deg", "gear.physical.shaft_angle = 180.0"),
    (
        "gear.physical.face_width=60 mm",
        "gear.physical.face_width = 0.06 is not allowed: it must be at most the cone distance",
    ),
    ("gear.physical.diametral_pitch=8/inch", "gear.physical.module = '4 mm' is not allowed: it must be one of them"),
    ("gear.physical.module=null", "gear.physical.module = None is not allowed"),
    ("gear.physical.blanks=null", "gear.physical.mass has no value: give it, or gear.physical.blanks"),
    ("gear.physical.blanks=[1,2]", "gear.physical.blanks = [1, 2] is not allowed"),
    ("gear.physical.blanks=[{width:1 mm},{}]", "gear.physical.blanks[0]."),
    ("gear.physical.density=-1 kg/m^3", "cannot be read"),
    ("gear.physical.density=-1 kg/m**3", "gear.physical.density = -1.0"),
    ("gear.physical.mass=1 kg gear.physical.inertia=1 kg*m**2", "gear.physical.blanks is not allowed"),
    ("gear.physical.error_harmonics=[1 um]", "it must be a list of [amplitude, phase]"),
    ("gear.physical.error_harmonics=[[1 um,0]]", "gear.physical.error_harmonics[0][1] = 0"),
    ("gear.physical.mesh_stiffness_harmonics=[[300 N/um,0 deg]]", "stays at least 0 all cycle"),
    ("gear.physical.mesh_stiffness=null", "gear.physical.mesh_stiffness has no value"),
    ("gear.physical.half_backlash=0 um", "gear.physical.reference_length = None"),
    ("gear.physical.torqe=1", "did you mean gear.physical.torque?"),
    ("plane=omega_fpm gear.physical.torque=60 N*m", "gear.physical.torque is not allowed here: f_pm"),
    (
        "plane.sweep.min=500",
        "plane.sweep.max = 2.0 is not allowed: it must be a finite number above plane.sweep.min = 500.0",
    ),
    ("plane.sweep.min=-500 rpm", "plane.sweep.min = '-500 rpm' is not allowed: it must be a finite number above 0"),
    ("plane.sweep.min=500 um", "pinion speed or mesh frequency"),
    (
        "plane.parameter.max=500 rpm",
        "plane.parameter.max = '500 rpm' is not allowed: it must be a number with a unit of length",
    ),
    ("plane.parameter.name=kappa plane.parameter.max=1 um", "it must be a number, kappa has no unit"),
    ("plane.omega=500 rpm", "omega is an axis of this plane"),
    ("gear=published plane.sweep.min=500 rpm", "units need a gear in physical units"),
    ("gear=published gear.physical.torque=1", "this gear is dimensionless"),
    ("gear=published figures.units=physical", "figures.units = 'physical' is not allowed"),
    ("figures.units=imperial", "figures.units = 'imperial' is not allowed: it must be one of dimensionless, physical"),
    ("gear=dimensional", "gear.physical.teeth has no value"),
]


@pytest.mark.usefixtures("no_helpers")
@pytest.mark.parametrize(("typed", "said"), MISTAKES, ids=[typed for typed, _ in MISTAKES])
def test_a_mistake_is_one_line_status_2_and_nothing_written(typed, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    # Words of one value hold together: only " gear" and " plane" begin another.
    words = typed.replace(" gear", "\ngear").replace(" plane", "\nplane").replace(" figures", "\nfigures").split("\n")
    assert main([*([] if any(word.startswith("gear=") for word in words) else ["gear=miter"]), *words]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: ") and said in lines[0]
    assert list(tmp_path.iterdir()) == []


def test_several_gears_at_once_have_stores_of_their_own():
    names = [compose([f"gear={gear}"]).store_name for gear in EXAMPLES]
    assert names == ["omega_fe-miter", "omega_fe-differential"]
    assert plan(compose(["gear=miter"])).fingerprint != plan(compose(["gear=differential"])).fingerprint
