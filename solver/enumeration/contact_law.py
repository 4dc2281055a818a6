"""The dead zone as a law between mean force and gain, with proven bounds and without the mean displacement.

For a motion of amplitude 1 let phi = |f_0| be the mean force, beta the half gap and nu >= 0 the mean displacement on
the side of the force. The motion is in contact with the near flank for 2 theta_+ and with the far flank for 2 theta_-
of a period of 2 pi, cos theta_+ = beta - nu and cos theta_- = beta + nu (theta = 0 where the cosine exceeds 1, pi
where it is below -1), and the describing functions (docs/physics.md, section 4) become

    phi = [(sin theta_+ - theta_+ cos theta_+) - (sin theta_- - theta_- cos theta_-)] / pi
    N   = [(theta_+ - sin theta_+ cos theta_+) + (theta_- - sin theta_- cos theta_-)] / pi

phi grows with nu, at the rate chi = (theta_+ + theta_-)/pi, from 0 at nu = 0 to 1 at nu = 1 + beta, so that nu and
N follow from (phi, beta); beyond phi = 1 contact is never lost and N = 1. Differentiating,

    dN/dphi  = 2 (sin theta_+ - sin theta_-)/(theta_+ + theta_-)                           in [0, 2]
    dN/dbeta = -(4/pi) (theta_- sin theta_+ + theta_+ sin theta_-)/(theta_+ + theta_-)     in [-4/pi, 0]
    dtheta_+/dphi >= 0, dtheta_+/dbeta <= 0, dtheta_-/dphi <= 0, dtheta_-/dbeta <= 0

hence over a rectangle in (phi, beta) every bound sits at a corner. N depends on beta only while both flanks are
touched.

Any system. Springs that hold lambda besides the contact carry a part of the mean load: the force that the mean row
knows is then f_0 + kappa lambda_m, with their stiffness kappa >= 0 over that of the contact, D_0/c of
`solver.harmonic.condensed`, and

    phi = [...] / pi + kappa nu

takes the place of the one above. It grows with nu at the rate chi + kappa, without end, so that (phi, beta) still fix
nu and N; nu beyond 1 + beta is permanent contact, below beta - 1 none. The slopes become

    dN/dphi  = 2 (sin theta_+ - sin theta_-)/(theta_+ + theta_- + kappa pi)                                     >= 0
    dN/dbeta = -(2/pi) [sin theta_+ (2 theta_- + kappa pi) + sin theta_- (2 theta_+ + kappa pi)]
               / (theta_+ + theta_- + kappa pi)                                                                 <= 0

and the angles move as above, so that bounds stay at the corners. Of a contact with one flank theta_- is 0 wherever the
motion is, beta is 0 (its displacement counts from the flank) and phi, as nu, may have either sign. A law is (kappa,
what bounds the error of kappa, the stiffness r of the far flank over that of the near one: 1 for two flanks alike, 0
for one); kappa is 0 exactly or certainly above 0.

Unlike flanks, 0 < r < 1. The near flank is the stiffer one, whatever the side of the force, and phi and nu have either
sign. What the far flank adds has the factor r, so that phi grows with nu at the rate (theta_+ + r theta_-)/pi + kappa,

    dN/dphi  = 2 (sin theta_+ - r sin theta_-)/(theta_+ + r theta_- + kappa pi)
    dN/dbeta = -(2/pi) [sin theta_+ (2 r theta_- + kappa pi) + r sin theta_- (2 theta_+ + kappa pi)]
               / (theta_+ + r theta_- + kappa pi)                                                                <= 0

and the angles move as before. N now falls with phi as long as sin theta_+ < r sin theta_-, from r at phi <= -r - kappa
(1 + beta), and grows beyond: where both flanks are touched, (sin theta_+)^2 - (r sin theta_-)^2 is a quadratic in nu
whose roots have different signs, so that it changes its sign once, and where one is touched the sign is that flank's.
Over a rectangle N is largest at one of the two corners of the smallest beta; its least value is that of a corner where
the slope has one sign along the largest beta, and elsewhere no less than that of the smallest angles. N is at most 1.

Rounding: acos and sin of the C library err by less than one unit in the last place, so that phi and N are off by less
than 16 u (theta_+ + theta_-)/pi + 1e-22 with u = 2^-53; a test measures that. Of unlike flanks 8 u (theta_+ + r theta_-
+ beta + |cos theta_+|) is added, for the far flank's cosine, the product with r, and because r is rounded, by u r at
most. The inverse is not trusted to any iteration: its result is moved outwards and then checked against phi with that
margin. How far it is moved is free, so that bounds over wide rectangles need not be solved for to the last digit
(`slack`).
"""

