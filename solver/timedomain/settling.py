"""Where motions settle.

A motion that returns close to itself after q forcing periods is polished by Newton's method: if the orbit found is
stable and near, and the motion still approaches it, it is the limit, however slowly it is reached. What does not settle
on a periodic orbit is told by its largest Lyapunov exponent.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from solver.model.checks import finite_number, frequency, instance_of
from solver.model.contact_system import ContactSystem, in_motion, reduced
from solver.timedomain.attractor import Attractor, AttractorKind, contact_impact
from solver.timedomain.integrator import Status, checked_states, checked_tolerance, with_the_rest
from solver.timedomain.poincare import advance, checked_count, growth, measure
from solver.timedomain.shooting import PeriodicOrbit, ShootingStatus, shoot

__all__ = ["Settling", "length_scale", "settle"]


@dataclass(frozen=True)
class Settling:
    """How long and how strictly motions are watched.

    Parameters
    ----------
    max_periods : int
        Forcing periods before the Lyapunov exponent decides.
    block : int
        Periods between two looks at the sections.
    highest_period : int
        Periodic motions are sought up to this number of forcing periods.
    near : float
        A return within this distance, relative to the scale of the motion, is polished by shooting.
    close : float
        A stable periodic orbit is the limit when the motion has come this near to it, and nearer than a block before.
    lyapunov_periods : int
        Window over which the exponent, the harmonics and the extremes of aperiodic motions are taken.
    lyapunov_floor : float
        An exponent per forcing period is above or below 0 only if its modulus exceeds this: deviations on a torus grow
        or shrink like powers of time, which over a window of N periods looks like an exponent of some (log N) / N.
        Chaos weaker than this is taken for a torus.
    tolerance : float
        Of the integration.
    ceiling : float
        A motion is unbounded when |lambda| exceeds this many times the length of the system (gaps, static deflection).

    Raises
    ------
    ParameterError
        If a setting is not allowed.
    """

    max_periods: int = 3000
    block: int = 60
    highest_period: int = 24
    near: float = 1e-2
    close: float = 1e-3
    lyapunov_periods: int = 2000
    lyapunov_floor: float = 4e-3
    tolerance: float = 1e-10
    ceiling: float = 1e4

    def __post_init__(self):
        checked_count("max_periods", self.max_periods)
        checked_count("highest_period", self.highest_period, 4, 1000)
        checked_count("block", self.block, 2 * self.highest_period)
        checked_count("lyapunov_periods", self.lyapunov_periods, 40)
        checked_tolerance(self.tolerance)
        for name in ("near", "close", "lyapunov_floor", "ceiling"):
            finite_number(name, getattr(self, name), above=0.0)


def length_scale(system: ContactSystem, omega: float) -> float:
    """A length of the system at one frequency: gaps and the deflection under the loads, at least."""
    gaps = [abs(system.front_gap), abs(system.back_gap) if system.two_sided else 0.0]
    rows = max(len(system.load), len(system.inertial_load))
    loads = np.abs(system.load_harmonics(omega, rows - 1)).sum(axis=0)
    closed = system.stiffness + np.outer(system.force, system.contact)
    deflection = np.max(np.abs(np.linalg.lstsq(closed, loads, rcond=None)[0]))
    return max(*gaps, float(deflection)) or 1.0


def settle(system: ContactSystem, omega: float, states, *, settling: Settling | None = None) -> tuple[Attractor, ...]:
    """Follow motions from tau = 0 until it is known where they settle.

    Parameters
    ----------
    system : ContactSystem
    omega : float
    states : (k, 2 n) array_like
        Initial states.
    settling : Settling, optional

    Returns
    -------
    tuple of k Attractor
        0 where a coordinate is no part of the motion (`solver.model.contact_system.in_motion`).

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    instance_of("system", system, ContactSystem)
    settling = Settling() if settling is None else instance_of("settling", settling, Settling)
    omega = frequency(omega)
    starts, kept = checked_states(system, states), np.tile(in_motion(system), 2)
    if not np.all(kept):
        found = settle(reduced(system), omega, starts[:, kept], settling=settling)
        wholes = ((with_the_rest(system, one.state), with_the_rest(system, one.points)) for one in found)
        return tuple(replace(one, state=s, points=p) for one, (s, p) in zip(found, wholes, strict=True))
    settler = _Settler(system, omega, settling)
    return tuple(settler.run(state) for state in starts)


