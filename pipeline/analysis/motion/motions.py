"""Which motions there are at a place: the attractors, and the motions of the map that none of them is."""

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.attractors.credibility import Cells, partners
from pipeline.analysis.attractors.places import search_place
from pipeline.analysis.attractors.wording import attractor_name, bound
from pipeline.analysis.motion.curves import APERIODIC, Curves, harmonic_curves, integrated_curves, own_period
from pipeline.config.schema import Attractors
from pipeline.plan.numerics import System, point_of
from pipeline.plan.plan import Plan
from pipeline.plan.traits import contact_system, dead_zone, static_force
from pipeline.plane.motions import SolvedMotions, motions_of_place
from solver.contact.quantities import Quantities
from solver.stability import Instability
from solver.timedomain import AttractorKind, AttractorRow, motion_quantities
from solver.timedomain.integrator import with_the_rest

__all__ = ["MapMotion", "Motion", "Motions", "attractor_motion", "map_motion", "motions_at"]


@dataclass(frozen=True, eq=False)
class MapMotion:
    """A motion of the harmonic balance.

    Parameters
    ----------
    number : int
        By ascending amplitude, from 1.
    label : str
        Period and impact state, "1T/0".
    stable : bool
        Static stability: counted by the map's label.
    instability : Instability
    multiplier : float
        Largest modulus of its multipliers over its period.
    leads : str or None
        Name of the attractor that integration from it ends on; None where that is not known, or was not asked.
    quantities : Quantities
    curves : Curves
    """

    number: int
    label: str
    stable: bool
    instability: Instability
    multiplier: float
    leads: str | None
    quantities: Quantities
    curves: Curves


@dataclass(frozen=True, eq=False)
class Motion:
    """An attractor.

    Parameters
    ----------
    name : str
        A letter, by descending share of the random starts.
    label : str
        Kind and impact state, "2T/1".
    kind : AttractorKind
    hits : int
        Random starts that ended on it.
    multiplier : float
        Largest modulus of its multipliers over its own period; nan where it does not repeat.
    lyapunov, lyapunov_error : float
        Largest Lyapunov exponent per unit of tau, and its standard error.
    of_map : MapMotion or None
        The motion of the map that it is.
    quantities : Quantities
    curves : Curves
    """

    name: str
    label: str
    kind: AttractorKind
    hits: int
    multiplier: float
    lyapunov: float
    lyapunov_error: float
    of_map: MapMotion | None
    quantities: Quantities
    curves: Curves


@dataclass(frozen=True, eq=False)
class Motions:
    """All motions at a place.

    Parameters
    ----------
    x, p : float
        The place, on the swept axis and on the row axis.
    model : Model or ContactSystem
    omega : float
    static_force : float
        f_pm/c of a bevel pair; of another system the contact force at rest.
    attractors : tuple of Motion
    others : tuple of MapMotion
        Those that no attractor is.
    starts : int
        Random starts that the integrator could carry on.
    unsettled, unbounded : int
        Random starts of which that was the end.
    notes : tuple of str
        What is not known.
    """

    x: float
    p: float
    model: System
    omega: float
    static_force: float
    attractors: tuple[Motion, ...]
    others: tuple[MapMotion, ...]
    starts: int
    unsettled: int
    unbounded: int
    notes: tuple[str, ...]

    @property
    def gap(self) -> tuple[float, float]:
        """Ends of the gap, low and high; low is -inf where there is no back flank."""
        return dead_zone(self.model)


def motions_at(plan: Plan, x: float, p: float, options: Attractors) -> Motions:
    """Every motion at a place of a plane, computed anew; the same for the same plan, place and settings.

    Parameters
    ----------
    plan : Plan
        Of a plane.
    x, p : float
        The place, on the swept axis and on the row axis.
    options : Attractors
        Settings of the search for attractors.

    Raises
    ------
    solver.RowError
        If the balance leaves the mean open there.
    """
    model, omega = point_of(plan, p, x)
    of_map, period = motions_of_place(plan, x, p), int(plan.solver["period"])
    started = np.where((of_map.stable == 1)[:, None], of_map.unknowns, np.nan)[None]
    row = search_place(model, omega, started, period, options)
    settled = [slot for slot, kind in enumerate(row.kind[0].tolist()) if AttractorKind(kind).settled]
    order = sorted(settled, key=lambda slot: (-int(row.hits[0, slot]), slot))
    names = {slot: _letter(i) for i, slot in enumerate(order)}
    partner = _partners(of_map, period, row, contact_system(model).motion_size, options.tolerance)
    leads = [names.get(slot) for slot in row.motion[0].tolist()]
    described = [map_motion(of_map, i, period, model, omega, leads[i]) for i in range(len(partner))]
    taken = {slot: motion for slot, motion in zip(partner.tolist(), described, strict=True) if slot >= 0}
    attractors = tuple(attractor_motion(row, slot, names[slot], taken.get(slot), model, omega) for slot in order)
    ended = {kind: int(np.sum(row.hits[0, row.kind[0] == kind])) for kind in AttractorKind}
    return Motions(
        x,
        p,
        model,
        omega,
        static_force(model),
        attractors,
        tuple(motion for slot, motion in zip(partner.tolist(), described, strict=True) if slot < 0),
        int(row.starts[0]),
        ended[AttractorKind.UNSETTLED],
        ended[AttractorKind.UNBOUNDED],
        (*of_map.doubts, *_search_notes(row), bound(int(row.starts[0]))),
    )


