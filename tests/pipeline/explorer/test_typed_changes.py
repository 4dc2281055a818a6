"""Changed parameters as they are typed: the plane of the command is the one whose motions the page shows."""

import shlex

import numpy as np
import pytest

from pipeline.config.compose import compose
from pipeline.errors import ConfigurationError
from pipeline.explorer.background_run import new_plane
from pipeline.explorer.fixed_parameters import changed_plan, fixed_parameters
from pipeline.explorer.typed_changes import check_same
from pipeline.plan.planning import plan as plan_of
from pipeline.plane.motions import motions_of_place

SIZES = ("plane.sweep.num=3", "plane.parameter.num=3")


def planned(*words: str):
    return plan_of(compose([*words, *SIZES]))


def computed(words: tuple[str, ...], fixed: dict[str, float]):
    """The plane as it was, as it is meant, and as the command of the changed one makes it."""
    plan = planned(*words)
    made = new_plane(" ".join(["python -m pipeline", *map(shlex.quote, [*words, *SIZES])]), plan, fixed)
    return plan, changed_plan(plan, fixed), plan_of(compose(made.overrides)), made


@pytest.mark.parametrize(
    ("words", "fixed", "typed"),
    [
        (("plane=omega_fe",), {"b": 0.9, "alpha_phase": 1.0}, ["gear.alpha_phase=1.0", "gear.b=0.9"]),
        (("plane=omega_fe", "gear=miter"), {"f_pm": 0.3}, None),
        (
            ("plane=omega_fe", "gear=miter"),
            {"b": 0.9},
            ["gear.physical.half_backlash='45 um'", "gear.physical.reference_length='50 um'"],
        ),
        (("plane=omega_fe", "gear=differential"), {"alpha": 0.1, "alpha_phase": 0.5}, None),
        (("plane=omega_temperature", "gear=miter"), {"f_e": 0.1}, ["gear.physical.error_harmonics=[['5 um','0 deg']]"]),
        (("plane=omega_gap", "gear=spur"), {"mean_load": 0.2}, ["gear.spur.mean_load=0.2"]),
        (("plane=omega_gap", "gear=rotor"), {"damping": 2.0}, None),
        (("plane=omega_excitation", "gear=stop"), {"stiffness": 1.1, "gap": 0.1}, None),
    ],
)
def test_the_command_makes_the_plane_that_is_meant(words, fixed, typed):
    plan, meant, made, new = computed(words, fixed)
    if typed is not None:
        assert list(new.overrides[len(words) + len(SIZES) :]) == typed
    x = 0.4 * plan.sweep.low + 0.6 * plan.sweep.high
    p = 0.5 * (plan.parameter.low + plan.parameter.high)
    before, expected, found = (motions_of_place(one, x, p).unknowns for one in (plan, meant, made))
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9)
    assert before.shape != expected.shape or not np.allclose(before, expected, rtol=1e-4)


def test_what_was_typed_before_is_replaced_and_a_name_goes_with_its_plane():
    words = ("plane=omega_fe", "gear=miter", "gear.physical.half_backlash='60 um'", "store.name=mine")
    _, _, _, new = computed(words, {"b": 0.5})
    assert [word for word in new.overrides if "half_backlash" in word] == ["gear.physical.half_backlash='30 um'"]
    assert new.path.stem == "mine-b=0.5"


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (("plane=omega_fe", "gear=miter"), "kappa"),
        (("plane=omega_fe", "gear=miter"), "xi_mesh"),
        (("plane=omega_load", "gear=rotor"), "gap"),
    ],
)
def test_what_follows_from_several_values_is_refused(words, name):
    value = {one.name: one for one in fixed_parameters(planned(*words))}[name].value
    with pytest.raises(ConfigurationError, match=f"^{name}: "):
        computed(words, {name: 1.1 * value})


def test_another_plane_is_not_taken_for_the_one_that_is_meant():
    meant = planned("plane=omega_fe", "gear.b=0.9")
    check_same(planned("plane=omega_fe", "gear.b=0.9"), meant, ["b"])
    for words in (["gear.b=0.91"], ["gear.b=0.9", "plane.sweep.max=1.9"], ["gear=miter"]):
        with pytest.raises(ConfigurationError, match="b: "):
            check_same(planned("plane=omega_fe", *words), meant, ["b"])