@dataclass
class _Settler:
    """Settles motions one after another and remembers the periodic orbits found, so that Newton runs once for each."""

    system: ContactSystem
    omega: float
    settling: Settling
    known: list[tuple[PeriodicOrbit, np.ndarray]] = field(default_factory=list)

    def __post_init__(self):
        self.length = length_scale(self.system, self.omega)
        self.ceiling = self.settling.ceiling * self.length

    def run(self, start) -> Attractor:
        settling = self.settling
        current, used, before = start, 0, {}
        while used < settling.max_periods:
            block = min(settling.block, settling.max_periods - used)
            sections = advance(
                self.system, self.omega, current, block, tolerance=settling.tolerance, ceiling=self.ceiling
            )
            status = Status(sections.status[0])
            if status is not Status.COMPLETE:
                return self._ended(current, used, status)
            current, used = sections.states[0, -1], used + block
            limit = self._limit(sections.states[0], before)
            if limit is not None:
                return self._periodic(*limit, used)
        return self._aperiodic(current, used)

    def _limit(self, sections, before):
        """The periodic orbit that the motion approaches, with its points in the order of the last section, or None.

        `before` holds the distances to known orbits one block ago and is brought up to date.
        """
        scale = max(self.length, float(np.max(np.abs(sections))))
        for number in range(len(self.known)):
            if self._approached(number, sections, scale, before):
                return self.known[number]
        # Two attractors may lie close together: a known orbit nearby does not spare the search for another.
        if self._polish(sections, scale) and self._approached(len(self.known) - 1, sections, scale, before):
            return self.known[-1]
        return None

    def _approached(self, number, sections, scale, before) -> bool:
        """Whether the motion is near one of the known orbits and comes nearer."""
        settling, last = self.settling, sections[-1]
        orbit, points = self.known[number]
        distance, previous = _distance(points, last), before.get(number, math.inf)
        before[number] = distance
        # The first distance of all is compared with that in the middle of the block.
        if previous == math.inf:
            previous = _distance(points, sections[len(sections) // 2 - 1])
        if distance < 1e3 * settling.tolerance * scale:
            return True
        if distance < settling.close * scale and distance < 0.9 * previous:
            return True
        # So near to a stable orbit, slow convergence shows in the rate that its multipliers promise.
        return distance < settling.near * scale and self._contracting(orbit, distance, previous)

    def _contracting(self, orbit, distance, previous) -> bool:
        """Whether the distance shrank, over a block, at least half as fast as the multipliers promise."""
        rate = math.log(max(orbit.largest_multiplier, 1e-300)) / orbit.minimal_period
        promised = rate * self.settling.block
        return 0.0 < distance < previous and math.log(distance / previous) < 0.5 * promised

    def _polish(self, sections, scale) -> bool:
        """Seek a stable periodic orbit where the motion returned close to itself; whether one was added to `known`."""
        near, last = self.settling.near * scale, sections[-1]
        most = min(self.settling.highest_period, len(sections) - 1)
        gaps = {period: float(np.max(np.abs(last - sections[-1 - period]))) for period in range(1, most + 1)}
        # A torus returns close after many periods, and each search would be in vain: of the long ones the closest does.
        candidates = [period for period in gaps if period <= 4]
        if most > 4:
            candidates.append(min((period for period in gaps if period > 4), key=gaps.__getitem__))
        for period in candidates:
            if gaps[period] >= near:
                continue
            orbit = shoot(self.system, self.omega, last, period, max_iterations=8)
            if orbit.status is ShootingStatus.CONVERGED and orbit.minimal_period < period:
                orbit = shoot(self.system, self.omega, orbit.state, orbit.minimal_period)
            if orbit.status is not ShootingStatus.CONVERGED or not orbit.stable:
                continue
            if float(np.max(np.abs(orbit.state - last))) >= 10.0 * near:
                continue
            if all(_distance(points, orbit.state) > 1e-7 * scale for _, points in self.known):
                self.known.append((orbit, self._points(orbit)))
                return True
        return False

    def _points(self, orbit):
        if orbit.period == 1:
            return orbit.state[None, :].copy()
        rest = advance(self.system, self.omega, orbit.state, orbit.period - 1, tolerance=1e-12).states[0]
        return np.concatenate([orbit.state[None, :], rest])

    def _impact(self, lowest, highest) -> int:
        return int(contact_impact(self.system, lowest, highest))

    def _periodic(self, orbit, points, used) -> Attractor:
        q = orbit.period
        found = measure(self.system, self.omega, orbit.state, q, divisor=2 * q, order=2 * q, tolerance=1e-12)
        # Lines between those of the orbit are rounding; of an odd period the half order is such a line.
        half = abs(found.harmonics[q]) if q % 2 == 0 else 0.0
        largest = orbit.largest_multiplier
        rate = math.log(largest) * self.omega / (2.0 * math.pi * q) if largest > 0.0 else -math.inf
        return Attractor(
            AttractorKind(min(q, int(AttractorKind.PERIOD_HIGHER))),
            q,
            used,
            float(found.harmonics[0].real),
            float(abs(found.harmonics[2 * q])),
            float(half),
            found.lowest,
            found.highest,
            self._impact(found.lowest, found.highest),
            rate,
            0.0,
            largest,
            orbit.state,
            points,
            Status.COMPLETE,
        )

    def _aperiodic(self, current, used) -> Attractor:
        settling, begin = self.settling, used
        window = settling.lyapunov_periods
        # A tenth of the window lets the deviation turn into the direction that grows fastest.
        logarithms, end, status = growth(
            self.system, self.omega, current, window + window // 10, tolerance=settling.tolerance, ceiling=self.ceiling
        )
        if status is not Status.COMPLETE:
            return self._ended(current, used, status)
        batches = logarithms[window // 10 :][: window - window % 20].reshape(20, -1).mean(axis=1)
        exponent, error = float(batches.mean()), float(batches.std(ddof=1) / math.sqrt(batches.size))
        even = window - window % 2
        found = measure(
            self.system,
            self.omega,
            current,
            even,
            divisor=2,
            order=2,
            tolerance=settling.tolerance,
            ceiling=self.ceiling,
        )
        sections = advance(
            self.system, self.omega, end, settling.block, tolerance=settling.tolerance, ceiling=self.ceiling
        )
        for result in (found.status, Status(sections.status[0])):
            if result is not Status.COMPLETE:
                return self._ended(current, used, result)
        used += window + window // 10 + settling.block
        # The longer watch may have brought a slow motion home.
        limit = self._limit(sections.states[0], {})
        if limit is not None:
            return self._periodic(*limit, used)
        margin = max(settling.lyapunov_floor, 4.0 * error)
        if exponent > margin:
            kind = AttractorKind.CHAOTIC
        elif exponent < -margin or self._approaching(current, sections.states[0], used - begin):
            kind = AttractorKind.UNSETTLED
        else:
            kind = AttractorKind.QUASI_PERIODIC
        rate = self.omega / (2.0 * math.pi)
        return Attractor(
            kind,
            0,
            used,
            float(found.harmonics[0].real),
            float(abs(found.harmonics[2])),
            float(abs(found.harmonics[1])),
            found.lowest,
            found.highest,
            self._impact(found.lowest, found.highest),
            exponent * rate,
            error * rate,
            math.nan,
            sections.states[0, -1],
            sections.states[0],
            Status.COMPLETE,
        )

    def _approaching(self, early, late, elapsed) -> bool:
        """Whether a motion far from a stable orbit of 1 or 2 periods still approaches it, slowly.

        An exponent so close to 0 looks like that of a torus; the distance to the orbit tells them apart.
        """
        first = advance(self.system, self.omega, early, self.settling.block, tolerance=self.settling.tolerance).states[
            0
        ]
        for period in (1, 2):
            orbit = shoot(self.system, self.omega, late[-1], period)
            if orbit.status is not ShootingStatus.CONVERGED or not orbit.stable:
                continue
            points = self._points(orbit)
            # The largest distance within a block does not feel where in its slow beat the motion happens to be.
            distances = [max(_distance(points, state) for state in block) for block in (first, late)]
            promised = math.log(max(orbit.largest_multiplier, 1e-300)) / period * elapsed
            if distances[0] > 0.0 and distances[1] < distances[0] * math.exp(0.5 * promised):
                return True
        return False

    def _ended(self, current, used, status) -> Attractor:
        kind = AttractorKind.UNBOUNDED if status is Status.CEILING else AttractorKind.FAILED
        nothing = (math.nan,) * 5
        return Attractor(
            kind, 0, used, *nothing, -1, math.nan, math.nan, math.nan, current, np.empty((0, current.size)), status
        )


def _distance(points, state) -> float:
    """Distance from a state to the nearest section of an orbit."""
    return float(np.min(np.max(np.abs(points - state), axis=1)))
