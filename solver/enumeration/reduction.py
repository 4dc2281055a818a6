"""The first-order balance reduced to one equation h(t) = 0 for the gain t = N_a on [0, 1], with proven bounds.

Derivation. With f_1 = t Lambda_1 the mean row gives f_0 = (f_pm - t Re(e conj Lambda_1))/c. Inserted into the first
harmonic (`solver.harmonic.describing_function`) this leaves, for a given t, a linear equation for L = Lambda_1 alone,

    (D + t A') L + t Q conj(L) = G,    A' = c - T - P_1 conj(e)/(2c),  Q = P_2 - P_1 e/(2c),  G = F_1 - P_1 f_pm/c

whose determinant and numerators are polynomials in t:

    q(t) = |D + t A'|^2 - t^2 |Q|^2,    l(t) = conj(D + t A') G - t Q conj(G),    n(t) = (f_pm q - t Re(e conj l))/c

so that L = l/q and f_0 = n/q wherever q is not 0; where q = 0 but l is not, no motion of that gain exists. The dead
zone is homogeneous: multiplied by |q|/|l| the motion has amplitude 1, mean force phi = |n|/|l| and half gap beta = b
|q|/|l|, in which nothing is singular where q vanishes and the amplitude is infinite. phi fixes the mean displacement,
since f_0 grows with it while there is contact, and with it the gain N(phi, beta) (`solver.enumeration.contact_law`).
All solutions with contact are therefore the roots of

    h(t) = N(phi(t), beta(t)) - t,    0 <= t <= 1,

each root belongs to exactly one motion, and the Jacobian of the balance there has the determinant -c q chi h'(t), where
chi in (0, 1] is the share of the period in contact. Three remarks make this complete:

- h(1) = 0 exactly where contact is never lost (phi(1) >= 1), otherwise h(1) < 0; h(0) > 0 if f_pm is not 0.
- Without mean load a motion inside the gap, t = 0 and |F_1/D| <= b, leaves the mean free: a continuum, not a root.
- h is continuous, and Lipschitz with dN/dphi phi' + dN/dbeta beta' - 1 as (generalised) derivative, where l is not 0.

Without any damping, and if Q and e are 0 as well, D + t A' is real and a common factor of q, l and n, which all
vanish with it. It is left out then: q = D + t A', l = G and n = f_pm q/c describe the same motions, and the determinant
is that above with q^2 in place of q.
"""

import math

from solver.enumeration.coefficients import enclosed_coefficients
from solver.enumeration.contact_law import contact_law, gain_over, gain_slopes, near_cosine
from solver.enumeration.interval import (
    INTERVAL,
    above,
    absolute,
    add,
    below,
    complex_conjugate,
    complex_multiply,
    complex_scale,
    complex_subtract,
    divide,
    exact,
    hull,
    intersect,
    length,
    multiply,
    square,
    subtract,
    symmetric,
    times,
)
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.parameters import (
    ALPHA,
    ALPHA_2,
    F_PM,
    SIGMA,
    VARIATION_R,
    VARIATION_T,
    XI_MESH,
    XI_SUPPORT,
    XI_TRANSLATION,
    B,
)

__all__ = [
    "GAP",
    "LOAD",
    "ROWS",
    "approximate_gain",
    "determinant_over",
    "gain_at",
    "motion_over",
    "numerators_at",
    "reduce_balance",
    "slope_over",
    "turning_point",
]

_F, _I = types.float64, types.int64

# Rows (low, high) of the array that holds a reduced balance.
_D, _A, _Q, _L_0, _L_1, _E = 0, 2, 4, 5, 7, 9
_C, LOAD, GAP, _Q_1, _Q_2, _N_1, _N_2, _FORCE, _GAP = 11, 12, 13, 14, 15, 16, 17, 18, 22
# l = l_0 + t l_1: |l_1|, Re(l_1 conj l_0) and how close the straight line comes to 0.
_SPEED, _APPROACH, _CLOSEST = 26, 27, 28
# 1 where the common factor is left out, else 0.
_FACTORED = 29
ROWS = 30

# Reduced coefficients must lie below the first, so that no product of them overflows, and the amplitude's numerator
# above its inverse; slopes must lie below the second.
_LARGEST, _STEEPEST = 1e40, 1e100
# Of the width of an interval of gains.
_SLACK = 1e-3


