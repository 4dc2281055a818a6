"""Which harmonics of the excitation a plan's balance does not feel, and that a run says so."""

import numpy as np
import pytest

from pipeline.plan.planning import warnings
from pipeline.plan.unfelt import unfelt_harmonics
from solver import enumerate_row
from tests.pipeline.planes import small_plan

STIFFNESS, ERROR = "gear.alpha_harmonics=[[0.1,0.0],[0.05,0.0]]", "gear.f_e_harmonics=[[0.0,0.0],[0.02,1.0]]"


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((), None),
        ((STIFFNESS,), ((2, 3), ())),
        ((ERROR,), ((), (3,))),
        ((STIFFNESS, ERROR), ((2, 3), (3,))),
        ((STIFFNESS, ERROR, "solver=hb", "solver.order=2"), ((3,), (3,))),
        ((STIFFNESS, ERROR, "solver=hb", "solver.order=3"), None),
        ((STIFFNESS, "gear.variation.translation=0", "gear.variation.rotation=0"), None),
        ((STIFFNESS, "plane=omega_b_fe"), ((2, 3), ())),
    ],
)
def test_harmonics_above_the_order(words, expected):
    plan = small_plan(*words)
    found = unfelt_harmonics(plan)
    assert (found and (found.stiffness, found.error)) == expected
    said = [text for text in warnings(plan) if "does not feel" in text]
    assert said == ([found.sentence] if found else []) and all("\n" not in text for text in said)


def test_first_order_does_not_feel_the_transmission_error_beyond_its_first_harmonic():
    from pipeline.plan.numerics import model_at

    plain, rich = (model_at(small_plan(*words), 0.1, 1.0) for words in ((), (ERROR,)))
    one, other = (enumerate_row(model, "omega", [0.6, 1.2]) for model in (plain, rich))
    assert np.array_equal(one.mean, other.mean, equal_nan=True)
