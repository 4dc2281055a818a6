"""Attractors of every cell of a row, each followed over its whole domain along the row.

In each cell motions are started from rest, from the stable motions of a map and from random states. Every attractor
found is a start in both neighbouring cells, until none of them gains one (global continuation; G. Datseris,
K. L. Rossi, A. Wagemakers, "Framework for global stability analysis of dynamical systems", Chaos 33 (2023) 073151).
Which attractor leads to which in the next cell is kept: it tells what a slow run-up and run-down would meet.
"""

import math

import numpy as np

from solver.model.checks import ParameterError, finite_array, frequency, instance_of, number_array, whole_number
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import check_axis
from solver.timedomain.attractor_row import AttractorRow, AttractorSearch, SeenFrom
from solver.timedomain.cell_search import CHAOTIC
from solver.timedomain.recognition import HIGHEST_PERIOD
from solver.timedomain.row_search import RowSearch, known_row
from solver.timedomain.row_systems import RowSystems, motion_states, random_states, row_systems

__all__ = ["continue_attractors", "find_attractors", "settle"]


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
    row = RowSearch(systems, search, motions.shape[1])
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
        found = RowSearch(systems, search, 0)
    else:
        if len(instance_of("known", known, AttractorRow).kind) != 1:
            raise ParameterError("known", f"a row of {len(known.kind)} cells", "a row of one cell")
        found = known_row(systems, search, known)
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
    found = known_row(systems, search, row)
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
