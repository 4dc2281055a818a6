"""The equation h(t) = N(phi(t), beta(t)) - t = 0 of the reduced balance, and the motions of its roots, with bounds.

`solver.enumeration.reduction` derives it and gives the polynomials that phi and beta are made of.
"""

import math

from solver.enumeration.contact_law import contact_law, is_unlike, near_cosine
from solver.enumeration.enclosed import interval_of, law_of
from solver.enumeration.gain_bounds import gain_over, gain_slopes
from solver.enumeration.interval import (
    INTERVAL,
    above,
    absolute,
    add,
    below,
    divide,
    exact,
    hull,
    intersect,
    multiply,
    square,
    subtract,
    symmetric,
    times,
)
from solver.enumeration.reduction import (
    CONTACT,
    FORCE_SLOPE,
    GAP,
    GAP_SLOPE,
    LARGEST,
    LOAD,
    N_1,
    N_2,
    l_at,
    numerators_at,
    numerators_over,
)
from solver.kernels import types
from solver.kernels.compile import MATRIX, kernel

__all__ = ["approximate_gain", "gain_at", "motion_over", "slope_over", "turning_point"]

_F = types.float64

#: Slopes of phi and beta must lie below it.
_STEEPEST = 1e100
#: Of the width of an interval of gains.
_SLACK = 1e-3


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def _ratio(numerator, size):
    """|numerator| / size for size >= 0; the upper end is infinite where size may be 0."""
    low, high = absolute(numerator)
    return max(below(low / size[1]), 0.0), above(high / size[0]) if size[0] > 0.0 else math.inf


@kernel(INTERVAL(MATRIX, INTERVAL, INTERVAL, INTERVAL), inline=True)
def _mean_force(reduced, n, q, size):
    """phi: |n|/|l|, and where the flanks are not alike n/|l| with the sign of q."""
    if reduced[CONTACT + 1, 0] == 1.0:
        return _ratio(n, size)
    least = n[0] / size[0] if n[0] < 0.0 else n[0] / size[1]
    most = n[1] / size[0] if n[1] > 0.0 else n[1] / size[1]
    phi = below(least), above(most)
    if q[0] > 0.0:
        return phi
    if q[1] < 0.0:
        return -phi[1], -phi[0]
    return symmetric(max(-phi[0], phi[1]))


@kernel(types.UniTuple(INTERVAL, 2)(MATRIX, _F), inner=True)
def _scaled_at(reduced, t):
    """phi and beta at one gain."""
    n, q, size = numerators_at(reduced, t)
    return _mean_force(reduced, n, q, size), _ratio(multiply(interval_of(reduced, GAP), q), size)


@kernel(types.UniTuple(INTERVAL, 2)(MATRIX, _F, _F), inner=True)
def gain_at(reduced, t, guess):
    """N at one gain, and the near flank's cosine there; `guess` as in `solver.enumeration.gain_bounds.gain_over`.

    Parameters
    ----------
    reduced : (ROWS, 2) array
        From `reduce_balance`.
    t : float
        Gain.
    guess : float
        The near flank's cosine nearby, or nan.
    """
    phi, beta = _scaled_at(reduced, t)
    return gain_over(phi, beta, law_of(reduced, CONTACT), guess, 0.0)


@kernel(types.UniTuple(_F, 2)(MATRIX, _F, _F), inner=True)
def approximate_gain(reduced, t, guess):
    """h(t) and the near flank's cosine to rounding, without proof.

    Parameters
    ----------
    reduced : (ROWS, 2) array
        From `reduce_balance`.
    t : float
        Gain.
    guess : float
        The near flank's cosine nearby, or nan.
    """
    phi, beta = _scaled_at(reduced, t)
    force, gap, law = 0.5 * (phi[0] + phi[1]), 0.5 * (beta[0] + beta[1]), law_of(reduced, CONTACT)
    if force >= 1.0 and law[0] == 0.0:
        return 1.0 - t, guess
    if is_unlike(law) and force <= -law[2] and law[0] == 0.0:
        return law[2] - t, guess
    cosine = min(gap, 1.0) if law[2] != 0.0 else 1.0
    if force > 0.0 or law[0] > 0.0 or is_unlike(law):
        cosine = near_cosine(force, gap, law, guess, 0.0)[0]
    return contact_law(cosine, gap, law)[1] - t, cosine


@kernel(types.UniTuple(INTERVAL, 2)(MATRIX, types.int64, _F), inline=True)
def _cubic_at(reduced, row, t):
    """Value and slope of a cubic at one gain."""
    a_0, a_1, a_2, a_3 = (
        interval_of(reduced, row),
        interval_of(reduced, row + 1),
        interval_of(reduced, row + 2),
        interval_of(reduced, row + 3),
    )
    value = add(a_0, times(t, add(a_1, times(t, add(a_2, times(t, a_3))))))
    return value, add(a_1, times(t, add(times(2.0, a_2), times(3.0 * t, a_3))))


