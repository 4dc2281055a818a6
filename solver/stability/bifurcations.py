"""Period doublings and Neimark-Sacker points of a branch: where a periodic motion loses stability unseen by its folds.

Test functions of the monodromy matrix M (`solver.stability.multipliers.spectral_tests`) are followed along the branch:
det(M + I), which changes sign where a real multiplier passes -1, and how many multipliers lie outside the unit circle,
which tells where a complex pair passes it. They are known at the points of the branch and at the grid values of its row
that lie on it. What two neighbouring ones of these bracket, or three of them suggest, is located on the branch
(`solver.stability.passages`, `solver.stability.dips`).

Only where multipliers pass the circle is an event; where one passes +1 is left to det J, and two that meet outside the
circle do not pass it.
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from solver.continuation.continuation import Continuation, Curve, Event
from solver.continuation.curve_point import point_size
from solver.continuation.hermite import cubic, cubic_value, fraction_at
from solver.continuation.problem import Balance, Problem
from solver.continuation.setup import SETUP, STRAND
from solver.kernels import types
from solver.kernels.brackets import first_above, first_not_below
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.model.packing import gear_vectors
from solver.model.parameters import ALPHA_2, ALPHA_2_PHASE
from solver.stability.dips import Recent, search_dips
from solver.stability.monodromy import new_room
from solver.stability.multipliers import LARGEST, TESTS
from solver.stability.passages import FOUND, UNKNOWN, Found, Watch, look, search

__all__ = ["KnownMotions", "locate_bifurcations", "packed_parameters", "with_bifurcations"]

_I, _F = types.int64, types.float64

# Room for the bifurcations of one branch.
_MOST = 256
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


_KNOWN = types.NamedTuple((ARRAY, MATRIX, MATRIX), KnownMotions)


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


@kernel(types.void(SETUP, STRAND, ARRAY, ARRAY, _KNOWN, FOUND))
def _bifurcations(setup, strand, parameters, parameter_slope, known, found):
    """Locate the bifurcations of a branch, with the packed parameters of its system."""
    n, branch, tangents, arclength = setup.unknowns, strand.points, strand.tangents, strand.arclength
    values = known.values
    watch = Watch(parameters, parameter_slope, new_room(parameters, parameter_slope, branch[0, n], n))
    recent = Recent(np.full(3, -math.inf), np.zeros(2, np.int64), np.full((3, TESTS), math.nan))
    size = point_size(setup)
    left, right = np.zeros(size), np.zeros(size)
    at_low, at_high, at_right = np.empty(TESTS), np.empty(TESTS), np.empty(TESTS)
    for i in range(branch.shape[0]):
        for j in range(n + 1):
            left[j], left[n + 1 + j] = right[j], right[n + 1 + j]
            right[j], right[n + 1 + j] = branch[i, j], tangents[i, j]
        look(watch, branch[i], at_right)
        told = not math.isnan(at_right[LARGEST])
        found.counts[UNKNOWN] += not told
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
                    copy_into(at_high, known.tests[k])
                    low = search(setup, watch, found, i - 1, left, right, arc, low, x, at_low, at_high)
                    copy_into(at_low, at_high)
                    position = arclength[i - 1] + x * arc
                    search_dips(setup, watch, found, branch, tangents, arclength, recent, position, i - 1, at_low)
            if told:
                search(setup, watch, found, i - 1, left, right, arc, low, 1.0, at_low, at_right)
        copy_into(at_low, at_right)
        search_dips(setup, watch, found, branch, tangents, arclength, recent, arclength[i], max(i - 1, 0), at_low)


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
    A real multiplier that passes -1 and back between two neighbouring places, or a pair that passes the circle and
    back, is seen where its test function shows a dip on the way. The frequency must be above 0 on the whole branch.
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
    found = Found(indices, fractions, kinds, np.empty((_MOST, size)), np.zeros(3, np.int64))
    _bifurcations(problem.setup(continuation.corrector), curve.strand, *parameters, known, found)
    count, missed, unknown = found.counts.tolist()
    notes = []
    here = f"between the axis values {curve.points[0, -1]:.9g} and {curve.points[-1, -1]:.9g} of a branch's ends"
    if missed:
        notes.append(f"bifurcations {here} that are bracketed but cannot be located: {missed}")
    if unknown:
        notes.append(f"points {here} whose multipliers cannot be computed: {unknown}")
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
