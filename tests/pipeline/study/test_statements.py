"""The published statements from small planes, against the digits of docs/physics.md, section 7."""

import re

import pytest

from pipeline.errors import StoreError
from pipeline.study.agreement import AGREES, DIFFERS, NOT_COMPARED
from pipeline.study.statements import STATEMENTS, Planes, evaluate
from pipeline.study.statements.planes import default_model
from pipeline.study.statements.quantities import LabelThreshold
from tests.conftest import MODELS, published
from tests.pipeline.planes import small_plan, small_store

BY_KEY = {statement.key: statement for statement in STATEMENTS}

#: What docs/physics.md prints as ours, and half a unit of the last digit printed (two of "0.61-0.63" and "0.18").
OURS = {
    "interval_mesh": ((0.55937, 0.63464), 5e-6),
    "interval_shaft": ((1.22381, 1.22971), 5e-6),
    "b_mesh_1_2": ((0.61, 0.63), 1e-2),
    "b_mesh_2_02": ((1.011,), 5e-4),
    "b_shaft_settles": ((0.18,), 5e-3),
    "fe_shaft_1_1": ((0.140,), 5e-4),
    "fe_mesh_2_02": ((0.198,), 5e-4),
    "fe_mesh_2_12": ((0.321, 0.370), 5e-4),
    "alpha_shaft_jumps": ((0.278,), 5e-4),
    "alpha_shaft_contact": ((0.388,), 5e-4),
    "fpm_shaft_jumps": ((0.5855,), 5e-5),
    "fpm_shaft_contact": ((0.714,), 5e-4 + 1e-6),
    "bilateral_shaft": ((1.0,), 0.0),
}
VERDICTS = {
    AGREES: {
        "interval_mesh",
        "b_mesh_1_2",
        "b_mesh_2_02",
        "alpha_shaft_contact",
        "fpm_shaft_jumps",
        "fpm_shaft_contact",
    },
    DIFFERS: {
        "interval_shaft",
        "b_shaft_settles",
        "fe_shaft_1_1",
        "fe_mesh_2_02",
        "fe_mesh_2_12",
        "alpha_shaft_jumps",
        "bilateral_shaft",
        "n3_b",
        "n3_fe",
    },
}


@pytest.fixture(scope="module")
def planes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("statements")
    return Planes(
        {
            plane: small_store(folder / f"{plane}.zarr", small_plan(f"plane={plane}", columns=60, rows=12))
            for plane in ("omega_b", "omega_alpha", "omega_fe", "omega_fpm")
        }
    )


@pytest.mark.parametrize("key", OURS)
def test_the_articles_numbers(planes, key):
    found = evaluate(BY_KEY[key], planes)
    expected, digits = OURS[key]
    assert found.ours == pytest.approx(expected, abs=digits)
    assert found.difference == tuple(a - b for a, b in zip(found.ours, found.article, strict=True))
    assert found.verdict in VERDICTS and key in VERDICTS[found.verdict]
    assert BY_KEY[key].source == "article"
    # The criterion is said, and the printed reference is what docs/physics.md has.
    assert found.reason == "not equal" or BY_KEY[key].agreement in found.reason
    assert tuple(map(float, re.split(", |–", BY_KEY[key].reference))) == expected


@pytest.mark.parametrize("key", ["n3_b", "n3_fe"])
def test_three_stable_motions_occur_in_narrow_strips(planes, key):
    found = evaluate(BY_KEY[key], planes)
    assert found.article == (0.0,) and 1e-5 < found.ours[0] < 5e-3 and found.verdict == DIFFERS


@pytest.mark.parametrize("key", [key for key, statement in BY_KEY.items() if statement.source == "reference"])
def test_the_reference_digits(planes, key, reference):
    """The digits stand in tests/reference as well: typed twice, compared here."""
    found = evaluate(BY_KEY[key], planes)
    assert found.verdict == AGREES, found.reason
    kind, gear, *omega = key.split("_")
    if kind == "folds":
        expected = sorted(reference[gear]["folds"])
    else:
        expected = next(value for place, value in reference[gear]["solutions"].items() if f"{place:.2f}" == omega[0])
    flat = tuple(number for row in expected for number in row)
    assert found.article == flat and found.ours == pytest.approx(flat, abs=1e-6)


def test_every_line_of_the_table_is_there():
    assert len(BY_KEY) == len(STATEMENTS) and set(OURS) | {"n3_b", "n3_fe"} <= set(BY_KEY)
    covered = {gear for gear in MODELS for key in BY_KEY if key == f"folds_{gear}"}
    assert covered == set(MODELS)
    planes = {"omega_b", "omega_alpha", "omega_fe", "omega_fpm", ""}
    for statement in STATEMENTS:
        assert statement.plane in planes and statement.text and statement.quantity.how and statement.agreement


def test_what_cannot_be_computed_says_why(planes, tmp_path):
    folds, share = BY_KEY["folds_published"], BY_KEY["n3_b"]
    for key in ("interval_mesh", "fe_shaft_1_1"):
        found = evaluate(BY_KEY[key], {})
        assert (found.ours, found.difference, found.verdict) == ((), (), NOT_COMPARED)
        assert found.reason == f"no store of {BY_KEY[key].plane} is given"
    plan = small_plan("plane=omega_b", "plane.parameter.max=0.5", columns=9, rows=3)
    low = small_store(tmp_path / "low.zarr", plan, blocks=[])
    assert "does not reach b = 1" in evaluate(folds, {"omega_b": low}).reason
    for label, end, message in (("1/1", "to", "1/1 to lies at the border"), ("9/0", "to", "there is no 9/0")):
        with pytest.raises(StoreError, match=message):
            LabelThreshold("omega_b", "mesh", ((label, end),)).values(planes)
    other = planes.paths["omega_alpha"]
    assert re.search("plane omega x alpha, not omega x b", evaluate(share, {"omega_b": other}).reason)
    plan = small_plan("plane=omega_b", "gear=antiphase", columns=9, rows=3)
    gear = small_store(tmp_path / "gear.zarr", plan, blocks=[])
    reason = evaluate(share, {"omega_b": gear}).reason
    assert "another gear" in reason and "alpha_phase" in reason and "\n" not in reason
    order = small_store(tmp_path / "order.zarr", small_plan("plane=omega_b", "solver=hb", columns=9, rows=3), blocks=[])
    assert "not balanced at first order" in evaluate(share, {"omega_b": order}).reason


def test_criteria_are_said_as_shares_of_what_they_are_about(planes):
    """Of an interval, its width: 1.22381–1.22971 against 1.220–1.233."""
    found = evaluate(BY_KEY["interval_shaft"], planes)
    gaps = re.findall(r"[+−][\d.]+", found.reason)
    expected = [100.0 * gap / (1.233 - 1.220) for gap in found.difference]
    assert [float(gap.replace("−", "-")) for gap in gaps] == pytest.approx(expected, abs=0.06)
    assert found.reason.startswith("by more than 5 % of the width")


def test_other_counts_differ(planes):
    statement = BY_KEY["folds_published"]
    fewer = type(statement)(**{**vars(statement), "article": statement.article[:6]})
    found = evaluate(fewer, planes)
    assert found.verdict == DIFFERS and found.reason == "12 numbers of ours against 6 published ones"


def test_default_models_are_those_of_the_tests():
    for gear, model in MODELS.items():
        assert default_model(gear) == model()
    assert default_model("published") == published()
