"""Wrong calls of Floquet stability and direct integration."""

import functools
import math

import numpy as np

import solver
from solver.harmonic.galerkin import Galerkin
from solver.timedomain import AttractorSearch
from tests.public import COUNT, NAME, NOT_NEGATIVE, NUMBER, OBJECT, POSITIVE, argument, array, optional
from tests.solver.calls.subjects import GRID, MOTION, WRONG_OMEGA, model, row, stop, wrong_settings


def motions(**further) -> dict:
    column = int(np.argmax(row().n_solutions))
    here = row().motions[column][row().stable[column] >= 0]
    values = np.full(len(here), GRID[column])
    return {
        "system": argument(model(), OBJECT),
        "axis": argument("omega", NAME),
        "values": argument(values, array(values, values[:1].repeat(7), -values), "motions", "omega"),
        "motions": argument(here, array(here, here[:, :2], here[:1].repeat(9, axis=0))),
        **further,
    }


def batch(**further) -> dict:
    """A system, its frequency and one state."""
    state = np.array([0.3, 0.1])
    return {
        "system": argument(stop(), OBJECT),
        "omega": argument(0.9, POSITIVE),
        "state": argument(state, array(state, [1.0] * 3, [[0.0, 0.0]] * 2)),
        **further,
    }


#: Teeth in contact, all else at rest.
GEAR_STATE = np.array([0.0, 1.2, 0.0, 0.0])


def periods(right: int = 2):
    return argument(right, (*COUNT, 0))


def tolerances(right: float = 1e-9):
    return argument(right, (*POSITIVE, 1.0))


def ceilings():
    return argument(math.inf, tuple(v for v in POSITIVE if not (isinstance(v, float) and v == math.inf)))


def quick() -> AttractorSearch:
    return AttractorSearch(starts=1, transient=100, watched=600)


@functools.cache
def found():
    return solver.timedomain.find_attractors(stop(), "omega", [0.9], search=quick())


@functools.cache
def stop_row() -> solver.Row:
    seeds = solver.LiftedSeeds(2)
    return solver.sweep_row(stop(), "omega", [0.8, 1.0], balance=Galerkin(3), seeds=seeds)


def places(**further) -> dict:
    """A system and the values of its frequency."""
    return {
        "system": argument(stop(), OBJECT),
        "axis": argument("omega", (*NAME, "f_e")),
        "values": argument([0.9], (None, 1, "ab", [], [np.nan], [-1.0], [0.9, 0.8], ["a"], {}, object()), "omega"),
        "omega": argument(None, WRONG_OMEGA),
        "search": argument(quick(), wrong_settings()),
        **further,
    }