import math

from solver.enumeration.interval import INTERVAL, above
from solver.kernels import types
from solver.kernels.compile import kernel

__all__ = ["LAW", "contact_law", "gain_over", "gain_slopes", "is_unlike", "near_cosine"]

_F = types.float64
_U = 2.0**-53
# Corners of a rectangle this small serve each other as starting values.
_THIN = 0.01
# With kappa > 0: how far mean force and gap, over the amplitude, may reach.
_FURTHEST = 1e30
# With unlike flanks: how far the gap may reach for the mean displacement to be told; the gain does not change beyond.
_WIDEST = 1e6
#: kappa, the bound of its error, and r: 1 for two flanks alike, 0 for one.
LAW = types.UniTuple(_F, 3)


@kernel(types.boolean(LAW), inline=True)
def is_unlike(law):
    """Whether there are two flanks of unlike stiffness."""
    return 0.0 < law[2] < 1.0


@kernel(types.UniTuple(_F, 2)(_F), inline=True)
def _arc(cosine):
    """theta and sin theta of a cosine, clipped to [-1, 1]."""
    if cosine >= 1.0:
        return 0.0, 0.0
    if cosine <= -1.0:
        return math.pi, 0.0
    return math.acos(cosine), math.sqrt((1.0 - cosine) * (1.0 + cosine))


@kernel(types.UniTuple(_F, 5)(_F, _F, LAW), inline=True)
def contact_law(cosine, beta, law):
    """Mean force, gain, their error bounds and theta_+ + r theta_- where the near flank's cosine is `cosine`."""
    near, near_sine = _arc(cosine)
    force = near_sine - near * cosine
    gain, angles = near - near_sine * cosine, near
    if law[2] != 0.0:
        far_cosine = 2.0 * beta - cosine
        far, far_sine = _arc(far_cosine)
        if far > 0.0:
            force -= law[2] * (far_sine - far * far_cosine)
            gain += law[2] * (far - far_sine * far_cosine)
        angles += law[2] * far
    error = 16.0 * _U / math.pi * angles + 1e-22
    if is_unlike(law):
        error += 8.0 * _U * (angles + abs(beta) + abs(cosine))
    if law[0] == 0.0:
        return force / math.pi, gain / math.pi, error, error, angles
    nu, size = beta - cosine, abs(beta) + abs(cosine)
    held = force / math.pi + law[0] * nu
    bound = error + law[1] * abs(nu) * (1.0 + 4.0 * _U) + 8.0 * _U * (1.0 + law[0]) * size
    return held, gain / math.pi, bound, 0.0 if angles == 0.0 or cosine <= -1.0 else error, angles


@kernel(_F(_F, _F), inner=True)
def _first_guess(phi, beta):
    """Starting value of `near_cosine` for 0 < phi < 1."""
    if beta < 1.0:
        # Where the far flank is about to be touched, cos theta_- = 1, the near flank alone carries the force.
        touching = 2.0 * beta - 1.0
        near, near_sine = _arc(touching)
        if phi * math.pi < near_sine - near * touching:
            # phi is concave in nu with both flanks touched: the tangent at nu = 0 stays on one side of the root.
            return max(beta - phi * math.pi / (2.0 * math.acos(beta)), touching)
    y = phi ** (2.0 / 3.0)
    return 1.0 + y * (-2.22492368 + y * (0.09332219 + y * (0.30355034 + y * (-0.39091187 + y * 0.21838701))))


@kernel(types.UniTuple(_F, 2)(_F, _F, LAW, _F), inner=True)
def _held_cosine(phi, beta, law, tolerance):
    """`near_cosine` with kappa > 0 or unlike flanks, for any phi: Newton's method in a bracket."""
    kappa = law[0]
    if phi >= 1.0 + kappa * (1.0 + beta):
        return beta - (phi + beta) / (1.0 + kappa), 1.0
    low, high = -1.0, 1.0
    if is_unlike(law):
        if kappa == 0.0 and phi <= -law[2]:
            return 1.0 + 2.0 * beta, 1.0
        if phi <= -law[2] - kappa * (1.0 + beta):
            return beta - (phi - law[2] * beta) / (law[2] + kappa), 1.0
        high = 1.0 + 2.0 * beta
    else:
        nothing = kappa * (beta - 1.0) if law[2] != 0.0 else -kappa
        if phi <= nothing:
            return beta - phi / kappa, 1.0
    cosine, room = min(max(beta - phi / (0.5 + kappa), low), high), 1.0
    for _ in range(60):
        force, _gain, _bound, _error, angles = contact_law(cosine, beta, law)
        if force > phi:
            low = cosine
        else:
            high = cosine
        rate = angles / math.pi + kappa
        moved = cosine + (force - phi) / rate if rate > 1e-12 else math.nan
        if not low <= moved <= high:
            moved = 0.5 * (low + high)
        step, cosine, room = abs(moved - cosine), moved, min(rate * rate, 1.0)
        if step < tolerance * room:
            break
    return cosine, room


