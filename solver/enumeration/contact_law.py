"""The dead zone as a law between mean force and gain, with proven bounds and without the mean displacement.

Here are the law, its inverse and its bounds at one place; `solver.enumeration.gain_bounds` has those over rectangles.

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
for one); kappa is 0 exactly or certainly above 0. With 0 < r < 1 the law is that of `solver.enumeration.unlike_flanks`.

Rounding: acos and sin of the C library err by less than one unit in the last place, so that phi and N are off by less
than 16 u (theta_+ + theta_-)/pi + 1e-22 with u = 2^-53; a test measures that. Of unlike flanks 8 u (theta_+ + r theta_-
+ beta + |cos theta_+|) is added, for the far flank's cosine, the product with r, and because r is rounded, by u r at
most. The inverse is not trusted to any iteration: its result is moved outwards and then checked against phi with that
margin. How far it is moved is free, so that bounds over wide rectangles need not be solved for to the last digit
(`slack`).
"""

import math

from solver.enumeration.interval import above
from solver.kernels import types
from solver.kernels.compile import kernel

__all__ = ["LAW", "contact_arc", "contact_law", "is_unlike", "largest_gain", "near_cosine", "smallest_gain"]

_F = types.float64
_U = 2.0**-53
#: kappa, the bound of its error, and r: 1 for two flanks alike, 0 for one.
LAW = types.UniTuple(_F, 3)


@kernel(types.boolean(LAW), inline=True)
def is_unlike(law):
    """Whether there are two flanks of unlike stiffness."""
    return 0.0 < law[2] < 1.0


@kernel(types.UniTuple(_F, 2)(_F), inline=True)
def contact_arc(cosine):
    """theta and sin theta of a cosine, clipped to [-1, 1]."""
    if cosine >= 1.0:
        return 0.0, 0.0
    if cosine <= -1.0:
        return math.pi, 0.0
    return math.acos(cosine), math.sqrt((1.0 - cosine) * (1.0 + cosine))


@kernel(types.UniTuple(_F, 5)(_F, _F, LAW), inline=True)
def contact_law(cosine, beta, law):
    """Mean force, gain, their error bounds and theta_+ + r theta_- where the near flank's cosine is `cosine`."""
    near, near_sine = contact_arc(cosine)
    force = near_sine - near * cosine
    gain, angles = near - near_sine * cosine, near
    if law[2] != 0.0:
        far_cosine = 2.0 * beta - cosine
        far, far_sine = contact_arc(far_cosine)
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
        near, near_sine = contact_arc(touching)
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
def largest_gain(phi, beta, law, guess, slack):
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
def smallest_gain(phi, beta, law, guess, slack):
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
