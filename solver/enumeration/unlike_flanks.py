"""Proven bounds of the law of `solver.enumeration.contact_law` where the two flanks are unlike, 0 < r < 1.

The near flank is the stiffer one, whatever the side of the force, and phi and nu have either sign. What the far flank
adds has the factor r, so that phi grows with nu at the rate (theta_+ + r theta_-)/pi + kappa,

    dN/dphi  = 2 (sin theta_+ - r sin theta_-)/(theta_+ + r theta_- + kappa pi)
    dN/dbeta = -(2/pi) [sin theta_+ (2 r theta_- + kappa pi) + r sin theta_- (2 theta_+ + kappa pi)]
               / (theta_+ + r theta_- + kappa pi)                                                                <= 0

and the angles move as before. N now falls with phi as long as sin theta_+ < r sin theta_-, from r at phi <= -r - kappa
(1 + beta), and grows beyond: where both flanks are touched, (sin theta_+)^2 - (r sin theta_-)^2 is a quadratic in nu
whose roots have different signs, so that it changes its sign once, and where one is touched the sign is that flank's.
Over a rectangle N is largest at one of the two corners of the smallest beta; its least value is that of a corner where
the slope has one sign along the largest beta, and elsewhere no less than that of the smallest angles. N is at most 1.
"""

import math

from solver.enumeration.contact_law import LAW, contact_arc, largest_gain, smallest_gain
from solver.enumeration.interval import INTERVAL
from solver.kernels import types
from solver.kernels.compile import kernel

__all__ = ["sine_over", "unlike_gain_over"]

_F = types.float64
_U = 2.0**-53


@kernel(INTERVAL(_F, _F), inline=True)
def sine_over(low, high):
    """sin over [low, high] within [0, pi]."""
    left, right = math.sin(low), math.sin(high)
    top = 1.0 if low <= 0.5 * math.pi <= high else max(left, right)
    return max(min(left, right) - 4.0 * _U, 0.0), min(top + 4.0 * _U, 1.0)


@kernel(INTERVAL(INTERVAL), inline=True)
def _sine_of(cosines):
    """Bounds of the sine over an interval of cosines, clipped to [-1, 1]."""
    low, high = contact_arc(cosines[1])[0] * (1.0 - 4.0 * _U), contact_arc(cosines[0])[0] * (1.0 + 4.0 * _U)
    if cosines[0] >= 1.0 or cosines[1] <= -1.0:
        return 0.0, 0.0
    sines = sine_over(low, min(high, math.pi))
    return (0.0 if high >= math.pi else sines[0]), sines[1]


@kernel(INTERVAL(_F), inline=True)
def _share(cosine):
    """Bounds of (theta - sin theta cos theta)/pi, what one flank adds to N."""
    if cosine >= 1.0:
        return 0.0, 0.0
    if cosine <= -1.0:
        return 1.0, 1.0
    angle, sine = contact_arc(cosine)
    value, error = (angle - sine * cosine) / math.pi, 16.0 * _U / math.pi * angle + 1e-22
    return max(value - error, 0.0), min(value + error, 1.0)


@kernel(types.UniTuple(_F, 2)(_F, _F), inline=True)
def _far_cosines(beta, cosine):
    """Below and above the far flank's cosine 2 beta - cosine."""
    value = 2.0 * beta - cosine
    margin = 4.0 * _U * (2.0 * abs(beta) + abs(cosine))
    return value - margin, value + margin


@kernel(types.UniTuple(INTERVAL, 2)(_F, _F, LAW, _F), inner=True)
def _unlike_at(phi, beta, law, slack):
    """Bounds of both flanks' cosines at (phi, beta)."""
    low = largest_gain(phi, beta, law, math.nan, slack)[0]
    high = smallest_gain(phi, beta, law, math.nan, slack)[0]
    return (low, high), (_far_cosines(beta, high)[0], _far_cosines(beta, low)[1])


@kernel(types.UniTuple(INTERVAL, 3)(_F, _F, _F, _F, LAW, _F), inner=True)
def unlike_gain_over(phi_low, phi_high, beta_low, beta_high, law, slack):
    """N and both flanks' cosines over a rectangle of unlike flanks; see the module."""
    # Of every corner the bounds of both cosines: of the smallest beta, and of the largest.
    (near_0, far_0), (near_1, far_1) = (
        _unlike_at(phi_low, beta_low, law, slack),
        _unlike_at(phi_high, beta_low, law, slack),
    )
    (near_2, far_2), (near_3, far_3) = (
        _unlike_at(phi_low, beta_high, law, slack),
        _unlike_at(phi_high, beta_high, law, slack),
    )
    up, down = law[2] * (1.0 + 4.0 * _U), law[2] * (1.0 - 4.0 * _U)
    most = max(_share(near_0[0])[1] + up * _share(far_0[0])[1], _share(near_1[0])[1] + up * _share(far_1[0])[1])
    # Along the largest beta: where N certainly grows from the left end on, or falls down to the right one.
    near, far = near_2[1], far_3[1]
    left, left_far = _sine_of(near_2), _sine_of(far_2)
    right, right_far = _sine_of(near_3), _sine_of(far_3)
    if left[0] > up * left_far[1]:
        far = far_2[1]
    elif right[1] < down * right_far[0]:
        near = near_3[1]
    least = _share(near)[0] + down * _share(far)[0]
    gain = max(least * (1.0 - 4.0 * _U), 0.0), min(most * (1.0 + 4.0 * _U), 1.0)
    if law[0] == 0.0 and phi_low >= 1.0:
        gain = 1.0, 1.0
    near_cosines = min(near_0[0], near_1[0], near_2[0], near_3[0]), max(near_0[1], near_1[1], near_2[1], near_3[1])
    return gain, near_cosines, (min(far_0[0], far_2[0]), max(far_1[1], far_3[1]))
