"""Proven bounds of the gain and of its slopes over a rectangle of mean force and gap.

By the signs of the slopes in `solver.enumeration.contact_law` every bound of flanks that are alike sits at a corner;
for unlike ones see `solver.enumeration.unlike_flanks`.
"""

import math

from solver.enumeration.contact_law import LAW, contact_arc, is_unlike, largest_gain, smallest_gain
from solver.enumeration.interval import INTERVAL
from solver.enumeration.unlike_flanks import sine_over, unlike_gain_over
from solver.kernels import types
from solver.kernels.compile import kernel

__all__ = ["gain_over", "gain_slopes"]

_F = types.float64
_U = 2.0**-53
# Corners of a rectangle this small serve each other as starting values.
_THIN = 0.01
# With kappa > 0: how far mean force and gap, over the amplitude, may reach.
_FURTHEST = 1e30
# With unlike flanks: how far the gap may reach for the mean displacement to be told; the gain does not change beyond.
_WIDEST = 1e6


@kernel(types.UniTuple(_F, 4)(INTERVAL, INTERVAL, LAW), inline=True)
def _clipped(phi, beta, law):
    """The ends of a rectangle; beyond phi = 1 and beta = 1 nothing changes, and the clip keeps infinities away.

    With kappa > 0 things change everywhere; of what reaches too far the ends are out of order.
    """
    if law[0] > 0.0:
        if max(abs(phi[0]), abs(phi[1])) < _FURTHEST and max(abs(beta[0]), abs(beta[1])) < _FURTHEST:
            return phi[0], phi[1], max(beta[0], 0.0), beta[1]
        return 1.0, 0.0, 1.0, 0.0
    most = min(phi[1], 2.0)
    if is_unlike(law):
        # The far flank's place is told by both angles, so that beta matters wherever it is touched.
        return (
            min(max(phi[0], -2.0), 2.0),
            min(max(phi[1], -2.0), 2.0),
            min(max(beta[0], 0.0), _WIDEST),
            min(beta[1], _WIDEST),
        )
    if law[2] == 0.0 and most < 0.0:
        # One flank does not pull.
        most = 0.0
    return min(max(phi[0], 0.0), 2.0), most, min(max(beta[0], 0.0), 2.0), min(beta[1], 2.0)


@kernel(types.UniTuple(INTERVAL, 2)(INTERVAL, INTERVAL, LAW, _F, _F), inner=True)
def gain_over(phi, beta, law, guess, slack):
    """Bounds over a rectangle of mean force and gap.

    Parameters
    ----------
    phi, beta : interval
        0 <= beta, and 0 <= phi of two flanks alike; either may end at infinity.
    law : LAW
    guess : float
        The near flank's cosine somewhere in the rectangle, to start from; nan if nothing is known.
    slack : float
        How far the bounds on the cosine may lie outside, about; 0 for the tightest.

    Returns
    -------
    gain : interval
        N.
    cosine : interval
        beta - nu, valid where phi < 1; with kappa > 0 everywhere.
    """
    phi_low, phi_high, beta_low, beta_high = _clipped(phi, beta, law)
    if not (phi_low <= phi_high and beta_low <= beta_high):
        return (0.0, 1.0), (-1.0, 1.0) if law[0] == 0.0 else (-math.inf, math.inf)
    if is_unlike(law):
        gain, cosine, _ = unlike_gain_over(phi_low, phi_high, beta_low, beta_high, law, slack)
        return gain, cosine if beta[1] < _WIDEST else (-math.inf, math.inf)
    cosine_low, gain_high = largest_gain(phi_high, beta_low, law, guess, slack)
    if phi_high < 1.0 and phi_high - phi_low + beta_high - beta_low < _THIN:
        guess = cosine_low
    cosine_high, gain_low = smallest_gain(phi_low, beta_high, law, guess, slack)
    return (gain_low, gain_high), (cosine_low, cosine_high)


@kernel(types.UniTuple(INTERVAL, 2)(INTERVAL, INTERVAL, INTERVAL, LAW), inner=True)
def _held_slopes(near, far, sines, law):
    """dN/dphi and dN/dbeta with kappa > 0 or unlike flanks, from bounds of both angles and of the near one's sine."""
    margin, r = 64.0 * _U, law[2] if law[2] != 0.0 else 1.0
    pull_low, pull_high = math.pi * (law[0] - law[1]) * (1.0 - margin), math.pi * (law[0] + law[1]) * (1.0 + margin)
    least, most = (
        (near[0] + r * far[0] + pull_low) * (1.0 - margin),
        (near[1] + r * far[1] + pull_high) * (1.0 + margin),
    )
    if not least > 0.0:
        return (-2.0, 2.0), (-4.0 / 3.0, 0.0)
    far_sines = sine_over(far[0], min(far[1], math.pi)) if far[1] > 0.0 else (0.0, 0.0)
    falling, rising = sines[0] - r * far_sines[1], sines[1] - r * far_sines[0]
    by_force = (max(2.0 * falling / most - margin, 0.0), 2.0 * max(rising, 0.0) / least * (1.0 + margin) + margin)
    if is_unlike(law):
        by_force = (
            max(2.0 * falling / (most if falling > 0.0 else least * (1.0 - margin)) - margin, -2.0),
            min(2.0 * rising / (least * (1.0 - margin) if rising > 0.0 else most) + margin, 2.0),
        )
    lowest = sines[0] * (2.0 * r * far[0] + pull_low) + r * far_sines[0] * (2.0 * near[0] + pull_low)
    highest = sines[1] * (2.0 * r * far[1] + pull_high) + r * far_sines[1] * (2.0 * near[1] + pull_high)
    factor = 2.0 / math.pi * (1.0 + margin)
    return by_force, (-factor * highest / least - margin, min(-lowest / most * (2.0 / math.pi) + margin, 0.0))


