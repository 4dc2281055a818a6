"""Stability of the motions of a row by both methods: what sweeps call."""

import math

import numpy as np

from solver.continuation.problem import Balance
from solver.model.checks import ParameterError
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.stability.floquet import contact_shares, multipliers
from solver.stability.hill import Truncation, centred_exponents
from solver.stability.hill_roots import condensed_exponents
from solver.stability.instability import Stability, combine
from solver.stability.system_row import SystemRow, system_row

__all__ = ["assess", "both_multipliers", "forget", "hill_multipliers", "truncation_of"]

# Motions in contact all the time are linear: their multipliers depend on the linear system and the frequency alone,
# which the rows of a plane share. Keyed by exactly that; emptied when full, which no plane of 400 columns reaches soon.
_linear: dict[tuple, np.ndarray] = {}
_LINEAR_ROOM = 20_000


def forget() -> None:
    """Drop what is remembered of linear motions; only measurements of time need it."""
    _linear.clear()


def truncation_of(balance: Balance | None) -> Truncation:
    """How Hill's matrix must be truncated to match a balance; None is the describing function of first order."""
    if balance is None:
        return Truncation()
    return Truncation(balance.harmonics, balance.period, balance.truncated)


def assess(
    system: Model | ContactSystem,
    axis: str,
    values,
    motions,
    *,
    omega: float | None = None,
    balance: Balance | None = None,
    static=None,
    tolerance: float = 1e-6,
) -> Stability:
    """Stability of k motions at values of one axis, by Hill's method and by Floquet's.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        "omega" or a scalar parameter of the gear; for a ContactSystem one of `solver.harmonic.layout.SYSTEM_AXES`.
    values : (k,) array_like
    motions : (k, n) array_like
        Solutions of the balance: (lambda_m, lambda_c, lambda_s) at first order, else (Lambda_0, c_1, s_1, ...).
    omega : float, optional
        The frequency, > 0; needed unless it is the axis.
    balance : Balance, optional
        Whose solutions the motions are; the describing function of first order unless given.
    static : (k,) array_like, optional
        Static stability of the motions, positive where det J > 0: a motion without it is not called stable.
    tolerance : float
        Moduli this close to 1 are undecided.

    Returns
    -------
    Stability

    Raises
    ------
    ParameterError
        If the axis, a value of it, the frequency or the shape of the motions is not allowed.
    """
    row = system_row(system, axis, values, omega)
    truncation = truncation_of(balance)
    motions = np.ascontiguousarray(motions, dtype=float)
    if motions.shape != (row.omega.size, 2 * truncation.harmonics + 1) or not np.all(np.isfinite(motions)):
        allowed = f"finite numbers of shape ({row.omega.size}, {2 * truncation.harmonics + 1})"
        raise ParameterError("motions", f"array of shape {motions.shape}", allowed)
    return combine(*both_multipliers(row, motions, truncation), static, tolerance)


def both_multipliers(row: SystemRow, motions: np.ndarray, truncation: Truncation) -> tuple[np.ndarray, np.ndarray]:
    """Multipliers of k motions over the period nu 2 pi/Omega by Hill and by Floquet: two complex (k, 2n) arrays."""
    found = np.empty((len(motions), 2, row.states), dtype=complex)
    shares, tokens = contact_shares(row, motions), row.tokens()
    keys: list[tuple | None] = [
        (tokens[which], omega, share, truncation) if share in (0.0, 1.0) else None
        for share, which, omega in zip(shares.tolist(), row.which.tolist(), row.omega.tolist(), strict=True)
    ]
    asked: dict[tuple | int, int] = {}
    for i, key in enumerate(keys):
        known = None if key is None else _linear.get(key)
        if known is None:
            asked.setdefault(i if key is None else key, i)
        else:
            found[i] = known
    places = np.fromiter(asked.values(), dtype=np.int64)
    if places.size:
        some, chosen = row.take(places), motions[places]
        floquet = multipliers(some, chosen, truncation.period)
        found[places, 0], found[places, 1] = hill_multipliers(some, chosen, truncation, floquet), floquet
        if len(_linear) > _LINEAR_ROOM:
            forget()
        for i, key in enumerate(keys):
            if key is not None and key in asked:
                found[i] = _linear[key] = found[asked[key]]
    return found[:, 0], found[:, 1]


def hill_multipliers(
    row: SystemRow, motions: np.ndarray, truncation: Truncation, starts: np.ndarray | None = None
) -> np.ndarray:
    """Multipliers of k motions by Hill's method, complex (k, 2n).

    Parameters
    ----------
    row : SystemRow
    motions : (k, 2 H + 1) array
    truncation : Truncation
    starts : (k, 2n) complex array, optional
        Multipliers near those sought, conjugates side by side, such as Floquet's. With them Hill's exponents are found
        one by one, and all at once only where that does not give a complete set, and for motions of one harmonic that
        lose contact.
    """
    time = 2.0 * math.pi * truncation.period / row.omega[:, None]
    found, complete = np.empty((len(motions), row.states), dtype=complex), np.zeros(len(motions), dtype=bool)
    if starts is not None:
        # One harmonic is too few to trust that sum where contact is lost, and few enough for all exponents at once.
        linear = np.isin(contact_shares(row, motions), (0.0, 1.0))
        near = np.flatnonzero(linear | (truncation.harmonics > 1))
        with np.errstate(divide="ignore", invalid="ignore"):
            exponents = np.log(starts[near]) / time[near]
        found[near], complete[near] = condensed_exponents(row.take(near), motions[near], truncation, exponents)
    missing = np.flatnonzero(~complete)
    if missing.size:
        found[missing] = centred_exponents(row.take(missing), motions[missing], truncation)
    with np.errstate(over="ignore", invalid="ignore"):
        return np.exp(found * time)