@kernel(INTERVAL(MATRIX, types.int64, _F, _F, INTERVAL), inner=True)
def _cubic_over(reduced, row, left, right, width):
    """Range of a cubic over an interval: the hull of its Bernstein coefficients."""
    value, slope = _cubic_at(reduced, row, left)
    value_right, slope_right = _cubic_at(reduced, row, right)
    third = divide(width, exact(3.0))
    inner = hull(add(value, multiply(third, slope)), subtract(value_right, multiply(third, slope_right)))
    return hull(hull(value, value_right), inner)


@kernel(INTERVAL(INTERVAL, INTERVAL, INTERVAL, INTERVAL, _F), inline=True)
def _between(whole, at_left, at_right, slope, width):
    """Range of a function over an interval, from a rougher one, its values at the ends and its slope.

    It is that of the end values where the function is monotone.
    """
    fall, rise = above(max(-slope[0], 0.0) * width), above(max(slope[1], 0.0) * width)
    low = max(below(at_left[0] - fall), below(at_right[0] - rise))
    high = min(above(at_left[1] + rise), above(at_right[1] + fall))
    return intersect(whole, (low, high))


@kernel(types.Tuple((INTERVAL, INTERVAL, INTERVAL, INTERVAL, types.boolean))(MATRIX, _F, _F), inner=True)
def _scaled_over(reduced, left, right):
    """phi, beta and their slopes over [left, right]; False (and no slopes) where l may vanish."""
    (n, q, size), (n_left, q_left, l_left), (n_right, q_right, l_right) = numerators_over(reduced, left, right)
    width, gap, signed = (
        subtract(exact(right), exact(left)),
        interval_of(reduced, GAP),
        reduced[CONTACT + 1, 0] != 1.0,
    )
    phi, beta = _mean_force(reduced, n, q, size), _ratio(multiply(gap, q), size)
    # Where the flanks are not alike the sign of phi is that of q as well, and phi jumps where that changes.
    if not size[0] > 1.0 / LARGEST or (signed and not (q[0] > 0.0 or q[1] < 0.0)):
        return phi, beta, (0.0, 0.0), (0.0, 0.0), False

    cube = multiply(size, square(size))
    by_force = divide(_cubic_over(reduced, FORCE_SLOPE, left, right, width), cube)
    by_gap = multiply(gap, divide(_cubic_over(reduced, GAP_SLOPE, left, right, width), cube))
    if not max(absolute(by_force)[1], absolute(by_gap)[1]) < _STEEPEST:
        return phi, beta, (0.0, 0.0), (0.0, 0.0), False
    # The slopes of |n| and |q| follow the sign of n and q; where that changes they have a kink.
    sign = 1 if n[0] > 0.0 else (-1 if n[1] < 0.0 else 0)
    if signed:
        sign = 1 if q[0] > 0.0 else -1
    elif left == 0.0 and reduced[LOAD, 0] == 0.0:
        # Without mean load n(0) = 0, so that n has the sign of its slope.
        n_slope = add(interval_of(reduced, N_1), multiply(times(2.0, (left, right)), interval_of(reduced, N_2)))
        sign = 1 if n_slope[0] > 0.0 else (-1 if n_slope[1] < 0.0 else 0)
    if sign < 0:
        by_force = -by_force[1], -by_force[0]
    elif sign == 0:
        by_force = symmetric(absolute(by_force)[1])
    if q[1] < 0.0:
        by_gap = -by_gap[1], -by_gap[0]
    elif not q[0] > 0.0:
        by_gap = symmetric(absolute(by_gap)[1])
    ends = _mean_force(reduced, n_left, q_left, l_left), _mean_force(reduced, n_right, q_right, l_right)
    phi = _between(phi, ends[0], ends[1], by_force, width[1])
    ends = _ratio(multiply(gap, q_left), l_left), _ratio(multiply(gap, q_right), l_right)
    beta = _between(beta, ends[0], ends[1], by_gap, width[1])
    return phi, beta, by_force, by_gap, True


@kernel(types.Tuple((INTERVAL, INTERVAL, types.boolean))(MATRIX, _F, _F, _F), inner=True)
def slope_over(reduced, left, right, guess):
    """What h does over an interval of gains.

    Parameters
    ----------
    reduced : (ROWS, 2) array
    left, right : float
        The interval.
    guess : float
        The near flank's cosine somewhere in it, or nan.

    Returns
    -------
    gain : interval
        N.
    slope : interval
        Generalised derivative of h; without bounds where N alone excludes a root.
    regular : bool
        Whether l does not vanish, so that h is continuous and `slope` holds.
    """
    phi, beta, by_force, by_gap, regular = _scaled_over(reduced, left, right)
    # What the bounds lose by being solved for to this share of the interval is not felt.
    slack, law = _SLACK * (right - left), law_of(reduced, CONTACT)
    gain, cosine = gain_over(phi, beta, law, guess, slack)
    # Where contact is never lost, or never made, N is 1 or 0 exactly.
    if not regular or gain[0] >= 1.0 or gain[0] > right or gain[1] < left:
        return gain, (-math.inf, math.inf), regular
    law_force, law_gap = gain_slopes(phi, beta, cosine, law, slack)
    slope = add(multiply(law_force, by_force), multiply(law_gap, by_gap))
    return gain, subtract(slope, exact(1.0)), True


