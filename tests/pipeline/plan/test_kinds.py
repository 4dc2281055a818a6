"""Planes of a spur pair, a rotor and a system of one's own: plans, axes, rows, boundaries, what is refused."""

import numpy as np
import pytest

import pipeline
from pipeline.config.compose import compose
from pipeline.errors import ConfigurationError
from pipeline.figures.naming import fixed_parameters, gear_text, mesh_energies
from pipeline.plan.kinds import KINDS
from pipeline.plan.numerics import frame_of, model_at, row_system
from pipeline.plan.plan import plan_of
from pipeline.plan.planning import plan
from pipeline.plan.scales import scales_of
from pipeline.plan.unfelt import unfelt_harmonics
from pipeline.plane.resonances import contact_modes
from pipeline.plane.stored import read_stored
from pipeline.store.attributes import LONG_NAMES
from solver import ContactSystem, all_solutions, spur_pair, sweep_row
from solver.model.parameter_path import place_on
from tests.pipeline.planes import small_plan, small_store, traced_store

#: One system of each kind with every axis that it has.
GEARS = {
    "spur": (),
    "rotor": ("gear.rotor.far_inertia=2e-3 kg*m**2", "gear.rotor.shaft_stiffness=2e4 N*m/rad")
    + ("gear.rotor.shaft_damping=5 N*m*s/rad",),
    "stop": ("gear.system.load=[[0.1,0],[0,0.375]]", "gear.system.varying_force=[1,0]", "gear.system.front_gap=0.5")
    + ("solver.certify=none",),
}
KIND_OF = {"spur": "spur", "rotor": "rotor", "stop": "system"}
AXES = [(gear, name) for gear, kind in KIND_OF.items() for name in KINDS[kind].axes]


def planned(gear, *overrides):
    return small_plan(f"gear={gear}", "plane=omega_excitation", *GEARS[gear], *overrides)


def same(one: ContactSystem, other: ContactSystem):
    for name, value in vars(one).items():
        np.testing.assert_allclose(value, getattr(other, name), rtol=1e-13, atol=1e-15, err_msg=name)


@pytest.mark.parametrize(("gear", "name"), AXES)
def test_every_axis_is_a_number_of_the_system(gear, name):
    """What the solver varies from the frame and from a row is the system at that place."""
    if name == "excitation":
        found = planned(gear)
    else:
        found = planned(gear, f"plane.parameter.name={name}", "plane.parameter.min=0.3", "plane.parameter.max=0.9")
    assert plan_of(found.inputs) == found
    start, x_axis, p_axis, *_ = frame_of(found)
    same(place_on(p_axis, 0.7, start)[0], model_at(found, 0.7, 1.0))
    same(row_system(found, 0.7), model_at(found, 0.7, 1.0))
    swept = planned(
        gear,
        f"plane.sweep.name={name}",
        "plane.sweep.min=0.3",
        "plane.sweep.max=0.9",
        "plane.parameter.name=omega",
        "plane.parameter.min=0.5",
    )
    start, x_axis, *_ = frame_of(swept)
    same(place_on(x_axis, 0.7, row_system(swept, 0.8))[0], model_at(swept, 0.8, 0.7))


def test_a_number_of_the_spur_pair_is_what_its_axis_says():
    swept = small_plan(
        "gear=spur",
        "plane=omega_load",
        "plane.sweep.name=damping_ratio",
        "plane.sweep.min=0.01",
        "plane.sweep.max=0.2",
        "plane.omega=0.8",
    )
    pi = np.pi
    harmonics = dict(stiffness_harmonics=[(0.2, pi), (0.1, pi), (0.05, pi)])
    harmonics |= dict(error_harmonics=[(0.01, 0.0), (0.004, 0.0), (0.002, 0.0)])
    same(model_at(swept, 0.12, 0.03), spur_pair(0.03, 1.0, 0.12, **harmonics))


def test_a_rotor_in_units_is_the_one_of_its_numbers():
    """Units scale; what is dimensionless stays. Without units the same numbers make the same system."""
    found = planned("rotor")
    system, scales = model_at(found, 1.0, 1.0), scales_of(found)
    assert system.degrees == 5 and system.front_gap == 1.0
    me = 0.5 * 1.2e-3 / 0.047**2
    assert scales["omega"].size == pytest.approx(np.sqrt(2.6e8 / me) / (2 * np.pi), rel=1e-12)
    assert system.mass[0, 0] == pytest.approx(1.2 / me, rel=1e-12)
    closed = system.stiffness + np.outer(system.force, system.contact)
    force = system.contact @ np.linalg.solve(closed, system.load[0].real)
    assert force * scales["mean_load"].size == pytest.approx(150.0, rel=1e-10)
    values = [entry.partition("=") for entry in GEARS["rotor"]]
    bare = [f"{key}={text.split()[0]}" for key, _, text in values]
    bare += ["gear.rotor.inertia=1.2e-3", "gear.rotor.base_radius=0.047", "gear.rotor.mesh_stiffness=2.6e8"]
    bare += ["gear.rotor.half_backlash=50e-6", "gear.rotor.torque=150", "gear.rotor.mass=1.2"]
    bare += [
        "gear.rotor.support_stiffness=4e8",
        "gear.rotor.support_damping=900",
        "gear.rotor.error_harmonics=[[2e-6,0]]",
    ]
    plain = small_plan("gear=rotor", "plane=omega_excitation", *bare)
    assert plain.physical is None and scales_of(plain) is None
    same(model_at(plain, 1.0, 1.0), system)


