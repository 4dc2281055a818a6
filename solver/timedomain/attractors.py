"""Attractors of every cell of a row, each followed over its whole domain along the row.

In each cell motions are started from rest, from the stable motions of a map and from random states. Every attractor
found is a start in both neighbouring cells, until none of them gains one (global continuation; G. Datseris,
K. L. Rossi, A. Wagemakers, "Framework for global stability analysis of dynamical systems", Chaos 33 (2023) 073151).
Which attractor leads to which in the next cell is kept: it tells what a slow run-up and run-down would meet.
"""

import enum
import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from solver.flow.loads import loaded_system_at
from solver.flow.switched_system import FREQUENCY, LENGTH
from solver.flow.zone_flows import ZONE_FLOWS, new_flows, zone_flows
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.model.checks import (
    ParameterError,
    finite_array,
    finite_number,
    frequency,
    instance_of,
    number_array,
    whole_number,
)
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import check_axis
from solver.timedomain.attractor import AttractorKind, impact_of_range
from solver.timedomain.integrator import COMPLETE, checked_tolerance
from solver.timedomain.orbits import new_orbit
from solver.timedomain.poincare import add_harmonics
from solver.timedomain.recognition import HIGHEST_PERIOD, KNOWN, Known, keep_sample, new_known, try_orbit
from solver.timedomain.row_systems import RowSystems, motion_states, random_states, row_systems
from solver.timedomain.section_map import MAP_ROOM, carry_period, new_room, new_steps, widen_over
from solver.timedomain.settling import (
    FAILED,
    LIMITS,
    MEMORY,
    NO_ROOM,
    Limits,
    Memory,
    new_memory,
    settle_state,
    spread_sample,
)

__all__ = ["AttractorRow", "AttractorSearch", "SeenFrom", "continue_attractors", "find_attractors", "settle"]

