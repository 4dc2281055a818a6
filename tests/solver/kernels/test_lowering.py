"""What is left out of the code of kernels is not missed: values, references to arrays and errors."""

from collections import namedtuple

import numpy as np
import pytest
from numba.core.errors import NumbaError
from numba.core.registry import cpu_target
from numba.core.runtime import _nrt_python, rtsys

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into

_I, _F, _B = types.int64, types.float64, types.boolean

Pair = namedtuple("Pair", "vector matrix number")
PAIR = types.NamedTuple((ARRAY, MATRIX, _F), Pair)
Nest = namedtuple("Nest", "pair flags inner")
NEST = types.NamedTuple((PAIR, types.int8[::1], types.UniTuple(_F, 2)), Nest)


@kernel(_F(NEST, _B, ARRAY, types.complex128), inner=True)
def weighed(nest, twice, more, z):
    total = nest.pair.number + nest.inner[1] + z.imag
    for i in range(nest.pair.vector.shape[0]):
        total += nest.pair.vector[i] * nest.pair.matrix[i, -1] + nest.flags[i]
        more[i] += total
    return 2.0 * total if twice else total


@kernel(PAIR(ARRAY, _I), inner=True)
def made(vector, size):
    matrix = np.zeros((size, size))
    for i in range(size):
        matrix[i, size - 1] = vector[i] + i
    return Pair(vector.copy(), matrix, 0.5)


@kernel(_F(ARRAY, types.int8[::1], _I, _B))
def through_calls(vector, flags, size, twice):
    pair, more = made(vector, size), np.empty(size)
    copy_into(more, vector)
    nest = Nest(pair, flags, (0.25, 0.75))
    first = weighed(nest, twice, more, complex(1.0, 2.0))
    part = more[1:] if twice else more
    return first + weighed(nest, not twice, more, complex(1.0, 3.0)) + np.sum(part)


@kernel(types.Tuple((MATRIX, ARRAY))(ARRAY, _I))
def handed_out(vector, size):
    pair = made(vector, size)
    return pair.matrix, vector


@kernel(_F(MATRIX, ARRAY), inner=True)
def filled(matrix, row):
    if row.shape[0] > matrix.shape[1]:
        raise ValueError("too long")
    copy_into(matrix[0], row)
    return matrix[0, 0]


@kernel(_F(ARRAY))
def fails_within(row):
    return 1.0 + filled(np.zeros((2, 3)), row)


VECTOR, BITS = np.array([1.0, -2.0, 3.5]), np.array([1, 0, 3], np.int8)


@pytest.mark.parametrize("twice", [False, True])
def test_arrays_and_tuples_arrive_as_they_are(twice):
    assert through_calls(VECTOR, BITS, 3, twice) == through_calls.__wrapped__(VECTOR, BITS, 3, twice)


def test_arrays_that_are_handed_out_live_on():
    matrix, vector = handed_out(VECTOR, 3)
    for _ in range(20):
        handed_out(np.full(3, 9.0), 3)
    np.testing.assert_array_equal(matrix[:, 2], VECTOR + [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(vector, VECTOR)


def test_an_error_in_a_kernel_comes_out_of_what_calls_it():
    assert fails_within(np.array([2.0, 3.0, 4.0])) == 3.0
    with pytest.raises(ValueError):
        fails_within(np.zeros(4))


def test_every_array_is_freed_once():
    through_calls(VECTOR, BITS, 3, True), handed_out(VECTOR, 3), fails_within(VECTOR)
    rtsys.initialize(cpu_target.target_context)
    _nrt_python.memsys_enable_stats()
    try:
        before = rtsys.get_allocation_stats()
        for _ in range(50):
            through_calls(VECTOR, BITS, 3, True)
            handed_out(VECTOR, 3)
            fails_within(VECTOR)
        after = rtsys.get_allocation_stats()
    finally:
        _nrt_python.memsys_disable_stats()
    assert after.alloc - before.alloc == after.free - before.free >= 50 * 6


def test_an_array_cannot_be_made_where_references_are_not_counted():
    @kernel(_F(_I))
    def forgotten(size):
        return np.sum(np.ones(size))

    with pytest.raises(NumbaError):
        forgotten(3)
