"""Attractors of every cell of a row, each followed over its whole domain along the row.

In each cell motions are started from rest, from the stable motions of a map and from random states. Every attractor
found is a start in both neighbouring cells, until none of them gains one (global continuation; G. Datseris,
K. L. Rossi, A. Wagemakers, "Framework for global stability analysis of dynamical systems", Chaos 33 (2023) 073151).
Which attractor leads to which in the next cell is kept: it tells what a slow run-up and run-down would meet.
"""

import math
from dataclasses import replace

import numpy as np

from solver.contact.impact import impact_of_range
from solver.contact.quantities import Slot
from solver.model.checks import ParameterError, finite_array, frequency, instance_of, number_array, whole_number
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import check_axis
from solver.timedomain.attractor_row import AttractorRow, AttractorSearch, SeenFrom
from solver.timedomain.cell_search import AMPLITUDE, CHAOTIC, NUMBERS, Cell, recall, seek
from solver.timedomain.recognition import HIGHEST_PERIOD, Known, new_known
from solver.timedomain.row_systems import RowSystems, motion_states, random_states, row_systems
from solver.timedomain.settling import FAILED, NO_ROOM, Memory, new_memory

__all__ = ["continue_attractors", "find_attractors", "settle"]

#: Where the numbers of an `AttractorRow` stand among those of a cell.
_QUANTITIES = {
    "lowest": Slot.LOWEST,
    "highest": Slot.HIGHEST,
    "mean": Slot.MEAN,
    "rms": Slot.RMS,
    "peak_to_peak": Slot.PEAK_TO_PEAK,
    "error_lowest": Slot.ERROR_LOWEST,
    "error_highest": Slot.ERROR_HIGHEST,
    "error_rms": Slot.ERROR_RMS,
    "error_peak_to_peak": Slot.ERROR_PEAK_TO_PEAK,
    "force": Slot.DYNAMIC_FACTOR,
    "contact_loss": Slot.CONTACT_LOSS,
    "impact_velocity": Slot.IMPACT_VELOCITY,
    "support_force": Slot.SUPPORT_FORCE,
    "amplitude": AMPLITUDE,
}


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
        self.numbers = np.full((columns, room, NUMBERS), np.nan)
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
        place = systems.parameters, systems.parameter_slope, float(systems.values[i]), systems.gauges[i]
        if self.known[i] is None:
            self.known[i] = new_known(room, size)
            count = int(np.count_nonzero(self.kind[i]))
            if count:
                # The row is a stored one: what is known of the cell is made again from its states.
                cell = Cell(*place, self.known[i], memory, self.limits)
                kinds, states = self.kind[i, :count].astype(np.int64), self.state[i, :count, :size].copy()
                recall(cell, kinds, states, self.rates[i, :count].copy())
        return Cell(*place, self.known[i], memory, self.limits)

    def seek(self, i: int, round: int, *, motions=None, period: int = 1, kinds=None, brought=None, states=None):
        """Start in a cell; the slots that motions, attractors of other cells, and other states lead to."""
        none = np.empty((0, self.size(i)))
        groups = [none if group is None else np.array(group, order="C") for group in (motions, brought, states)]
        kinds = np.empty(0, np.int64) if kinds is None else kinds.astype(np.int64)
        cell, ends = self._cell(i), np.cumsum([len(group) for group in groups])
        before, slots = int(cell.known.count[0]), np.empty(ends[-1], np.int64)
        seek(cell, period, groups[0], kinds, groups[1], groups[2], slots, self.numbers[i])
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
        return self.kind[source, slots], self.systems.adapted(i, self.state[source, slots])

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
        kind = self.kind
        quantities = {name: self.numbers[..., at] for name, at in _QUANTITIES.items()}
        links = {way: np.maximum(array, -1) for way, array in self.links.items()}
        seen = self.seen.copy()
        for way, bit in ((1, SeenFrom.UPWARDS), (-1, SeenFrom.DOWNWARDS)):
            seen |= np.where(_run(kind, links[way], way), int(bit), 0).astype(np.uint8)
        rate = (self.systems.omega / (2.0 * math.pi))[:, None]
        impact = impact_of_range(quantities["lowest"], quantities["highest"], *self.systems.gaps.T[:, :, None])
        return AttractorRow(
            kind=kind,
            impact=impact,
            seen=seen,
            round=self.round,
            lyapunov=self.rates[..., 0] * rate,
            lyapunov_error=self.rates[..., 1] * rate,
            hits=self.hits,
            upwards=links[1],
            downwards=links[-1],
            state=self.state,
            starts=self.starts,
            motion=self.motion,
            box=self.systems.box,
            overflow=self.overflow,
            failures=self.failures,
            **quantities,
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
    for name, at in _QUANTITIES.items():
        found.numbers[..., at] = getattr(row, name)
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
        _, slots, _ = found.seek(i, round, kinds=kinds[here], brought=found.systems.adapted(i, states[here]))
        found.see(i, slots, SeenFrom.NEIGHBOUR)
    found.spread(round)
    return found.result()
