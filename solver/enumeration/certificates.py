"""From the roots of the reduced balance to boxes of motions that are proven to hold exactly one solution each."""

import math

import numpy as np

from solver.enumeration.contact_law import LAW
from solver.enumeration.enclosed import MIRRORED, SHIFT, interval_of, law_of
from solver.enumeration.gain_bounds import gain_over
from solver.enumeration.gain_equation import motion_over
from solver.enumeration.interval import add
from solver.enumeration.reduction import CONTACT, GAP, ROWS, determinant_over, is_modulated, reduce_balance
from solver.enumeration.search import CONTRADICTION, FREE_MOTION, narrow, search
from solver.kernels import types
from solver.kernels.compile import ARRAY, FLAGS, MATRIX, kernel
from solver.kernels.linear import copy_into

__all__ = [
    "AMPLITUDE",
    "GAIN_BOUNDS",
    "MEAN",
    "MOST",
    "ROOT",
    "STABLE",
    "enumerate_point",
    "enumerate_points",
    "workspace",
]

_I, _F = types.int64, types.float64

# Columns of what is recorded about one box: pairs (low, high) of the gains that hold no other root, the unknowns, the
# amplitude and the gain itself, then stability.
GAIN_BOUNDS, MEAN, _COS, _SIN, AMPLITUDE, ROOT, STABLE, _COLUMNS = 0, 2, 4, 6, 8, 10, 12, 13

#: Most solutions that can be told apart at one point; more would be undecided.
MOST = 32
_UNDECIDED, _STACK = 16, 256

# Values of `solver.enumeration.solutions.Proof` and `Above`.
_NOT_DECIDED, _PROVEN, _CONTINUUM, _CONTRADICTORY = range(4)
_EMPTY, _OCCUPIED, _OPEN = range(3)


@kernel(types.UniTuple(MATRIX, 3)(), inner=True)
def workspace():
    """Arrays that `enumerate_point` needs: found (32, 13), undecided (48, 13) and its own work space."""
    boxes = MOST + _UNDECIDED
    return np.empty((MOST, _COLUMNS)), np.empty((boxes, _COLUMNS)), np.empty((ROWS + boxes + _STACK, 5))


@kernel(types.void(MATRIX, _F, _F, _F, ARRAY), inner=True)
def _describe(reduced, left, right, near, box):
    """Fill one box with the motions of gain between left and right."""
    mean, cosine, sine, amplitude = motion_over(reduced, left, right, near)
    box[GAIN_BOUNDS], box[GAIN_BOUNDS + 1] = 0.0, 1.0
    box[ROOT], box[ROOT + 1] = left, right
    box[MEAN], box[MEAN + 1] = mean
    box[_COS], box[_COS + 1] = cosine
    box[_SIN], box[_SIN + 1] = sine
    box[AMPLITUDE], box[AMPLITUDE + 1] = amplitude
    box[STABLE] = 0.0


@kernel(types.boolean(ARRAY, _F, LAW), inner=True)
def _alone(box, b, law):
    """Do all motions within the bounds of the unknowns have gains within those of the gain? Then one is a solution.

    N is 1 where |lambda_m| - b >= lambda_a. Elsewhere its derivatives by lambda_m and lambda_a are at most
    (2/pi)/lambda_a, as the weights w of `solver.contact.dead_zone` are at most 2/pi and mu w at most 1/pi.
    """
    least = max(max(box[MEAN], -box[MEAN + 1]), 0.0)
    largest = max(abs(box[_COS]), abs(box[_COS + 1])) + max(abs(box[_SIN]), abs(box[_SIN + 1]))
    if law[2] != 1.0:
        # N is 1 only beyond the stiffer flank.
        least = box[MEAN]
    if law[2] == 0.0:
        if box[GAIN_BOUNDS] == 0.0 and -box[MEAN + 1] > largest * (1.0 + 1e-12):
            return True
    elif law[0] > 0.0 and box[GAIN_BOUNDS] == 0.0:
        furthest = max(box[MEAN + 1], -box[MEAN])
        if (furthest + largest) * (1.0 + 1e-12) < b:
            return True
    if box[GAIN_BOUNDS + 1] == 1.0 and ((b == 0.0 and law[2] == 1.0) or least - b > largest * (1.0 + 1e-12)):
        return True
    spread = box[MEAN + 1] - box[MEAN] + box[_COS + 1] - box[_COS] + box[_SIN + 1] - box[_SIN]
    smallest = box[AMPLITUDE] - spread
    if not smallest > 0.0:
        return False
    change = spread / smallest
    return (box[GAIN_BOUNDS] == 0.0 or box[ROOT] - change > box[GAIN_BOUNDS]) and (
        box[GAIN_BOUNDS + 1] == 1.0 or box[ROOT + 1] + change < box[GAIN_BOUNDS + 1]
    )


