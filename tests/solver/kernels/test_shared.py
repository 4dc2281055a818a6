"""Shared kernels: compiled once, called by the units of other kernels, and kept on disk beside them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

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


VALUES = np.array([1.0, -2.0, 4.0])


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
from tests.solver.kernels.test_shared import VALUES, first_user, second_user
kept = [first_user.is_kept(), second_user.is_kept()]
results = [first_user(VALUES, 2)[1], second_user(VALUES, 2)]
print(json.dumps([kept, made, results]))
"""


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
        assert results == [9.0, 4.0]
        return kept, sorted(made)

    everything = ["first_user", "second_user", "spread", "total", "total"]
    assert run() == ([False, False], everything)
    assert run() == ([True, True], [])
    (lost,) = (tmp_path / "bevelmap").glob("*.spread-*.kernel")
    lost.unlink()
    assert run() == ([False, False], ["spread"])
    (damaged,) = (tmp_path / "bevelmap").glob("*.spread-*.kernel")
    damaged.write_bytes(damaged.read_bytes()[:-1])
    assert run() == ([True, True], ["spread"])
    assert run() == ([True, True], [])