@kernel(_F(MATRIX, _F, _F), inner=True)
def turning_point(reduced, left, right):
    """Where phi or beta turns round inside an interval, approximately; nan if neither seems to.

    Between such places both are monotone and bounds over intervals are sharp, so that it is good to cut there.

    Parameters
    ----------
    reduced : (ROWS, 2) array
        From `reduce_balance`.
    left, right : float
        Ends of the interval of gains.
    """
    for row in (FORCE_SLOPE, GAP_SLOPE):
        a_0, a_1 = 0.5 * (reduced[row, 0] + reduced[row, 1]), 0.5 * (reduced[row + 1, 0] + reduced[row + 1, 1])
        a_2, a_3 = 0.5 * (reduced[row + 2, 0] + reduced[row + 2, 1]), 0.5 * (reduced[row + 3, 0] + reduced[row + 3, 1])
        low, high = left, right
        at_low = a_0 + low * (a_1 + low * (a_2 + low * a_3))
        at_high = a_0 + high * (a_1 + high * (a_2 + high * a_3))
        if not at_low * at_high < 0.0:
            continue
        t = 0.5 * (low + high)
        for _ in range(30):
            value = a_0 + t * (a_1 + t * (a_2 + t * a_3))
            if value * at_low > 0.0:
                low = t
            else:
                high = t
            # Newton's method, kept in the bracket.
            slope = a_1 + t * (2.0 * a_2 + 3.0 * t * a_3)
            moved = t - value / slope
            if not low < moved < high:
                moved = 0.5 * (low + high)
            step, t = abs(moved - t), moved
            if step < 1e-6 * (right - left):
                break
        return t
    return math.nan


@kernel(types.UniTuple(INTERVAL, 4)(MATRIX, _F, _F, _F), inner=True)
def motion_over(reduced, left, right, guess):
    """lambda_m, lambda_c, lambda_s, lambda_a of all solutions with gain in [left, right]; infinite where q may be 0.

    Parameters
    ----------
    reduced : (ROWS, 2) array
        From `reduce_balance`.
    left, right : float
        Ends of the interval of gains.
    guess : float
        The near flank's cosine nearby, or nan.
    """
    (n, q, size), _, _ = numerators_over(reduced, left, right)
    if not (q[0] > 0.0 or q[1] < 0.0):
        least = below(size[0] / above(absolute(q)[1]))
        everything = -math.inf, math.inf
        return everything, everything, everything, (max(least, 0.0), math.inf)
    amplitude, force, gap = divide(size, absolute(q)), divide(n, q), interval_of(reduced, GAP)
    mean, phi, law = (math.inf, -math.inf), _mean_force(reduced, n, q, size), law_of(reduced, CONTACT)
    # Mean displacement on the side of the force: b - a cos theta_+, or b plus the force if contact is never lost.
    far_alone = is_unlike(law) and law[0] == 0.0 and phi[1] < -law[2] * (1.0 + 1e-15)
    if law[0] > 0.0 or (phi[0] < 1.0 and not far_alone):
        cosine = gain_over(phi, _ratio(multiply(gap, q), size), law, guess, 0.0)[1]
        mean = hull(mean, subtract(gap, multiply(amplitude, cosine)))
    if not phi[1] < 1.0 and law[0] == 0.0:
        mean = hull(mean, add(gap, absolute(force)))
    if is_unlike(law) and law[0] == 0.0 and not phi[0] > -law[2] * (1.0 - 1e-15):
        # Or, in permanent contact with the far flank, -b less the force over its stiffness.
        behind = divide(absolute(force), (law[2] * (1.0 - 1e-15), law[2] * (1.0 + 1e-15)))
        mean = hull(mean, subtract((0.0, 0.0), add(gap, behind)))
    if law[2] == 1.0:
        mean = max(mean[0], 0.0), mean[1]
        if force[1] < 0.0:
            mean = -mean[1], -mean[0]
        elif not force[0] > 0.0:
            mean = symmetric(mean[1])
    l_left, l_right = l_at(reduced, left), l_at(reduced, right)
    l_real, l_imaginary = hull(l_left[0], l_right[0]), hull(l_left[1], l_right[1])
    l_imaginary = -l_imaginary[1], -l_imaginary[0]
    return mean, divide(l_real, q), divide(l_imaginary, q), amplitude
