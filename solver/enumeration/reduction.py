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

Springs that hold lambda besides the contact add D_0 lambda_m to the mean row. Written with g_0 = f_0 + kappa lambda_m,
kappa = D_0/c, in the place of f_0 the balance is the same, as long as f_0 acts in the mean row alone: P_1 = e = 0. The
contact law is another one then (`solver.enumeration.contact_law`), motions without contact are roots t = 0 of a fixed
mean, and the determinant is -c q (chi + kappa) h'(t). Of a contact with one flank phi is n/q / |L|, with its sign.

Without any damping, and if Q and e are 0 as well, D + t A' is real and a common factor of q, l and n, which all
vanish with it. It is left out then: q = D + t A', l = G and n = f_pm q/c describe the same motions, and the determinant
is that above with q^2 in place of q.
"""

from solver.enumeration.enclosed import FACTORED, HALF_GAP, LAW_ROW, MEAN_GAIN, MEAN_LOAD, complex_of, interval_of, put
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
    times,
)
from solver.kernels import types
from solver.kernels.compile import MATRIX, kernel

__all__ = [
    "CONTACT",
    "FORCE_SLOPE",
    "GAP",
    "GAP_SLOPE",
    "LARGEST",
    "LOAD",
    "N_1",
    "N_2",
    "ROWS",
    "determinant_over",
    "is_modulated",
    "l_at",
    "numerators_at",
    "numerators_over",
    "reduce_balance",
]

_F, _I = types.float64, types.int64

# Rows (low, high) of the array that holds a reduced balance. Four rows from `FORCE_SLOPE` and `GAP_SLOPE` on are the
# cubics |l|^3 phi' and |l|^3 beta'/b.
_D, _A, _Q, _L_0, _L_1, _E = 0, 2, 4, 5, 7, 9
_C, LOAD, GAP, _Q_1, _Q_2, N_1, N_2, FORCE_SLOPE, GAP_SLOPE = 11, 12, 13, 14, 15, 16, 17, 18, 22
# l = l_0 + t l_1: |l_1|, Re(l_1 conj l_0) and how close the straight line comes to 0.
_SPEED, _APPROACH, _CLOSEST = 26, 27, 28
# 1 where the common factor is left out, else 0.
_FACTORED = 29
#: The contact law, as in `solver.enumeration.enclosed`.
CONTACT = 30
ROWS = 32

#: Reduced coefficients must lie below it, so that no product of them overflows, and the amplitude's numerator above its
#: inverse.
LARGEST = 1e40


@kernel(types.void(MATRIX, types.int64, INTERVAL, INTERVAL, INTERVAL, INTERVAL, INTERVAL, INTERVAL), inner=True)
def _put_cubic(reduced, row, n_0, n_1, n_2, r_0, r_1, r_2):
    """n' r - n r'/2 for n = n_0 + n_1 t + n_2 t^2 and r likewise: r^(3/2) times the slope of n/sqrt(r)."""
    half = multiply(exact(0.5), r_1)
    put(reduced, row, subtract(multiply(n_1, r_0), multiply(n_0, half)))
    middle = add(multiply(n_1, half), multiply(exact(2.0), multiply(n_2, r_0)))
    put(reduced, row + 1, subtract(middle, multiply(n_0, r_2)))
    put(reduced, row + 2, multiply(exact(3.0), multiply(n_2, half)))
    put(reduced, row + 3, multiply(n_2, r_2))


@kernel(types.boolean(MATRIX, MATRIX), inner=True)
def reduce_balance(enclosed, reduced):
    """Fill `reduced` (ROWS, 2) with the reduced balance at one point; False if it is not finite or D may be 0.

    Parameters
    ----------
    enclosed : (SLOTS, 2) array
        Of `solver.enumeration.enclosed`.
    reduced : (ROWS, 2) array
        Read by the other kernels of this module.
    """
    D, A, P_1 = complex_of(enclosed, 0), complex_of(enclosed, 2), complex_of(enclosed, 4)
    P_2, F, e = complex_of(enclosed, 6), complex_of(enclosed, 8), complex_of(enclosed, 10)
    c, load = interval_of(enclosed, MEAN_GAIN), interval_of(enclosed, MEAN_LOAD)
    per_c = divide(exact(1.0), c)
    half = multiply(exact(0.5), per_c)
    A = complex_subtract(A, complex_scale(half, complex_multiply(P_1, complex_conjugate(e))))
    Q = complex_subtract(P_2, complex_scale(half, complex_multiply(P_1, e)))
    G = complex_subtract(F, complex_scale(multiply(load, per_c), P_1))
    L_0 = complex_multiply(complex_conjugate(D), G)
    L_1 = complex_subtract(complex_multiply(complex_conjugate(A), G), complex_multiply(Q, complex_conjugate(G)))
    factored, zero = enclosed[FACTORED, 0] != 0.0, (0.0, 0.0)
    if factored:
        L_0, L_1 = G, (zero, zero)
    put(reduced, _FACTORED, exact(1.0 if factored else 0.0))
    for i in range(2):
        put(reduced, _D + i, D[i])
        put(reduced, _A + i, A[i])
        put(reduced, _L_0 + i, L_0[i])
        put(reduced, _L_1 + i, L_1[i])
        put(reduced, _E + i, e[i])
    Q_squared = add(square(Q[0]), square(Q[1]))
    put(reduced, _Q, Q_squared)
    put(reduced, _C, per_c)
    put(reduced, LOAD, load)
    put(reduced, GAP, interval_of(enclosed, HALF_GAP))
    put(reduced, CONTACT, interval_of(enclosed, LAW_ROW))
    put(reduced, CONTACT + 1, interval_of(enclosed, LAW_ROW + 1))

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
    put(reduced, _Q_1, q_1)
    put(reduced, _Q_2, q_2)
    put(reduced, N_1, n_1)
    put(reduced, N_2, n_2)
    speed, cross = length(L_1[0], L_1[1]), subtract(multiply(L_0[0], L_1[1]), multiply(L_0[1], L_1[0]))
    put(reduced, _SPEED, speed)
    put(reduced, _APPROACH, multiply(exact(0.5), r_1))
    closest = divide(absolute(cross), speed)
    put(reduced, _CLOSEST, closest if closest[0] > 0.0 else (0.0, 0.0))
    _put_cubic(reduced, FORCE_SLOPE, n_0, n_1, n_2, r_0, r_1, r_2)
    _put_cubic(reduced, GAP_SLOPE, q_0, q_1, q_2, r_0, r_1, r_2)
    for row in range(FORCE_SLOPE):
        for side in range(2):
            if not abs(reduced[row, side]) < LARGEST:
                return False
    return q_0[0] > 0.0 or q_0[1] < 0.0


@kernel(types.UniTuple(INTERVAL, 2)(MATRIX, _F), inline=True)
def l_at(reduced, t):
    """Real and imaginary part of l at one gain."""
    return (
        add(interval_of(reduced, _L_0), times(t, interval_of(reduced, _L_1))),
        add(interval_of(reduced, _L_0 + 1), times(t, interval_of(reduced, _L_1 + 1))),
    )


@kernel(types.UniTuple(INTERVAL, 3)(MATRIX, _F), inner=True)
def numerators_at(reduced, t):
    """n, q and |l| at one gain; q is summed so that no digits cancel at a resonance."""
    X_real = add(interval_of(reduced, _D), times(t, interval_of(reduced, _A)))
    X_imaginary = add(interval_of(reduced, _D + 1), times(t, interval_of(reduced, _A + 1)))
    q = X_real
    if reduced[_FACTORED, 0] == 0.0:
        q = add(square(X_real), square(X_imaginary))
        q = subtract(q, times(t, times(t, interval_of(reduced, _Q))))
    l_real, l_imaginary = l_at(reduced, t)
    work = add(multiply(interval_of(reduced, _E), l_real), multiply(interval_of(reduced, _E + 1), l_imaginary))
    n = multiply(interval_of(reduced, _C), subtract(multiply(interval_of(reduced, LOAD), q), times(t, work)))
    return n, q, length(l_real, l_imaginary)


@kernel(INTERVAL(MATRIX, types.int64, types.int64, INTERVAL, INTERVAL, _F, INTERVAL), inline=True)
def _quadratic_over(reduced, first, second, at_left, at_right, left, width):
    """Range of a quadratic over an interval, from its values at the ends: the hull of its Bernstein coefficients."""
    slope = add(interval_of(reduced, first), times(2.0 * left, interval_of(reduced, second)))
    middle = add(at_left, multiply(times(0.5, width), slope))
    return hull(hull(at_left, at_right), middle)


@kernel(INTERVAL(MATRIX, INTERVAL, INTERVAL, _F, _F), inner=True)
def _size_over(reduced, at_left, at_right, left, right):
    """Range of |l| over an interval: l runs along a straight line of the complex plane at constant speed."""
    speed, largest = interval_of(reduced, _SPEED), max(at_left[1], at_right[1])
    squared = square(speed)
    if add(interval_of(reduced, _APPROACH), times(left, squared))[0] >= 0.0:
        return at_left[0], largest
    if add(interval_of(reduced, _APPROACH), times(right, squared))[1] <= 0.0:
        return at_right[0], largest
    # The foot of the perpendicular from 0 may lie between; nearer than the ends by what l moves it does not.
    reach = above(speed[1] * above(0.5 * above(right - left)))
    return max(interval_of(reduced, _CLOSEST)[0], max(below(min(at_left[0], at_right[0]) - reach), 0.0)), largest


@kernel(types.UniTuple(types.UniTuple(INTERVAL, 3), 3)(MATRIX, _F, _F), inner=True)
def numerators_over(reduced, left, right):
    """n, q and |l| over an interval of gains, at its left end and at its right end.

    Parameters
    ----------
    reduced : (ROWS, 2) array
        From `reduce_balance`.
    left, right : float
        Ends of the interval.
    """
    n_left, q_left, l_left = numerators_at(reduced, left)
    n_right, q_right, l_right = numerators_at(reduced, right)
    width = subtract(exact(right), exact(left))
    n = _quadratic_over(reduced, N_1, N_2, n_left, n_right, left, width)
    q = _quadratic_over(reduced, _Q_1, _Q_2, q_left, q_right, left, width)
    size = _size_over(reduced, l_left, l_right, left, right)
    return (n, q, size), (n_left, q_left, l_left), (n_right, q_right, l_right)


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
    q = numerators_over(reduced, left, right)[0][1]
    return q if reduced[_FACTORED, 0] == 0.0 else square(q)


@kernel(types.boolean(MATRIX), inner=True)
def is_modulated(reduced):
    """Whether the stiffness varies in the mean row: e is not exactly 0."""
    return reduced[_E, 0] != 0.0 or reduced[_E, 1] != 0.0 or reduced[_E + 1, 0] != 0.0 or reduced[_E + 1, 1] != 0.0