CALLS = {
    "solver.stability.assess": lambda: motions(
        omega=argument(None, WRONG_OMEGA),
        balance=argument(None, optional((*OBJECT, Galerkin, Galerkin(2))), "motions"),
        static=argument([1, 0, 1], (1, "ab", [1], [1.0] * 9, [None] * 3, {}, object())),
        tolerance=argument(1e-6, NOT_NEGATIVE),
    ),
    "solver.stability.classify": lambda: {
        "multipliers": argument(np.ones((2, 2)), array(np.ones((2, 2)), finite=False)),
        "static": argument([1, 0], (1, "ab", [1], [1.0] * 9, [None] * 2, {}, object())),
        "tolerance": argument(1e-6, NOT_NEGATIVE),
    },
    "solver.stability.monodromies": lambda: motions(omega=argument(None, WRONG_OMEGA), period=argument(1, (*COUNT, 0))),
    "solver.stability.multipliers": lambda: motions(omega=argument(None, WRONG_OMEGA), period=argument(1, (*COUNT, 0))),
    "solver.stability.motion_multipliers": lambda: {
        "system": argument(model(), OBJECT),
        "omega": argument(0.6, (*(v for v in POSITIVE if v != [1.0]), [0.6, 0.7, 0.8])),
        "motions": argument(MOTION, array(MOTION, [1.0, 2.0])),
        "period": argument(1, (*COUNT, 0)),
    },
    "solver.timedomain.AttractorRow.gains": lambda: {"self": found(), "round": argument(0, COUNT)},
    "solver.timedomain.AttractorSearch": lambda: {
        "starts": argument(4, COUNT),
        "transient": argument(300, (*COUNT, 0, 99)),
        "watched": argument(700, (*COUNT, 0, 599)),
        **{name: argument(1e-2, POSITIVE) for name in ("floor", "near", "ceiling")},
        "tolerance": tolerances(),
        "room": argument(8, (*COUNT, 0, 1)),
    },
    "solver.timedomain.Trajectory.displacement": lambda: {
        "self": solver.timedomain.integrate(stop(), 0.9, [0.3, 0.0], 0.0, 2.0),
        "at": argument([0.5, 1.0], array([0.5, 1.0], [3.0], [-1.0], any_shape=True)),
    },
    "solver.timedomain.advance": lambda: {
        **{name: one for name, one in batch().items() if name != "state"},
        "states": argument(np.zeros((2, 2)), array(np.zeros((2, 2)), np.zeros((2, 3)), np.zeros(3))),
        "periods": periods(),
        "tolerance": tolerances(),
        "ceiling": ceilings(),
    },
    "solver.timedomain.continue_attractors": lambda: places(
        row=argument(found(), OBJECT),
        columns=argument([0], (None, "ab", [1], [-1], [0.5], [0, 0], {}, object()), "kinds", "states"),
        kinds=argument([1], (None, "ab", [0], [99], [0.5], [1, 1], {}, object())),
        states=argument([[0.0, 0.0]], array([[0.0, 0.0]], [[0.0] * 3], [0.0])),
        round=argument(1, (*COUNT, 0)),
    ),
    "solver.timedomain.find_attractors": lambda: places(
        motions=argument(None, (1, "ab", [1.0], np.zeros((2, 1, 3)), np.zeros((1, 1, 4)), {}, object())),
        period=argument(1, (*COUNT, 0, 9)),
        keys=argument([3], (1, "ab", [0.5], [1, 2], [-1], {}, object())),
    ),
    "solver.timedomain.growth": lambda: batch(
        periods=periods(),
        tolerance=tolerances(),
        ceiling=ceilings(),
        direction=argument(None, optional(array([1.0, 0.0], [1.0], [0.0, 0.0]))),
    ),
    "solver.timedomain.integrate": lambda: batch(
        start=argument(0.0, (*NUMBER, 3.0), "stop"),
        stop=argument(2.0, (*NUMBER, -1.0)),
        tolerance=tolerances(),
        max_steps=argument(1000, (*COUNT, 0)),
    ),
    "solver.timedomain.isolated_branches": lambda: {
        "row": argument(stop_row(), (*OBJECT, row())),
        "values": argument([0.9], array([0.9], [0.5], [1.1], [0.95, 0.9]), "attractors"),
        "omega": argument(None, WRONG_OMEGA),
        "attractors": argument(found(), optional(OBJECT)),
        "search": argument(quick(), wrong_settings()),
        "continuation": argument(None, optional(OBJECT)),
    },
    "solver.timedomain.measure": lambda: batch(
        periods=periods(), divisor=periods(), order=argument(4, COUNT), tolerance=tolerances(), ceiling=ceilings()
    ),
    "solver.timedomain.monodromy": lambda: batch(periods=periods(), tolerance=tolerances(), ceiling=ceilings()),
    "solver.timedomain.motion_quantities": lambda: {
        "system": argument(model(), OBJECT),
        "omega": argument(0.9, POSITIVE),
        "state": argument(GEAR_STATE, array(GEAR_STATE, [1.0] * 3, [GEAR_STATE] * 2)),
        "periods": periods(),
        "tolerance": tolerances(),
    },
    "solver.timedomain.orbit_state": lambda: {
        "system": argument(stop(), OBJECT),
        "omega": argument(0.9, POSITIVE),
        "coefficients": argument(MOTION, array(MOTION, [1.0, 2.0])),
        "period": periods(1),
        "samples": argument(64, (*COUNT, 0, 4)),
    },
    "solver.timedomain.order_spectrum": lambda: {
        "samples": argument([0.0, 1.0, 0.5], array([0.0, 1.0, 0.5], [1.0], any_shape=True)),
        "periods": argument(2.0, POSITIVE),
        "window": argument(None, tuple(v for v in NAME if v is not None)),
    },
    "solver.timedomain.settle": lambda: {
        "system": argument(stop(), OBJECT),
        "omega": argument(0.9, POSITIVE),
        "states": argument(np.zeros((1, 2)), array(np.zeros((1, 2)), np.zeros((2, 3)), np.zeros(3))),
        "known": argument(None, optional(OBJECT)),
        "search": argument(quick(), wrong_settings()),
    },
    "solver.timedomain.shoot": lambda: batch(
        period=periods(1),
        order=argument(4, COUNT),
        tolerance=tolerances(),
        integration_tolerance=tolerances(1e-12),
        max_iterations=argument(20, (*COUNT, 0)),
    ),
    "solver.timedomain.slow_run": lambda: places(
        values=argument(
            [0.9, 0.8], (None, 1, "ab", [], [np.nan], [-1.0], [0.9, 0.8, 0.85], ["a"], {}, object()), "omega"
        ),
        state=argument(None, optional(array(np.zeros(2), np.zeros(3), np.zeros((1, 2))))),
    ),
    "solver.timedomain.trajectory": lambda: batch(
        periods=periods(), samples=argument(16, (*COUNT, 0)), tolerance=tolerances()
    ),
}

#: Calls over other axes and with other systems: what is called, and with what.
FURTHER = {
    "multipliers of a stop": (
        "solver.stability.multipliers",
        lambda: {
            "system": argument(stop(), OBJECT),
            "axis": argument("alpha", (*NAME, "f_e")),
            "values": argument([0.0, 0.1], array([0.0, 0.1], [0.1]), "motions"),
            "motions": argument(
                np.tile(MOTION, (2, 1)), array(np.tile(MOTION, (2, 1)), np.ones((2, 4)), np.ones((3, 5)))
            ),
            "omega": argument(0.9, (None, *WRONG_OMEGA)),
        },
    )
}
