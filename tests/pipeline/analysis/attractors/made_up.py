"""A made-up world of attractors in place of the solver: domains in the plane, each found by chance in one cell only."""

import numpy as np

from pipeline.analysis.attractors.dataset import NUMBERS
from solver.timedomain import AttractorKind, AttractorRow, SeenFrom

__all__ = ["World"]

_ROOM = 8


class World:
    """Attractors 1, 2, ... by kind: where each exists, and the one cell in which a random start reaches it.

    Attractor 0 is 1T, exists everywhere and is reached from rest. States are the attractor's number and its column.

    Parameters
    ----------
    rows, columns : arrays
        Values of both axes.
    domains : dict
        Kind -> ((P, X) bool array, (row, column) where it is found).
    """

    def __init__(self, rows, columns, domains):
        self.rows, self.columns = np.asarray(rows), np.asarray(columns)
        everywhere = np.ones((self.rows.size, self.columns.size), bool)
        self.domains = [(AttractorKind.PERIOD_1, everywhere, None)]
        self.domains += [(AttractorKind(kind), where, seed) for kind, (where, seed) in domains.items()]
        #: Rows that raise: row -> round.
        self.raising: dict[int, int] = {}

    def _row(self, model) -> int:
        return int(np.argmin(np.abs(self.rows - model.f_e)))

    def _places(self, values):
        return np.argmin(np.abs(self.columns[None, :] - np.asarray(values)[:, None]), axis=1)

    def find(self, model, axis, values, *, omega=None, motions=None, period=1, keys=None, search=None) -> AttractorRow:
        """As `solver.timedomain.find_attractors`."""
        row, places = self._row(model), self._places(values)
        self._may_raise(row, 0)
        cells = len(values)
        arrays = dict(
            kind=np.zeros((cells, _ROOM), np.int8),
            impact=np.full((cells, _ROOM), -1, np.int8),
            seen=np.zeros((cells, _ROOM), np.uint8),
            round=np.full((cells, _ROOM), -1, np.int16),
            **{name: np.full((cells, _ROOM), np.nan) for name in NUMBERS},
            hits=np.zeros((cells, _ROOM), np.int32),
            upwards=np.full((cells, _ROOM), -1, np.int8),
            downwards=np.full((cells, _ROOM), -1, np.int8),
            state=np.full((cells, _ROOM, 4), np.nan),
            starts=np.full(cells, search.starts, np.int32),
            motion=np.full((cells, motions.shape[1]), -1, np.int8),
            box=np.tile([4.0, 2.0], (cells, 1)),
            overflow=np.zeros(cells, bool),
            failures=np.zeros(cells, np.int32),
        )
        result = AttractorRow(**arrays)
        for i, place in enumerate(places):
            self._add(result, i, 0, 0, SeenFrom.REST)
            result.hits[i, 0] = int(keys[i] % np.uint64(search.starts + 1))
            result.motion[i, np.isfinite(motions[i, :, 0])] = 0
            for number, (_, _, seed) in enumerate(self.domains):
                if seed == (row, place):
                    self._add(result, i, number, 0, SeenFrom.RANDOM)
        return self._spread(result, row, places, 0)

    def go_on(self, model, axis, values, row, columns, kinds, states, *, round, omega=None, search=None):
        """As `solver.timedomain.continue_attractors`."""
        number, places = self._row(model), self._places(values)
        self._may_raise(number, round)
        assert row.round.max() < round
        copied = AttractorRow(**{name: np.array(value) for name, value in vars(row).items()})
        for i, kind, state in zip(columns, kinds, states, strict=True):
            known = int(state[0])
            assert self.domains[known][0] == kind
            if self.domains[known][1][number, places[i]]:
                self._add(copied, i, known, round, SeenFrom.NEIGHBOUR)
        return self._spread(copied, number, places, round)

    def _may_raise(self, row: int, round: int) -> None:
        if self.raising.get(row) == round:
            raise ArithmeticError(f"row {row} cannot be done in round {round}")

    def _add(self, found: AttractorRow, i: int, number: int, round: int, bit: SeenFrom) -> bool:
        slots = np.flatnonzero(found.kind[i])
        there = [slot for slot in slots if found.state[i, slot, 0] == number]
        if there:
            found.seen[i, there[0]] |= int(bit)
            return False
        slot = slots.size
        kind = self.domains[number][0]
        found.kind[i, slot], found.impact[i, slot], found.round[i, slot] = kind, number % 3, round
        found.state[i, slot], found.seen[i, slot] = (number, i, 0.0, 0.0), int(bit)
        for name in NUMBERS:
            getattr(found, name)[i, slot] = number + 0.1 * i
        return True

    def _spread(self, found: AttractorRow, row: int, places, round: int) -> AttractorRow:
        gained = True
        while gained:
            gained = False
            for way in (1, -1):
                for i in range(len(places)):
                    if not 0 <= i + way < len(places):
                        continue
                    for slot in np.flatnonzero(found.kind[i]):
                        number = int(found.state[i, slot, 0])
                        if self.domains[number][1][row, places[i + way]]:
                            gained |= self._add(found, i + way, number, round, SeenFrom.NEIGHBOUR)
        return found