@kernel(INTERVAL(MATRIX, types.int64), inline=True)
def _get(reduced, row):
    return reduced[row, 0], reduced[row, 1]


@kernel(types.void(MATRIX, types.int64, INTERVAL), inline=True)
def _put(reduced, row, value):
    reduced[row, 0], reduced[row, 1] = value[0], value[1]


@kernel(types.void(MATRIX, types.int64, INTERVAL, INTERVAL, INTERVAL, INTERVAL, INTERVAL, INTERVAL), inner=True)
def _put_cubic(reduced, row, n_0, n_1, n_2, r_0, r_1, r_2):
    """n' r - n r'/2 for n = n_0 + n_1 t + n_2 t^2 and r likewise: r^(3/2) times the slope of n/sqrt(r)."""
    half = multiply(exact(0.5), r_1)
    _put(reduced, row, subtract(multiply(n_1, r_0), multiply(n_0, half)))
    middle = add(multiply(n_1, half), multiply(exact(2.0), multiply(n_2, r_0)))
    _put(reduced, row + 1, subtract(middle, multiply(n_0, r_2)))
    _put(reduced, row + 2, multiply(exact(3.0), multiply(n_2, half)))
    _put(reduced, row + 3, multiply(n_2, r_2))


@kernel(types.boolean(ARRAY, ARRAY, _F, _I, _I), inline=True)
def _are_zero(parameters, parameter_slope, p, first, stop):
    """Whether parameters first ... stop - 1 are exactly 0 at an axis value."""
    for slot in range(first, stop):  # noqa: SIM110 (kernels have no generators)
        if parameters[slot] + p * parameter_slope[slot] != 0.0:
            return False
    return True


@kernel(types.boolean(ARRAY, ARRAY, _F), inner=True)
def _has_common_factor(parameters, parameter_slope, p):
    """Whether D and A' are real and Q and e are 0 for certain: nothing is damped, and what could make Q and e is 0."""
    uncoupled = _are_zero(parameters, parameter_slope, p, SIGMA, SIGMA + 1)
    undamped = _are_zero(parameters, parameter_slope, p, XI_MESH, XI_MESH + 1) and (
        uncoupled
        or (
            _are_zero(parameters, parameter_slope, p, XI_TRANSLATION, XI_TRANSLATION + 2)
            and _are_zero(parameters, parameter_slope, p, XI_SUPPORT, XI_SUPPORT + 6)
        )
    )
    first_fixed = _are_zero(parameters, parameter_slope, p, ALPHA, ALPHA + 1)
    second_fixed = _are_zero(parameters, parameter_slope, p, ALPHA_2, ALPHA_2 + 1)
    rotation_fixed = _are_zero(parameters, parameter_slope, p, VARIATION_R, VARIATION_R + 1)
    all_fixed = rotation_fixed and (
        uncoupled or _are_zero(parameters, parameter_slope, p, VARIATION_T, VARIATION_T + 1)
    )
    return undamped and (first_fixed or rotation_fixed) and (second_fixed or all_fixed)


