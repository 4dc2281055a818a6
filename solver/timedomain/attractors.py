"""Attractors of every cell of a row, each followed over its whole domain along the row.

In each cell motions are started from rest, from the stable motions of a map and from random states. Then every attractor
found is a start in both neighbouring cells, until none of them gains one (global continuation; G. Datseris,
K. L. Rossi, A. Wagemakers, "Framework for global stability analysis of dynamical systems", Chaos 33 (2023) 073151).
Which attractor leads to which in the next cell is kept: it tells what a slow run-up and run-down would meet.
"""

import enum
import math
from dataclasses import dataclass, replace

import numpy as np

from solver.flow.loads import loaded_system_at
from solver.flow.switched_system import FREQUENCY, LENGTH
from solver.flow.taylor import new_series
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.model.checks import ParameterError, finite_array, finite_number, instance_of, number_array, whole_number
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import check_axis
from solver.timedomain.attractor import AttractorKind, impact_of_range
from solver.timedomain.integrator import COMPLETE, checked_tolerance, new_deviations
from solver.timedomain.orbits import HIGHEST_PERIOD, ORBITS, SAMPLE, Orbits, new_orbits
from solver.timedomain.poincare import Watch, carry_over_period, watch_nothing
from solver.timedomain.row_systems import RowSystems, motion_states, random_states, row_systems
from solver.timedomain.settling import FAILED, LIMITS, NO_ROOM, Limits, keep_aperiodic, settle_states, try_orbit

__all__ = ["AttractorRow", "AttractorSearch", "SeenFrom", "continue_attractors", "find_attractors", "settle"]

_F, _I = types.float64, types.int64
_COUNTS = types.int64[::1]

#: Forcing periods over which the quantities of an aperiodic attractor are taken.
_WINDOW = 128

# An orbit that Newton's method finds from a motion of a map, or from an attractor of a neighbouring cell, is taken for
# what that motion ends on if it is no farther away than this share of the system's length; else the motion is followed.
_APART = 0.2


class SeenFrom(enum.IntFlag):
    """What led to an attractor."""

    REST = 1
    UPWARDS = 2
    DOWNWARDS = 4
    MOTION = 8
    RANDOM = 16
    NEIGHBOUR = 32


@dataclass(frozen=True)
class AttractorSearch:
    """How attractors are sought.

    Parameters
    ----------
    starts : int
        Random initial states in each cell.
    transient : int
        Forcing periods that a motion has to settle.
    watched : int
        Forcing periods, after these, over which the growth of a deviation tells chaos from a torus.
    floor : float
        Growth per forcing period below which a motion counts as a torus: deviations on a torus grow like powers of
        time, which over N periods looks like a growth of some (log N) / N.
    near : float
        A return within this distance, as a share of the length of the system, is polished by Newton's method.
    tolerance : float
        Of the integration.
    ceiling : float
        A motion is unbounded when |lambda| exceeds this many times the length of the system.
    room : int
        Attractors that can be told apart in a cell.

    Raises
    ------
    ParameterError
        If a setting is not allowed.
    """

    starts: int = 4
    transient: int = 240
    watched: int = 1000
    floor: float = 6e-3
    near: float = 0.03
    tolerance: float = 1e-9
    ceiling: float = 1e4
    room: int = 8

    def __post_init__(self):
        whole_number("starts", self.starts, 0, 10**6)
        whole_number("transient", self.transient, 100, 10**7)
        whole_number("watched", self.watched, 400, 10**7)
        whole_number("room", self.room, 2, 100)
        checked_tolerance(self.tolerance)
        for name in ("near", "floor", "ceiling"):
            finite_number(name, getattr(self, name), above=0.0)

    def limits(self, length: float) -> Limits:
        """For kernels, in a system of this length."""
        return Limits(
            self.tolerance, self.ceiling * length, self.near, int(self.transient), int(self.watched), self.floor
        )