def _partners(of_map: SolvedMotions, period: int, row: AttractorRow, size: float, tolerance: float) -> np.ndarray:
    """Slot of the attractor that each motion of the map is, (S,); -1 where it is none."""

    def cell(array: np.ndarray) -> np.ndarray:
        return np.asarray(array)[None, None]

    cells = Cells(
        label=cell(1),
        stable=cell(of_map.stable == 1),
        mean=cell(of_map.unknowns[:, 0]),
        amplitude=cell(of_map.amplitude),
        impact=cell(of_map.impact),
        leads=cell(row.motion[0]),
        kind=cell(row.kind[0]),
        found_impact=cell(row.impact[0]),
        found_mean=cell(row.mean[0]),
        found_amplitude=cell(row.amplitude[0]),
        size=cell(size),
        unresolved=cell(bool(row.failures[0])),
        overflow=cell(bool(row.overflow[0])),
        failed=cell(False),
        period=period,
    )
    return partners(cells, tolerance)[0, 0]


def map_motion(
    of_map: SolvedMotions, i: int, period: int, system: System, omega: float, leads: str | None = None
) -> MapMotion:
    """One of the motions of a place, over its own period.

    Parameters
    ----------
    of_map : SolvedMotions
    i : int
        Which of them, from 0.
    period : int
        Forcing periods that their balance is over.
    system : Model or ContactSystem
    omega : float
    leads : str, optional
        Name of the attractor that integration from it ends on.
    """
    unknowns, repeats = own_period(of_map.unknowns[i], period)
    return MapMotion(
        i + 1,
        attractor_name(repeats, int(of_map.impact[i])),
        bool(of_map.stable[i] == 1),
        Instability(int(of_map.instability[i])),
        float(of_map.multiplier[i]) ** (repeats / period),
        leads,
        Quantities(*of_map.quantities[i].tolist()),
        harmonic_curves(system, omega, unknowns, repeats),
    )


def attractor_motion(
    row: AttractorRow, slot: int, name: str, of_map: MapMotion | None, system: System, omega: float
) -> Motion:
    """One attractor of a cell, integrated over its own period.

    Parameters
    ----------
    row : AttractorRow
        Of one cell.
    slot : int
    name : str
    of_map : MapMotion or None
        The motion of the map that it is.
    system : Model or ContactSystem
    omega : float
    """
    kind = AttractorKind(int(row.kind[0, slot]))
    repeats = int(kind) if kind.periodic else None
    state, exponent = row.state[0, slot], float(row.lyapunov[0, slot])
    whole = with_the_rest(contact_system(system), state[np.isfinite(state)])
    quantities, _ = motion_quantities(system, omega, whole, repeats or APERIODIC)
    return Motion(
        name,
        attractor_name(int(kind), int(row.impact[0, slot])),
        kind,
        int(row.hits[0, slot]),
        float(np.exp(exponent * 2.0 * np.pi / omega * repeats)) if repeats else float("nan"),
        exponent,
        float(row.lyapunov_error[0, slot]),
        of_map,
        quantities,
        integrated_curves(system, omega, state[np.isfinite(state)], repeats),
    )


def _search_notes(row: AttractorRow) -> tuple[str, ...]:
    notes = []
    if row.overflow[0]:
        notes.append(f"There are more than the {row.kind.shape[1]} attractors that can be told apart.")
    if row.failures[0]:
        notes.append(f"{int(row.failures[0])} starts could not be integrated.")
    return tuple(notes)


def _letter(index: int) -> str:
    return chr(ord("A") + index)
