"""Shared kernels: compiled once, called by the units of other kernels, and kept on disk beside them."""

import json
import os
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

ROOT = Path(__file__).parents[3]
_F, _I = types.float64, types.int64


@kernel(_F(ARRAY), types.complex128(types.complex128[::1]), inner=True, shared=True)
def total(values):
    result = values[0] - values[0]
    for i in range(values.shape[0]):
        result += values[i]
    return result


@kernel(types.Tuple((MATRIX, _F))(ARRAY, _I), inner=True, shared=True)
def spread(values, count):
    if count < 1:
        raise ValueError("nothing to make")
    matrix = np.zeros((count, values.shape[0]))
    for i in range(count):
        for j in range(values.shape[0]):
            matrix[i, j] = values[j] + i
    return matrix, total(values)


@kernel(types.Tuple((MATRIX, _F))(ARRAY, _I), inner=True)
def between(values, count):
    matrix, sum_ = spread(values, count)
    return matrix, sum_ + total(matrix[count - 1])


@kernel(types.Tuple((MATRIX, _F))(ARRAY, _I))
def first_user(values, count):
    return between(values, count)


@kernel(_F(ARRAY, _I))
def second_user(values, count):
    return spread(values, count)[1] + total(np.array([1j, 2.0 + 0j])).imag


@kernel(_F(types.FunctionType(_F(_F)), _F))
def by_pointer(function, x):
    return function(x)


@kernel(_F(_F), shared=True)
def halved(x):
    return 0.5 * x


@kernel(_F(_F))
def quartered(x):
    return halved(halved(x))


Several = namedtuple("Several", "given vector matrix flags")
SEVERAL = types.NamedTuple((ARRAY, ARRAY, MATRIX, types.int8[::1]), Several)


@kernel(SEVERAL(ARRAY, _I), shared=True)
def several(values, count):
    """One of its arguments, and new arrays of several types."""
    matrix, flags = np.zeros((count, 2)), np.zeros(count, np.int8)
    matrix[count - 1, 1], flags[0] = values[0], count
    return Several(values, values.copy(), matrix, flags)


@kernel(types.Tuple((ARRAY, SEVERAL))(ARRAY, _I))
def several_times(values, count):
    made = several(values, count)
    for _ in range(count):
        made = several(made.given, count)
    return values, made


@kernel(ARRAY(ARRAY, ARRAY, types.boolean), shared=True)
def one_of(left, right, is_left):
    return left if is_left else right


@kernel(_F(ARRAY, ARRAY))
def sum_of_both(left, right):
    return one_of(left, right, True)[0] + one_of(left.copy(), right, False)[0]


VALUES = np.array([1.0, -2.0, 4.0])
USERS = "first_user", "second_user", "several", "several_times", "one_of", "sum_of_both"
CALLS = 600


def _called_by_both(values, other) -> None:
    """Call shared kernels from Python as well as from others, which hand out their arguments and new arrays."""
    for count in (1, 2, 3) * (CALLS // 3):
        alone, (same, inside) = several(values, count), several_times(values, count)
        assert type(alone) is type(inside) is Several
        for one in (alone, inside):
            assert one.given is values is same
            for array, expected in zip(one, several.__wrapped__(values, count), strict=True):
                assert array.dtype == expected.dtype
                np.testing.assert_array_equal(array, expected)
            one.vector[:] = one.matrix[:] = np.nan
        assert one_of(values, other, True) is values and one_of(values, other, False) is other


def results() -> list[float]:
    """Numbers from all kernels; every array is freed once."""
    values, other = VALUES.copy(), np.full(3, 0.25)
    found = [first_user(values, 2)[1], second_user(values, 2), sum_of_both(values, other)]
    _nrt_python.memsys_enable_stats()
    held, before = (sys.getrefcount(values), sys.getrefcount(other)), rtsys.get_allocation_stats()
    _called_by_both(values, other)
    after = rtsys.get_allocation_stats()
    assert (sys.getrefcount(values), sys.getrefcount(other)) == held
    assert after.alloc - before.alloc == after.free - before.free >= 9 * CALLS
    return found


def test_every_user_finds_it():
    matrix, sum_ = first_user(VALUES, 2)
    np.testing.assert_array_equal(matrix, [VALUES, VALUES + 1.0])
    assert sum_ == 9.0 and second_user(VALUES, 2) == 4.0
    assert (total(VALUES), total(np.array([1j, 2j]))) == (3.0, 3j)
    assert (halved(3.0), quartered(3.0), by_pointer(halved, 3.0), by_pointer(quartered, 3.0)) == (1.5, 0.75, 1.5, 0.75)


def test_an_error_comes_out_of_what_calls_it():
    for call in (first_user, second_user, spread):
        with pytest.raises(ValueError):
            call(VALUES, 0)


def _of(factor):
    @kernel(_F(_F), inner=True, shared=True)
    def inside(x):
        return factor * x

    @kernel(_F(_F))
    def outside(x):
        return inside(x) + factor

    return outside


def test_shared_kernels_of_one_name_are_kept_apart():
    for factor in (2.0, 4.0, 2.0, 8.0):
        assert _of(factor)(3.0) == 4.0 * factor


RUN = f"""
import json, sys
sys.path.insert(0, {str(ROOT)!r})
from solver.kernels import backend
made = []
for name in ("_compiled", "_compiled_alone"):
    def listed(kernel, signature, original=getattr(backend, name)):
        made.append(kernel.__name__)
        return original(kernel, signature)
    setattr(backend, name, listed)
from tests.solver.kernels import test_shared
kept = [getattr(test_shared, name).is_kept() for name in test_shared.USERS]
results = test_shared.results()
print(json.dumps([kept, made, results]))
"""


@pytest.mark.costly
def test_it_is_compiled_once_and_again_if_it_is_lost(tmp_path):
    def run():
        done = subprocess.run(
            [sys.executable, "-c", RUN],
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert done.returncode == 0, done.stderr
        kept, made, results = json.loads(done.stdout)
        assert results == [9.0, 4.0, 1.25]
        return kept, sorted(made)

    def entries(name):
        return list((tmp_path / "bevelmap").glob(f"*.{name}-*.kernel"))

    # What Python and other kernels call is kept twice: once for each.
    everything = [*USERS, "spread", "total", "total", "several", "one_of"]
    assert run() == ([False] * 6, sorted(everything))
    assert run() == ([True] * 6, [])
    (spread,), for_each = entries("spread"), entries("several")
    assert len(for_each) == 2
    for lost in (spread, for_each[0]):
        lost.unlink()
    assert run()[1] == ["several", "spread"]
    spread.write_bytes(spread.read_bytes()[:-1])
    for_each[1].unlink()
    assert run()[1] == ["several", "spread"]
    assert run() == ([True] * 6, [])