@kernel(types.void(MATRIX, _I), inner=True)
def _settle(solutions, last):
    """Move row `last` down to where it belongs: ascending amplitude."""
    while last > 0 and solutions[last - 1, AMPLITUDE] > solutions[last, AMPLITUDE]:
        for j in range(_COLUMNS):
            solutions[last - 1, j], solutions[last, j] = solutions[last, j], solutions[last - 1, j]
        last -= 1


@kernel(types.void(MATRIX, _I, types.UniTuple(_F, 2)), inner=True)
def _move(boxes, count, shift):
    """Count lambda_m of so many boxes from 0, and not from the middle of the gap."""
    if shift[0] == 0.0 and shift[1] == 0.0:
        return
    for i in range(count):
        boxes[i, MEAN], boxes[i, MEAN + 1] = add((boxes[i, MEAN], boxes[i, MEAN + 1]), shift)


@kernel(types.void(MATRIX, _I), inner=True)
def _turn(boxes, count):
    """Give so many motions the other sign."""
    for i in range(count):
        for slot in (MEAN, _COS, _SIN):
            boxes[i, slot], boxes[i, slot + 1] = -boxes[i, slot + 1], -boxes[i, slot]


@kernel(types.boolean(MATRIX, _I), inner=True)
def _adds_up(reduced, degree):
    """Whether the signs of det J of all solutions add up to that of q where motions of infinite amplitude would be.

    With two flanks alike these feel a closed contact. With one they are half free, and with unlike ones in between, as
    (phi, beta) = (0, 0) tells, unless the stiffness varies in the mean row: then nothing is known.
    """
    law, gain = law_of(reduced, CONTACT), (1.0, 1.0)
    if law[2] != 1.0:
        if is_modulated(reduced):
            return True
        gain = gain_over((0.0, 0.0), (0.0, 0.0), law, math.nan, 0.0)[0]
    q = determinant_over(reduced, gain[0], gain[1])
    return not ((q[0] > 0.0 and degree != 1) or (q[1] < 0.0 and degree != -1))


@kernel(types.UniTuple(_I, 5)(MATRIX, _F, MATRIX, MATRIX, MATRIX), inner=True)
def enumerate_point(enclosed, ceiling, solutions, undecided, work):
    """All solutions at one point.

    Parameters
    ----------
    enclosed : (SLOTS, 2) array
        The condensed balance there, of `solver.enumeration.enclosed`.
    ceiling : float
        Amplitude ceiling.
    solutions, undecided, work : arrays
        From `workspace`; the first two are filled with boxes.

    Returns
    -------
    solutions, undecided, proof, above, visits : int
        Numbers of boxes, `Proof`, `Above` and the number of intervals that the search looked at.
    """
    reduced = work[:ROWS]
    roots, boxes, stack = work[ROWS : ROWS + MOST], work[ROWS + MOST : ROWS + MOST + _UNDECIDED], work[-_STACK:]
    if not reduce_balance(enclosed, reduced):
        for j in range(_COLUMNS):
            undecided[0, j] = math.nan
        undecided[0, ROOT], undecided[0, ROOT + 1] = 0.0, 1.0
        return 0, 1, _NOT_DECIDED, _OPEN, 0
    n_roots, n_boxes, flags, visits = search(reduced, roots, boxes, stack)
    count, n_open, above, degree, law = 0, 0, _EMPTY, 0, law_of(reduced, CONTACT)
    for i in range(n_roots):
        roots[i, 0], roots[i, 1], roots[i, 3] = narrow(reduced, roots[i, 0], roots[i, 1], roots[i, 2])
    for i in range(n_roots):
        left, right, sign = roots[i, 0], roots[i, 1], roots[i, 2]
        _describe(reduced, left, right, roots[i, 3], solutions[count])
        # Every root lies in one of the intervals: between the neighbours there is no other. A free motion has gain 0.
        if flags & FREE_MOTION:
            solutions[count, GAIN_BOUNDS] = 1e-300
        for j in range(n_roots + n_boxes):
            low, high = (roots[j, 0], roots[j, 1]) if j < n_roots else (boxes[j - n_roots, 0], boxes[j - n_roots, 1])
            if j != i and high <= left:
                solutions[count, GAIN_BOUNDS] = max(solutions[count, GAIN_BOUNDS], high)
            elif j != i:
                solutions[count, GAIN_BOUNDS + 1] = min(solutions[count, GAIN_BOUNDS + 1], low)
        q = determinant_over(reduced, left, right)
        if not (q[0] > 0.0 or q[1] < 0.0) or not _alone(solutions[count], reduced[GAP, 1], law):
            # A root whose motion may be infinite, or whose box is so coarse that it may reach to another solution.
            if solutions[count, AMPLITUDE] > ceiling:
                above = _OPEN
            else:
                copy_into(undecided[n_open], solutions[count])
                n_open += 1
            continue
        stable = (sign < 0.0) == (q[0] > 0.0)
        degree += 1 if stable else -1
        if solutions[count, AMPLITUDE] > ceiling:
            above = max(above, _OCCUPIED)
            continue
        solutions[count, STABLE] = 1.0 if stable else 0.0
        _settle(solutions, count)
        count += 1
    decided = n_open == 0 and above != _OPEN
    for i in range(n_boxes):
        decided = False
        if n_open == undecided.shape[0]:
            break
        _describe(reduced, boxes[i, 0], boxes[i, 1], np.nan, undecided[n_open])
        if undecided[n_open, AMPLITUDE] > ceiling:
            above = _OPEN
        else:
            n_open += 1
    proof = _PROVEN
    if flags & FREE_MOTION:
        proof = _CONTINUUM
    if n_open > 0:
        proof = _NOT_DECIDED
    if decided and proof == _PROVEN and not _adds_up(reduced, degree):
        proof = _CONTRADICTORY
    if flags & CONTRADICTION:
        proof = _CONTRADICTORY
    shift = interval_of(enclosed, SHIFT)
    _move(solutions, count, shift)
    _move(undecided, n_open, shift)
    if enclosed[MIRRORED, 0] != 0.0:
        _turn(solutions, count)
        _turn(undecided, n_open)
    return count, n_open, proof, above, visits


