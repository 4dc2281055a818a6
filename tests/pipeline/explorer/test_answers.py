"""Answers of the explorer: those of the other ways to ask the same, for the plane as it is and for a changed gear."""

import dataclasses

import numpy as np
import pytest

import pipeline
from pipeline.errors import ConfigurationError
from pipeline.explorer import answers
from pipeline.explorer.fixed_parameters import changed_plan, fixed_parameters
from pipeline.plan.kinds import kind_of
from pipeline.plan.numerics import point_of
from pipeline.plane.motions import label_of, proven_label
from solver import gear_system
from solver.timedomain import AttractorKind, orbit_state
from tests.pipeline.planes import COARSE, small_plan, traced_store

PLAN = small_plan(*COARSE)
#: Three motions, one of them unstable.
PLACE = (0.6, 0.2)


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    path = tmp_path_factory.mktemp("asked") / "omega_fe.zarr"
    traced_store(path, PLAN)
    return pipeline.open_plane(path)


def test_row_and_motions_are_those_that_the_plane_tells(plane):
    curve, row = plane.curve_at(f_e=0.2), answers.row(PLAN, 0.2)
    assert np.array_equal(curve.amplitude.values, row.values("amplitude"))
    assert np.array_equal(curve.omega.values, row.points["position"])
    told, found = plane.motions_at(omega=0.6, f_e=0.2), answers.motions(PLAN, *PLACE)
    for name, values in found.values.items():
        assert np.array_equal(told[name].values, values, equal_nan=True), name


@pytest.mark.parametrize("place", [PLACE, (0.3, 0.2), (0.65, 0.3), (0.58, 0.3), (1.3, 0.3)])
def test_the_label_is_the_proven_one(place):
    found = answers.motions(PLAN, *place)
    assert label_of(found.stable, found.impact) == proven_label(PLAN, *place)


def test_integration_from_a_motion_ends_on_an_attractor_that_is_known_here():
    known = {(one.kind, round(one.quantities.mean, 6)) for one in answers.integrated(PLAN, *PLACE).attractors}
    for number in (1, 2, 3):
        found = answers.ending_of_motion(PLAN, *PLACE, number)
        assert found.of_map.number == number
        assert (found.motion.kind, round(found.motion.quantities.mean, 6)) in known
        # It starts where the contact force of the balance brings the linear pair, by another transform.
        model, omega = point_of(PLAN, *reversed(PLACE))
        unknowns = answers.motions(PLAN, *PLACE).unknowns[number - 1]
        state = orbit_state(gear_system(model), omega, unknowns)
        assert found.start == pytest.approx((state[state.size // 2 - 1], state[-1]), abs=0.02)


@pytest.mark.parametrize("number", [0, 4, -1])
def test_a_motion_that_is_not_there_is_refused(number):
    with pytest.raises(ConfigurationError, match="motion"):
        answers.ending_of_motion(PLAN, *PLACE, number)


def test_a_state_of_a_slice_of_basins_ends_where_the_slice_says():
    place = (0.65, 0.1)
    found = answers.basins(PLAN, *place)
    assert found.slots.shape == (found.speed.size, found.displacement.size)
    for i, j in ((0, 0), (20, 31), (47, 12)):
        slot = int(found.slots[i, j])
        ending = answers.ending_of_state(PLAN, *place, float(found.displacement[j]), float(found.speed[i]))
        assert ending.start == pytest.approx((found.displacement[j], found.speed[i]))
        assert ending.motion.kind == AttractorKind(int(found.row.kind[0, slot]))
        assert ending.motion.quantities.mean == pytest.approx(found.row.mean[0, slot], abs=1e-6)


def test_margins_are_cut_at_the_ends_of_the_axes(plane):
    found = answers.design_answer(plane.path, PLAN, (1.95, 0.02), (0.2, 0.1))
    assert (found.design.low, found.design.high) == pytest.approx((1.75, 2.0))
    assert found.design.tolerance == pytest.approx(0.02)
    assert found.label == plane.label_at(omega=1.95, f_e=0.02)


def test_what_was_asked_is_kept_and_what_is_changed_is_another_answer():
    asked = answers.Answers(PLAN)
    first = asked.ask(answers.row, {}, 0.2)
    assert asked.ask(answers.row, {}, 0.2) is first
    changed = asked.ask(answers.row, {"b": 0.5, "alpha": 0.1}, 0.2)
    assert changed.system.b == 0.5 and changed.system.alpha == 0.1 and first.system.b == PLAN.gear["b"]
    assert asked.ask(answers.row, {"alpha": 0.1, "b": 0.5}, 0.2) is changed


def test_a_changed_plan_is_the_one_that_a_user_would_configure():
    for name, key, value in (
        ("b", "gear.b", 0.5),
        ("f_pm", "gear.f_pm", 0.7),
        ("variation_rotation", "gear.variation.rotation", 0.5),
        ("xi_mesh", "gear.xi_mesh", 0.02),
    ):
        typed = small_plan("plane=omega_fe", f"{key}={value}", columns=20, rows=3)
        model, _ = point_of(changed_plan(PLAN, {name: value}), 0.2, 0.6)
        assert dataclasses.asdict(model) == dataclasses.asdict(point_of(typed, 0.2, 0.6)[0]), name


@pytest.mark.parametrize("name", ["omega", "f_e", "nothing", "alpha_harmonics"])
def test_only_fixed_parameters_are_changed(name):
    with pytest.raises(ConfigurationError, match=name):
        changed_plan(PLAN, {name: 0.5})


@pytest.mark.parametrize(("name", "value"), [("b", -0.1), ("f_pm", 0.0), ("xi_mesh", 1e9)])
def test_a_value_out_of_range_is_refused(name, value):
    with pytest.raises(ConfigurationError, match=f"{name} = "):
        changed_plan(PLAN, {name: value})


@pytest.mark.parametrize(
    "overrides",
    [["plane=omega_fe"], ["plane=b_fe"], ["gear=miter"], ["plane=omega_xi"], ["gear=spur", "plane=omega_excitation"]],
)
def test_every_fixed_parameter_may_have_both_ends_of_its_range(overrides):
    plan = small_plan(*overrides)
    found = fixed_parameters(plan)
    assert {"alpha", "f_pm" if plan.kind == "bevel" else "mean_load"} <= {one.name for one in found}
    assert {one.name for one in found} <= {"omega", *kind_of(plan).axes}
    for one in found:
        assert one.low < one.high and one.low <= one.value <= one.high
        for value in (one.low, one.high):
            changed_plan(plan, {one.name: value})


def test_a_plane_of_a_higher_order_is_answered_too():
    plan = small_plan("plane=omega_fe", "solver=hb", "solver.order=2", columns=20, rows=3)
    found = answers.motions(plan, *PLACE)
    assert label_of(found.stable, found.impact) == "2/0-1"
    assert answers.ending_of_motion(plan, *PLACE, 1).motion.label == "1T/0"