@kernel(types.UniTuple(INTERVAL, 2)(INTERVAL, INTERVAL, INTERVAL, LAW, _F), inner=True)
def gain_slopes(phi, beta, cosine, law, slack):
    """dN/dphi and dN/dbeta over a rectangle, generalised derivatives included where N has a kink.

    Parameters
    ----------
    phi, beta : interval
    cosine : interval
        From `gain_over` of the same rectangle.
    law : LAW
    slack : float

    Returns
    -------
    by_force, by_gap : interval
    """
    phi_low, phi_high, beta_low, beta_high = _clipped(phi, beta, law)
    held, by_force, by_gap = law[0] > 0.0, (0.0, 2.0), (-4.0 / 3.0, 0.0)
    if not (phi_low <= phi_high and beta_low <= beta_high):
        if is_unlike(law):
            by_force = -2.0, 2.0
        return ((-math.inf, math.inf), (-math.inf, 0.0)) if held else (by_force, by_gap)
    near_low, near_high = contact_arc(cosine[1])[0], contact_arc(cosine[0])[0]
    far_low, far_high = 0.0, 0.0
    if is_unlike(law):
        _, _, far_cosine = unlike_gain_over(phi_low, phi_high, beta_low, beta_high, law, slack)
        far_low, far_high = contact_arc(far_cosine[1])[0], contact_arc(far_cosine[0])[0]
        if phi_low >= 1.0 and not held:
            return (0.0, 0.0), (0.0, 0.0)
    elif law[2] != 0.0 and beta_low < 1.0 and (phi_low < 1.0 or held) and 2.0 * beta_low - cosine[1] < 1.0 + 8.0 * _U:
        # Far flank: cos theta_- = 2 beta - (beta - nu) at its own two corners.
        corner = smallest_gain(phi_low, beta_low, law, cosine[1], slack)[0]
        far_high = contact_arc(2.0 * beta_low - corner - 4.0 * _U)[0]
        if far_high > 0.0 and (phi_high < 1.0 or held):
            corner = largest_gain(phi_high, beta_high, law, cosine[0], slack)[0]
            far_low = contact_arc(2.0 * beta_high - corner + 4.0 * _U)[0]
    near_low, near_high = near_low * (1.0 - 4.0 * _U), near_high * (1.0 + 4.0 * _U)
    far_low, far_high = far_low * (1.0 - 4.0 * _U), far_high * (1.0 + 4.0 * _U)
    if held or is_unlike(law):
        sines = sine_over(near_low, min(near_high, math.pi))
        return _held_slopes(
            (near_low, near_high), (far_low, far_high), (0.0 if near_high > math.pi else sines[0], sines[1]), law
        )

    if far_high == 0.0:
        # 2 sin(theta)/theta falls with theta.
        by_gap = 0.0, 0.0
        highest = 2.0
        if near_low > 0.0:
            highest = min(2.0 * math.sin(min(near_low, math.pi)) / near_low + 16.0 * _U, 2.0)
        lowest = 2.0
        if near_high > 0.0:
            lowest = max(2.0 * math.sin(min(near_high, math.pi)) / near_high - 16.0 * _U, 0.0)
        by_force = lowest, highest
    elif near_low + far_low > 0.0:
        near_sine = sine_over(near_low, min(near_high, math.pi))
        if near_high > math.pi:
            near_sine = 0.0, near_sine[1]
        far_sine = sine_over(far_low, min(far_high, math.pi))
        least, most = near_low + far_low, near_high + far_high
        margin = 32.0 * _U
        by_force = (
            max(2.0 * (near_sine[0] - far_sine[1]) / most - margin, 0.0),
            min(2.0 * max(near_sine[1] - far_sine[0], 0.0) / least * (1.0 + margin), 2.0),
        )
        # The two terms in the numerator weigh each sine by the other flank's share of the contact.
        share_low, share_high = near_low / (near_low + far_high), near_high / (near_high + far_low)
        lowest = (1.0 - share_high) * near_sine[0] + share_low * far_sine[0]
        highest = (1.0 - share_low) * near_sine[1] + share_high * far_sine[1]
        by_gap = (max(-4.0 / math.pi * highest - margin, -4.0 / 3.0), min(-4.0 / math.pi * lowest + margin, 0.0))
    return by_force, by_gap