_CUBE, _CODES, _COUNTS = types.float64[:, :, ::1], types.int8[:, ::1], types.int64[::1]


@kernel(types.Tuple((_CUBE, MATRIX, _CODES, _COUNTS, FLAGS, FLAGS))(_CUBE, _F))
def enumerate_points(enclosed, ceiling):
    """All solutions at X points, S at most at one.

    Parameters
    ----------
    enclosed : (X, SLOTS, 2) array
        The condensed balance at each, of `solver.enumeration.enclosed`.
    ceiling : float
        Amplitude ceiling.

    Returns
    -------
    motions : (X, S, 3) array
        (lambda_m, lambda_c, lambda_s), ascending amplitude; nan beyond their number.
    radius : (X, S) array
        What bounds the error of each unknown.
    stable : (X, S) int8 array
        1, 0, or -1 beyond the number of solutions.
    counts : (X,) int array
    proof, above : (X,) int8 arrays
        `Proof` and `Above`.
    """
    size, most = enclosed.shape[0], 1
    solutions, undecided, work = workspace()
    # All solutions one after the other; there is mostly one at a value.
    boxes = np.empty((2 * size + MOST, _COLUMNS))
    counts, proof, above = np.empty(size, np.int64), np.empty(size, np.int8), np.empty(size, np.int8)
    total = 0
    for i in range(size):
        counts[i], _open, proof[i], above[i], _visits = enumerate_point(
            enclosed[i], ceiling, solutions, undecided, work
        )
        if total + counts[i] > boxes.shape[0]:
            longer = np.empty((2 * boxes.shape[0] + MOST, _COLUMNS))
            for k in range(total):
                copy_into(longer[k], boxes[k])
            boxes = longer
        for k in range(counts[i]):
            copy_into(boxes[total + k], solutions[k])
        total += counts[i]
        most = max(most, counts[i])
    motions, radius = np.full((size, most, 3), np.nan), np.full((size, most), np.nan)
    stable = np.full((size, most), np.int8(-1))
    total = 0
    for i in range(size):
        for k in range(counts[i]):
            box = boxes[total]
            radius[i, k] = 0.0
            for j in range(3):
                low, high = box[MEAN + 2 * j], box[MEAN + 2 * j + 1]
                motions[i, k, j] = 0.5 * (low + high)
                # Twice the half width covers the rounding of the middle.
                radius[i, k] = max(radius[i, k], high - low)
            stable[i, k] = 1 if box[STABLE] == 1.0 else 0
            total += 1
    return motions, radius, stable, counts, proof, above
