"""Elements of arrays, numbers and loops do in a kernel what they do in Python."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

_F, _I, _C, _B = types.float64, types.int64, types.complex128, types.boolean
CUBE = types.float64[:, :, ::1]


def same(compiled, *arguments):
    """Call a kernel and the function that it was made of, each with arrays of its own: results and arrays agree."""
    copies = [[a.copy() if isinstance(a, np.ndarray) else a for a in arguments] for _ in range(2)]
    for one, other in zip(copies[0], copies[1], strict=True):
        np.testing.assert_array_equal(one, other)
    with np.errstate(all="ignore"):
        results = compiled(*copies[0]), compiled.__wrapped__(*copies[1])
    np.testing.assert_array_equal(*results)
    for one, other in zip(copies[0], copies[1], strict=True):
        np.testing.assert_array_equal(one, other)
    return results[0]


@kernel(_F(CUBE, MATRIX, ARRAY, _I, _I, _I))
def reads(cube, matrix, vector, i, j, k):
    row, plane = matrix[i], cube[j]
    total = cube[j, i, k] + matrix[i, -1] + matrix[-1, k] + vector[k] + vector[-2] + vector[0]
    total += row[k] + row[-1] + plane[i, k] + plane[-1, 0] + plane[i][k] + cube[j][i][-1] + cube[0, 1, 2]
    for index in range(row.shape[0]):
        total = 0.5 * total + row[index] * plane[i].size + plane.shape[1] + cube[-1, i].sum() + cube[j, i].shape[0]
    return total


@pytest.mark.parametrize("index", [(0, 0, 0), (1, 2, 3), (-1, -1, -1), (2, -3, -4), (-3, 1, 2)])
def test_elements_are_read_where_they_are(index):
    i, j, k = index
    random = np.random.default_rng(1)
    same(reads, random.random((3, 3, 4)), random.random((3, 4)), random.random(4), i, j, k)


@kernel(types.void(MATRIX, types.complex128[::1], types.int8[::1], types.int64[::1], _I, _F))
def writes(matrix, numbers, flags, counts, i, x):
    matrix[i, 1] = x
    matrix[-1, i] = i
    matrix[i][2] = 2 * x
    matrix[0] = x + 1.0
    numbers[i] = x
    numbers[-1] = 1j * x
    flags[i] = 3
    flags[0] = x > 0.0
    counts[i] = flags[i] + 1
    counts[-1] += counts[i]
    counts[np.uint64(1)] = 7
    matrix[i, 1:][-1] *= 2.0


@pytest.mark.parametrize("i", [0, 1, -1, 2])
@pytest.mark.parametrize("x", [0.25, -3.0])
def test_elements_are_written_where_they_are(i, x):
    matrix = np.arange(12.0).reshape(3, 4)
    copies = [(matrix.copy(), np.zeros(3, complex), np.zeros(3, np.int8), np.zeros(3, np.int64)) for _ in range(2)]
    writes(*copies[0], i, x)
    writes.__wrapped__(*copies[1], i, x)
    for one, other in zip(*copies, strict=True):
        np.testing.assert_array_equal(one, other)


@kernel(MATRIX(_I))
def owned_part(size):
    cube = np.zeros((2, size, size))
    for i in range(size):
        cube[1, i, i] = i + 1.0
    part = cube[1]
    cube = np.full((2, size, size), 9.0)
    return part


def test_a_part_keeps_its_array_alive():
    kept = [owned_part(3) for _ in range(50)]
    for one in kept:
        np.testing.assert_array_equal(one, np.diag([1.0, 2.0, 3.0]))


@kernel(_I(_I, _I, _I, types.int64[::1]))
def loops(start, stop, step, seen):
    count = 0
    for i in range(stop):
        count += 1 + i
    for i in range(start, stop):
        count += 10 * (i + 1)
        if i == 3:
            continue
        for j in range(i, start, -1):
            count += 100 * j
            if j == 2:
                break
    last = -1
    for i in range(start, stop, step):
        seen[count % seen.shape[0]] += i
        last = i
    for i in range(stop, start - 1, -2):
        count += i
    backwards = range(stop, start, -1)
    return count * 7 + last + len(backwards) + len(range(start))


@settings(max_examples=80, deadline=None)
@given(st.integers(-6, 6), st.integers(-6, 6), st.sampled_from([-3, -1, 1, 2]))
def test_loops_run_as_often_as_in_python(start, stop, step):
    same(loops, start, stop, step, np.zeros(3, np.int64))


@kernel(types.void(_F, _F, _I, _I, ARRAY, types.int64[::1]))
def calculates(x, y, m, n, numbers, counts):
    numbers[0], numbers[1], numbers[2], numbers[3] = x + y, x - y, x * y, x / y
    numbers[4], numbers[5] = m * x, n - y
    total = x
    total += y
    total *= 3
    total -= m
    numbers[6] = total
    numbers[7] = m / 4
    counts[0] = (x < y) + 2 * (x <= y) + 4 * (x > y) + 8 * (x >= y) + 16 * (x == y) + 32 * (x != y)
    counts[1] = (m < n) + 2 * (m <= n) + 4 * (m > n) + 8 * (m >= n) + 16 * (m == n) + 32 * (m != n)
    counts[2], counts[3], counts[4] = m + n, m - n, m * n
    counts[5] = (x < m) + 2 * (n == y)
    counts[6] = 5 * (not x < y) + (m < 2) * 3


NUMBERS = st.sampled_from([0.0, -0.0, 1.0, -2.5, 3.0, np.inf, -np.inf, np.nan, 1e308, 5e-324])


@settings(max_examples=200, deadline=None)
@given(NUMBERS, NUMBERS, st.integers(-5, 5), st.integers(-5, 5))
def test_numbers_are_those_of_numpy(x, y, m, n):
    found, expected = [(np.zeros(8), np.zeros(7, np.int64)) for _ in range(2)]
    calculates(x, y, m, n, *found)
    with np.errstate(all="ignore"):
        calculates.__wrapped__(np.float64(x), np.float64(y), m, n, *expected)
    np.testing.assert_array_equal(found[0], expected[0])
    np.testing.assert_array_equal(np.signbit(found[0][:3]), np.signbit(expected[0][:3]))
    np.testing.assert_array_equal(found[1], expected[1])
