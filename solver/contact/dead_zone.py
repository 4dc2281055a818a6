"""Dead-zone contact force of a gear mesh with backlash and its describing functions.

The dead zone is f(x) = x - b for x > b, 0 for |x| <= b, x + b for x < -b. For x(theta) = mean + amplitude cos(theta)
its mean and fundamental follow in closed form from the two angles at which x crosses +b and -b
(docs/physics.md, section 4; the article's N_m, N_a, G and H).
"""

import math

import numpy as np

from solver.kernels import types
from solver.kernels.compile import kernel

__all__ = ["contact_functions", "dead_zone", "describing_functions", "force_and_gain"]

_F = types.float64


def dead_zone(displacement, b):
    """Contact deformation f of a symmetric gap of half width `b`.

    Parameters
    ----------
    displacement : array_like
        Displacement along the line of action, in units of the reference length.
    b : float
        Half backlash, b >= 0, in the same unit.

    Returns
    -------
    ndarray
        f(displacement), of the shape of `displacement`.

    Examples
    --------
    >>> dead_zone([-1.5, 0.3, 2.0], 1.0)
    array([-0.5,  0. ,  1. ])
    """
    displacement = np.asarray(displacement, dtype=float)
    return np.where(np.abs(displacement) <= b, 0.0, displacement - np.copysign(b, displacement))


def force_and_gain(mean, amplitude, b):
    """The first two numbers of `describing_functions` for arrays; nothing is compiled for it.

    Parameters
    ----------
    mean, amplitude : array_like
        lambda_m and lambda_a >= 0; they broadcast.
    b : float
        Half backlash, b >= 0.

    Returns
    -------
    force, gain : ndarrays
        f_0 and N_a.
    """
    mean = np.asarray(mean, dtype=float)
    ahead, ahead_gain = _flanks(b - mean, amplitude)
    behind, behind_gain = _flanks(-b - mean, amplitude)
    return mean + 0.5 * (ahead - behind), 1.0 - 0.5 * (ahead_gain - behind_gain)


def _flanks(distance, amplitude):
    """The first two numbers of `_flank` for arrays."""
    distance, amplitude = np.broadcast_arrays(np.asarray(distance, dtype=float), np.asarray(amplitude, dtype=float))
    beyond = np.abs(distance) >= amplitude
    mu = np.where(beyond, np.sign(distance), distance / np.where(beyond, 1.0, amplitude))
    root, angle = (2.0 / np.pi) * np.sqrt((1.0 - mu) * (1.0 + mu)), (2.0 / np.pi) * np.arcsin(mu)
    return distance * angle + amplitude * root, angle + mu * root


@kernel(types.UniTuple(_F, 4)(_F, _F), inline=True)
def _flank(distance, amplitude):
    """One flank at signed `distance` from the mean: amplitude * G, H, G' and w at mu = distance / amplitude.

    G(mu) = (2/pi)(mu asin mu + sqrt(1 - mu^2)), H(mu) = (2/pi)(asin mu + mu sqrt(1 - mu^2)) for |mu| <= 1, else |mu|
    and sign(mu). w = (2/pi) sqrt(1 - mu^2) = H'/2 = G - mu G'. Regular at amplitude 0, where mu is infinite.
    """
    if abs(distance) >= amplitude:
        sign = 0.0
        if distance > 0.0:
            sign = 1.0
        elif distance < 0.0:
            sign = -1.0
        return abs(distance), sign, sign, 0.0
    mu = distance / amplitude
    root = (2.0 / math.pi) * math.sqrt((1.0 - mu) * (1.0 + mu))
    angle = (2.0 / math.pi) * math.asin(mu)
    return distance * angle + amplitude * root, angle + mu * root, angle, root


@kernel(types.UniTuple(_F, 8)(_F, _F, _F, _F, _F, _F, _F), inline=True)
def contact_functions(mean, amplitude, front, back, far, d_front, d_back):
    """Mean force and fundamental gain of a contact with two flanks or one, with bounded derivatives.

    f = max(lambda - front, 0) - far max(-lambda - back, 0), each half of it written as (x + |x|)/2.

    Parameters
    ----------
    mean, amplitude : float
        lambda_m and lambda_a >= 0.
    front, back : float
        Gaps, both finite; where far is 0 the back one does not matter.
    far : float
        Stiffness of the back flank over that of the front one: 0 where there is none.
    d_front, d_back : float
        How the gaps move.

    Returns
    -------
    force : float
        f_0, the mean of f (finite at mean = 0, unlike N_m lambda_m written as a product).
    gain : float
        N_a: the fundamental of f is gain * amplitude.
    force_mean, force_amplitude, force_along : float
        Derivatives of f_0 by both, and with the gaps.
    gain_mean, gain_amplitude, gain_along : float
        *Amplitude times* the derivatives of N_a, which stays bounded as amplitude -> 0.
    """
    ahead, ahead_h, ahead_g, ahead_w = _flank(front - mean, amplitude)
    behind, behind_h, behind_g, behind_w = _flank(-back - mean, amplitude)
    behind, behind_h, behind_g, behind_w = far * behind, far * behind_h, far * behind_g, far * behind_w
    share, gain_amplitude = 0.5 * (1.0 + far), 0.0
    if amplitude > 0.0:
        gain_amplitude = (ahead_w * (front - mean) + behind_w * (back + mean)) / amplitude
    return (
        share * mean - 0.5 * (front - far * back) + 0.5 * (ahead - behind),
        share - 0.5 * (ahead_h - behind_h),
        share - 0.5 * (ahead_g - behind_g),
        0.5 * (ahead_w - behind_w),
        0.5 * (ahead_g * d_front + behind_g * d_back) - 0.5 * (d_front - far * d_back),
        ahead_w - behind_w,
        gain_amplitude,
        -(ahead_w * d_front + behind_w * d_back),
    )


@kernel(types.UniTuple(_F, 8)(_F, _F, _F), inline=True)
def describing_functions(mean, amplitude, b):
    """`contact_functions` of the dead zone of half width b, with the derivatives by b last of either three."""
    return contact_functions(mean, amplitude, b, b, 1.0, 1.0, 1.0)