#: The last kind of a bounded attractor.
CHAOTIC = int(AttractorKind.CHAOTIC)

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
    transient: int = 300
    watched: int = 2000
    floor: float = 4e-3
    near: float = 0.03
    tolerance: float = 1e-9
    ceiling: float = 1e4
    room: int = 8

    def __post_init__(self):
        whole_number("starts", self.starts, 0, 10**6)
        whole_number("transient", self.transient, 100, 10**7)
        whole_number("watched", self.watched, 600, 10**7)
        whole_number("room", self.room, 2, 100)
        checked_tolerance(self.tolerance)
        for name in ("near", "floor", "ceiling"):
            finite_number(name, getattr(self, name), above=0.0)

    def limits(self) -> Limits:
        """For kernels."""
        return Limits(
            self.tolerance, float(self.ceiling), float(self.near), int(self.transient), int(self.watched), self.floor
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
        """Columns (K,), kinds (K,) and states (K, m) of the bounded attractors found in one round.

        Parameters
        ----------
        round : int

        Raises
        ------
        ParameterError
            If it is no round.
        """
        whole_number("round", round, 0, 2**15 - 1)
        columns, slots = np.nonzero((self.round == round) & (self.kind >= 1) & (self.kind <= CHAOTIC))
        return columns, self.kind[columns, slots], self.state[columns, slots]


class Cell(NamedTuple):
    """What kernels are told of a cell: the row's `parameters` and `parameter_slope`, its value of the axis `p`, what is
    known of it, and room for a motion."""

    parameters: np.ndarray
    parameter_slope: np.ndarray
    p: float
    known: Known
    memory: Memory
    limits: Limits


_CELL = types.NamedTuple((ARRAY, ARRAY, _F, KNOWN, MEMORY, LIMITS), Cell)


@kernel(types.void(_CELL, _I, MATRIX, _COUNTS, MATRIX, MATRIX, _COUNTS, MATRIX))
def _seek(cell, period, motions, kinds, brought, states, slots, numbers):
    """What motions in one cell lead to.

    Parameters
    ----------
    cell : Cell
    period : int
        Forcing periods of the motions of a map.
    motions : (a, m) array
        States on motions of a map; overwritten, as all states are.
    kinds, brought : (b,) int array, (b, m) array
        Attractors of other cells.
    states : (c, m) array
        Others.
    slots : (a + b + c,) int array
        Slot that each leads to, in this order, or FAILED or NO_ROOM.
    numbers : (A, NUMBERS) array
        What is new is described there.
    """
    known, memory = cell.known, cell.memory
    system = loaded_system_at(cell.parameters, cell.parameter_slope, cell.p)
    limits, length = _scaled(cell.limits, system.numbers[LENGTH]), system.numbers[LENGTH]
    flows = zone_flows(system, limits.tolerance, new_flows(system, 1))
    room, orbit, before, first = new_room(flows), new_orbit(flows), known.count[0], 0
    for group in range(3):
        starts = motions if group == 0 else (brought if group == 1 else states)
        for i in range(starts.shape[0]):
            slot = -1
            if group == 0 or group == 1 and kinds[i] <= HIGHEST_PERIOD:
                repeats = period if group == 0 else kinds[i]
                slot = try_orbit(flows, known, starts[i], repeats, limits.ceiling, _APART * length, orbit, room)
            if slot < 0:
                slot = settle_state(flows, known, starts[i], limits, memory, orbit, room)
            slots[first + i] = slot
        first += starts.shape[0]
    _describe(flows, known, before, limits.ceiling, memory.before, numbers, room)


@kernel(LIMITS(LIMITS, _F), inner=True)
def _scaled(limits, length):
    """The ceiling as a length."""
    return Limits(
        limits.tolerance, limits.ceiling * length, limits.near, limits.transient, limits.watched, limits.floor
    )


@kernel(types.void(ZONE_FLOWS, KNOWN, _I, _F, ARRAY, MATRIX, MAP_ROOM), inner=True)
def _describe(flows, known, first, ceiling, state, numbers, room):
    """Fill in numbers (A, 4) of the attractors from slot `first` on: lowest, highest, mean, amplitude of lambda."""
    if known.count[0] == first:
        return
    omega, steps = flows.system.numbers[FREQUENCY], new_steps(flows)
    for slot in range(first, known.count[0]):
        kind = known.kind[slot]
        if kind < 1 or kind > CHAOTIC:
            continue
        periods = kind if kind <= HIGHEST_PERIOD else _WINDOW
        copy_into(state, known.points[slot, 0])
        extremes, sums = np.array([math.inf, -math.inf]), np.zeros((2, 2))
        for _ in range(periods):
            status, count = carry_period(flows, state, steps[:0], steps, ceiling, room)
            if status != COMPLETE:
                break
            widen_over(flows, steps, count, extremes, room)
            add_harmonics(flows, steps, count, 0.0, omega, sums, room)
        scale = omega / (math.pi * periods)
        numbers[slot, 0], numbers[slot, 1] = extremes[0], extremes[1]
        numbers[slot, 2] = 0.5 * sums[0, 0] * scale
        numbers[slot, 3] = math.hypot(sums[1, 0], sums[1, 1]) * scale


@kernel(types.void(_CELL, _COUNTS, MATRIX, MATRIX))
def _recall(cell, kinds, states, rates):
    """Make attractors of these kinds (k,) known again from a state (k, m) of each, in their slots."""
    known, memory = cell.known, cell.memory
    system = loaded_system_at(cell.parameters, cell.parameter_slope, cell.p)
    limits = _scaled(cell.limits, system.numbers[LENGTH])
    flows = zone_flows(system, limits.tolerance, new_flows(system, 1))
    room, orbit = new_room(flows), new_orbit(flows)
    for slot in range(kinds.shape[0]):
        if kinds[slot] <= HIGHEST_PERIOD:
            try_orbit(flows, known, states[slot], kinds[slot], limits.ceiling, math.inf, orbit, room)
        elif kinds[slot] <= CHAOTIC:
            copy_into(memory.before, states[slot])
            for i in range(limits.watched):
                carry_period(flows, memory.before, memory.none, memory.none, limits.ceiling, room)
                copy_into(memory.sections[i], memory.before)
            spread_sample(memory.sections, limits.watched, memory.sample)
            keep_sample(system, known, kinds[slot], memory.sample, rates[slot, 0], rates[slot, 1], memory.gaps)
        # What has no sections, or was not found again, keeps its slot.
        if known.count[0] <= slot:
            known.kind[slot] = kinds[slot] if kinds[slot] > CHAOTIC else 0
            known.count[0] = slot + 1


class _RowSearch:
    """The cells of a row while attractors are sought in them."""

    def __init__(self, systems: RowSystems, search: AttractorSearch, motions: int):
        columns, room = systems.values.size, search.room
        self.systems, self.search = systems, search
        self.limits = search.limits()
        self.memories: dict[int, Memory] = {}
        self.known: list[Known | None] = [None] * columns
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

    def size(self, i: int) -> int:
        """Numbers m of a state in a cell."""
        return 2 * int(self.systems.degrees[i])

    def _cell(self, i: int) -> Cell:
        size, room = self.size(i), self.search.room
        if size not in self.memories:
            self.memories[size] = new_memory(size, room, self.search.watched)
        systems, memory = self.systems, self.memories[size]
        place = systems.parameters, systems.parameter_slope, float(systems.values[i])
        if self.known[i] is None:
            self.known[i] = new_known(room, size)
            count = int(np.count_nonzero(self.kind[i]))
            if count:
                # The row is a stored one: what is known of the cell is made again from its states.
                cell = Cell(*place, self.known[i], memory, self.limits)
                kinds, states = self.kind[i, :count].astype(np.int64), self.state[i, :count, :size].copy()
                _recall(cell, kinds, states, self.rates[i, :count].copy())
        return Cell(*place, self.known[i], memory, self.limits)

    def seek(self, i: int, round: int, *, motions=None, period: int = 1, kinds=None, brought=None, states=None):
        """Start in a cell; the slots that motions, attractors of other cells, and other states lead to."""
        none = np.empty((0, self.size(i)))
        groups = [none if group is None else np.array(group, order="C") for group in (motions, brought, states)]
        kinds = np.empty(0, np.int64) if kinds is None else kinds.astype(np.int64)
        cell, ends = self._cell(i), np.cumsum([len(group) for group in groups])
        before, slots = int(cell.known.count[0]), np.empty(ends[-1], np.int64)
        _seek(cell, period, groups[0], kinds, groups[1], groups[2], slots, self.numbers[i])
        new = slice(before, int(cell.known.count[0]))
        self.kind[i, new], self.round[i, new] = cell.known.kind[new], round
        self.rates[i, new] = cell.known.rates[new]
        self.state[i, new, : self.size(i)] = cell.known.points[new, 0]
        self.overflow[i] |= bool(np.any(slots == NO_ROOM))
        self.failures[i] += np.count_nonzero(slots == FAILED)
        return np.split(slots, ends[:-1])

    def see(self, i: int, slots: np.ndarray, bits: SeenFrom) -> None:
        self.seen[i, slots[slots >= 0]] |= int(bits)

    def start(self, motions: np.ndarray, randoms: np.ndarray, period: int) -> None:
        """Seek attractors in every cell from motions (X, S, m), from rest, and from random states (X, k, m).

        What a cell begins with is what its left neighbour has: the links upwards are known on the way.
        """
        for i in range(self.systems.values.size):
            size = self.size(i)
            there = np.flatnonzero(np.isfinite(motions[i, :, 0]))
            states = np.concatenate([self.systems.rest[None, i, :size], randoms[i, :, :size]])
            brought = self._open(i - 1, 1) if i else np.empty(0, np.int64)
            kinds, own = self._brought(i, i - 1, brought) if i else (None, None)
            of_motions, of_brought, of_states = self.seek(
                i, 0, motions=motions[i, there, :size], period=period, kinds=kinds, brought=own, states=states
            )
            if i:
                self._link(i - 1, 1, brought, of_brought)
            of_random = of_states[1:]
            self.see(i, of_motions, SeenFrom.MOTION)
            self.see(i, of_states[:1], SeenFrom.REST)
            self.see(i, of_random, SeenFrom.RANDOM)
            self.motion[i, there] = np.where(self._settled(i, of_motions), of_motions, -1)
            np.add.at(self.hits[i], of_random[of_random >= 0], 1)
            self.starts[i] = np.count_nonzero(of_random >= 0)

    def _settled(self, i: int, slots: np.ndarray) -> np.ndarray:
        """Which slots of a cell hold bounded attractors."""
        kinds = np.where(slots >= 0, self.kind[i][slots], 0)
        return (kinds >= 1) & (kinds <= CHAOTIC)

    def _open(self, i: int, way: int) -> np.ndarray:
        """Slots of attractors that have not been followed into the next cell of a direction."""
        return np.flatnonzero(self._settled(i, np.arange(self.search.room)) & (self.links[way][i] == -2))

    def _link(self, i: int, way: int, slots: np.ndarray, ends: np.ndarray) -> None:
        """Keep where attractors of a cell lead in the next one."""
        self.links[way][i, slots] = np.where(self._settled(i + way, ends), ends, -1)
        self.see(i + way, ends, SeenFrom.NEIGHBOUR)

    def _brought(self, i: int, source: int, slots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.kind[source, slots], self.adapted(i, self.state[source, slots])

    def adapted(self, i: int, states: np.ndarray) -> np.ndarray:
        """States (k, m) of other cells as states of this one.

        Where the number of coordinates differs, lambda and its speed are brought and the others are at rest.
        """
        size = self.size(i)
        if not (np.isnan(states[:, :size]).any() or np.isfinite(states[:, size:]).any()):
            return states[:, :size]
        own, n = np.tile(self.systems.rest[i, :size], (len(states), 1)), size // 2
        for target, state in zip(own, states, strict=True):
            given = np.count_nonzero(np.isfinite(state)) // 2
            target[n - 1], target[2 * n - 1] = state[given - 1], state[2 * given - 1]
        return own

    def spread(self, round: int) -> None:
        """Follow attractors along the row, both ways, until no cell gains one."""
        last, gained = self.systems.values.size - 1, True
        while gained:
            gained = False
            for way, columns in ((-1, range(last, 0, -1)), (1, range(last))):
                for i in columns:
                    slots = self._open(i, way)
                    if slots.size:
                        before = np.count_nonzero(self.kind[i + way])
                        kinds, states = self._brought(i + way, i, slots)
                        _, ends, _ = self.seek(i + way, round, kinds=kinds, brought=states)
                        self._link(i, way, slots, ends)
                        gained |= np.count_nonzero(self.kind[i + way]) > before

    def result_from(self, states: np.ndarray) -> tuple[AttractorRow, np.ndarray]:
        """Of a row of one cell: what was found when motions start from states (k, m), and the slots they lead to."""
        _, _, slots = self.seek(0, max(int(self.round.max()), 0), states=states)
        return self.result(), np.where(self._settled(0, slots), slots, -1).astype(np.int8)

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
            met[i] = (kind[i] >= 1) & (kind[i] <= CHAOTIC)
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
    keys = np.arange(columns) if keys is None else _whole_numbers("keys", keys, columns)
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


def _whole_numbers(name: str, values, count: int | None, highest: int | None = None, lowest: int = 0) -> np.ndarray:
    """So many whole numbers within bounds."""
    array = np.asarray(values)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu") or count not in (None, array.size):
        raise ParameterError(name, values, f"{'' if count is None else f'{count} '}whole numbers")
    if array.size and (array.min() < lowest or (highest is not None and array.max() > highest)):
        raise ParameterError(name, values, f"at least {lowest}" + ("" if highest is None else f", at most {highest}"))
    return array


def _is_padded_state(state: np.ndarray) -> bool:
    count = np.count_nonzero(np.isfinite(state))
    return count >= 2 and count % 2 == 0 and bool(np.all(np.isfinite(state[:count]) & ~np.isinf(state[-1])))


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
    systems = _checked_row(system, "omega", [frequency(omega)], None)
    states = finite_array("states", states, (None, systems.size))
    if known is None:
        found = _RowSearch(systems, search, 0)
    else:
        if len(instance_of("known", known, AttractorRow).kind) != 1:
            raise ParameterError("known", f"a row of {len(known.kind)} cells", "a row of one cell")
        found = _known_row(systems, search, known)
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
    columns = _whole_numbers("columns", columns, None, systems.values.size - 1)
    kinds = _whole_numbers("kinds", kinds, columns.size, CHAOTIC, 1)
    states = number_array("states", states)
    if states.ndim != 2 or len(states) != columns.size or not all(map(_is_padded_state, states)):
        raise ParameterError("states", states, f"{columns.size} states: y and y', then nan")
    for i in np.unique(columns).tolist():
        here = columns == i
        _, slots, _ = found.seek(i, round, kinds=kinds[here], brought=found.adapted(i, states[here]))
        found.see(i, slots, SeenFrom.NEIGHBOUR)
    found.spread(round)
    return found.result()
