"""The cells of a row while attractors are sought in them: starts, what is found, and links between neighbours."""

import math
from dataclasses import replace

import numpy as np

from solver.contact.impact import impact_of_range
from solver.contact.quantities import Slot
from solver.timedomain.attractor_row import AttractorRow, AttractorSearch, SeenFrom
from solver.timedomain.cell_search import AMPLITUDE, CHAOTIC, NUMBERS, Cell, recall, seek
from solver.timedomain.recognition import Known, new_known
from solver.timedomain.row_systems import RowSystems
from solver.timedomain.settling import FAILED, NO_ROOM, Memory, new_memory

__all__ = ["RowSearch", "known_row"]

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


class RowSearch:
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


def known_row(systems: RowSystems, search: AttractorSearch, row: AttractorRow) -> RowSearch:
    """A search that goes on from what was found before.

    Parameters
    ----------
    systems : RowSystems
    search : AttractorSearch
    row : AttractorRow
        What was found.

    Returns
    -------
    RowSearch
    """
    found = RowSearch(systems, replace(search, room=row.kind.shape[1]), row.motion.shape[1])
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
