"""The flow of every contact zone over one forcing period, as polynomials: computed once for all motions of a system.

Within a zone the equation of `solver.flow.switched_system` is linear, so that its solutions are an affine function of
one state. The period is cut into equal intervals; about the middle of each of them, at the local time u from -1 to 1,

    z(u) = Phi(u) m + p(u),      m = Gamma(u) (z(u) - p(u)),      z = (y, y')

where m is the state in the middle, Phi' = A Phi and Gamma' = -Gamma A with Phi(0) = Gamma(0) = 1, and p(0) = 0. All
are entire functions: sixteen Taylor coefficients hold over intervals that are as long as the tolerance allows (the next
two terms are computed and must be below it; `solver.flow.tabulation` does so). A motion is named by m: the motion
itself need not be in the zone there, only its continuation by the law of the zone. From interval to interval m is
carried by one matrix, into another zone by Phi of the one and Gamma of the other at the switch. Deviations jump there
if touching teeth have a damper of their own.

lambda is also kept in Bernstein's basis, whose coefficients bound the polynomial and count its roots (R. T. Farouki,
"The Bernstein polynomial basis: a centennial retrospective", Computer Aided Geometric Design 29 (2012) 379-419).
"""

import math
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import SWITCHED_SYSTEM, SwitchedSystem
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = ["CUBE", "COEFFICIENTS", "ZONE_FLOWS", "ZoneFlows", "apply_map", "change_basis", "matrix_at", "new_flows"]

_F, _I, _B = types.float64, types.int64, types.boolean
CUBE, FOUR = types.float64[:, :, ::1], types.float64[:, :, :, ::1]

#: Coefficients of every polynomial.
COEFFICIENTS = 16


def _to_bernstein() -> np.ndarray:
    """Bernstein coefficients over [-1, 1], in columns, of the powers of u = x - (1 - x), where 1 = x + (1 - x)."""
    degree = COEFFICIENTS - 1
    matrix = np.empty((COEFFICIENTS, COEFFICIENTS))
    for power in range(COEFFICIENTS):
        for i in range(COEFFICIENTS):
            total = sum(
                (-1) ** (power - l) * math.comb(power, l) * math.comb(degree - power, i - l)
                for l in range(max(0, i - degree + power), min(power, i) + 1)
            )
            matrix[i, power] = total / math.comb(degree, i)
    return matrix


_TO_BERNSTEIN = _to_bernstein()


class ZoneFlows(NamedTuple):
    """The flows of a system of n coordinates in zones free, front, back, over intervals k = 0 ... K - 1.

    Row `(zone % 3) K + k` of each table belongs to one zone and interval. Columns are the 2 n components of m, and one
    more for what does not depend on it. States are padded with zeros to a multiple of four components.

    `count` (1,): K. `half` (1,): half an interval. `forward` (3 K, 16, 2 n + 1, padded): Phi and p, powers of u.
    `backward` (3 K, 16, 2 n, padded): Gamma. `contact` and `bernstein` (3 K, 2 n + 1, 16): lambda. `entry`, `leave` and
    `step` (3 K, 2 n + 1, padded): m from the state at the left end, the state at the right end from m, and m of the
    next interval. `stiffness` (K, 16): s. `limits` (3, 2): where lambda is within a zone. What is
    beyond them by less than `slack` (1,), far below the tolerance, is no exit: a motion at rest on a border does not
    switch for ever.
    """

    system: SwitchedSystem
    count: np.ndarray
    half: np.ndarray
    forward: np.ndarray
    backward: np.ndarray
    contact: np.ndarray
    bernstein: np.ndarray
    entry: np.ndarray
    leave: np.ndarray
    step: np.ndarray
    stiffness: np.ndarray
    limits: np.ndarray
    slack: np.ndarray


