"""Branch and bound for all roots of the reduced balance h(t) = N - t on [0, 1] (`solver.enumeration.gain_equation`).

Every interval on the stack carries the proven signs of h at its two ends, so that cuts never fall onto a root and no
root is counted twice; at t = 1, where h <= 0 and may be 0, the sign counts as negative. An interval is

- finished if contact is never lost on it: then N = 1, and t = 1 is the only root it can have (where springs hold
  lambda, motions without contact are a root t = 0, whose surroundings, in which N = 0, are cut off before the search);
- cut down to the values that N takes on it, and discarded if there are none;
- finished if the slope of h has one sign on it: exactly one root if the signs at the ends differ, none otherwise;
- else cut at a place where the sign of h is certain, and with it goes the neighbourhood in which the slope keeps h
  from zero (the interval Newton step with a slope that contains 0).

Where no certain place is found, rounding or the uncertainty of the coefficients is larger than h: the interval is
returned as undecided.
"""

import math

from solver.enumeration.gain_equation import approximate_gain, gain_at, slope_over, turning_point
from solver.enumeration.interval import above, absolute, below, divide, exact, subtract
from solver.enumeration.reduction import CONTACT, GAP, LOAD, numerators_at
from solver.kernels import types
from solver.kernels.compile import MATRIX, kernel

__all__ = ["CONTRADICTION", "FREE_MOTION", "narrow", "search"]

_F, _I = types.float64, types.int64

#: Flags of `search`: a motion inside the gap leaves its mean free; two proofs contradict each other.
FREE_MOTION, CONTRADICTION = 1, 2

_VISITS = 20_000
_NARROWEST = 1e-15
# Cuts keep this share of an interval away from its ends; half the width of the first interval around a root.
_EDGE, _AROUND = 0.02, 1e-6
# Sign of h at an end: proven, exactly zero (only at t = 0), or not known (only at t = 0).
_ZERO, _UNKNOWN = 0.0, 2.0


@kernel(types.UniTuple(_F, 2)(_F, _F, _F, _F, _F, _F, _F), inner=True)
def _root_free(left, cut, right, h_low, h_high, slope_low, slope_high):
    """How far to both sides of `cut`, where h lies in [h_low, h_high] without 0, the slope keeps h from 0."""
    if h_low > 0.0:
        size, falling, rising = h_low, -slope_low, slope_high
    else:
        size, falling, rising = -h_high, slope_high, -slope_low
    ahead, behind = right, left
    if falling > 0.0:
        ahead = min(max(below(cut + below(size / falling)), cut), right)
    if rising > 0.0:
        behind = max(min(above(cut - below(size / rising)), cut), left)
    return behind, ahead


@kernel(types.Tuple((_F, _F, _F, _F))(MATRIX, _F, _F, _F), inner=True)
def _certain_cut(reduced, left, right, guess):
    """A place inside where the sign of h is certain: place (nan if none), bounds of h, near flank's cosine."""
    turn = (turning_point(reduced, left, right) - left) / (right - left)
    # Too close to an end it would cut off next to nothing.
    first = turn if _EDGE < turn < 1.0 - _EDGE else 0.5
    for k in range(5):
        fraction = first if k == 0 else (0.4375 if k == 1 else (0.5625 if k == 2 else (0.3 if k == 3 else 0.7)))
        cut = left + fraction * (right - left)
        if not left < cut < right:
            break
        gain, cosine = gain_at(reduced, cut, guess)
        h = subtract(gain, exact(cut))
        if h[0] > 0.0 or h[1] < 0.0:
            return cut, h[0], h[1], 0.5 * (cosine[0] + cosine[1])
    return math.nan, 0.0, 0.0, math.nan


@kernel(_F(MATRIX), inner=True)
def _without_contact(reduced):
    """Up to which gain N is certainly 0; 0 if it is not at any."""
    right = 0.5
    for _ in range(50):
        if slope_over(reduced, 0.0, right, math.nan)[0][1] == 0.0:
            return right
        right *= 0.5
    return 0.0


@kernel(types.void(MATRIX, _I, _F, _F, _F, _F, _F), inline=True)
def _push(stack, count, left, right, sign_left, sign_right, guess):
    stack[count, 0], stack[count, 1], stack[count, 2], stack[count, 3] = left, right, sign_left, sign_right
    stack[count, 4] = guess


