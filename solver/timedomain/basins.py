"""How much of a box of initial states leads to which attractor."""

import math
from dataclasses import dataclass

import numpy as np

from solver.model.checks import ParameterError, finite_array, finite_number, frequency, instance_of
from solver.model.contact_system import ContactSystem
from solver.timedomain.attractor import Attractor, AttractorKind
from solver.timedomain.poincare import checked_count
from solver.timedomain.settling import Settling, length_scale, settle

__all__ = ["BasinShare", "basin_box", "basin_shares", "same_attractor", "wilson_interval"]


@dataclass(frozen=True, eq=False)
class BasinShare:
    """One attractor and the share of the random starts that reached it.

    Parameters
    ----------
    attractor : Attractor
        The first that was found of those taken for one.
    count, total : int
        Starts that reached it, and all starts.
    low, high : float
        Wilson 95 % confidence interval of the share.
    """

    attractor: Attractor
    count: int
    total: int
    low: float
    high: float

    @property
    def share(self) -> float:
        """Observed share."""
        return self.count / self.total


def wilson_interval(count: int, total: int, quantile: float = 1.959963984540054) -> tuple[float, float]:
    """Confidence interval of a share p from `count` successes in `total` trials.

    With p = count / total and z the normal quantile (97.5 % unless given),

        (p + z^2 / 2n -+ z sqrt(p (1 - p) / n + z^2 / 4 n^2)) / (1 + z^2 / n)

    (E. B. Wilson, "Probable inference, the law of succession, and statistical inference", Journal of the American
    Statistical Association 22 (1927) 209-212).

    Parameters
    ----------
    count : int
        From 0 to total.
    total : int
        From 1.
    quantile : float
        z, > 0.

    Returns
    -------
    (low, high)

    Raises
    ------
    ParameterError
        If an argument is not allowed.

    Examples
    --------
    >>> low, high = wilson_interval(0, 10)
    >>> float(low), round(high, 4)
    (0.0, 0.2775)
    """
    total, quantile = checked_count("total", total), finite_number("quantile", quantile, above=0.0)
    count = checked_count("count", count, 0, total)
    share, square = count / total, quantile**2 / total
    centre = share + 0.5 * square
    half = math.sqrt(share * (1.0 - share) * square + 0.25 * square**2)
    # At the ends the formula gives 0 and 1 exactly, rounding does not.
    low = 0.0 if count == 0 else (centre - half) / (1.0 + square)
    high = 1.0 if count == total else (centre + half) / (1.0 + square)
    return low, high


def basin_box(system: ContactSystem, omega: float) -> np.ndarray:
    """Half widths (2 n,) of the default box of initial states, centred at 0.

    Positions reach 3 times the largest gap (both are lengths of lambda) plus the deflection that the sum of the load
    amplitudes gives in permanent contact; speeds reach as far times the frequency of the softest mode in contact, or
    times Omega where that is lower, so that a start at the edge has energy of the order of one at the edge in position.

    Raises
    ------
    ParameterError
        If it is no ContactSystem, or omega is not a finite number above 0.
    """
    inverse, omega = np.linalg.inv(instance_of("system", system, ContactSystem).mass), frequency(omega)
    closed = system.stiffness + np.outer(system.force, system.contact)
    frequencies = np.sqrt(np.abs(np.linalg.eigvals(inverse @ closed)))
    frequencies = frequencies[frequencies > 1e-9 * max(1.0, float(np.max(frequencies)))]
    gaps = max(abs(system.front_gap), abs(system.back_gap) if system.two_sided else 0.0)
    reach = 3.0 * gaps + length_scale(system, omega)
    speed = reach * min(float(np.min(frequencies, initial=omega)), omega)
    return np.concatenate([np.full(system.degrees, reach), np.full(system.degrees, speed)])


def same_attractor(one: Attractor, other: Attractor, tolerance: float = 1e-5) -> bool:
    """Whether two results describe one attractor.

    Periodic motions are compared by their sections, whichever comes first. Aperiodic ones are one attractor when mean
    and amplitude agree to a twentieth of their range of lambda: over finite windows no more can be said. Failures and
    unbounded motions count as one outcome each.

    Parameters
    ----------
    one, other : Attractor
    tolerance : float
        Largest distance of sections, as a share of the motion's size.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    instance_of("one", one, Attractor)
    instance_of("other", other, Attractor)
    finite_number("tolerance", tolerance, above=0.0)
    if one.kind is not other.kind or one.period != other.period:
        return False
    if one.kind.periodic:
        scale = max(1.0, float(np.max(np.abs(one.points))))
        gaps = np.max(np.abs(other.points - one.points[0]), axis=1)
        return bool(np.min(gaps) < tolerance * scale)
    if one.kind in (AttractorKind.UNBOUNDED, AttractorKind.FAILED):
        return True
    room = 0.05 * max(one.highest - one.lowest, other.highest - other.lowest)
    return abs(one.mean - other.mean) < room and abs(one.amplitude - other.amplitude) < room


def basin_shares(
    system: ContactSystem, omega: float, count: int, seed: int, *, box=None, settling: Settling | None = None
) -> tuple[BasinShare, ...]:
    """Settle random initial states, uniform in a box, and count which attractors they reach.

    Parameters
    ----------
    system : ContactSystem
    omega : float
    count : int
        Number of initial states.
    seed : int
        Of `numpy.random.default_rng`; the same seed gives the same states.
    box : (2 n,) or (2, 2 n) array_like, optional
        Half widths about 0, or lower and upper ends, of (y, y'); `basin_box` unless given.
    settling : Settling, optional

    Returns
    -------
    tuple of BasinShare
        The largest share first; counts add up to `count`.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    count, seed = checked_count("count", count), checked_count("seed", seed, 0, 2**63 - 1)
    instance_of("system", system, ContactSystem)
    omega = frequency(omega)
    width = basin_box(system, omega) if box is None else finite_array("box", box, None)
    ends = np.array([-width, width]) if width.ndim == 1 else width
    if ends.shape != (2, 2 * system.degrees) or not np.all(ends[0] <= ends[1]):
        raise ParameterError("box", box, f"{2 * system.degrees} half widths, or as many lower and upper ends")
    starts = np.random.default_rng(seed).uniform(ends[0], ends[1], (count, 2 * system.degrees))
    groups: list[list[Attractor]] = []
    for attractor in settle(system, omega, starts, settling=settling):
        for group in groups:
            if same_attractor(group[0], attractor):
                group.append(attractor)
                break
        else:
            groups.append([attractor])
    groups.sort(key=lambda group: (-len(group), group[0].kind, group[0].amplitude))
    return tuple(BasinShare(group[0], len(group), count, *wilson_interval(len(group), count)) for group in groups)
