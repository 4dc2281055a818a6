"""Where motions settle, and what kind of motion that is.

A motion that returns close to itself after q forcing periods is polished by Newton's method: if the periodic orbit found
is stable, near, and the motion still approaches it, it is the limit, however slowly it is reached. What does not settle
on a periodic orbit is told by its largest Lyapunov exponent.
"""

import enum
import math
from dataclasses import dataclass, field

import numpy as np

from solver.contact_system import ContactSystem
from solver.errors import ParameterError
from solver.impact import ImpactState, impact_state
from solver.timedomain.integrator import Status, checked_states, checked_tolerance
from solver.timedomain.poincare import advance, checked_count, growth, measure
from solver.timedomain.shooting import PeriodicOrbit, ShootingStatus, shoot

__all__ = ["Attractor", "AttractorKind", "Settling", "contact_impact", "settle"]


class AttractorKind(enum.IntEnum):
    """What a motion settles on."""

    FAILED = 0
    PERIOD_1 = 1
    PERIOD_2 = 2
    PERIOD_3 = 3
    PERIOD_4 = 4
    PERIOD_HIGHER = 5
    QUASI_PERIODIC = 6
    CHAOTIC = 7
    UNBOUNDED = 8
    UNSETTLED = 9

    @property
    def sentence(self) -> str:
        """What the kind means."""
        return _SENTENCES[self]

    @property
    def periodic(self) -> bool:
        """Whether the motion repeats."""
        return AttractorKind.PERIOD_1 <= self <= AttractorKind.PERIOD_HIGHER


_SENTENCES = {
    AttractorKind.FAILED: "The integrator could not continue the motion; its status says why.",
    AttractorKind.PERIOD_1: "The motion repeats after every forcing period.",
    AttractorKind.PERIOD_2: "The motion repeats after two forcing periods.",
    AttractorKind.PERIOD_3: "The motion repeats after three forcing periods.",
    AttractorKind.PERIOD_4: "The motion repeats after four forcing periods.",
    AttractorKind.PERIOD_HIGHER: "The motion repeats after more than four forcing periods.",
    AttractorKind.QUASI_PERIODIC: "The motion never repeats, and neighbouring motions neither part nor meet: a torus.",
    AttractorKind.CHAOTIC: "Neighbouring motions part exponentially: the largest Lyapunov exponent is above 0.",
    AttractorKind.UNBOUNDED: "The contact coordinate grew above the ceiling.",
    AttractorKind.UNSETTLED: "The motion still converges, slowly: it had not settled after the allowed periods.",
}


@dataclass(frozen=True, eq=False)
class Attractor:
    """What one motion settled on; numbers that do not apply are nan.

    Parameters
    ----------
    kind : AttractorKind
    period : int
        Forcing periods after which the motion repeats; 0 if it does not.
    periods_used : int
        Forcing periods integrated before the kind was known.
    mean, amplitude : float
        Lambda_0 and |Lambda_1| at the forcing frequency, over the orbit or over the window of an aperiodic motion.
    half_order_amplitude : float
        |Lambda_{1/2}| at half the forcing frequency; 0 where the motion repeats after one period.
    lowest, highest : float
        Extremes of lambda.
    impact : int
        `solver.impact.ImpactState` of these extremes for the gaps of the system; -1 if unknown.
    lyapunov, lyapunov_error : float
        Largest Lyapunov exponent per unit of tau and its standard error; of periodic motions from the multipliers.
    largest_multiplier : float
        Largest modulus of the multipliers over `period`.
    state : (2 n,) array
        The last state, at tau = 0 modulo the forcing period; of a periodic motion the point of the orbit itself.
    points : (period, 2 n) array
        All sections of a periodic motion; a sample of those of another.
    status : Status
        How the integration ended.
    """

    kind: AttractorKind
    period: int
    periods_used: int
    mean: float
    amplitude: float
    half_order_amplitude: float
    lowest: float
    highest: float
    impact: int
    lyapunov: float
    lyapunov_error: float
    largest_multiplier: float
    state: np.ndarray
    points: np.ndarray
    status: Status


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
        An exponent per forcing period is above or below 0 only if its modulus exceeds this: deviations on a torus grow or
        shrink like powers of time, which over a window of N periods looks like an exponent of some (log N) / N.
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
            if not 0.0 < getattr(self, name) < math.inf:
                raise ParameterError(name, getattr(self, name), "a finite number above 0")


def contact_impact(system: ContactSystem, lowest: float, highest: float) -> ImpactState | int:
    """Impact state for the two gaps of the system, which need not be alike; -1 where an extreme is nan."""
    if not system.two_sided:
        if math.isnan(lowest) or math.isnan(highest):
            return -1
        if lowest > system.front_gap:
            return ImpactState.PERMANENT
        return ImpactState.SINGLE_SIDED if highest > system.front_gap else ImpactState.FREE
    # Seen from the middle of the dead zone both gaps are alike.
    middle, half = 0.5 * (system.front_gap - system.back_gap), 0.5 * (system.front_gap + system.back_gap)
    code = int(impact_state(lowest - middle, highest - middle, half))
    return ImpactState(code) if code >= 0 else -1


