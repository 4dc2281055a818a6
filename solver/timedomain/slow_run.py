"""A slow run along a row, up or down: what one motion settles on while the swept parameter goes in steps.

At every value the motion goes on from the state in which it had settled at the value before: coordinates and speeds in
dimensionless time are kept as they are, at phase 0 of the mesh frequency, where the parameter is changed. It is
followed by integration alone. Where the motion that it was on has ended, it goes wherever it really goes.

A step is a jump where the way back does not undo it: the motion that is found after the step, started at the value
before, settles on something else than what was there. (Two motions without a period are told apart by their range.)
Where a periodic motion or a torus is lost, or its range changes much, the step is taken again in small ones: the run is
a slow one, and a motion is not to be thrown out of a narrow basin by the step itself.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solver.contact.impact import impact_of_range
from solver.contact.quantities import Slot
from solver.model.checks import ParameterError, finite_array, instance_of
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import check_axis
from solver.timedomain.attractor import AttractorKind
from solver.timedomain.attractor_row import AttractorSearch
from solver.timedomain.cell_search import AMPLITUDE, NUMBERS, WINDOW, Cell, pursue, seek
from solver.timedomain.recognition import HIGHEST_PERIOD, new_known
from solver.timedomain.row_systems import RowSystems, row_systems
from solver.timedomain.settling import Memory, new_memory

__all__ = ["SlowRun", "slow_run"]

# Sections of a motion that repeats differ by less than this share of the largest.
_SAME = 1e-5
# The range of lambda changes much where its ends move by more than this share of it.
_FAR = 0.1
# A step over which a periodic motion or a torus is lost is taken again in so many.
_FINER = 16


@dataclass(frozen=True, eq=False)
class SlowRun:
    """What a slow run met at each of X values, in the order of the run.

    Parameters
    ----------
    values : (X,) array
    kind : (X,) int8 array
        `AttractorKind`; NONE where the motion could not be integrated.
    impact : (X,) int8 array
        `ImpactState`; -1 where there is no bounded motion.
    quantities : dict of str to (X,) array
        By the names of `Slot` in small letters, and "amplitude": over the own period of a motion, or over 128 forcing
        periods of one without, unsettled ones included; nan where there is no bounded motion.
    sections : (X, 128) array
        lambda at the start of each forcing period of the own period, or of 128; nan beyond.
    lyapunov, lyapunov_error : (X,) arrays
        Largest Lyapunov exponent per unit of tau and its standard error; of periodic motions from the multipliers.
    jumps : (X,) array
        Where the motion jumped on the way to this value: the middle of the step, which is a small one where a periodic
        motion or a torus ended; nan where it did not jump.
    from_rest : (X,) bool array
        Where the motion started at rest: at the first value unless a state was given, and where there was none to go on
        from.
    state : (X, m) array
        Where the motion has settled, at phase 0, in the coordinates of `solver.model.contact_system.reduced`; nan
        beyond those that the system has there, and where there is no bounded motion.
    """

    values: np.ndarray
    kind: np.ndarray
    impact: np.ndarray
    quantities: dict[str, np.ndarray]
    sections: np.ndarray
    lyapunov: np.ndarray
    lyapunov_error: np.ndarray
    jumps: np.ndarray
    from_rest: np.ndarray
    state: np.ndarray


@dataclass(frozen=True, eq=False)
class _Settled:
    """What is known of the motion at one value: cell i of some systems, the slot there, and what goes into a run."""

    systems: RowSystems
    i: int
    cell: Cell
    slot: int
    kind: int
    state: np.ndarray | None
    sections: np.ndarray
    numbers: np.ndarray

    @property
    def value(self) -> float:
        """Of the axis."""
        return float(self.systems.values[self.i])


class _Runner:
    """Follows a motion from value to value."""

    def __init__(self, systems_at: Callable[[np.ndarray], RowSystems], search: AttractorSearch):
        self.systems_at, self.search = systems_at, search
        self.memories: dict[int, Memory] = {}

    def settle(self, systems: RowSystems, i: int, state: np.ndarray | None) -> _Settled:
        """What a motion from a state of another value, or from rest, settles on in cell i."""
        size, room = 2 * int(systems.degrees[i]), self.search.room
        if size not in self.memories:
            self.memories[size] = new_memory(size, room, self.search.watched)
        place = systems.parameters, systems.parameter_slope, float(systems.values[i]), systems.gauges[i]
        cell = Cell(*place, new_known(room, size), self.memories[size], self.search.limits())
        current = systems.rest[i, :size].copy() if state is None else systems.adapted(i, state[None])[0].copy()
        sections, numbers = np.full(WINDOW, np.nan), np.full(NUMBERS, np.nan)
        slot = pursue(cell, current, sections, numbers)
        kind = int(cell.known.kind[slot]) if slot >= 0 else 0
        if kind == AttractorKind.PERIOD_LONGER:
            _shorten(sections)
        bounded = kind not in (AttractorKind.NONE, AttractorKind.UNBOUNDED)
        return _Settled(systems, i, cell, slot, kind, current if bounded else None, sections, numbers)

    def step(self, before: _Settled, systems: RowSystems, i: int) -> tuple[_Settled, float]:
        """What follows in cell i of a row, and at which value the motion jumped on the way; nan if it did not."""
        after = self.settle(systems, i, before.state)
        jumped = self._jumped(before, after)
        if not (jumped or _far(before, after)):
            return after, np.nan
        if not AttractorKind.PERIOD_1 <= before.kind <= AttractorKind.QUASI_PERIODIC:
            return after, 0.5 * (before.value + after.value) if jumped else np.nan
        # Perhaps the step alone was too large for a narrow basin, or for the way back to tell; if not, the place
        # becomes known more closely.
        values, at = np.linspace(before.value, after.value, _FINER + 1)[1:], np.nan
        finer = self.systems_at(values)
        for k in range(_FINER):
            after = self.settle(finer, k, before.state)
            if np.isnan(at) and self._jumped(before, after):
                at = 0.5 * (before.value + after.value)
            before = after
        return after, at

    def _jumped(self, before: _Settled, after: _Settled) -> bool:
        """Whether the way back leads elsewhere."""
        if before.state is None or after.state is None:
            return (before.state is None) != (after.state is None)
        if min(before.kind, after.kind) > AttractorKind.PERIOD_LONGER:
            # Samples of sections tell two such motions that are near each other apart less surely than their ranges.
            return _far(before, after)
        states, slots = before.systems.adapted(before.i, after.state[None]).copy(), np.empty(1, np.int64)
        none, nobody = np.empty((0, states.shape[1])), np.empty(0, np.int64)
        seek(before.cell, 1, none, nobody, none, states, slots, np.empty((self.search.room, NUMBERS)))
        return int(slots[0]) != before.slot


def _far(before: _Settled, after: _Settled) -> bool:
    """Whether the ranges of lambda of two motions differ by more than a tenth of the larger; not where one has none."""
    ranges = np.array([one.numbers[[Slot.LOWEST, Slot.HIGHEST]] for one in (before, after)])
    return bool(np.max(np.abs(ranges[1] - ranges[0])) > _FAR * np.max(np.ptp(ranges, axis=1)))


def _shorten(sections: np.ndarray) -> None:
    """Leave one period of the sections of a motion that repeats after more than eight."""
    limit = _SAME * np.max(np.abs(sections))
    for period in range(HIGHEST_PERIOD + 1, sections.size // 2 + 1):
        if np.max(np.abs(sections[period:] - sections[:-period])) < limit:
            sections[period:] = np.nan
            return


def slow_run(
    system: Model | ContactSystem,
    axis: str,
    values,
    *,
    omega: float | None = None,
    state=None,
    search: AttractorSearch | None = None,
) -> SlowRun:
    """Follow one motion along an axis.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        What changes along the row: one of `solver.AXES`, or of `solver.SYSTEM_AXES` for a contact system.
    values : (X,) array_like
        Of the axis in the order of the run, ascending or descending.
    omega : float, optional
        The mesh frequency; needed unless it is the axis.
    state : (m,) array_like, optional
        Where the motion starts, in the coordinates of `solver.model.contact_system.reduced`: such as the last state of
        the run that went before. At rest under the mean load unless given.
    search : AttractorSearch, optional
        How long motions settle and how they are told apart; there are no random starts.

    Returns
    -------
    SlowRun

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    search = AttractorSearch() if search is None else instance_of("search", search, AttractorSearch)
    systems = _checked_row(system, axis, values, omega)
    if state is not None:
        state = finite_array("state", state, (2 * int(systems.degrees[0]),))
    runner = _Runner(lambda places: row_systems(system, axis, places, omega), search)
    found, jumps = [runner.settle(systems, 0, state)], [np.nan]
    for i in range(1, systems.values.size):
        following, at = runner.step(found[-1], systems, i)
        found.append(following)
        jumps.append(at)
    return _run_of(systems, found, np.array(jumps), state is None)