@kernel(types.boolean(ARRAY, ARRAY, _F, MATRIX), inner=True)
def reduce_balance(parameters, parameter_slope, p, reduced):
    """Fill `reduced` (ROWS, 2) with the reduced balance at one axis value; False if it is not finite or D may be 0.

    Parameters
    ----------
    parameters, parameter_slope : (34,) arrays
    p : float
        Axis value.
    reduced : (ROWS, 2) array
        Read by the other kernels of this module.
    """
    values, c = enclosed_coefficients(parameters, parameter_slope, p)
    D, A, P_1, P_2, F, e = values
    load = exact(parameters[F_PM] + p * parameter_slope[F_PM])
    per_c = divide(exact(1.0), c)
    half = multiply(exact(0.5), per_c)
    A = complex_subtract(A, complex_scale(half, complex_multiply(P_1, complex_conjugate(e))))
    Q = complex_subtract(P_2, complex_scale(half, complex_multiply(P_1, e)))
    G = complex_subtract(F, complex_scale(multiply(load, per_c), P_1))
    L_0 = complex_multiply(complex_conjugate(D), G)
    L_1 = complex_subtract(complex_multiply(complex_conjugate(A), G), complex_multiply(Q, complex_conjugate(G)))
    factored, zero = _has_common_factor(parameters, parameter_slope, p), (0.0, 0.0)
    if factored:
        L_0, L_1 = G, (zero, zero)
    _put(reduced, _FACTORED, exact(1.0 if factored else 0.0))
    for i in range(2):
        _put(reduced, _D + i, D[i])
        _put(reduced, _A + i, A[i])
        _put(reduced, _L_0 + i, L_0[i])
        _put(reduced, _L_1 + i, L_1[i])
        _put(reduced, _E + i, e[i])
    Q_squared = add(square(Q[0]), square(Q[1]))
    _put(reduced, _Q, Q_squared)
    _put(reduced, _C, per_c)
    _put(reduced, LOAD, load)
    _put(reduced, GAP, exact(parameters[B] + p * parameter_slope[B]))

    q_0 = add(square(D[0]), square(D[1]))
    q_1 = multiply(exact(2.0), add(multiply(D[0], A[0]), multiply(D[1], A[1])))
    q_2 = subtract(add(square(A[0]), square(A[1])), Q_squared)
    if factored:
        q_0, q_1, q_2 = D[0], A[0], zero
    scale = multiply(load, per_c)
    n_0 = multiply(scale, q_0)
    n_1 = subtract(multiply(scale, q_1), multiply(per_c, add(multiply(e[0], L_0[0]), multiply(e[1], L_0[1]))))
    n_2 = subtract(multiply(scale, q_2), multiply(per_c, add(multiply(e[0], L_1[0]), multiply(e[1], L_1[1]))))
    r_0 = add(square(L_0[0]), square(L_0[1]))
    r_1 = multiply(exact(2.0), add(multiply(L_0[0], L_1[0]), multiply(L_0[1], L_1[1])))
    r_2 = add(square(L_1[0]), square(L_1[1]))
    _put(reduced, _Q_1, q_1)
    _put(reduced, _Q_2, q_2)
    _put(reduced, _N_1, n_1)
    _put(reduced, _N_2, n_2)
    speed, cross = length(L_1[0], L_1[1]), subtract(multiply(L_0[0], L_1[1]), multiply(L_0[1], L_1[0]))
    _put(reduced, _SPEED, speed)
    _put(reduced, _APPROACH, multiply(exact(0.5), r_1))
    closest = divide(absolute(cross), speed)
    _put(reduced, _CLOSEST, closest if closest[0] > 0.0 else (0.0, 0.0))
    _put_cubic(reduced, _FORCE, n_0, n_1, n_2, r_0, r_1, r_2)
    _put_cubic(reduced, _GAP, q_0, q_1, q_2, r_0, r_1, r_2)
    for row in range(_FORCE):
        for side in range(2):
            if not abs(reduced[row, side]) < _LARGEST:
                return False
    return q_0[0] > 0.0 or q_0[1] < 0.0


@kernel(types.UniTuple(INTERVAL, 2)(MATRIX, _F), inline=True)
def _l_at(reduced, t):
    """Real and imaginary part of l at one gain."""
    return (
        add(_get(reduced, _L_0), times(t, _get(reduced, _L_1))),
        add(_get(reduced, _L_0 + 1), times(t, _get(reduced, _L_1 + 1))),
    )


@kernel(types.UniTuple(INTERVAL, 3)(MATRIX, _F), inner=True)
def numerators_at(reduced, t):
    """n, q and |l| at one gain; q is summed so that no digits cancel at a resonance."""
    X_real = add(_get(reduced, _D), times(t, _get(reduced, _A)))
    X_imaginary = add(_get(reduced, _D + 1), times(t, _get(reduced, _A + 1)))
    q = X_real
    if reduced[_FACTORED, 0] == 0.0:
        q = add(square(X_real), square(X_imaginary))
        q = subtract(q, times(t, times(t, _get(reduced, _Q))))
    l_real, l_imaginary = _l_at(reduced, t)
    work = add(multiply(_get(reduced, _E), l_real), multiply(_get(reduced, _E + 1), l_imaginary))
    n = multiply(_get(reduced, _C), subtract(multiply(_get(reduced, LOAD), q), times(t, work)))
    return n, q, length(l_real, l_imaginary)


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def _ratio(numerator, size):
    """|numerator| / size for size >= 0; the upper end is infinite where size may be 0."""
    low, high = absolute(numerator)
    return max(below(low / size[1]), 0.0), above(high / size[0]) if size[0] > 0.0 else math.inf