@pytest.mark.parametrize(
    ("overrides", "names"),
    [
        (["gear=spur"], ["plane.parameter.name", "'f_e'", "mean_load, alpha"]),
        (["gear=spur", "plane=omega_load", "plane.parameter.name=stiffness"], ["'stiffness'", "damping_ratio"]),
        (["gear=stop", "plane=omega_load"], ["'mean_load'", "nothing", "contact_damping"]),
        (["gear=stop", "plane=omega_gap", "plane.parameter.name=alpha"], ["'alpha'", "nothing"]),
        (
            [
                "gear=stop",
                "plane=omega_gap",
                "plane.sweep.name=damping",
                "plane.omega=1",
                "plane.parameter.name=contact_damping",
            ],
            ["damping and contact_damping"],
        ),
        (["gear=spur", "plane=omega_load", "gear.spur.mean_load=1"], ["gear.spur.mean_load", "axis"]),
        (["gear=rotor", "plane=omega_load", "gear.rotor.torque=1 N*m"], ["gear.rotor.torque", "mean_load"]),
        (["gear=rotor", "plane=omega_load", "gear.rotor.mass=1"], ["gear.rotor.mass", "unit"]),
        (["gear=rotor", "plane=omega_load", "gear.rotor.mass=1 m"], ["gear.rotor.mass", "'1 m'"]),
        (["gear=rotor", "plane=omega_load", "gear.rotor.mass=null"], ["gear.rotor.mass", "support_stiffness"]),
        (["gear=rotor", "plane=omega_load", "gear.rotor.base_radius=[1 m]"], ["gear.rotor.base_radius", "list of 2"]),
        (["gear=rotor", "plane=omega_load", "plane.sweep.min=100 rpm"], ["plane.sweep.min", "'100 rpm'", "kHz"]),
        (["gear=spur", "plane=omega_load", "gear.spur.gap=-1"], ["gear.spur.gap = -1.0", "at least 0"]),
        (["gear=spur", "plane=omega_load", "gear.spur.error_harmonics=[1]"], ["gear.spur.error_harmonics", "pairs"]),
        (["gear=spur", "plane=omega_load", "gear.b=1"], ["gear.b", "gear=published"]),
        (["gear=spur", "plane=omega_load", "+gear.b=1"], ["gear.b = 1.0", "null"]),
        (["gear.spur.gap=1"], ["gear.spur", "gear=spur"]),
        (["gear=system", "plane=omega_gap"], ["gear.system.mass"]),
    ],
)
def test_what_a_gear_has_not_is_refused_with_what_it_has(overrides, names):
    with pytest.raises(ConfigurationError) as caught:
        plan(compose(overrides))
    said = str(caught.value)
    assert "\n" not in said and all(name in said for name in names), said


def test_modes_in_contact_are_those_of_the_closed_system():
    """One mode of a spur pair, at 1; of the stop, det(K + h w - omega^2 M) = 0 and shares that add up to what the
    contact gives: sum of share omega^2 = w M^-1 h."""
    (only,) = contact_modes(row_system(planned("spur"), 1.0))
    assert only == pytest.approx((1.0, 1.0), rel=1e-12)
    system = row_system(planned("stop"), 1.0)
    modes = contact_modes(system)
    squares = np.roots([1.0, -8.0, 11.0])
    np.testing.assert_allclose([f for f, _ in modes], np.sqrt(np.sort(squares)), rtol=1e-12)
    assert sum(share * f * f for f, share in modes) == pytest.approx(5.0, rel=1e-12)


def test_a_plane_of_a_spur_pair_is_stored_divided_and_read(tmp_path):
    """Rows, boundaries and what an opened plane answers are what the solver says of the same pair."""
    found = small_plan("gear=spur", "plane=omega_load", "plane.sweep.min=0.4", columns=41, rows=7)
    assert unfelt_harmonics(found).stiffness == (2, 3)
    path = traced_store(tmp_path / "omega_load.zarr", found)
    stored, plane = read_stored(path), pipeline.open_plane(path)
    assert np.all(stored.array("certified") == 1) and stored.modes.tolist() == [[1.0]] * 7
    for row in (0, 5):
        value = float(stored.rows[row])
        alone = sweep_row(model_at(found, value, 1.0), "omega", found.sweep.values)
        np.testing.assert_array_equal(stored.amplitude[row, :, : alone.amplitude.shape[1]], alone.amplitude)
    solutions = all_solutions(model_at(found, 0.11, 0.7), 0.7)
    motions = plane.motions_at(omega=0.7, mean_load=0.11)
    np.testing.assert_allclose(motions.amplitude.values, solutions.amplitude, rtol=1e-12)
    assert plane.label_at(omega=0.7, mean_load=0.11) == plane.label_near(omega=0.7, mean_load=0.11) == "2/0-1"
    fold = next(one for one in plane.nearest_boundaries(omega=0.62, mean_load=0.11) if one.kind.name == "FOLD")
    beside = [len(all_solutions(model_at(found, 0.11, 0.7), fold.place + d).amplitude) for d in (-1e-6, 1e-6)]
    assert fold.name == "omega" and sorted(beside) == [1, 3]
    assert "0.2" in fixed_parameters(found) and "1 degree of freedom" in gear_text(found)
    assert mesh_energies(stored) == ("100 % mesh",)


@pytest.mark.parametrize(("gear", "name"), [("stop", "frequency of the excitation"), ("spur", LONG_NAMES["omega"])])
def test_matrices_of_ones_own_have_no_mesh_frequency(gear, name, tmp_path):
    small_store(tmp_path / "plane.zarr", planned(gear), blocks=())
    assert read_stored(tmp_path / "plane.zarr").attributes["omega"]["long_name"] == name