@kernel(_I(MATRIX, _I, _F, _F), inner=True)
def _append(boxes, count, left, right):
    """Append an interval, joined to the one before it where they touch; boxes come from left to right."""
    if count > 0 and boxes[count - 1, 1] >= left:
        boxes[count - 1, 1] = right
        return count
    if count == boxes.shape[0]:
        # No room: the last box grows over what lies between, which is then undecided as well.
        boxes[count - 1, 1] = right
        return count
    boxes[count, 0], boxes[count, 1] = left, right
    return count + 1


@kernel(types.UniTuple(_I, 4)(MATRIX, MATRIX, MATRIX, MATRIX), inner=True)
def search(reduced, roots, undecided, stack):
    """Find all roots of the reduced balance.

    Parameters
    ----------
    reduced : (ROWS, 2) array
        From `solver.enumeration.reduction.reduce_balance`.
    roots : (R, 3) array
        Filled with intervals of gains that hold exactly one root each, ascending, and the sign that the slope of h has
        on them; one more than fits is undecided.
    undecided : (U, 2) array
        Filled with the intervals outside which every root is in `roots`.
    stack : (S, 5) array
        Work space.

    Returns
    -------
    roots, undecided, flags, visits : int
        Numbers of roots and undecided intervals, the sum of the flags that apply, and the intervals looked at.
    """
    n_roots, open_boxes, flags, visits, size = 0, 0, 0, 0, 0
    start, start_sign, held = 0.0, 1.0, reduced[CONTACT, 0] > 0.0
    if reduced[GAP, 1] == 0.0 and reduced[CONTACT + 1, 0] == 1.0:
        # Without backlash N is 1 throughout.
        roots[0, 0], roots[0, 1], roots[0, 2] = 0.0, 1.0, -1.0
        return 1, 0, 0, 0
    at_zero, _cosine = gain_at(reduced, 0.0, math.nan)
    if held and not at_zero[0] > 0.0:
        start_sign = _UNKNOWN
        start = _without_contact(reduced)
        if start > 0.0:
            # N is 0 up to there: t = 0 is a root, and h = -t negative beyond it.
            roots[0, 0], roots[0, 1], roots[0, 2] = 0.0, start, -1.0
            n_roots, start_sign = 1, -1.0
    # Without mean load n(0) is exactly 0.
    elif reduced[LOAD, 0] == 0.0 and not at_zero[0] > 0.0:
        _n, q, length = numerators_at(reduced, 0.0)
        start_sign = _UNKNOWN
        if reduced[GAP, 0] * absolute(q)[0] > above(length[1]):
            start_sign, flags = _ZERO, FREE_MOTION

    _push(stack, 0, start, 1.0, start_sign, -1.0, math.nan)
    size = 1
    while size > 0:
        size -= 1
        left, right, sign_left, sign_right = stack[size, 0], stack[size, 1], stack[size, 2], stack[size, 3]
        guess = stack[size, 4]
        visits += 1
        gain, slope, regular = slope_over(reduced, left, right, guess)
        if gain[0] >= 1.0:
            if sign_left != sign_right and right != 1.0:
                flags |= CONTRADICTION
            elif right == 1.0 and n_roots < roots.shape[0]:
                roots[n_roots, 0], roots[n_roots, 1], roots[n_roots, 2] = left, right, -1.0
                n_roots += 1
            elif right == 1.0:
                open_boxes = _append(undecided, open_boxes, left, right)
            continue
        if gain[0] > right or gain[1] < left:
            if sign_left != sign_right and sign_left != _UNKNOWN:
                flags |= CONTRADICTION
            continue
        if gain[0] > left or gain[1] < right:
            # Where N ends, t on the outside cannot be a root; at the new end the sign of N - t is known.
            before = right - left
            if gain[0] > left:
                left, sign_left = gain[0], 1.0
            if gain[1] < right:
                right, sign_right = gain[1], -1.0
            if right - left < 0.7 * before:
                _push(stack, size, left, right, sign_left, sign_right, guess)
                size += 1
                continue
        if regular and (slope[0] > 0.0 or slope[1] < 0.0) and sign_left != _UNKNOWN:
            # With h(0) = 0 that zero is the only one here, and it belongs to the continuum.
            if sign_left != sign_right and sign_left != _ZERO:
                if n_roots == roots.shape[0]:
                    open_boxes = _append(undecided, open_boxes, left, right)
                    continue
                roots[n_roots, 0], roots[n_roots, 1], roots[n_roots, 2] = left, right, sign_right
                n_roots += 1
            continue

        cut, h_low, h_high, near = math.nan, 0.0, 0.0, math.nan
        if right - left > _NARROWEST and visits < _VISITS and size + 2 <= stack.shape[0]:
            cut, h_low, h_high, near = _certain_cut(reduced, left, right, guess)
        if math.isnan(cut):
            open_boxes = _append(undecided, open_boxes, left, right)
            continue
        sign = 1.0 if h_low > 0.0 else -1.0
        behind, ahead = cut, cut
        if regular:
            behind, ahead = _root_free(left, cut, right, h_low, h_high, slope[0], slope[1])
        if ahead < right:
            _push(stack, size, ahead, right, sign, sign_right, near)
            size += 1
        elif sign != sign_right:
            flags |= CONTRADICTION
        if behind > left:
            _push(stack, size, left, behind, sign_left, sign, near)
            size += 1
        elif sign != sign_left and sign_left != _UNKNOWN:
            flags |= CONTRADICTION
    return n_roots, open_boxes, flags, visits