@kernel(types.UniTuple(INTERVAL, 2)(MATRIX, _F), inner=True)
def _scaled_at(reduced, t):
    """phi and beta at one gain."""
    n, q, size = numerators_at(reduced, t)
    return _ratio(n, size), _ratio(multiply(_get(reduced, GAP), q), size)


@kernel(types.UniTuple(INTERVAL, 2)(MATRIX, _F, _F), inner=True)
def gain_at(reduced, t, guess):
    """h(t) at one gain, and the near flank's cosine there; `guess` as in `solver.enumeration.contact_law.gain_over`.

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
    gain, cosine = gain_over(phi, beta, guess, 0.0)
    return subtract(gain, exact(t)), cosine


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
    force, gap = 0.5 * (phi[0] + phi[1]), 0.5 * (beta[0] + beta[1])
    if force >= 1.0:
        return 1.0 - t, guess
    cosine = min(gap, 1.0)
    if force > 0.0:
        cosine = near_cosine(force, gap, guess, 0.0)[0]
    return contact_law(cosine, gap)[1] - t, cosine


@kernel(INTERVAL(MATRIX, types.int64, types.int64, INTERVAL, INTERVAL, _F, INTERVAL), inline=True)
def _quadratic_over(reduced, first, second, at_left, at_right, left, width):
    """Range of a quadratic over an interval, from its values at the ends: the hull of its Bernstein coefficients."""
    slope = add(_get(reduced, first), times(2.0 * left, _get(reduced, second)))
    middle = add(at_left, multiply(times(0.5, width), slope))
    return hull(hull(at_left, at_right), middle)


@kernel(types.UniTuple(INTERVAL, 2)(MATRIX, types.int64, _F), inline=True)
def _cubic_at(reduced, row, t):
    """Value and slope of a cubic at one gain."""
    a_0, a_1, a_2, a_3 = _get(reduced, row), _get(reduced, row + 1), _get(reduced, row + 2), _get(reduced, row + 3)
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


@kernel(INTERVAL(MATRIX, INTERVAL, INTERVAL, _F, _F), inner=True)
def _size_over(reduced, at_left, at_right, left, right):
    """Range of |l| over an interval: l runs along a straight line of the complex plane at constant speed."""
    speed, largest = _get(reduced, _SPEED), max(at_left[1], at_right[1])
    squared = square(speed)
    if add(_get(reduced, _APPROACH), times(left, squared))[0] >= 0.0:
        return at_left[0], largest
    if add(_get(reduced, _APPROACH), times(right, squared))[1] <= 0.0:
        return at_right[0], largest
    # The foot of the perpendicular from 0 may lie between; nearer than the ends by what l moves it does not.
    reach = above(speed[1] * above(0.5 * above(right - left)))
    return max(_get(reduced, _CLOSEST)[0], max(below(min(at_left[0], at_right[0]) - reach), 0.0)), largest


@kernel(types.UniTuple(INTERVAL, 3)(MATRIX, _F, _F), inner=True)
def _numerators_over(reduced, left, right):
    """n, q and |l| over an interval of gains."""
    n_left, q_left, l_left = numerators_at(reduced, left)
    n_right, q_right, l_right = numerators_at(reduced, right)
    width = subtract(exact(right), exact(left))
    return (
        _quadratic_over(reduced, _N_1, _N_2, n_left, n_right, left, width),
        _quadratic_over(reduced, _Q_1, _Q_2, q_left, q_right, left, width),
        _size_over(reduced, l_left, l_right, left, right),
    )


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
    n_left, q_left, l_left = numerators_at(reduced, left)
    n_right, q_right, l_right = numerators_at(reduced, right)
    width, gap = subtract(exact(right), exact(left)), _get(reduced, GAP)
    n = _quadratic_over(reduced, _N_1, _N_2, n_left, n_right, left, width)
    q = _quadratic_over(reduced, _Q_1, _Q_2, q_left, q_right, left, width)
    size = _size_over(reduced, l_left, l_right, left, right)
    phi, beta = _ratio(n, size), _ratio(multiply(gap, q), size)
    if not size[0] > 1.0 / _LARGEST:
        return phi, beta, (0.0, 0.0), (0.0, 0.0), False

    cube = multiply(size, square(size))
    by_force = divide(_cubic_over(reduced, _FORCE, left, right, width), cube)
    by_gap = multiply(gap, divide(_cubic_over(reduced, _GAP, left, right, width), cube))
    if not max(absolute(by_force)[1], absolute(by_gap)[1]) < _STEEPEST:
        return phi, beta, (0.0, 0.0), (0.0, 0.0), False
    # The slopes of |n| and |q| follow the sign of n and q; where that changes they have a kink.
    sign = 1 if n[0] > 0.0 else (-1 if n[1] < 0.0 else 0)
    if left == 0.0 and reduced[LOAD, 0] == 0.0:
        # Without mean load n(0) = 0, so that n has the sign of its slope.
        n_slope = add(_get(reduced, _N_1), multiply(times(2.0, (left, right)), _get(reduced, _N_2)))
        sign = 1 if n_slope[0] > 0.0 else (-1 if n_slope[1] < 0.0 else 0)
    if sign < 0:
        by_force = -by_force[1], -by_force[0]
    elif sign == 0:
        by_force = symmetric(absolute(by_force)[1])
    if q[1] < 0.0:
        by_gap = -by_gap[1], -by_gap[0]
    elif not q[0] > 0.0:
        by_gap = symmetric(absolute(by_gap)[1])
    phi = _between(phi, _ratio(n_left, l_left), _ratio(n_right, l_right), by_force, width[1])
    ends = _ratio(multiply(gap, q_left), l_left), _ratio(multiply(gap, q_right), l_right)
    beta = _between(beta, ends[0], ends[1], by_gap, width[1])
    return phi, beta, by_force, by_gap, True


@kernel(types.Tuple((INTERVAL, INTERVAL, INTERVAL, types.boolean))(MATRIX, _F, _F, _F), inner=True)
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
    phi, gain : interval
        Mean force over amplitude, and N.
    slope : interval
        Generalised derivative of h; without bounds where N alone excludes a root.
    regular : bool
        Whether l does not vanish, so that h is continuous and `slope` holds.
    """
    phi, beta, by_force, by_gap, regular = _scaled_over(reduced, left, right)
    # What the bounds lose by being solved for to this share of the interval is not felt.
    slack = _SLACK * (right - left)
    gain, cosine = gain_over(phi, beta, guess, slack)
    if not regular or phi[0] >= 1.0 or gain[0] > right or gain[1] < left:
        return phi, gain, (-math.inf, math.inf), regular
    law_force, law_gap = gain_slopes(phi, beta, cosine, slack)
    slope = add(multiply(law_force, by_force), multiply(law_gap, by_gap))
    return phi, gain, subtract(slope, exact(1.0)), True


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
    for row in (_FORCE, _GAP):
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


