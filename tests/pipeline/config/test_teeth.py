"""Mesh stiffness of a gear in physical units from its teeth: the key, what a plan keeps, and what is refused."""

import json

import numpy as np
import pytest

from pipeline.errors import ConfigurationError
from pipeline.plan.differences import by_key, differences
from pipeline.plan.plan import plan_of
from pipeline.plan.planning import warnings
from pipeline.plan.scales import gear_of
from solver import GearTeeth, bevel_mesh, iso_6336_stiffness
from tests.pipeline.planes import small_plan

GEOMETRY = ("mesh_stiffness=from_geometry", "mesh_stiffness_harmonics=[]")


def drawn(*physical, gear="miter"):
    return small_plan(f"gear={gear}", *(f"gear.physical.{text}" for text in physical))


def miter_mesh(**changes):
    gear = GearTeeth(20, 4e-3, **{"bore": 0.02, **changes})
    return bevel_mesh(gear, gear, 90.0, 0.016)


def test_the_stiffness_of_the_teeth_is_the_gears():
    found, mesh = drawn(*GEOMETRY), miter_mesh()
    gear = gear_of(found)
    assert gear.mesh_stiffness == pytest.approx(mesh.mean_stiffness, rel=1e-14)
    np.testing.assert_allclose(gear.mesh_stiffness_harmonics, mesh.harmonics(3), rtol=1e-13)
    assert found.gear["alpha"] == pytest.approx(mesh.harmonics(1)[0][0] / mesh.mean_stiffness, rel=1e-13)
    assert found.gear["alpha_phase"] == pytest.approx(mesh.harmonics(1)[0][1], rel=1e-13)
    teeth = found.physical["teeth"]
    assert teeth["contact_ratio"] == mesh.contact_ratio and teeth["estimate"] == iso_6336_stiffness(mesh)
    # As a store has it.
    assert plan_of(json.loads(json.dumps(found.inputs))) == found
    (line,) = [line for line in warnings(found) if line.startswith("teeth")]
    for number in (f"{mesh.contact_ratio:.4g}", f"{mesh.mean_stiffness / 1e6:.4g} N/um"):
        assert number in line


def test_number_of_harmonics():
    found = gear_of(drawn(*GEOMETRY, "mesh_cycle_harmonics=5")).mesh_stiffness_harmonics
    np.testing.assert_allclose(found, miter_mesh().harmonics(5), rtol=1e-13)


def test_teeth_and_bodies_are_read_for_each_gear():
    keys = ("tooth.profile_shift=[0.2,-0.2]", "tooth.bore=[22 mm,30 mm]", "tooth.addendum=0.9", "tooth.dedendum=1.3")
    found = gear_of(drawn(*GEOMETRY, *keys, "tooth.youngs_modulus=[206 GPa,100 kN/mm**2]", "tooth.poisson=0.25"))
    same = dict(addendum=0.9, dedendum=1.3, poisson=0.25)
    first = GearTeeth(20, 4e-3, bore=0.022, profile_shift=0.2, **same)
    second = GearTeeth(20, 4e-3, bore=0.03, profile_shift=-0.2, youngs_modulus=1e11, **same)
    assert found.mesh_stiffness == pytest.approx(bevel_mesh(first, second, 90.0, 0.016).mean_stiffness, rel=1e-13)


def test_the_estimate_leaves_the_harmonics_to_the_user():
    found = drawn("mesh_stiffness=iso6336")
    gear = gear_of(found)
    assert gear.mesh_stiffness == iso_6336_stiffness(miter_mesh())
    assert gear.mesh_stiffness_harmonics == ((45e6, 0.0),)
    assert not any("100 N/mm" in line for line in warnings(found))
    assert any("100 N/mm" in line for line in warnings(drawn("mesh_stiffness=iso6336", "torque=20 N*m")))


def test_examples():
    found = drawn(*GEOMETRY, gear="differential")
    assert found.physical["teeth"]["bodies_fit"] == [False, True]
    assert any("pinion" in line for line in warnings(found))


def test_other_plans_keep_nothing_of_teeth():
    assert "teeth" not in small_plan("gear=miter").physical


def test_a_difference_is_said_by_the_keys():
    stored, asked = (by_key(drawn(*GEOMETRY, f"tooth.profile_shift=[{x},-{x}]").inputs) for x in (0.1, 0.2))
    assert "gear.physical.mesh_stiffness" in differences(stored, asked)


@pytest.mark.parametrize(
    ("key", "texts"),
    [
        ("gear.physical.mesh_stiffness", ["mesh_stiffness=geometry"]),
        ("gear.physical.mesh_stiffness_harmonics", ["mesh_stiffness=from_geometry"]),
        ("gear.physical.tooth.bore", [*GEOMETRY, "tooth.bore=20"]),
        ("gear.physical.tooth.bore", [*GEOMETRY, "tooth.bore=[20 mm]"]),
        ("gear.physical.tooth.bore", [*GEOMETRY, "tooth.bore=200 mm"]),
        ("gear.physical.tooth.bore", [*GEOMETRY, "blanks=null", "mass=1 kg", "inertia=1e-3 kg*m**2"]),
        ("gear.physical.tooth.profile_shift", [*GEOMETRY, "tooth.profile_shift=x"]),
        ("gear.physical.tooth.profile_shift", [*GEOMETRY, "tooth.profile_shift=[0.1,0.2,0.3]"]),
        ("gear.physical.tooth.profile_shift", ["mesh_stiffness=iso6336", "tooth.profile_shift=[-0.1,0.1]"]),
        ("gear.physical.tooth.addendum", [*GEOMETRY, "tooth.addendum=0.3"]),
        ("gear.physical.tooth.dedendum", [*GEOMETRY, "tooth.dedendum=0.8"]),
        ("gear.physical.tooth.edge_radius", [*GEOMETRY, "tooth.edge_radius=2"]),
        ("gear.physical.tooth.youngs_modulus", [*GEOMETRY, "tooth.youngs_modulus=206 MN"]),
        ("gear.physical.tooth.poisson", [*GEOMETRY, "tooth.poisson=0.7"]),
        ("gear.physical.pressure_angle", [*GEOMETRY, "pressure_angle=5 deg"]),
        ("gear.physical.teeth", [*GEOMETRY, "teeth=20"]),
        ("gear.physical.teeth", [*GEOMETRY, "teeth=[20,20.5]"]),
        ("gear.physical.shaft_angle", [*GEOMETRY, "teeth=[20,40]", "shaft_angle=130 deg"]),
        ("gear.physical.face_width", [*GEOMETRY, "face_width=90 mm"]),
        ("gear.physical.mesh_cycle_harmonics", [*GEOMETRY, "mesh_cycle_harmonics=1000"]),
    ],
)
def test_what_is_not_allowed_is_named(key, texts):
    with pytest.raises(ConfigurationError) as error:
        drawn(*texts)
    assert str(error.value).startswith(key) and "\n" not in str(error.value)
