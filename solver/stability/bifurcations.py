"""Period doublings and Neimark-Sacker points of a branch: where a periodic motion loses stability unseen by its folds.

Test functions of the monodromy matrix M (`solver.stability.multipliers.spectral_tests`) are followed along the branch:
det(M + I), which changes sign where a real multiplier passes -1, and how many multipliers lie outside the unit circle,
which tells where a complex pair passes it. They are known at the points of the branch and at the grid values of its row
that lie on it. What two neighbouring ones of these bracket is located on the branch by regula falsi, bisected where
that is slow: next to a grazing the functions have square-root corners. Two of one kind between two neighbours cancel
and are not seen.

Only where multipliers pass the circle is an event; where one passes +1 is left to det J, and two that meet outside the
circle do not pass it.
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from solver.continuation.continuation import Continuation, Curve, Event
from solver.continuation.curve_point import point_size, state_at
from solver.continuation.hermite import cubic, cubic_value, fraction_at
from solver.continuation.problem import Balance, Problem
from solver.continuation.setup import SETUP, STRAND
from solver.kernels import types
from solver.kernels.brackets import first_above, first_not_below
from solver.kernels.compile import ARRAY, FLAGS, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.model.packing import gear_vectors
from solver.model.parameters import ALPHA_2, ALPHA_2_PHASE
from solver.stability.monodromy import ROOM, Room, monodromy_at, new_room
from solver.stability.multipliers import DOUBLING, GAP, LARGEST, OUTSIDE, TESTS, eigenvalues, spectral_tests

__all__ = ["KnownMotions", "locate_bifurcations", "packed_parameters", "with_bifurcations"]

_I, _F, _B = types.int64, types.float64, types.boolean
_INDICES = types.int64[::1]
_DOUBLING, _TORUS = int(Event.PERIOD_DOUBLING), int(Event.NEIMARK_SACKER)

# Room for the bifurcations of one branch, the looks that one of them may take, and pairs that may pass in one step.
_MOST, _LOOKS, _MOST_PAIRS = 256, 80, 8
# An event is located when its function has fallen to this share of what it was, or in so short a stretch of arc.
_ROUNDING, _NARROW = 1e-13, 1e-12
# A pair whose modulus is this close to 1 on both sides is on the circle, as of undamped systems, and passes nothing.
_ON_CIRCLE = 1e-8
# At a Neimark-Sacker point the pair nearest to the circle lies on it; if not, a real multiplier was what passed it.
_PASSED = 1e-5
# The cubic between two points tells to some share of the arc where on the branch a motion of the raster lies: where its
# test functions are not those of the branch there, these shares further outward.
_ASIDE = (0.0, 1e-4, 1e-3, 1e-2)
# A motion of the raster lies on the branch if the cubic between two points comes as near to it as this share of the arc
# between them, and to no other one as near as the second.
_NEAR, _APART = 0.01, 0.05


class KnownMotions(NamedTuple):
    """Motions at grid values of a row whose test functions are known; those that lie on a branch help to bracket.

    Parameters
    ----------
    values : (k,) array
        Axis values, ascending.
    motions : (k, n) array
    tests : (k, TESTS) array
    """

    values: np.ndarray
    motions: np.ndarray
    tests: np.ndarray


class _Watch(NamedTuple):
    """What test functions are computed with: packed parameters of the system, and room for its matrices."""

    parameters: np.ndarray
    parameter_slope: np.ndarray
    room: Room


class _Found(NamedTuple):
    """Bifurcations found: behind which point of the branch, at which fraction of the arc, kind, and point array; and
    how many were found, how many were not located, and how many points had no multipliers."""

    after: np.ndarray
    fractions: np.ndarray
    kinds: np.ndarray
    points: np.ndarray
    counts: np.ndarray


_WATCH = types.NamedTuple((ARRAY, ARRAY, ROOM), _Watch)
_FOUND = types.NamedTuple((_INDICES, ARRAY, FLAGS, MATRIX, _INDICES), _Found)
_KNOWN = types.NamedTuple((ARRAY, MATRIX, MATRIX), KnownMotions)
_LOCATED, _MISSED, _UNKNOWN = range(3)


@kernel(types.void(_WATCH, ARRAY, ARRAY), inner=True)
def _look(watch, y, tests):
    """Fill in the test functions at y = (u, p)."""
    n = y.shape[0] - 1
    room = monodromy_at(watch.parameters, watch.parameter_slope, y[:n], y[n], watch.room)
    eigenvalues(room.matrix, room.multipliers[0], room.multipliers[1])
    spectral_tests(room.multipliers[0], room.multipliers[1], tests)


@kernel(_F(_I, ARRAY, _F), inline=True)
def _value(kind, tests, level):
    """The function of one kind that changes sign at the event; for pairs, where OUTSIDE rises above `level`."""
    if kind == _DOUBLING:
        return tests[DOUBLING]
    size = min(abs(tests[GAP]), 1.0)
    return size if tests[OUTSIDE] > level else -size


@kernel(_F(SETUP, _WATCH, ARRAY, ARRAY, _F, _I, _F, ARRAY, MATRIX, ARRAY, ARRAY), inner=True)
def _pinpoint(setup, watch, left, right, arc, kind, level, bracket, at_ends, tests, found):
    """Locate an event between two fractions of a piece of the branch.

    Parameters
    ----------
    setup, watch
    left, right : point arrays
        Ends of the piece.
    arc : float
        Its length.
    kind : int
    level : float
        As for `_value`.
    bracket : (2,) array
        The two fractions; narrowed.
    at_ends : (2, TESTS) array
        Test functions there; replaced by those at the narrowed bracket.
    tests, found
        Filled with the test functions and the point array at the event.

    Returns
    -------
    float
        Its fraction; -1 if it cannot be located.
    """
    g_low, g_high = _value(kind, at_ends[0], level), _value(kind, at_ends[1], level)
    reference, side, width = max(abs(g_low), abs(g_high)), 0, bracket[1] - bracket[0]
    for look in range(_LOOKS):
        low, high = bracket[0], bracket[1]
        x = (low * g_high - high * g_low) / (g_high - g_low)
        margin = 1e-3 * (high - low)
        x = min(max(x, low + margin), high - margin)
        # Three looks must halve the bracket.
        if not math.isfinite(x) or (look % 3 == 2 and high - low > 0.5 * width):
            x = 0.5 * (low + high)
        if look % 3 == 2:
            width = high - low
        if state_at(setup, left, right, arc, x, found) < 0:
            return -1.0
        _look(watch, found[: setup.unknowns + 1], tests)
        if math.isnan(tests[LARGEST]):
            return -1.0
        g = _value(kind, tests, level)
        if abs(g) <= _ROUNDING * reference or (high - low) * arc <= _NARROW:
            return x
        if g * g_high < 0.0:
            bracket[0], g_low = x, g
            for i in range(TESTS):
                at_ends[0, i] = tests[i]
            if side == -1:
                g_high *= 0.5
            side = -1
        else:
            bracket[1], g_high = x, g
            for i in range(TESTS):
                at_ends[1, i] = tests[i]
            if side == 1:
                g_low *= 0.5
            side = 1
    return -1.0


@kernel(types.void(_FOUND, _I, _F, _I, ARRAY), inner=True)
def _record(found, after, fraction, kind, point):
    """Keep one event, or count it as missed where there is no more room."""
    count = found.counts[_LOCATED]
    if count == found.after.shape[0]:
        found.counts[_MISSED] += 1
        return
    found.after[count], found.fractions[count], found.kinds[count] = after, fraction, kind
    for j in range(point.shape[0]):
        found.points[count, j] = point[j]
    found.counts[_LOCATED] += 1


@kernel(_F(SETUP, _WATCH, ARRAY, ARRAY, _F, _F, _F, ARRAY, ARRAY, ARRAY), inner=True)
def _end_on_branch(setup, watch, left, right, arc, x, sense, expected, tests, point):
    """Where, from fraction x on in one sense, the branch's own test functions have the signs of those expected.

    Fills `tests` with them; x and what was expected where they are nowhere near.
    """
    for aside in _ASIDE:
        place = min(max(x + sense * aside, 0.0), 1.0)
        # At the points of the branch they are its own.
        if place in (0.0, 1.0) and place == x:
            break
        if state_at(setup, left, right, arc, place, point) < 0:
            break
        _look(watch, point[: setup.unknowns + 1], tests)
        if tests[OUTSIDE] == expected[OUTSIDE] and tests[DOUBLING] * expected[DOUBLING] > 0.0:
            return place
    copy_into(tests, expected)
    return x


@kernel(_F(SETUP, _WATCH, _FOUND, _I, ARRAY, ARRAY, _F, _F, _F, ARRAY, ARRAY), inner=True)
def _search(setup, watch, found, after, left, right, arc, low, high, at_low, at_high):
    """Locate all events between two neighbouring fractions of a piece whose test functions are known.

    Returns the fraction up to which it looked, which may be a little more.
    """
    pairs = at_low[OUTSIDE] != at_high[OUTSIDE]
    # What lies on the circle on both sides, as in undamped systems, passes nothing.
    pairs &= max(abs(at_low[GAP]), abs(at_high[GAP])) > _ON_CIRCLE
    if not pairs and at_low[DOUBLING] * at_high[DOUBLING] >= 0.0:
        return high
    bracket, at_ends = np.empty(2), np.empty((2, TESTS))
    tests, point = np.empty(TESTS), np.empty(point_size(setup))
    # Places, in order, between which a real multiplier may pass -1.
    places, at_places = np.empty(2 + 2 * _MOST_PAIRS), np.empty((2 + 2 * _MOST_PAIRS, TESTS))
    low = _end_on_branch(setup, watch, left, right, arc, low, -1.0, at_low, at_places[0], point)
    high = _end_on_branch(setup, watch, left, right, arc, high, 1.0, at_high, at_places[1], point)
    places[0], places[1], count = low, high, 2
    at_first, at_last = at_places[0].copy(), at_places[1].copy()
    if pairs:
        level, top = min(at_low[OUTSIDE], at_high[OUTSIDE]), max(at_low[OUTSIDE], at_high[OUTSIDE])
        while level < top and count < places.shape[0]:
            bracket[0], bracket[1] = low, high
            copy_into(at_ends[0], at_first)
            copy_into(at_ends[1], at_last)
            x = _pinpoint(setup, watch, left, right, arc, _TORUS, level, bracket, at_ends, tests, point)
            if x < 0.0:
                found.counts[_MISSED] += 1
            elif abs(tests[GAP]) <= _PASSED:
                _record(found, after, x, _TORUS, point)
            # Both ends of the bracket are places to look at. Of two real multipliers that passed one after the other
            # the second one is what was found here.
            for end in range(2):
                k = count
                while places[k - 1] > bracket[end]:
                    places[k] = places[k - 1]
                    for i in range(TESTS):
                        at_places[k, i] = at_places[k - 1, i]
                    k -= 1
                places[k] = bracket[end]
                for i in range(TESTS):
                    at_places[k, i] = at_ends[end, i]
                count += 1
            level += 2.0
    for k in range(1, count):
        if at_places[k - 1, DOUBLING] * at_places[k, DOUBLING] < 0.0:
            bracket[0], bracket[1] = places[k - 1], places[k]
            for i in range(TESTS):
                at_ends[0, i], at_ends[1, i] = at_places[k - 1, i], at_places[k, i]
            x = _pinpoint(setup, watch, left, right, arc, _DOUBLING, 0.0, bracket, at_ends, tests, point)
            if x < 0.0:
                found.counts[_MISSED] += 1
            else:
                _record(found, after, x, _DOUBLING, point)
    return high


@kernel(_I(SETUP, ARRAY, ARRAY, _F, _F, MATRIX, _I, _I), inner=True)
def _on_piece(setup, left, right, arc, x, motions, first, last):
    """Which of the motions first ... last - 1 lies on the branch at one fraction of a piece; -1 if none surely does."""
    nearest, distance, second = -1, math.inf, math.inf
    for k in range(first, last):
        gap = 0.0
        for j in range(setup.unknowns):
            leave, arrive = arc * left[setup.unknowns + 1 + j], arc * right[setup.unknowns + 1 + j]
            start, end = left[j] / setup.scale[j], right[j] / setup.scale[j]
            a, b = cubic(start, end, leave, arrive)
            gap = max(gap, abs(cubic_value(a, b, leave, start, x) - motions[k, j] / setup.scale[j]))
        if gap < distance:
            nearest, distance, second = k, gap, distance
        else:
            second = min(second, gap)
    return nearest if distance <= _NEAR * arc and second >= _APART * arc else -1


@kernel(types.void(SETUP, STRAND, ARRAY, ARRAY, _KNOWN, _FOUND))
def _bifurcations(setup, strand, parameters, parameter_slope, known, found):
    """Locate the bifurcations of a branch, with the packed parameters of its system."""
    n, branch, tangents, arclength = setup.unknowns, strand.points, strand.tangents, strand.arclength
    values = known.values
    watch = _Watch(parameters, parameter_slope, new_room(parameters, parameter_slope, branch[0, n], n))
    size = point_size(setup)
    left, right = np.zeros(size), np.zeros(size)
    at_low, at_high, at_right = np.empty(TESTS), np.empty(TESTS), np.empty(TESTS)
    for i in range(branch.shape[0]):
        for j in range(n + 1):
            left[j], left[n + 1 + j] = right[j], right[n + 1 + j]
            right[j], right[n + 1 + j] = branch[i, j], tangents[i, j]
        _look(watch, branch[i], at_right)
        told = not math.isnan(at_right[LARGEST])
        found.counts[_UNKNOWN] += not told
        if i > 0 and not math.isnan(at_low[LARGEST]):
            arc, low = arclength[i] - arclength[i - 1], 0.0
            begin, end = left[n], right[n]
            first = first_above(values, min(begin, end))
            last = first_not_below(values, max(begin, end))
            # Grid values in the order in which the piece passes them.
            while first < last:
                if begin < end:
                    lower, upper = first, first + 1
                    while upper < last and values[upper] == values[lower]:
                        upper += 1
                    first = upper
                else:
                    lower, upper = last - 1, last
                    while lower > first and values[lower - 1] == values[upper - 1]:
                        lower -= 1
                    last = lower
                leave, arrive = arc * left[2 * n + 1] * setup.scale[n], arc * right[2 * n + 1] * setup.scale[n]
                x = fraction_at(left[n], right[n], leave, arrive, values[lower], 1e-9)
                k = _on_piece(setup, left, right, arc, x, known.motions, lower, upper)
                if k >= 0 and x > low and not math.isnan(known.tests[k, LARGEST]):
                    for j in range(TESTS):
                        at_high[j] = known.tests[k, j]
                    low = _search(setup, watch, found, i - 1, left, right, arc, low, x, at_low, at_high)
                    for j in range(TESTS):
                        at_low[j] = at_high[j]
            if told:
                _search(setup, watch, found, i - 1, left, right, arc, low, 1.0, at_low, at_right)
        for j in range(TESTS):
            at_low[j] = at_right[j]


def packed_parameters(balance: Balance, problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """Vectors of `solver.model.packing.packed` for the motions of a problem of a balance.

    A Galerkin problem carries them. That of the describing function knows two harmonics of the stiffness; where the
    gear has more, pack them from the gear.
    """
    if not balance.truncated:
        return problem.parameters, problem.parameter_slope
    second = problem.parameters[[ALPHA_2, ALPHA_2_PHASE]]
    return gear_vectors(problem.parameters, problem.parameter_slope, [second], [], 1, 1)


def with_bifurcations(balance: Balance, problem: Problem, curve: Curve, continuation: Continuation) -> Curve:
    """`locate_bifurcations` of a branch by itself, with the parameters that its problem knows; the branch alone.

    Parameters
    ----------
    balance : Balance
    problem : Problem
        Of that balance.
    curve : Curve
        As traced for that problem.
    continuation : Continuation
        Whose corrector is used.
    """
    return locate_bifurcations(packed_parameters(balance, problem), problem, curve, continuation)[0]


def locate_bifurcations(
    parameters: tuple[np.ndarray, np.ndarray],
    problem: Problem,
    curve: Curve,
    continuation: Continuation,
    known: KnownMotions | None = None,
) -> tuple[Curve, tuple[str, ...]]:
    """The same branch with its period doublings and Neimark-Sacker points located.

    Parameters
    ----------
    parameters : (parameters, parameter_slope)
        `solver.model.packing.packed(system, axis, omega, balance.order, balance.period)`.
    problem : Problem
        `balance.problem(...)`.
    curve : Curve
        As traced for that problem.
    continuation : Continuation
        Whose corrector is used.
    known : KnownMotions, optional
        Solutions of the problem; those on the branch help to bracket.

    Returns
    -------
    Curve
        With points of the events PERIOD_DOUBLING and NEIMARK_SACKER inserted, in place of those that it may have had;
        all else is as it was. Static stability of an inserted point is that of its piece.
    notes : tuple of str
        What is bracketed but could not be located, and is left out; where multipliers cannot be computed.

    Notes
    -----
    A real multiplier that passes -1 and back between two neighbouring places is not seen, nor is a pair that passes the
    circle and back. The frequency of the system must be above 0 on the whole branch.
    """
    old = np.isin(curve.event, (Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER))
    if np.any(old):
        curve = Curve(*(part[~old] for part in curve.strand), curve.ends, curve.refused)
    if len(curve.points) < 2:
        return curve, ()
    n = problem.unknowns
    if known is None:
        known = KnownMotions(np.empty(0), np.empty((0, n)), np.empty((0, TESTS)))
    size = 2 * (n + 1) + 2 * problem.test_count + 1
    indices, fractions, kinds = np.empty(_MOST, np.int64), np.empty(_MOST), np.empty(_MOST, np.int8)
    found = _Found(indices, fractions, kinds, np.empty((_MOST, size)), np.zeros(3, np.int64))
    _bifurcations(problem.setup(continuation.corrector), curve.strand, *parameters, known, found)
    count, missed, unknown = found.counts.tolist()
    notes = []
    here = f"between the axis values {curve.points[0, -1]:.9g} and {curve.points[-1, -1]:.9g} of a branch's ends"
    if missed:
        notes.append(f"{missed} bifurcations {here} are bracketed but cannot be located")
    if unknown:
        notes.append(f"the multipliers of {unknown} points {here} cannot be computed")
    if count == 0:
        return curve, tuple(notes)
    order = np.lexsort((fractions[:count], indices[:count]))
    at, steps, points = indices[order], np.diff(curve.arclength), found.points[order]
    # A fold's neighbour on the far side tells the stability of the piece behind it.
    piece = np.where(curve.event[at] != Event.FOLD, curve.stable[at], curve.stable[at + 1])
    return dataclasses.replace(
        curve,
        points=np.insert(curve.points, at + 1, points[:, : n + 1], axis=0),
        tangents=np.insert(curve.tangents, at + 1, points[:, n + 1 : 2 * n + 2], axis=0),
        arclength=np.insert(curve.arclength, at + 1, curve.arclength[at] + fractions[order] * steps[at]),
        stable=np.insert(curve.stable, at + 1, piece),
        event=np.insert(curve.event, at + 1, kinds[order]),
    ), tuple(notes)
