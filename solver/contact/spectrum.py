"""When a periodic motion is in contact, and the Fourier coefficients of that: exact, not sampled.

The formulas are derived in docs/physics.md, section 4. A motion is the array u = (Lambda_0, c_1, s_1, ..., c_H, s_H),
lambda(theta) = Lambda_0 + sum_k c_k cos k theta + s_k sin k theta. Its crossings of the two flanks are isolated by
bisection of the period with the bound |lambda''| <= sum_k k^2 |Lambda_k|: a piece is left alone once lambda cannot
reach a flank in it, or is monotone in it. What is missed is at most a contact shorter than 1e-9 of a radian on either
side, whose force is below rounding.
"""

import cmath
import math

import numpy as np

from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel

__all__ = ["COMPLEX", "contact_arcs", "contact_spectrum", "displacement", "extrema", "extremes", "most_arcs"]

_I, _F, _C = types.int64, types.float64, types.complex128
COMPLEX = types.complex128[::1]

# Pieces of the period shorter than this are not divided.
_SHORTEST = 1e-9
# Motions that cling to a flank to rounding, over a whole stretch, are not divided for ever.
_MOST_LOOKS = 100_000
_PIECES = 8
_TURN = 2.0 * math.pi


def most_arcs(harmonics: int) -> int:
    """Room for the arcs of a motion of so many harmonics: two flanks, each crossed at most 2H times, and rounding."""
    return 4 * harmonics + 8