@kernel(types.UniTuple(_F, 2)(MATRIX, _F, _F, _F), inner=True)
def _approximate_root(reduced, left, right, sign):
    """The root in an interval on which h runs through 0 with a slope of that sign, and the near flank's cosine there.

    The Illinois variant of regula falsi, without proof; the middle where h is 0 to rounding at both ends.
    """
    h_left, near = approximate_gain(reduced, left, math.nan)
    h_right, near = approximate_gain(reduced, right, near)
    low, high, t, side = left, right, 0.5 * (left + right), 0
    for _ in range(40):
        if not (h_left * sign < 0.0 and h_right * sign > 0.0):
            break
        t = min(max((low * h_right - high * h_left) / (h_right - h_left), low), high)
        h, near = approximate_gain(reduced, t, near)
        if abs(h) < 1e-15 or high - low < 1e-15:
            break
        if h * sign < 0.0:
            low, h_left = t, h
            h_right *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            high, h_right = t, h
            h_left *= 0.5 if side > 0 else 1.0
            side = 1
    return t, near


@kernel(types.Tuple((_F, _F, _F, types.boolean))(MATRIX, _F, _F, _F, _F), inner=True)
def _newton_step(reduced, left, middle, right, guess):
    """N from an interval and a place in it, the near flank's cosine there, and whether N lies inside the interval.

    Where the slope has no certain sign N is the interval itself.
    """
    _gain, slope, regular = slope_over(reduced, left, right, guess)
    if not (regular and (slope[0] > 0.0 or slope[1] < 0.0)):
        return left, right, guess, False
    gain, cosine = gain_at(reduced, middle, guess)
    h = subtract(gain, exact(middle))
    step = subtract(exact(middle), divide(h, slope))
    return step[0], step[1], 0.5 * (cosine[0] + cosine[1]), left < step[0] and step[1] < right


@kernel(types.UniTuple(_F, 3)(MATRIX, _F, _F, _F), inner=True)
def narrow(reduced, left, right, sign):
    """Narrow an interval with one root by interval Newton steps, as far as rounding allows.

    N = m - h(m)/h'(X) holds every root that X holds (Moore), and one if it lies inside X. The first X is tiny and laid
    around an approximate root: if N lies inside it, it is the root. If not, X is the whole interval.

    Parameters
    ----------
    reduced : (ROWS, 2) array
    left, right : float
        From `search`.
    sign : float
        Sign of the slope of h over the interval, from there.

    Returns
    -------
    left, right : float
    near : float
        The near flank's cosine at the root.
    """
    held = reduced[CONTACT, 0] > 0.0
    if left == 0.0 and held and gain_at(reduced, 0.0, math.nan)[0][1] == 0.0:
        return 0.0, 0.0, math.nan
    if right == 1.0:
        n, _q, length = numerators_at(reduced, 1.0)
        alike = reduced[CONTACT + 1, 0] == 1.0
        if reduced[GAP, 1] == 0.0 and alike:
            return 1.0, 1.0, math.nan
        if alike and not held:
            permanent = max(n[0], -n[1]) >= length[1]
        else:
            permanent = gain_at(reduced, 1.0, math.nan)[0][0] >= 1.0
        if permanent:
            return 1.0, 1.0, math.nan
    root, near = _approximate_root(reduced, left, right, sign)
    low, high = max(root - _AROUND, left), min(root + _AROUND, right)
    low, high, near, inside = _newton_step(reduced, low, root, high, near)
    if inside:
        return low, high, near
    for _ in range(80):
        before = right - left
        low, high, near, _inside = _newton_step(reduced, left, min(max(0.5 * (left + right), left), right), right, near)
        # An empty intersection is a contradiction that rounding cannot cause; the comparisons keep the interval then.
        if low > left and low <= right:
            left = low
        if high < right and high >= left:
            right = high
        if not right - left < 0.75 * before:
            break
    return left, right, near