@kernel(types.UniTuple(_F, 2)(_F, _F, LAW, _F, _F), inner=True)
def near_cosine(phi, beta, law, guess, slack):
    """The near flank's cosine at (phi, beta), by Newton's method; not proven.

    With 0 < phi < 1 unless kappa > 0, and -r < phi < 1 for unlike flanks.

    Parameters
    ----------
    phi, beta : float
    law : LAW
    guess : float
        Where to start; nan if nothing is known.
    slack : float
        About the error that is allowed, as a share of the second value returned.

    Returns
    -------
    cosine, room : float
        room is (theta_+ + theta_-)^2, or the square of how fast phi grows, at most 1.
    """
    # What is left after a step is about its square.
    top, tolerance, room = min(beta, 1.0), max(math.sqrt(slack), 1e-8), 1.0
    if law[0] > 0.0 or is_unlike(law):
        return _held_cosine(phi, beta, law, tolerance)
    if law[2] == 0.0:
        top = 1.0
    for attempt in range(2):
        cosine = guess if attempt == 0 else _first_guess(phi, beta if law[2] != 0.0 else 1.0)
        if not (-1.0 <= cosine <= top):
            if attempt == 0:
                continue
            cosine = min(max(cosine, -1.0), top)
        for _ in range(12):
            force, _gain, _bound, _error, angles = contact_law(cosine, beta, law)
            if angles == 0.0:
                break
            step = (force - phi) * math.pi / angles
            moved = min(max(cosine + step, -1.0), top)
            step, cosine, room = abs(moved - cosine), moved, min(angles * angles, 1.0)
            if step < tolerance * room:
                return cosine, room
    return cosine, room


@kernel(types.UniTuple(_F, 2)(_F, _F, LAW, _F, _F), inner=True)
def _largest(phi, beta, law, guess, slack):
    """A proven lower bound on the near flank's cosine and an upper one on N at (phi, beta)."""
    held = law[0] > 0.0
    if phi >= 1.0 and not held:
        return -1.0, 1.0
    start, room = min(beta, 1.0) if law[2] != 0.0 else 1.0, 1.0
    if phi > 0.0 or held or is_unlike(law):
        start, room = near_cosine(phi, beta, law, guess, slack)
    margin = max(slack * room, 64.0 * _U)
    if held or is_unlike(law):
        margin *= max(abs(start), 1.0) + beta
    for _ in range(30):
        cosine = start - margin
        if cosine <= -1.0 and not held:
            break
        force, gain, bound, error, _angles = contact_law(cosine, beta, law)
        if force - bound >= phi:
            return cosine, min(gain + error, 1.0)
        margin *= 8.0
    # At cosine -1 the mean force is exactly 1.
    return -math.inf if held else -1.0, 1.0


@kernel(types.UniTuple(_F, 2)(_F, _F, LAW, _F, _F), inner=True)
def _smallest(phi, beta, law, guess, slack):
    """A proven upper bound on the near flank's cosine and a lower one on N at (phi, beta)."""
    held = law[0] > 0.0
    if phi >= 1.0 and not held:
        return -1.0, 1.0
    # At nu = 0 the mean force is exactly 0, so that cosine = beta is always an upper bound; of one flank it is none.
    top = min(beta, 1.0)
    if law[2] == 0.0:
        top = math.inf if held else 1.0
    elif is_unlike(law):
        top = math.inf if held else above(1.0 + above(2.0 * beta))
    elif held:
        top = beta
    cosine = top
    if phi > 0.0 or held or is_unlike(law):
        start, room = near_cosine(phi, beta, law, guess, slack)
        margin = max(slack * room, 64.0 * _U)
        if held or is_unlike(law):
            margin *= max(abs(start), 1.0) + beta
        for _ in range(30):
            cosine = start + margin
            if cosine >= top:
                break
            force, gain, bound, error, _angles = contact_law(cosine, beta, law)
            if force + bound <= phi:
                return cosine, max(gain - error, 0.0)
            margin *= 8.0
        cosine = top
    if cosine == math.inf:
        return cosine, 0.0
    _force, gain, _bound, error, _angles = contact_law(cosine, beta, law)
    return cosine, max(gain - error, 0.0)


