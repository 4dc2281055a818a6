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
"""

import math

from solver.enumeration.coefficients import enclosed_coefficients
from solver.enumeration.contact_law import LAW, gain_over
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
    length,
    multiply,
    square,
    subtract,
    symmetric,
)
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.condensation import F_PM, B

__all__ = [
    "GAP",
    "LOAD",
    "ROWS",
    "determinant_over",
    "gain_at",
    "motion_over",
    "numerators_at",
    "reduce_balance",
    "slope_over",
]

_F = types.float64

# Rows (low, high) of the array that holds a reduced balance.
_D, _A, _Q, _L_0, _L_1, _E = 0, 2, 4, 5, 7, 9
_C, LOAD, GAP, _Q_1, _Q_2, _N_1, _N_2, _FORCE, _GAP = 11, 12, 13, 14, 15, 16, 17, 18, 22
ROWS = 26

# Reduced coefficients must lie below the first, so that no product of them overflows, and the amplitude's numerator
# above its inverse; slopes must lie below the second.
_LARGEST, _STEEPEST = 1e40, 1e100


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


@kernel(types.boolean(ARRAY, ARRAY, _F, MATRIX), inner=True)
def reduce_balance(theta, direction, p, reduced):
    """Fill `reduced` (ROWS, 2) with the reduced balance at one axis value; False if it is not finite or D may be 0.

    Parameters
    ----------
    theta, direction : (34,) arrays
    p : float
        Axis value.
    reduced : (ROWS, 2) array
        Read by the other kernels of this module.
    """
    values, c = enclosed_coefficients(theta, direction, p)
    D, A, P_1, P_2, F, e = values
    load = exact(theta[F_PM] + p * direction[F_PM])
    per_c = divide(exact(1.0), c)
    half = multiply(exact(0.5), per_c)
    A = complex_subtract(A, complex_scale(half, complex_multiply(P_1, complex_conjugate(e))))
    Q = complex_subtract(P_2, complex_scale(half, complex_multiply(P_1, e)))
    G = complex_subtract(F, complex_scale(multiply(load, per_c), P_1))
    L_0 = complex_multiply(complex_conjugate(D), G)
    L_1 = complex_subtract(complex_multiply(complex_conjugate(A), G), complex_multiply(Q, complex_conjugate(G)))
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
    _put(reduced, GAP, exact(theta[B] + p * direction[B]))

    q_0 = add(square(D[0]), square(D[1]))
    q_1 = multiply(exact(2.0), add(multiply(D[0], A[0]), multiply(D[1], A[1])))
    q_2 = subtract(add(square(A[0]), square(A[1])), Q_squared)
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
    _put_cubic(reduced, _FORCE, n_0, n_1, n_2, r_0, r_1, r_2)
    _put_cubic(reduced, _GAP, q_0, q_1, q_2, r_0, r_1, r_2)
    for row in range(_FORCE):
        for side in range(2):
            if not abs(reduced[row, side]) < _LARGEST:
                return False
    return q_0[0] > 0.0


@kernel(types.UniTuple(INTERVAL, 2)(MATRIX, INTERVAL), inner=True)
def _l_over(reduced, t):
    """Real and imaginary part of l over an interval of gains."""
    return (
        add(_get(reduced, _L_0), multiply(t, _get(reduced, _L_1))),
        add(_get(reduced, _L_0 + 1), multiply(t, _get(reduced, _L_1 + 1))),
    )


@kernel(types.UniTuple(INTERVAL, 3)(MATRIX, INTERVAL), inner=True)
def numerators_at(reduced, t):
    """n, q and |l| at one gain; q is summed so that no digits cancel at a resonance."""
    X_real = add(_get(reduced, _D), multiply(t, _get(reduced, _A)))
    X_imaginary = add(_get(reduced, _D + 1), multiply(t, _get(reduced, _A + 1)))
    q = add(square(X_real), square(X_imaginary))
    q = subtract(q, multiply(square(t), _get(reduced, _Q)))
    l_real, l_imaginary = _l_over(reduced, t)
    work = add(multiply(_get(reduced, _E), l_real), multiply(_get(reduced, _E + 1), l_imaginary))
    n = multiply(_get(reduced, _C), subtract(multiply(_get(reduced, LOAD), q), multiply(t, work)))
    return n, q, length(l_real, l_imaginary)


@kernel(INTERVAL(INTERVAL, INTERVAL), inline=True)
def _ratio(numerator, size):
    """|numerator| / size for size >= 0; the upper end is infinite where size may be 0."""
    low, high = absolute(numerator)
    return max(below(low / size[1]), 0.0), above(high / size[0]) if size[0] > 0.0 else math.inf


@kernel(types.Tuple((INTERVAL, LAW))(MATRIX, _F, _F), inner=True)
def gain_at(reduced, t, guess):
    """h(t) at one gain, and the contact law there; `guess` as in `solver.enumeration.contact_law.gain_over`."""
    n, q, size = numerators_at(reduced, exact(t))
    phi, beta = _ratio(n, size), _ratio(multiply(_get(reduced, GAP), q), size)
    law = gain_over(phi, beta, guess)
    return subtract(law[0], exact(t)), law


@kernel(INTERVAL(MATRIX, types.int64, types.int64, INTERVAL, INTERVAL, INTERVAL, _F), inline=True)
def _quadratic_over(reduced, first, second, t, ends, middle, radius):
    """Range of a quadratic: the hull `ends` of its end values if it is monotone, else by its slope around `middle`."""
    slope = add(_get(reduced, first), multiply(multiply(exact(2.0), t), _get(reduced, second)))
    if slope[0] > 0.0 or slope[1] < 0.0:
        return ends
    return add(middle, multiply(slope, symmetric(radius)))


@kernel(INTERVAL(MATRIX, types.int64, _F, _F), inner=True)
def _cubic_over(reduced, row, center, radius):
    """Range of a cubic over center +- radius, from its Taylor polynomial at the center."""
    t = exact(center)
    a_0, a_1, a_2, a_3 = _get(reduced, row), _get(reduced, row + 1), _get(reduced, row + 2), _get(reduced, row + 3)
    value = add(a_0, multiply(t, add(a_1, multiply(t, add(a_2, multiply(t, a_3))))))
    three = multiply(exact(3.0), a_3)
    slope = add(a_1, multiply(t, add(multiply(exact(2.0), a_2), multiply(t, three))))
    curvature = add(a_2, multiply(t, three))
    reach = absolute(slope)[1] + radius * (absolute(curvature)[1] + radius * absolute(a_3)[1])
    return add(value, symmetric(above(above(above(reach * radius)))))


@kernel(types.Tuple((INTERVAL, INTERVAL, INTERVAL, INTERVAL, types.boolean))(MATRIX, _F, _F, _F), inner=True)
def _scaled_over(reduced, left, center, right):
    """phi, beta and their slopes over [left, right]; False (and no slopes) where l may vanish."""
    t, radius = (left, right), above(max(right - center, center - left))
    n_left, q_left, l_left = numerators_at(reduced, exact(left))
    n_center, q_center, l_center = numerators_at(reduced, exact(center))
    n_right, q_right, l_right = numerators_at(reduced, exact(right))
    n = _quadratic_over(reduced, _N_1, _N_2, t, hull(n_left, n_right), n_center, radius)
    q = _quadratic_over(reduced, _Q_1, _Q_2, t, hull(q_left, q_right), q_center, radius)

    # |l| is convex: largest at an end, and above its tangent at the center.
    l_real, l_imaginary = _l_over(reduced, exact(center))
    slope = add(multiply(l_real, _get(reduced, _L_1)), multiply(l_imaginary, _get(reduced, _L_1 + 1)))
    size = 0.0, max(l_left[1], l_right[1])
    if l_center[0] > 0.0:
        slope = divide(slope, l_center)
        size = max(below(l_center[0] - above(absolute(slope)[1] * radius)), 0.0), size[1]
    gap = _get(reduced, GAP)
    phi, beta = _ratio(n, size), _ratio(multiply(gap, q), size)
    if not size[0] > 1.0 / _LARGEST:
        return phi, beta, (0.0, 0.0), (0.0, 0.0), False

    cube = multiply(size, square(size))
    by_force = divide(_cubic_over(reduced, _FORCE, center, radius), cube)
    by_gap = multiply(gap, divide(_cubic_over(reduced, _GAP, center, radius), cube))
    if not max(absolute(by_force)[1], absolute(by_gap)[1]) < _STEEPEST:
        return phi, beta, (0.0, 0.0), (0.0, 0.0), False
    # The slopes of |n| and |q| follow the sign of n and q; where that changes they have a kink.
    sign = 1 if n[0] > 0.0 else (-1 if n[1] < 0.0 else 0)
    if left == 0.0 and reduced[LOAD, 0] == 0.0:
        # Without mean load n(0) = 0, so that n has the sign of its slope.
        n_slope = add(_get(reduced, _N_1), multiply(multiply(exact(2.0), t), _get(reduced, _N_2)))
        sign = 1 if n_slope[0] > 0.0 else (-1 if n_slope[1] < 0.0 else 0)
    if sign < 0:
        by_force = -by_force[1], -by_force[0]
    elif sign == 0:
        by_force = symmetric(absolute(by_force)[1])
    if q[1] < 0.0:
        by_gap = -by_gap[1], -by_gap[0]
    elif not q[0] > 0.0:
        by_gap = symmetric(absolute(by_gap)[1])
    if by_force[0] > 0.0 or by_force[1] < 0.0:
        phi = hull(_ratio(n_left, l_left), _ratio(n_right, l_right))
    if by_gap[0] > 0.0 or by_gap[1] < 0.0:
        beta = hull(_ratio(multiply(gap, q_left), l_left), _ratio(multiply(gap, q_right), l_right))
    return phi, beta, by_force, by_gap, True


@kernel(types.Tuple((INTERVAL, INTERVAL, INTERVAL, types.boolean))(MATRIX, _F, _F, _F, _F), inner=True)
def slope_over(reduced, left, center, right, guess):
    """What h does over an interval of gains.

    Parameters
    ----------
    reduced : (ROWS, 2) array
    left, center, right : float
        The interval and a place inside it.
    guess : float
        The near flank's cosine somewhere in it, or nan.

    Returns
    -------
    phi, gain : interval
        Mean force over amplitude, and N.
    slope : interval
        Generalised derivative of h.
    regular : bool
        Whether l does not vanish, so that h is continuous and `slope` holds.
    """
    phi, beta, by_force, by_gap, regular = _scaled_over(reduced, left, center, right)
    gain, law_force, law_gap, _cosine = gain_over(phi, beta, guess)
    if not regular:
        return phi, gain, (0.0, 0.0), False
    slope = add(multiply(law_force, by_force), multiply(law_gap, by_gap))
    return phi, gain, subtract(slope, exact(1.0)), True


@kernel(INTERVAL(MATRIX, _F, _F), inner=True)
def determinant_over(reduced, left, right):
    """Range of q over an interval of gains."""
    center = 0.5 * (left + right)
    ends = hull(numerators_at(reduced, exact(left))[1], numerators_at(reduced, exact(right))[1])
    middle = numerators_at(reduced, exact(center))[1]
    return _quadratic_over(reduced, _Q_1, _Q_2, (left, right), ends, middle, above(0.5 * (right - left)))


@kernel(types.UniTuple(INTERVAL, 4)(MATRIX, _F, _F, _F), inner=True)
def motion_over(reduced, left, right, guess):
    """lambda_m, lambda_c, lambda_s, lambda_a of all solutions with gain in [left, right]; infinite where q may be 0."""
    center = min(max(0.5 * (left + right), left), right)
    phi, beta, _by_force, _by_gap, _regular = _scaled_over(reduced, left, center, right)
    cosine = gain_over(phi, beta, guess)[3]
    q = determinant_over(reduced, left, right)
    l_left, l_right = numerators_at(reduced, exact(left))[2], numerators_at(reduced, exact(right))[2]
    l_real, l_imaginary = _l_over(reduced, (left, right))
    size = length(l_real, l_imaginary)
    size = size[0], min(size[1], max(l_left[1], l_right[1]))
    if not (q[0] > 0.0 or q[1] < 0.0):
        least = below(size[0] / above(absolute(q)[1]))
        everything = -math.inf, math.inf
        return everything, everything, everything, (max(least, 0.0), math.inf)
    amplitude = divide(size, absolute(q))
    gap = _get(reduced, GAP)
    n = numerators_at(reduced, exact(center))[0]
    ends = hull(numerators_at(reduced, exact(left))[0], numerators_at(reduced, exact(right))[0])
    n = _quadratic_over(reduced, _N_1, _N_2, (left, right), ends, n, above(max(right - center, center - left)))
    force = divide(n, q)
    # Mean displacement on the side of the force: b - a cos theta_+, or b plus the force if contact is never lost.
    mean = math.inf, -math.inf
    if phi[0] < 1.0:
        mean = hull(mean, subtract(gap, multiply(amplitude, cosine)))
    if not phi[1] < 1.0:
        mean = hull(mean, add(gap, absolute(force)))
    mean = max(mean[0], 0.0), mean[1]
    if force[1] < 0.0:
        mean = -mean[1], -mean[0]
    elif not force[0] > 0.0:
        mean = symmetric(mean[1])
    l_imaginary = -l_imaginary[1], -l_imaginary[0]
    return mean, divide(l_real, q), divide(l_imaginary, q), amplitude