def _run_of(systems: RowSystems, found: list[_Settled], jumps: np.ndarray, from_rest: bool) -> SlowRun:
    numbers = np.array([one.numbers for one in found])
    quantities = {slot.name.lower(): numbers[:, slot] for slot in Slot} | {"amplitude": numbers[:, AMPLITUDE]}
    states, rates = np.full((len(found), systems.size), np.nan), np.full((len(found), 2), np.nan)
    for i, one in enumerate(found):
        if one.state is not None:
            states[i, : one.state.size] = one.state
            rates[i] = one.cell.known.rates[one.slot] * systems.omega[i] / (2.0 * np.pi)
    lost = [one.state is None for one in found]
    return SlowRun(
        values=systems.values,
        kind=np.array([one.kind for one in found], np.int8),
        impact=impact_of_range(quantities["lowest"], quantities["highest"], *systems.gaps.T),
        quantities=quantities,
        sections=np.array([one.sections for one in found]),
        lyapunov=rates[:, 0],
        lyapunov_error=rates[:, 1],
        jumps=jumps,
        from_rest=np.array([from_rest, *lost[:-1]]),
        state=states,
    )


def _checked_row(system, axis: str, values, omega: float | None) -> RowSystems:
    values = finite_array("values", values, (None,))
    steps = np.diff(values)
    if values.size == 0 or not (np.all(steps > 0.0) or np.all(steps < 0.0)):
        raise ParameterError("values", values, "at least one number, ascending or descending")
    low, high = float(values.min()), float(values.max())
    # One place is no range, and as good as two.
    check_axis(system, axis, low, high if high > low else float(np.nextafter(low, np.inf)), omega)
    return row_systems(system, axis, values, omega)
