"""Pairs of events between three places of a branch that do not bracket them.

Where a test function comes nearest to zero at the middle one of three places the branch is looked at in between, as
long as a parabola, or how steeply it falls, says that it may reach zero there.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.continuation.curve_point import point_size, state_at
from solver.continuation.setup import SETUP
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.stability.multipliers import DOUBLING, GAP, LARGEST, OUTSIDE, TESTS
from solver.stability.passages import FOUND, INDICES, ON_CIRCLE, WATCH, look, search

__all__ = ["Recent", "search_dips"]

_F, _I, _B = types.float64, types.int64, types.boolean

# Looks for a pair of events between three places; a function that comes no nearer to zero than this share of its least
# value is not followed.
_DIP_LOOKS, _CLEARANCE = 8, 0.5


class Recent(NamedTuple):
    """The last three places of a branch whose test functions are known: arc lengths, ascending, behind which points of
    the branch lies what is between two of them, and the functions (3, TESTS)."""

    positions: np.ndarray
    pieces: np.ndarray
    tests: np.ndarray


RECENT = types.NamedTuple((ARRAY, INDICES, MATRIX), Recent)


@kernel(_B(MATRIX, _I), inline=True)
def _dips(tests, slot):
    """Whether a function has one sign at three places (3, TESTS) and comes nearest to zero at the middle one."""
    sign = math.copysign(1.0, tests[1, slot])
    return ON_CIRCLE < sign * tests[1, slot] <= min(sign * tests[0, slot], sign * tests[2, slot]) < math.inf


@kernel(types.void(SETUP, WATCH, FOUND, MATRIX, MATRIX, ARRAY, RECENT, _I), inner=True)
def _search_dip(setup, watch, found, branch, tangents, arclength, recent, slot):
    """`search_dips` for one of the test functions."""
    n, size = setup.unknowns, point_size(setup)
    positions, pieces, at_positions = recent.positions.copy(), recent.pieces.copy(), recent.tests.copy()
    left, right, point, tests = np.zeros(size), np.zeros(size), np.zeros(size), np.empty(TESTS)
    for _ in range(_DIP_LOOKS):
        if not _dips(at_positions, slot):
            return
        before, least, behind = at_positions[0, slot], at_positions[1, slot], at_positions[2, slot]
        first = (least - before) / (positions[1] - positions[0])
        bend = ((behind - least) / (positions[2] - positions[1]) - first) / (positions[2] - positions[0])
        if not bend * least > 0.0:
            return
        position = 0.5 * (positions[0] + positions[1]) - 0.5 * first / bend
        lowest = before + (position - positions[0]) * (first + bend * (position - positions[1]))
        # From either side it may fall on as steeply for half the way to the other one.
        left_step, right_step = positions[1] - positions[0], positions[2] - positions[1]
        falls = 0.5 * max(abs(before - least) * right_step / left_step, abs(behind - least) * left_step / right_step)
        if not (lowest * math.copysign(1.0, least) < _CLEARANCE * abs(least) or falls > abs(least)):
            return
        margin = 0.05 * (positions[2] - positions[0])
        if abs(position - positions[1]) < margin:
            position = positions[1] + (margin if positions[2] - positions[1] > positions[1] - positions[0] else -margin)
        side = 0 if position < positions[1] else 1
        piece = pieces[side]
        arc = arclength[piece + 1] - arclength[piece]
        for j in range(n + 1):
            left[j], left[n + 1 + j] = branch[piece, j], tangents[piece, j]
            right[j], right[n + 1 + j] = branch[piece + 1, j], tangents[piece + 1, j]
        x = (position - arclength[piece]) / arc
        if state_at(setup, left, right, arc, x, point) < 0:
            return
        look(watch, point[: n + 1], tests)
        if math.isnan(tests[LARGEST]):
            return
        if tests[OUTSIDE] != at_positions[side, OUTSIDE] or tests[DOUBLING] * at_positions[side, DOUBLING] < 0.0:
            # One call in a loop: every further one is compiled once more.
            for part in range(2):
                low, high = (positions[side] - arclength[piece]) / arc, x
                at_low, at_high = at_positions[side], tests
                if part == 1:
                    low, high = x, (positions[side + 1] - arclength[piece]) / arc
                    at_low, at_high = tests, at_positions[side + 1]
                search(setup, watch, found, piece, left, right, arc, low, high, at_low, at_high)
            return
        # The three places among four that have the least value in the middle.
        closer = abs(tests[slot]) <= abs(least)
        if closer:
            other = 2 - 2 * side
            positions[other], pieces[1 - side] = positions[1], piece
            copy_into(at_positions[other], at_positions[1])
        new = 1 if closer else 2 * side
        positions[new] = position
        copy_into(at_positions[new], tests)


@kernel(types.void(SETUP, WATCH, FOUND, MATRIX, MATRIX, ARRAY, RECENT, _F, _I, ARRAY), inner=True)
def search_dips(setup, watch, found, branch, tangents, arclength, recent, position, piece, tests):
    """Take one more place, and locate pairs of events that the last three suggest and do not bracket.

    Parameters
    ----------
    setup, watch, found
    branch, tangents, arclength : (k, n + 1), (k, n + 1) and (k,) arrays
        Points of the branch.
    recent : Recent
    position : float
        Its arc length.
    piece : int
        Behind which point of the branch it and the place before lie.
    tests : (TESTS,) array
    """
    for k in range(2):
        recent.positions[k] = recent.positions[k + 1]
        copy_into(recent.tests[k], recent.tests[k + 1])
    recent.positions[2], recent.pieces[0], recent.pieces[1] = position, recent.pieces[1], piece
    copy_into(recent.tests[2], tests)
    if not recent.positions[0] < recent.positions[1] < recent.positions[2]:
        return
    if not recent.tests[0, OUTSIDE] == recent.tests[1, OUTSIDE] == recent.tests[2, OUTSIDE]:
        return
    for slot in (DOUBLING, GAP):
        if _dips(recent.tests, slot):
            _search_dip(setup, watch, found, branch, tangents, arclength, recent, slot)