ZONE_FLOWS = types.NamedTuple(
    (SWITCHED_SYSTEM, types.int64[::1], ARRAY, FOUR, FOUR, CUBE, CUBE, CUBE, CUBE, CUBE, MATRIX, MATRIX, ARRAY),
    ZoneFlows,
)


@kernel(_I(_I), inline=True)
def padded(size):
    """A number of components, rounded up to a multiple of four."""
    return (size + 3) // 4 * 4


@kernel(ZONE_FLOWS(SWITCHED_SYSTEM, _I), inner=True, shared=True)
def new_flows(system, room):
    """Room for the flows of a system, in so many intervals."""
    size = 2 * system.vectors.shape[1]
    columns, rows, width = size + 1, 3 * room, padded(size)
    return ZoneFlows(
        system,
        np.zeros(1, np.int64),
        np.zeros(1),
        np.zeros((rows, COEFFICIENTS, columns, width)),
        np.zeros((rows, COEFFICIENTS, size, width)),
        np.zeros((rows, columns, COEFFICIENTS)),
        np.zeros((rows, columns, COEFFICIENTS)),
        np.zeros((rows, columns, width)),
        np.zeros((rows, columns, width)),
        np.zeros((rows, columns, width)),
        np.zeros((room, COEFFICIENTS)),
        np.empty((3, 2)),
        np.empty(1),
    )


@kernel(types.void(CUBE, _I, ARRAY, ARRAY), inline=True)
def apply_map(maps, row, state, image):
    """Fill image with maps[row] applied to a state: another state (padded), or the coefficients (16,) of lambda."""
    columns = maps.shape[1] - 1
    for r in range(0, maps.shape[2], 4):
        t0, t1, t2, t3 = (
            maps[row, columns, r],
            maps[row, columns, r + 1],
            maps[row, columns, r + 2],
            maps[row, columns, r + 3],
        )
        for c in range(columns):
            z = state[c]
            t0 += maps[row, c, r] * z
            t1 += maps[row, c, r + 1] * z
            t2 += maps[row, c, r + 2] * z
            t3 += maps[row, c, r + 3] * z
        image[r], image[r + 1], image[r + 2], image[r + 3] = t0, t1, t2, t3


@kernel(types.void(ARRAY, ARRAY), inner=True)
def change_basis(powers, hull):
    """Fill in Bernstein coefficients over [-1, 1] from those of powers of u."""
    # Of a length that the compiler does not know: it would unroll 256 products.
    for i in range(hull.shape[0]):
        total = 0.0
        for j in range(powers.shape[0]):
            total += _TO_BERNSTEIN[i, j] * powers[j]
        hull[i] = total


@kernel(types.void(FOUR, _I, _I, _F, MATRIX), inner=True)
def matrix_at(table, row, first, at, matrix):
    """Fill columns from `first` on of matrix (columns, padded) with the values of `forward` or `backward` at u."""
    square = at * at
    for c in range(first, table.shape[2]):
        for r in range(0, table.shape[3], 4):
            # Even and odd powers apart: two short chains of products instead of one long one.
            e0, e1, e2, e3 = 0.0, 0.0, 0.0, 0.0
            o0, o1, o2, o3 = 0.0, 0.0, 0.0, 0.0
            for j in range(COEFFICIENTS - 2, -1, -2):
                e0 = e0 * square + table[row, j, c, r]
                e1 = e1 * square + table[row, j, c, r + 1]
                e2 = e2 * square + table[row, j, c, r + 2]
                e3 = e3 * square + table[row, j, c, r + 3]
                o0 = o0 * square + table[row, j + 1, c, r]
                o1 = o1 * square + table[row, j + 1, c, r + 1]
                o2 = o2 * square + table[row, j + 1, c, r + 2]
                o3 = o3 * square + table[row, j + 1, c, r + 3]
            matrix[c, r], matrix[c, r + 1] = e0 + at * o0, e1 + at * o1
            matrix[c, r + 2], matrix[c, r + 3] = e2 + at * o2, e3 + at * o3