def length_scale(system: ContactSystem, omega: float) -> float:
    """A length of the system at one frequency: gaps and the deflection under the loads, at least."""
    gaps = [abs(system.front_gap), abs(system.back_gap) if system.two_sided else 0.0]
    rows = max(len(system.load), len(system.inertial_load))
    loads = np.abs(system.load_harmonics(omega, rows - 1)).sum(axis=0)
    closed = system.stiffness + np.outer(system.force, system.contact)
    deflection = np.max(np.abs(np.linalg.lstsq(closed, loads, rcond=None)[0]))
    return max(*gaps, float(deflection)) or 1.0


def settle(
    system: ContactSystem, omega: float, states, *, settling: Settling | None = None
) -> tuple[Attractor, ...]:
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

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    settling = Settling() if settling is None else settling
    settler = _Settler(system, omega, settling)
    return tuple(settler.run(state) for state in checked_states(system, states))


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
        settling = self.settling
        last = sections[-1]
        scale = max(self.length, float(np.max(np.abs(sections))))
        if not any(_distance(points, last) < settling.near * scale for orbit, points in self.known):
            self._polish(sections, scale)
        for number, (orbit, points) in enumerate(self.known):
            distance, previous = _distance(points, last), before.get(number, math.inf)
            before[number] = distance
            # The first distance of all is compared with that of the earlier half of the block.
            if previous == math.inf:
                previous = _distance(points, sections[len(sections) // 2 - 1])
            exact = 1e3 * settling.tolerance * scale
            if orbit.stable and distance < settling.close * scale and (distance < 0.9 * previous or distance < exact):
                return orbit, points
            # So near to one, slow convergence shows in the rate that its multipliers promise.
            if orbit.stable and distance < settling.near * scale and self._contracting(orbit, distance, previous):
                return orbit, points
        return None

    def _contracting(self, orbit, distance, previous) -> bool:
        """Whether the distance shrank, over a block, at least half as fast as the multipliers promise."""
        rate = math.log(max(orbit.largest_multiplier, 1e-300)) / orbit.minimal_period
        promised = rate * self.settling.block
        return 0.0 < distance < previous and math.log(distance / previous) < 0.5 * promised

    def _polish(self, sections, scale):
        last = sections[-1]
        for period in range(1, min(self.settling.highest_period, len(sections) - 1) + 1):
            gap = float(np.max(np.abs(last - sections[-1 - period])))
            if gap >= self.settling.near * scale:
                continue
            orbit = shoot(self.system, self.omega, last, period, max_iterations=8)
            if orbit.status is not ShootingStatus.CONVERGED:
                continue
            away = float(np.max(np.abs(orbit.state - last)))
            if away < 10.0 * self.settling.near * scale and orbit.stable:
                if orbit.minimal_period < orbit.period:
                    orbit = shoot(self.system, self.omega, orbit.state, orbit.minimal_period)
                    if orbit.status is not ShootingStatus.CONVERGED:
                        continue
                self.known.append((orbit, self._points(orbit)))
                return

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
            AttractorKind(min(q, int(AttractorKind.PERIOD_HIGHER))), q, used, float(found.harmonics[0].real),
            float(abs(found.harmonics[2 * q])), float(half), found.lowest, found.highest,
            self._impact(found.lowest, found.highest), rate, 0.0, largest, orbit.state, points, Status.COMPLETE,
        )  # fmt: skip

    def _aperiodic(self, current, used) -> Attractor:
        settling, begin = self.settling, used
        window = settling.lyapunov_periods
        # A tenth of the window lets the deviation turn into the direction that grows fastest.
        logarithms, end, status = growth(
            self.system, self.omega, current, window + window // 10, tolerance=settling.tolerance,
            ceiling=self.ceiling,
        )  # fmt: skip
        if status is not Status.COMPLETE:
            return self._ended(current, used, status)
        batches = logarithms[window // 10 :][: window - window % 20].reshape(20, -1).mean(axis=1)
        exponent, error = float(batches.mean()), float(batches.std(ddof=1) / math.sqrt(batches.size))
        even = window - window % 2
        found = measure(
            self.system, self.omega, current, even, divisor=2, order=2, tolerance=settling.tolerance,
            ceiling=self.ceiling,
        )  # fmt: skip
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
            kind, 0, used, float(found.harmonics[0].real), float(abs(found.harmonics[2])),
            float(abs(found.harmonics[1])), found.lowest, found.highest, self._impact(found.lowest, found.highest),
            exponent * rate, error * rate, math.nan, sections.states[0, -1], sections.states[0], Status.COMPLETE,
        )  # fmt: skip

    def _approaching(self, early, late, elapsed) -> bool:
        """Whether a motion far from a stable orbit of 1 or 2 periods still approaches it, slowly.

        An exponent so close to 0 looks like that of a torus; the distance to the orbit tells them apart.
        """
        first = advance(
            self.system, self.omega, early, self.settling.block, tolerance=self.settling.tolerance
        ).states[0]
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
