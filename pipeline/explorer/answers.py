"""What the explorer answers: functions of a plan and a place alone, and answers kept while they may be asked again."""

import contextlib
import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeline.analysis import margins
from pipeline.analysis.attractors.options import search_of
from pipeline.analysis.attractors.places import IntegratedPlace, place_of, states_at_rest
from pipeline.analysis.motion.motions import MapMotion, Motion, Motions, attractor_motion, map_motion, motions_at
from pipeline.config.compose import compose
from pipeline.config.places import Place
from pipeline.config.schema import Attractors
from pipeline.errors import refused
from pipeline.explorer.fixed_parameters import changed_plan
from pipeline.plan.numerics import point_of
from pipeline.plan.plan import Plan
from pipeline.plane.motions import SolvedMotions, motions_of_place
from pipeline.plane.row_curves import RowCurves, solved_curves
from pipeline.run.kernels import kernels_for
from solver import RowError
from solver.kernels.warm import kernels_of, warm
from solver.timedomain import AttractorKind, settle
from solver.timedomain.row_systems import motion_states, row_systems

__all__ = [
    "Answers",
    "Ending",
    "basins",
    "design_answer",
    "ending_of_motion",
    "ending_of_state",
    "integrated",
    "motions",
    "ready",
    "row",
]

#: Answers that are kept, and the starts across a slice of basins.
_KEPT, _SLICE = 128, 48


def ready(plan: Plan) -> None:
    """Compile or load whatever answers need, so that none waits for it."""
    warm(kernels_of(kernels_for(["explore"], plan.solver["balance"])))
    # What is imported where it is used is loaded by the first answer.
    x, p = 0.5 * (plan.sweep.low + plan.sweep.high), 0.5 * (plan.parameter.low + plan.parameter.high)
    with contextlib.suppress(RowError, ArithmeticError):
        row(plan, p)
        integrated(plan, x, p)


@dataclass(frozen=True, eq=False)
class Ending:
    """What a motion from an initial state ends on.

    Parameters
    ----------
    start : tuple of float
        lambda and lambda' at tau = 0.
    of_map : MapMotion or None
        The motion of the map that it started from.
    motion : Motion or None
        The attractor; None where it had not settled, was unbounded or could not be integrated.
    """

    start: tuple[float, float]
    of_map: MapMotion | None
    motion: Motion | None


def row(plan: Plan, p: float) -> RowCurves:
    """The branches at exactly one value of the row parameter.

    Raises
    ------
    solver.RowError, ArithmeticError
        If a branch cannot be followed.
    """
    return solved_curves(plan, p)


def motions(plan: Plan, x: float, p: float) -> SolvedMotions:
    """Every motion of the balance at exactly one place.

    Raises
    ------
    solver.RowError
        If the row cannot be solved.
    """
    return motions_of_place(plan, x, p)


def integrated(plan: Plan, x: float, p: float) -> Motions:
    """Every motion at a place with what integration says of it: attractors from the motions of the map and from random
    states, with the settings that the configuration has for them.

    Raises
    ------
    solver.RowError
        If the row cannot be solved.
    """
    return motions_at(plan, x, p, _options())


def ending_of_motion(plan: Plan, x: float, p: float, number: int) -> Ending:
    """What integration from one of the motions of the map ends on, stable or not.

    Parameters
    ----------
    plan : Plan
    x, p : float
    number : int
        By ascending amplitude, from 1.

    Raises
    ------
    ConfigurationError
        If there is no such motion.
    """
    found, period = motions_of_place(plan, x, p), int(plan.solver["period"])
    if not 1 <= number <= len(found.amplitude):
        raise refused("motion", number, f"from 1 to {len(found.amplitude)}")
    model, omega = point_of(plan, p, x)
    systems = row_systems(model, "omega", np.array([omega]), None)
    state = motion_states(systems, found.unknowns[None, [number - 1]], period)[0, 0]
    return _ending(model, omega, state, map_motion(found, number - 1, period, model, omega))


def ending_of_state(plan: Plan, x: float, p: float, displacement: float, speed: float) -> Ending:
    """What integration from an initial state ends on; all coordinates but lambda and lambda' are at rest."""
    model, omega = point_of(plan, p, x)
    return _ending(model, omega, states_at_rest(model, omega, np.array([[displacement, speed]]))[0], None)


def _ending(model, omega: float, state: np.ndarray, of_map: MapMotion | None) -> Ending:
    found, slots = settle(model, omega, state[None], search=search_of(_options()))
    slot, motion = int(slots[0]), None
    if slot >= 0 and AttractorKind(int(found.kind[0, slot])).settled:
        motion = attractor_motion(found, slot, "A", of_map, model, omega)
    return Ending((float(state[state.size // 2 - 1]), float(state[-1])), of_map, motion)


def basins(plan: Plan, x: float, p: float) -> IntegratedPlace:
    """A slice of the basins at a place: initial states in lambda and lambda', and what each of them ends on.

    Raises
    ------
    solver.RowError
        If the row cannot be solved.
    """
    found, (model, omega) = motions_of_place(plan, x, p), point_of(plan, p, x)
    started = np.where((found.stable == 1)[:, None], found.unknowns, np.nan)[None]
    return place_of(model, omega, started, int(plan.solver["period"]), replace(_options(), slice=_SLICE))


def design_answer(
    path: Place, plan: Plan, point: tuple[float, float], tolerances: tuple[float, float]
) -> margins.Answer:
    """Margins of a design point with tolerances, cut at the ends of the axes.

    Parameters
    ----------
    path : Place
        The store, its boundaries traced.
    plan : Plan
        The store's own.
    point : tuple of float
        On the swept axis and on the row axis.
    tolerances : tuple of float
        Plus or minus, of either.

    Raises
    ------
    StoreError
        If there are no boundaries.
    ArithmeticError, ValueError
        If boundaries cannot be followed.
    """
    (x, p), (dx, dp), axis = point, tolerances, plan.sweep
    dp = min(dp, p - plan.parameter.low, plan.parameter.high - p)
    return margins.answer(path, plan, margins.Design(x, p, max(x - dx, axis.low), min(x + dx, axis.high), dp))


@functools.cache
def _options() -> Attractors:
    """Settings of the search for attractors, as the configuration has them."""
    return compose([]).config.attractors


class Answers:
    """Answers about one plane, kept for who asks the same again; may be asked from several threads.

    Parameters
    ----------
    plan : Plan
        Of the plane, with its own fixed parameters.
    """

    def __init__(self, plan: Plan):
        self._plans = functools.lru_cache(_KEPT)(lambda fixed: changed_plan(plan, dict(fixed)))
        self._answers = functools.lru_cache(_KEPT)(lambda function, fixed, where: function(self._plans(fixed), *where))

    def plan(self, fixed: Mapping[str, float]) -> Plan:
        """The plane's plan with fixed parameters changed; raises as `changed_plan`."""
        return self._plans(tuple(sorted(fixed.items())))

    def ask(self, function: Callable, fixed: Mapping[str, float], *where: float):
        """function(plan, *where) for the plane with fixed parameters changed; what it raises is not kept.

        Parameters
        ----------
        function : callable
            One of this module.
        fixed : mapping
            Name of a fixed parameter -> value.
        *where : float
            A place, and what else it takes.
        """
        return self._answers(function, tuple(sorted(fixed.items())), where)