@dataclass(frozen=True, eq=False)
class AttractorRow:
    """Attractors of the X cells of a row, in the order in which they were found; A slots a cell.

    Numbers that do not apply are nan; amplitudes, extremes and RMS are those of lambda over the own period of a motion,
    or over 128 forcing periods of an aperiodic one.

    Parameters
    ----------
    kind : (X, A) int8 array
        `AttractorKind`.
    impact : (X, A) int8 array
        `ImpactState`; -1 for none.
    seen : (X, A) uint8 array
        Bits of `SeenFrom`.
    round : (X, A) int16 array
        Round in which it was found; -1 for none.
    lowest, highest, mean, amplitude, rms, peak_to_peak : (X, A) arrays
    force : (X, A) array
        Largest mesh force over the static one: K_v.
    contact_loss : (X, A) array
        Share of the period.
    lyapunov, lyapunov_error : (X, A) arrays
        Largest Lyapunov exponent per unit of tau and its standard error; of periodic motions from the multipliers.
    hits : (X, A) int32 array
        Random starts that ended on it.
    upwards, downwards : (X, A) int8 arrays
        Slot that it leads to in the next and in the previous column; -1 where there is none.
    state : (X, A, m) array
        On the section tau = 0 mod 2 pi / Omega, in the coordinates of `solver.model.contact_system.reduced`.
    starts : (X,) int32 array
        Random starts that the integrator could carry on.
    motion : (X, S) int8 array
        Slot that each motion of the map leads to; -1 where it is not known.
    box : (X, 2) array
        Half widths of the box of random states: of coordinates and of speeds.
    overflow : (X,) bool array
        Where there are more attractors than slots.
    failures : (X,) int32 array
        Starts that the integrator could not carry on.
    """

    kind: np.ndarray
    impact: np.ndarray
    seen: np.ndarray
    round: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    mean: np.ndarray
    amplitude: np.ndarray
    rms: np.ndarray
    peak_to_peak: np.ndarray
    force: np.ndarray
    contact_loss: np.ndarray
    lyapunov: np.ndarray
    lyapunov_error: np.ndarray
    hits: np.ndarray
    upwards: np.ndarray
    downwards: np.ndarray
    state: np.ndarray
    starts: np.ndarray
    motion: np.ndarray
    box: np.ndarray
    overflow: np.ndarray
    failures: np.ndarray

    def gains(self, round: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Columns (K,), kinds (K,) and states (K, m) of the settled attractors found in one round."""
        columns, slots = np.nonzero((self.round == round) & (self.kind >= 1) & (self.kind <= AttractorKind.CHAOTIC))
        return columns, self.kind[columns, slots], self.state[columns, slots]


@kernel(types.void(ARRAY, ARRAY, _F, ORBITS, _I, MATRIX, MATRIX, LIMITS, _COUNTS))
def _search(parameters, parameter_slope, p, orbits, period, motions, states, limits, slots):
    """Slots (k + l,) that k motions of a map and l other states lead to; the states are overwritten."""
    system = loaded_system_at(parameters, parameter_slope, p)
    limits = _scaled(limits, system.numbers[LENGTH])
    for i in range(motions.shape[0]):
        slots[i] = try_orbit(system, orbits, motions[i], period, limits.ceiling, _APART * system.numbers[LENGTH])
        if slots[i] < 0:
            settle_states(system, orbits, motions[i : i + 1], limits, slots[i : i + 1])
    settle_states(system, orbits, states, limits, slots[motions.shape[0] :])


@kernel(LIMITS(LIMITS, _F), inner=True)
def _scaled(limits, length):
    """The ceiling as a length."""
    return Limits(
        limits.tolerance, limits.ceiling * length, limits.near, limits.transient, limits.watched, limits.floor
    )


@kernel(types.void(ARRAY, ARRAY, _F, ORBITS, _COUNTS, MATRIX, LIMITS, _COUNTS))
def _continue(parameters, parameter_slope, p, orbits, kinds, states, limits, slots):
    """Slots (k,) that k attractors of another cell, of these kinds, lead to; the states are overwritten."""
    system = loaded_system_at(parameters, parameter_slope, p)
    limits = _scaled(limits, system.numbers[LENGTH])
    for i in range(states.shape[0]):
        slots[i] = -1
        if kinds[i] <= HIGHEST_PERIOD:
            apart = _APART * system.numbers[LENGTH]
            slots[i] = try_orbit(system, orbits, states[i], kinds[i], limits.ceiling, apart)
        if slots[i] < 0:
            settle_states(system, orbits, states[i : i + 1], limits, slots[i : i + 1])


@kernel(types.void(ARRAY, ARRAY, _F, ORBITS, _COUNTS, MATRIX, MATRIX, LIMITS))
def _recall(parameters, parameter_slope, p, orbits, kinds, states, rates, limits):
    """Make attractors of these kinds (k,) known again from a state (k, m) of each, in their slots."""
    system = loaded_system_at(parameters, parameter_slope, p)
    limits = _scaled(limits, system.numbers[LENGTH])
    size = states.shape[1]
    deviations, series, nothing = new_deviations(np.empty((0, size))), new_series(size // 2), watch_nothing()
    sample, state = np.empty((SAMPLE, size)), np.empty(size)
    for slot in range(kinds.shape[0]):
        if kinds[slot] <= HIGHEST_PERIOD:
            try_orbit(system, orbits, states[slot], kinds[slot], limits.ceiling, math.inf)
        elif kinds[slot] <= 10:
            copy_into(state, states[slot])
            for i in range(7 * SAMPLE):
                carry_over_period(system, state, deviations, limits.tolerance, limits.ceiling, 0.0, nothing, series)
                if i % 7 == 0:
                    copy_into(sample[i // 7], state)
            keep_aperiodic(system, orbits, kinds[slot], sample, rates[slot, 0], rates[slot, 1])
        # What has no sections, or was not found again, keeps its slot.
        if orbits.count[0] <= slot:
            orbits.kind[slot] = kinds[slot] if kinds[slot] > 10 else 0
            orbits.count[0] = slot + 1


@kernel(types.void(ARRAY, ARRAY, _F, ORBITS, _I, LIMITS, MATRIX))
def _describe(parameters, parameter_slope, p, orbits, first, limits, numbers):
    """Quantities (A, 4) of the attractors from slot `first` on: lowest, highest, mean, amplitude of lambda."""
    system = loaded_system_at(parameters, parameter_slope, p)
    limits = _scaled(limits, system.numbers[LENGTH])
    size, omega = orbits.points.shape[2], system.numbers[FREQUENCY]
    deviations, series, state = new_deviations(np.empty((0, size))), new_series(size // 2), np.empty(size)
    for slot in range(first, orbits.count[0]):
        kind = orbits.kind[slot]
        if kind < 1 or kind > 10:
            continue
        periods = kind if kind <= HIGHEST_PERIOD else _WINDOW
        copy_into(state, orbits.points[slot, 0])
        extremes, sums = np.array([math.inf, -math.inf]), np.zeros((2, 2))
        watch = Watch(extremes, sums, np.zeros(1, np.int64), omega)
        for _ in range(periods):
            status = carry_over_period(system, state, deviations, limits.tolerance, limits.ceiling, 0.0, watch, series)
            if status != COMPLETE:
                break
        scale = omega / (math.pi * periods)
        numbers[slot, 0], numbers[slot, 1] = extremes[0], extremes[1]
        numbers[slot, 2] = 0.5 * sums[0, 0] * scale
        numbers[slot, 3] = math.hypot(sums[1, 0], sums[1, 1]) * scale


class _RowSearch:
    """The cells of a row while attractors are sought in them."""

    def __init__(self, systems: RowSystems, search: AttractorSearch, motions: int):
        columns, room = systems.values.size, search.room
        self.systems, self.search = systems, search
        self.limits = search.limits(1.0)
        self.orbits: list[Orbits | None] = [None] * columns
        self.kind = np.zeros((columns, room), np.int8)
        self.round = np.full((columns, room), -1, np.int16)
        self.seen = np.zeros((columns, room), np.uint8)
        self.hits = np.zeros((columns, room), np.int32)
        self.numbers = np.full((columns, room, 4), np.nan)
        self.rates = np.full((columns, room, 2), np.nan)
        self.state = np.full((columns, room, systems.size), np.nan)
        # -2: not tried yet.
        self.links = {1: np.full((columns, room), -2, np.int8), -1: np.full((columns, room), -2, np.int8)}
        self.starts, self.failures = np.zeros(columns, np.int32), np.zeros(columns, np.int32)
        self.motion = np.full((columns, motions), -1, np.int8)
        self.overflow = np.zeros(columns, bool)

    def _orbits(self, i: int) -> Orbits:
        """What is known of a cell, made again from its states where the row is a stored one."""
        if self.orbits[i] is None:
            size = 2 * int(self.systems.degrees[i])
            orbits = new_orbits(self.search.room, size)
            count = int(np.count_nonzero(self.kind[i]))
            if count:
                kinds, states = self.kind[i, :count].astype(np.int64), self.state[i, :count, :size].copy()
                _recall(*self._at(i), orbits, kinds, states, self.rates[i, :count].copy(), self.limits)
            self.orbits[i] = orbits
        return self.orbits[i]

    def _at(self, i: int) -> tuple:
        return self.systems.parameters, self.systems.parameter_slope, float(self.systems.values[i])

    def _took(self, i: int, before: int, round: int) -> None:
        """Take over what became known in a cell."""
        orbits = self.orbits[i]
        count = int(orbits.count[0])
        if count == before:
            return
        numbers = self.numbers[i]
        _describe(*self._at(i), orbits, before, self.limits, numbers)
        self.kind[i, before:count] = orbits.kind[before:count]
        self.round[i, before:count] = round
        self.rates[i, before:count] = orbits.rates[before:count]
        self.state[i, before:count, : orbits.points.shape[2]] = orbits.points[before:count, 0]

    def _mark(self, i: int, slots: np.ndarray, bits: SeenFrom) -> None:
        reached = slots[slots >= 0]
        self.seen[i, reached] |= int(bits)
        self.overflow[i] |= bool(np.any(slots == NO_ROOM))
        self.failures[i] += np.count_nonzero(slots == FAILED)

    def start(self, motions: np.ndarray, randoms: np.ndarray, period: int) -> None:
        """Seek attractors in every cell from motions (X, S, m), from rest, and from random states (X, k, m)."""
        for i in range(self.systems.values.size):
            orbits, size = self._orbits(i), 2 * int(self.systems.degrees[i])
            there = np.flatnonzero(np.isfinite(motions[i, :, 0]))
            states = np.concatenate([self.systems.rest[None, i, :size], randoms[i, :, :size]])
            slots = np.empty(there.size + len(states), np.int64)
            own = np.ascontiguousarray(motions[i, there, :size])
            _search(*self._at(i), orbits, period, own, states, self.limits, slots)
            self._took(i, 0, 0)
            of_motions, of_rest, of_random = np.split(slots, [there.size, there.size + 1])
            self._mark(i, of_motions, SeenFrom.MOTION)
            self._mark(i, of_rest, SeenFrom.REST)
            self._mark(i, of_random, SeenFrom.RANDOM)
            self.motion[i, there] = np.maximum(of_motions, -1)
            np.add.at(self.hits[i], of_random[of_random >= 0], 1)
            self.starts[i] = np.count_nonzero(of_random != FAILED)

    def bring(self, i: int, kinds: np.ndarray, states: np.ndarray, round: int) -> np.ndarray:
        """Start in a cell from attractors of another one; the slots (k,) that they lead to."""
        orbits, size = self._orbits(i), 2 * int(self.systems.degrees[i])
        own = np.array(states[:, :size])
        foreign = np.isnan(own).any(axis=1) | np.isfinite(states[:, size:]).any(axis=1)
        if np.any(foreign):
            # Another number of coordinates: lambda and its speed are brought, the others are at rest.
            own[foreign] = [self._brought(i, state) for state in states[foreign]]
        before, slots = int(orbits.count[0]), np.empty(len(kinds), np.int64)
        _continue(*self._at(i), orbits, kinds.astype(np.int64), own, self.limits, slots)
        self._took(i, before, round)
        self._mark(i, slots, SeenFrom.NEIGHBOUR)
        return slots

    def _brought(self, i: int, state: np.ndarray) -> np.ndarray:
        n, given = int(self.systems.degrees[i]), np.count_nonzero(np.isfinite(state)) // 2
        own = self.systems.rest[i, : 2 * n].copy()
        own[n - 1], own[2 * n - 1] = state[given - 1], state[2 * given - 1]
        return own

    def spread(self, round: int) -> None:
        """Follow attractors along the row, both ways, until no cell gains one."""
        last, gained = self.systems.values.size - 1, True
        while gained:
            gained = False
            for way, columns in ((1, range(last)), (-1, range(last, 0, -1))):
                links = self.links[way]
                for i in columns:
                    settled = (self.kind[i] >= 1) & (self.kind[i] <= AttractorKind.CHAOTIC)
                    open_ = np.flatnonzero(settled & (links[i] == -2))
                    if open_.size:
                        before = np.count_nonzero(self.kind[i + way])
                        slots = self.bring(i + way, self.kind[i, open_], self.state[i, open_], round)
                        ends = np.where(slots >= 0, self.kind[i + way][slots], 0)
                        links[i, open_] = np.where((ends >= 1) & (ends <= AttractorKind.CHAOTIC), slots, -1)
                        gained |= np.count_nonzero(self.kind[i + way]) > before

    def result_from(self, states: np.ndarray) -> tuple[AttractorRow, np.ndarray]:
        """Of a row of one cell: what was found when motions start from states (k, m), and the slots they lead to."""
        orbits, slots = self._orbits(0), np.empty(len(states), np.int64)
        before, none = int(orbits.count[0]), np.empty((0, self.systems.size))
        _search(*self._at(0), orbits, 1, none, np.array(states), self.limits, slots)
        self._took(0, before, max(int(self.round.max()), 0))
        self._mark(0, slots, SeenFrom(0))
        return self.result(), np.maximum(slots, -1).astype(np.int8)

    def result(self) -> AttractorRow:
        """What was found."""
        kind, lowest, highest = self.kind, self.numbers[..., 0], self.numbers[..., 1]
        links = {way: np.maximum(array, -1) for way, array in self.links.items()}
        seen = self.seen.copy()
        for way, bit in ((1, SeenFrom.UPWARDS), (-1, SeenFrom.DOWNWARDS)):
            seen |= np.where(_run(kind, links[way], way), int(bit), 0).astype(np.uint8)
        rate = (self.systems.omega / (2.0 * math.pi))[:, None]
        nothing = np.full(kind.shape, np.nan)
        return AttractorRow(
            kind,
            impact_of_range(lowest, highest, *self.systems.gaps.T[:, :, None]),
            seen,
            self.round,
            lowest,
            highest,
            self.numbers[..., 2],
            self.numbers[..., 3],
            nothing,
            highest - lowest,
            nothing,
            nothing,
            self.rates[..., 0] * rate,
            self.rates[..., 1] * rate,
            self.hits,
            links[1],
            links[-1],
            self.state,
            self.starts,
            self.motion,
            self.systems.box,
            self.overflow,
            self.failures,
        )


def _run(kind: np.ndarray, links: np.ndarray, way: int) -> np.ndarray:
    """Which attractors (X, A) a slow run along the row meets, from any attractor of the column where it begins."""
    met = np.zeros(kind.shape, bool)
    columns = range(len(kind)) if way > 0 else range(len(kind) - 1, -1, -1)
    for number, i in enumerate(columns):
        if number == 0:
            met[i] = (kind[i] >= 1) & (kind[i] <= AttractorKind.CHAOTIC)
        else:
            ends = links[i - way][met[i - way]]
            met[i, ends[ends >= 0]] = True
    return met


def find_attractors(
    system: Model | ContactSystem,
    axis: str,
    values,
    *,
    omega: float | None = None,
    motions=None,
    period: int = 1,
    keys=None,
    search: AttractorSearch | None = None,
) -> AttractorRow:
    """Attractors along an axis.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        What changes along the row: one of `solver.AXES`, or of `solver.SYSTEM_AXES` for a contact system.
    values : (X,) array_like
        Of the axis, ascending.
    omega : float, optional
        The mesh frequency; needed unless it is the axis.
    motions : (X, S, 2 H + 1) array_like, optional
        Stable motions of a map, nan where there is none: Lambda_0, then c_k, s_k of
        lambda = Lambda_0 + sum_k c_k cos k theta + s_k sin k theta, theta = Omega tau / period.
    period : int
        Forcing periods of these motions, up to 8.
    keys : (X,) array_like of int, optional
        Seeds of the random states of each cell; the column numbers unless given.
    search : AttractorSearch, optional

    Returns
    -------
    AttractorRow

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    search = AttractorSearch() if search is None else instance_of("search", search, AttractorSearch)
    systems = _checked_row(system, axis, values, omega)
    columns = systems.values.size
    period = whole_number("period", period, 1, HIGHEST_PERIOD)
    motions = np.empty((columns, 0, 3)) if motions is None else number_array("motions", motions)
    if motions.ndim != 3 or motions.shape[0] != columns or motions.shape[2] % 2 == 0 or motions.shape[2] < 3:
        raise ParameterError("motions", motions.shape, f"of shape ({columns}, S, 2 H + 1)")
    keys = np.arange(columns, dtype=np.uint64) if keys is None else np.asarray(keys)
    if keys.shape != (columns,) or keys.dtype.kind not in "iu":
        raise ParameterError("keys", keys, f"{columns} whole numbers")
    row = _RowSearch(systems, search, motions.shape[1])
    randoms = random_states(systems, keys.astype(np.uint64), search.starts)
    row.start(motion_states(systems, motions, period), randoms, period)
    row.spread(0)
    return row.result()


def _checked_row(system, axis: str, values, omega: float | None) -> RowSystems:
    values = finite_array("values", values, (None,))
    if values.size == 0 or np.any(np.diff(values) <= 0.0):
        raise ParameterError("values", values, "at least one number, ascending")
    low, high = float(values[0]), float(values[-1])
    # One place is no range, and as good as two.
    check_axis(system, axis, low, high if high > low else math.nextafter(low, math.inf), omega)
    return row_systems(system, axis, values, omega)


def _known_row(systems: RowSystems, search: AttractorSearch, row: AttractorRow) -> _RowSearch:
    """A search that goes on from what was found before."""
    found = _RowSearch(systems, replace(search, room=row.kind.shape[1]), row.motion.shape[1])
    for name in ("kind", "round", "hits", "state", "starts", "failures", "motion", "overflow"):
        np.copyto(getattr(found, name), getattr(row, name))
    found.seen[:] = row.seen & ~np.uint8(SeenFrom.UPWARDS | SeenFrom.DOWNWARDS)
    for place, name in enumerate(("lowest", "highest", "mean", "amplitude")):
        found.numbers[..., place] = getattr(row, name)
    rate = (systems.omega / (2.0 * math.pi))[:, None]
    found.rates[..., 0], found.rates[..., 1] = row.lyapunov / rate, row.lyapunov_error / rate
    known = row.kind > 0
    found.links[1][known], found.links[-1][known] = row.upwards[known], row.downwards[known]
    return found


def settle(
    system: Model | ContactSystem,
    omega: float,
    states,
    *,
    known: AttractorRow | None = None,
    search: AttractorSearch | None = None,
) -> tuple[AttractorRow, np.ndarray]:
    """What motions from given states end on.

    Parameters
    ----------
    system : Model or ContactSystem
    omega : float
        The mesh frequency.
    states : (k, m) array_like
        At tau = 0, in the coordinates of `solver.model.contact_system.reduced`.
    known : AttractorRow, optional
        Of this one place: its slots keep their numbers.
    search : AttractorSearch, optional

    Returns
    -------
    row : AttractorRow
        Of one cell, X = 1.
    slots : (k,) int8 array
        Slot that each state leads to; -1 where that is not known.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    search = AttractorSearch() if search is None else instance_of("search", search, AttractorSearch)
    systems = _checked_row(system, "omega", [omega], None)
    states = finite_array("states", states, (None, systems.size))
    if known is None:
        found = _RowSearch(systems, search, 0)
    elif instance_of("known", known, AttractorRow).kind.shape[0] == 1:
        found = _known_row(systems, search, known)
    else:
        raise ParameterError("known", f"a row of {len(known.kind)} cells", "a row of one cell")
    return found.result_from(states)


def continue_attractors(
    system: Model | ContactSystem,
    axis: str,
    values,
    row: AttractorRow,
    columns,
    kinds,
    states,
    *,
    round: int,
    omega: float | None = None,
    search: AttractorSearch | None = None,
) -> AttractorRow:
    """Start in a row from attractors of neighbouring rows, and follow what is new along the row.

    Parameters
    ----------
    system, axis, values, omega, search
        As for `find_attractors`, whose result, or one of this function, `row` is.
    row : AttractorRow
    columns, kinds : (K,) int arrays
        Cells that are started in, and `AttractorKind` of what is started from.
    states : (K, m) array
        States on the section.
    round : int
        By which new attractors are marked, above those of the row.

    Returns
    -------
    AttractorRow
        What was known is unchanged, but for what it is seen from.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    search = AttractorSearch() if search is None else instance_of("search", search, AttractorSearch)
    systems = _checked_row(system, axis, values, omega)
    instance_of("row", row, AttractorRow)
    round = whole_number("round", round, int(row.round.max(initial=0)) + 1, 2**15 - 1)
    found = _known_row(systems, search, row)
    columns, kinds, states = np.asarray(columns), np.asarray(kinds), np.asarray(states, dtype=float)
    for i in np.unique(columns).tolist():
        here = columns == i
        found.bring(i, kinds[here], states[here], round)
    found.spread(round)
    return found.result()