@kernel(types.UniTuple(_F, 2)(ARRAY, _F), inline=True)
def displacement(u, angle):
    """lambda and d lambda/d theta at one angle."""
    z = complex(math.cos(angle), math.sin(angle))
    value, slope = 0j, 0j
    for k in range(u.shape[0] // 2, 0, -1):
        coefficient = complex(u[2 * k - 1], -u[2 * k])
        value = value * z + coefficient
        slope = slope * z + k * coefficient
    value, slope = value * z, slope * z
    return u[0] + value.real, -slope.imag


@kernel(_I(_F, _F, _F), inline=True)
def _zone(value, front, back):
    """1 in front contact, -1 in back contact, 0 between."""
    return 1 if value > front else (-1 if value < -back else 0)


@kernel(_F(ARRAY, _F, _F, _F, _F, _F), inner=True)
def _crossing(u, level, low, high, value_low, value_high):
    """Where lambda, monotone between two angles, takes a value between those at its ends."""
    sense = 1.0 if value_high > value_low else -1.0
    angle = low + (high - low) * (level - value_low) / (value_high - value_low)
    for _ in range(60):
        value, slope = displacement(u, angle)
        if (value - level) * sense < 0.0:
            low = angle
        else:
            high = angle
        moved = angle - (value - level) / slope if slope != 0.0 else low
        if not low <= moved <= high:
            moved = 0.5 * (low + high)
        if abs(moved - angle) <= 4e-16 * (1.0 + angle):
            return moved
        angle = moved
    return angle


@kernel(_I(ARRAY, _F, _F, ARRAY, types.int64[::1]), inner=True, shared=True)
def contact_arcs(u, front, back, angles, zones):
    """Cut the period at the angles where lambda crosses a flank.

    Parameters
    ----------
    u : (2 H + 1,) array
    front, back : float
        Contact at lambda > front and lambda < -back; back may be infinite.
    angles : (most_arcs(H),) array
        Filled with the ascending angles in [0, 2 pi) of the crossings.
    zones : (most_arcs(H),) int array
        Filled with the zone (1 front, 0 free, -1 back) that begins at each; the last one lasts to the first angle of
        the next period.

    Returns
    -------
    int
        Number of crossings; where it is 0, zones[0] holds all the time.
    """
    bend, size = 0.0, abs(u[0])
    for k in range(1, u.shape[0] // 2 + 1):
        amplitude = math.sqrt(u[2 * k - 1] * u[2 * k - 1] + u[2 * k] * u[2 * k])
        bend += k * k * amplitude
        size += amplitude
    # A motion that rests on a flank would be divided for ever: what moves by less than this does not move.
    rounding = 1e-16 * size
    count, room, looks = 0, angles.shape[0], 0
    # A stack of the pieces still to be looked at, in order of angle: each halving adds one.
    ends = np.empty(64)
    start = displacement(u, 0.0)[0]
    left, value_left = 0.0, start
    for piece in range(_PIECES):
        depth = 1
        ends[0] = _TURN * (piece + 1) / _PIECES
        while depth > 0:
            right = ends[depth - 1]
            centre, radius = 0.5 * (left + right), 0.5 * (right - left)
            value, slope = displacement(u, centre)
            reach = abs(slope) * radius + 0.5 * bend * radius * radius
            clear = abs(value - front) >= reach and abs(value + back) >= reach
            looks += 1
            divided = abs(slope) <= bend * radius and radius > _SHORTEST and reach > rounding and looks < _MOST_LOOKS
            if not clear and divided:
                ends[depth] = centre
                depth += 1
                continue
            # Of a piece that reaches no flank only the zone matters, and that is the centre's: at an end that just
            # touches a flank rounding may have seen another.
            first, value_right = value, value
            if not clear:
                first = displacement(u, left)[0]
                value_right = displacement(u, right)[0] if right < _TURN else start
            # The zone at the left end as the piece before saw it, so that no crossing is counted twice or not at all.
            before, after = _zone(value_left, front, back), _zone(value_right, front, back)
            step = 1 if after > before else -1
            zone = before
            while zone != after and count < room:
                upper = zone + step if step > 0 else zone
                level = front if upper == 1 else -back
                if (first - level) * (value_right - level) < 0.0 and abs(slope) > bend * radius:
                    angle = _crossing(u, level, left, right, first, value_right)
                else:
                    angle = centre if (first - level) * (value_right - level) < 0.0 else left
                zone += step
                angles[count], zones[count] = min(angle, np.nextafter(_TURN, 0.0)), zone
                count += 1
            left, value_left = right, value_right
            depth -= 1
    # Likewise where the period closes.
    zone, after = _zone(value_left, front, back), _zone(start, front, back)
    while zone != after and count < room:
        zone += 1 if after > zone else -1
        angles[count], zones[count] = np.nextafter(_TURN, 0.0), zone
        count += 1
    if count == 0:
        zones[0] = _zone(start, front, back)
    return count


@kernel(types.void(_I, ARRAY, types.int64[::1], COMPLEX, COMPLEX, COMPLEX), inner=True)
def contact_spectrum(count, angles, zones, contact, ahead, behind):
    """Fourier coefficients of the contact: (1/2 pi) times the integral of exp(-i m theta) over the time in contact.

    Parameters
    ----------
    count, angles, zones
        From `contact_arcs`.
    contact, ahead, behind : (m,) complex arrays
        Filled with chi_0 ... chi_(m-1) of both flanks together, of the front one and of the back one.
    """
    size = contact.shape[0]
    for m in range(size):
        ahead[m], behind[m] = 0j, 0j
    if count == 0:
        if zones[0] == 1:
            ahead[0] = 1.0 + 0j
        elif zones[0] == -1:
            behind[0] = 1.0 + 0j
    for i in range(count):
        zone = zones[i]
        if zone == 0:
            continue
        target = ahead if zone == 1 else behind
        begin, end = angles[i], angles[i + 1] if i + 1 < count else angles[0] + _TURN
        # chi_m = exp(-i m c) sin(m h)/(pi m) with the arc's centre c and half width h: no cancellation in short arcs.
        half = 0.5 * (end - begin)
        turn, open_by = cmath.exp(-1j * (begin + half)), cmath.exp(1j * half)
        at, width = 1.0 + 0j, 1.0 + 0j
        target[0] += 2.0 * half / _TURN
        for m in range(1, size):
            at, width = at * turn, width * open_by
            target[m] += at * (2.0 * width.imag / (_TURN * m))
    for m in range(size):
        contact[m] = ahead[m] + behind[m]


@kernel(_I(ARRAY, ARRAY, ARRAY, types.int64[::1]), inner=True)
def extrema(u, slope, angles, zones):
    """Local extrema of lambda: their number, angles, and zones: 1 at a minimum, where the slope becomes positive.

    `slope` (2 H + 1,) is filled with d lambda/d theta; angles and zones have room for `most_arcs(H)`.

    Parameters
    ----------
    u : (n,) array
        Unknowns (Lambda_0, c_1, s_1, ...).
    slope : (n,) array
        Room for the coefficients of the derivative.
    angles, zones : (2 n + 8,) arrays
        Filled with angles (rad) and, for each, whether the derivative becomes positive there.
    """
    slope[0] = 0.0
    for k in range(1, u.shape[0] // 2 + 1):
        slope[2 * k - 1], slope[2 * k] = k * u[2 * k], -k * u[2 * k - 1]
    return contact_arcs(slope, 0.0, math.inf, angles, zones)


@kernel(types.UniTuple(_F, 4)(ARRAY), inner=True)
def extremes(u):
    """Lowest and highest lambda over a period and where they are taken: (low, its angle, high, its angle)."""
    size = u.shape[0]
    slope = np.empty(size)
    angles, zones = np.empty(2 * size + 8), np.empty(2 * size + 8, np.int64)
    count = extrema(u, slope, angles, zones)
    low, low_at, high, high_at = u[0], 0.0, u[0], 0.0
    for i in range(count):
        value = displacement(u, angles[i])[0]
        if value < low:
            low, low_at = value, angles[i]
        if value > high:
            high, high_at = value, angles[i]
    return low, low_at, high, high_at