@kernel(INTERVAL(MATRIX, _F, _F), inner=True)
def determinant_over(reduced, left, right):
    """Range of q over an interval of gains, with the common factor.

    Parameters
    ----------
    reduced : (ROWS, 2) array
        From `reduce_balance`.
    left, right : float
        Ends of the interval of gains.
    """
    q = _numerators_over(reduced, left, right)[1]
    return q if reduced[_FACTORED, 0] == 0.0 else square(q)


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
    n, q, size = _numerators_over(reduced, left, right)
    if not (q[0] > 0.0 or q[1] < 0.0):
        least = below(size[0] / above(absolute(q)[1]))
        everything = -math.inf, math.inf
        return everything, everything, everything, (max(least, 0.0), math.inf)
    amplitude, force, gap = divide(size, absolute(q)), divide(n, q), _get(reduced, GAP)
    # Mean displacement on the side of the force: b - a cos theta_+, or b plus the force if contact is never lost.
    mean, phi = (math.inf, -math.inf), _ratio(n, size)
    if phi[0] < 1.0:
        cosine = gain_over(phi, _ratio(multiply(gap, q), size), guess, 0.0)[1]
        mean = hull(mean, subtract(gap, multiply(amplitude, cosine)))
    if not phi[1] < 1.0:
        mean = hull(mean, add(gap, absolute(force)))
    mean = max(mean[0], 0.0), mean[1]
    if force[1] < 0.0:
        mean = -mean[1], -mean[0]
    elif not force[0] > 0.0:
        mean = symmetric(mean[1])
    l_left, l_right = _l_at(reduced, left), _l_at(reduced, right)
    l_real, l_imaginary = hull(l_left[0], l_right[0]), hull(l_left[1], l_right[1])
    l_imaginary = -l_imaginary[1], -l_imaginary[0]
    return mean, divide(l_real, q), divide(l_imaginary, q), amplitude
