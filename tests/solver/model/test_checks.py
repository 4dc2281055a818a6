"""The checks that every public function makes of its arguments: what passes, and what is named when it does not."""

import pickle

import numpy as np
import pytest

from solver import ParameterError
from solver.model import checks

BAD_NUMBERS = [None, "1", True, np.bool_(True), np.nan, np.inf, -np.inf, 1j, [1.0], np.array([1.0])]


@pytest.mark.parametrize("value", [0.5, 3, np.float32(0.5), np.int64(3)])
def test_finite_numbers_pass_as_floats(value):
    found = checks.finite_number("x", value, above=0.0)
    assert found == value and type(found) is float


@pytest.mark.parametrize("value", BAD_NUMBERS)
def test_what_is_no_finite_number_is_named(value):
    with pytest.raises(ParameterError) as caught:
        checks.finite_number("gap", value)
    assert caught.value.name == "gap" and "gap = " in str(caught.value)
    assert type(pickle.loads(pickle.dumps(caught.value))) is ParameterError


def test_bounds():
    assert checks.finite_number("x", 0.0, at_least=0.0) == 0.0
    for value, bounds in ((0.0, {"above": 0.0}), (-1e-300, {"at_least": 0.0}), (1.0, {"above": 1.0})):
        with pytest.raises(ParameterError, match="x = "):
            checks.finite_number("x", value, **bounds)
    assert checks.frequency(1) == 1.0
    for value in (0.0, -1.0, None):
        with pytest.raises(ParameterError, match="omega = "):
            checks.frequency(value)


def test_one_number_stands_for_all_and_a_wrong_one_among_several_is_named():
    assert checks.finite_numbers("k", 2.0, 3) == (2.0,) * 3 and checks.finite_numbers("k", [1, 2], 2) == (1.0, 2.0)
    for value in ([1.0], "ab", None):
        with pytest.raises(ParameterError, match="k = "):
            checks.finite_numbers("k", value, 2)
    with pytest.raises(ParameterError, match=r"k\[1\] = -1"):
        checks.finite_numbers("k", [1.0, -1.0], 2, at_least=0.0)


def test_whole_numbers():
    assert checks.whole_number("n", np.int32(4), 1, 4) == 4
    for value in (0, 5, 2.0, True, "2", None):
        with pytest.raises(ParameterError, match="n = "):
            checks.whole_number("n", value, 1, 4)


def test_names():
    assert checks.one_of("axis", "b", ("a", "b")) == "b"
    for value in ("c", None, 1, ["a"]):
        with pytest.raises(ParameterError, match="axis = "):
            checks.one_of("axis", value, ("a", "b"))


def test_arrays_are_copies_of_the_right_shape():
    values = np.zeros((2, 3))
    found = checks.finite_array("m", values, (None, 3))
    found[0, 0] = 1.0
    assert values[0, 0] == 0.0 and found.dtype == float
    assert checks.finite_array("m", [1j], (1,), complex)[0] == 1j
    masked = np.ma.masked_array([1.0, 2.0], [False, True])
    for bad, shape in (
        ([1.0], (2,)),
        ([1.0], (1, 1)),
        (["x"], (1,)),
        ([np.nan], (1,)),
        (masked, (2,)),
        ([[1], [1, 2]], (2,)),
    ):
        with pytest.raises(ParameterError, match="m = "):
            checks.finite_array("m", bad, shape)


@pytest.mark.parametrize("bad", [[], [1.0], [1.0, 1.0], [2.0, 1.0], [1.0, np.nan], [[1.0, 2.0]], "ab", None])
def test_grids_ascend(bad):
    np.testing.assert_array_equal(checks.ascending_grid("grid", [1, 2]), [1.0, 2.0])
    with pytest.raises(ParameterError, match="grid = "):
        checks.ascending_grid("grid", bad)
    with pytest.raises(ParameterError, match="range = "):
        checks.value_range("range", bad)
    assert checks.value_range("range", (0, 1)) == (0.0, 1.0)