@kernel(INTERVAL(_F, _F), inline=True)
def _sine_over(low, high):
    """sin over [low, high] within [0, pi]."""
    left, right = math.sin(low), math.sin(high)
    top = 1.0 if low <= 0.5 * math.pi <= high else max(left, right)
    return max(min(left, right) - 4.0 * _U, 0.0), min(top + 4.0 * _U, 1.0)


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


@kernel(INTERVAL(_F), inline=True)
def _share(cosine):
    """Bounds of (theta - sin theta cos theta)/pi, what one flank adds to N."""
    if cosine >= 1.0:
        return 0.0, 0.0
    if cosine <= -1.0:
        return 1.0, 1.0
    angle, sine = _arc(cosine)
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
    low = _largest(phi, beta, law, math.nan, slack)[0]
    high = _smallest(phi, beta, law, math.nan, slack)[0]
    return (low, high), (_far_cosines(beta, high)[0], _far_cosines(beta, low)[1])


@kernel(types.UniTuple(INTERVAL, 3)(_F, _F, _F, _F, LAW, _F), inner=True)
def _unlike_over(phi_low, phi_high, beta_low, beta_high, law, slack):
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


@kernel(INTERVAL(INTERVAL), inline=True)
def _sine_of(cosines):
    """Bounds of the sine over an interval of cosines, clipped to [-1, 1]."""
    low, high = _arc(cosines[1])[0] * (1.0 - 4.0 * _U), _arc(cosines[0])[0] * (1.0 + 4.0 * _U)
    if cosines[0] >= 1.0 or cosines[1] <= -1.0:
        return 0.0, 0.0
    sines = _sine_over(low, min(high, math.pi))
    return (0.0 if high >= math.pi else sines[0]), sines[1]


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
        gain, cosine, _ = _unlike_over(phi_low, phi_high, beta_low, beta_high, law, slack)
        return gain, cosine if beta[1] < _WIDEST else (-math.inf, math.inf)
    cosine_low, gain_high = _largest(phi_high, beta_low, law, guess, slack)
    if phi_high < 1.0 and phi_high - phi_low + beta_high - beta_low < _THIN:
        guess = cosine_low
    cosine_high, gain_low = _smallest(phi_low, beta_high, law, guess, slack)
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
    far_sines = _sine_over(far[0], min(far[1], math.pi)) if far[1] > 0.0 else (0.0, 0.0)
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
    near_low, near_high = _arc(cosine[1])[0], _arc(cosine[0])[0]
    far_low, far_high = 0.0, 0.0
    if is_unlike(law):
        _, _, far_cosine = _unlike_over(phi_low, phi_high, beta_low, beta_high, law, slack)
        far_low, far_high = _arc(far_cosine[1])[0], _arc(far_cosine[0])[0]
        if phi_low >= 1.0 and not held:
            return (0.0, 0.0), (0.0, 0.0)
    elif law[2] != 0.0 and beta_low < 1.0 and (phi_low < 1.0 or held) and 2.0 * beta_low - cosine[1] < 1.0 + 8.0 * _U:
        # Far flank: cos theta_- = 2 beta - (beta - nu) at its own two corners.
        corner = _smallest(phi_low, beta_low, law, cosine[1], slack)[0]
        far_high = _arc(2.0 * beta_low - corner - 4.0 * _U)[0]
        if far_high > 0.0 and (phi_high < 1.0 or held):
            corner = _largest(phi_high, beta_high, law, cosine[0], slack)[0]
            far_low = _arc(2.0 * beta_high - corner + 4.0 * _U)[0]
    near_low, near_high = near_low * (1.0 - 4.0 * _U), near_high * (1.0 + 4.0 * _U)
    far_low, far_high = far_low * (1.0 - 4.0 * _U), far_high * (1.0 + 4.0 * _U)
    if held or is_unlike(law):
        sines = _sine_over(near_low, min(near_high, math.pi))
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
        near_sine = _sine_over(near_low, min(near_high, math.pi))
        if near_high > math.pi:
            near_sine = 0.0, near_sine[1]
        far_sine = _sine_over(far_low, min(far_high, math.pi))
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
