"""Wrong calls of correctors, continuation, balances, enumeration and rows."""

import numpy as np

import solver
from solver import Broyden, Continuation, LiftedSeeds, LinearSeeds, ProvenSeeds
from solver.harmonic.galerkin import Galerkin
from solver.rows.span import RowSpan
from tests.public import COUNT, NAME, NUMBER, OBJECT, POSITIVE, argument, array, optional
from tests.solver.calls.subjects import (
    CORRECTOR,
    GRID,
    MOTION,
    STEPS,
    WRONG_OMEGA,
    model,
    problem,
    row,
    stop,
    wrong_settings,
)


def trace_arguments() -> dict:
    curve = row().curves[0]
    start = curve.points[0]
    return {
        "self": Continuation(max_points=400),
        "problem": argument(problem(), OBJECT),
        "start": argument(start, array(start, start[:2])),
        "low": argument(0.5, (*NUMBER, 0.8, 0.9), "high"),
        "high": argument(0.8, (*NUMBER, 0.5, 0.4), "low"),
        "heading": argument(1, (*NUMBER, 0, [0.0] * 4, [1.0] * 3)),
    }


def balance_arguments(balance) -> dict:
    return {"problem": argument(problem(balance), OBJECT)}


def about(*, ends: bool = True) -> dict:
    """A gear pair over the frequency."""
    found = {"system": argument(model(), OBJECT), "axis": argument("omega", NAME)}
    if ends:
        found["low"] = argument(0.5, (*NUMBER, 0.8, 0.9, 0.0, -1.0), "omega", "high")
        found["high"] = argument(0.8, (*NUMBER, 0.5, 0.4))
    return found | {"omega": argument(None, WRONG_OMEGA)}


def over(axis: str, system=model) -> dict:
    """A system over an axis whose values are above 0."""
    low, high = argument(0.5, (*NUMBER, 0.8, -1.0), "high", axis), argument(0.8, (*NUMBER, 0.5, 0.4))
    return {"system": argument(system(), OBJECT), "axis": argument(axis, NAME), "low": low, "high": high}


def span(balance=None):
    return RowSpan(balance or solver.DescribingFunction(), model(), "omega", 0.5, 0.8, None, STEPS)


GALERKIN = Galerkin(2)

CALLS = {
    "solver.Broyden": lambda: {
        "tolerance": argument(1e-8, (*POSITIVE, 1e-5)),
        "max_iterations": argument(9, (*COUNT, 0, 1)),
    },
    "solver.Newton": lambda: {
        "tolerance": argument(1e-8, (*POSITIVE, 1e-5)),
        "max_iterations": argument(9, (*COUNT, 0, 1)),
    },
    "solver.Continuation": lambda: {
        "corrector": argument(CORRECTOR, (*OBJECT, Broyden)),
        **{
            name: argument(1e-2, POSITIVE)
            for name in ("first_step", "largest_step", "smallest_step", "growth", "amplitude_max")
        },
        **{name: argument(0.3, (*POSITIVE, 11.0)) for name in ("largest_angle", "largest_distance", "parameter_step")},
        "max_points": argument(99, (*COUNT, 0, 1)),
    },
    "solver.Continuation.trace": trace_arguments,
    "solver.Continuation.trace_both_ways": trace_arguments,
    "solver.Curve.between": lambda: {
        "self": row().curves[0],
        "first": argument(1, (*COUNT, 9), "last"),
        "last": argument(3, (*COUNT, 0), "first"),
        "ends": argument(row().curves[0].ends, (None, 1, "ab", (1, 2), (None, None), row().curves[0].ends[:1])),
    },
    "solver.Curve.followed_by": lambda: {"self": row().curves[0], "other": argument(row().curves[0], OBJECT)},
    "solver.DescribingFunction.degree": lambda: {
        "self": solver.DescribingFunction(),
        **balance_arguments(None),
        "grid": argument(GRID, array(GRID, empty=True)),
    },
    "solver.DescribingFunction.extremes": lambda: {
        "self": solver.DescribingFunction(),
        "motions": argument(
            np.ones((2, 3)), (*array(np.ones((2, 3)), np.ones((3, 2)), finite=False, any_shape=True), 1.0)
        ),
    },
    "solver.DescribingFunction.linear_solution": lambda: {
        "self": solver.DescribingFunction(),
        **balance_arguments(None),
        "p": argument(0.6, NUMBER),
    },
    "solver.DescribingFunction.problem": lambda: {"self": solver.DescribingFunction(), **about()},
    "solver.LiftedSeeds": lambda: {"columns": argument(9, (*COUNT, 0, 1))},
    "solver.LiftedSeeds.branches": lambda: {
        "self": LiftedSeeds(9),
        "span": argument(span(Galerkin(2)), OBJECT),
        "grid": argument(GRID, array(GRID, GRID[::-1], GRID[:1])),
    },
    "solver.LinearSeeds.branches": lambda: {
        "self": LinearSeeds(),
        "span": argument(span(), OBJECT),
        "grid": argument(GRID, array(GRID, GRID[::-1], GRID[:1])),
    },
    "solver.ProvenSeeds.branches": lambda: {
        "self": ProvenSeeds(9),
        "span": argument(span(), OBJECT),
        "grid": argument(GRID, array(GRID, GRID[::-1], GRID[:1])),
    },
    "solver.ProvenSeeds": lambda: {
        "columns": argument(9, (*COUNT, 0, 1)),
        "every_column": argument(True, (None, 1, "no", [], {})),
    },
    "solver.Problem": lambda: {
        **{
            name: argument(getattr(problem(), name), (None, 1, "foo"))
            for name in ("residual_and_jacobian", "test_functions", "contacts")
        },
        **{
            name: argument(getattr(problem(), name), array(getattr(problem(), name), finite=False, empty=True))
            for name in ("parameters", "parameter_slope")
        },
        "scale": argument(problem().scale, array(problem().scale, -problem().scale, problem().scale[:1])),
        "test_count": argument(5, (*COUNT, 0)),
    },
    "solver.Problem.corrected": lambda: {
        "self": problem(),
        "y": argument(row().curves[0].points[0], array(row().curves[0].points[0], [1.0] * 3)),
        "corrector": argument(CORRECTOR, OBJECT),
        "normal": argument(None, optional(array(np.ones(4), [1.0] * 3))),
        "max_iterations": argument(None, optional((*COUNT, 0))),
    },
    "solver.Problem.corrected_all": lambda: {
        "self": problem(),
        "guesses": argument(row().curves[0].points[:2], array(row().curves[0].points[:2], np.ones((2, 3)), empty=True)),
        "corrector": argument(CORRECTOR, OBJECT),
        "normal": argument(None, optional(array(np.ones(4), [1.0] * 3))),
        "max_iterations": argument(None, optional((*COUNT, 0))),
    },
    "solver.Problem.evaluated": lambda: {
        "self": problem(),
        "y": argument(row().curves[0].points[0], array(row().curves[0].points[0], [1.0] * 3, finite=False)),
    },
    "solver.Problem.observed": lambda: {
        "self": problem(),
        "y": argument(row().curves[0].points[0], array(row().curves[0].points[0], [1.0] * 3, finite=False)),
        "count": argument(5, (*COUNT, 0)),
    },
    "solver.Problem.observed_all": lambda: {
        "self": problem(),
        "points": argument(
            row().curves[0].points[:2], array(row().curves[0].points[:2], np.ones((2, 3)), finite=False, empty=True)
        ),
        "count": argument(5, (*COUNT, 0)),
    },
    "solver.Problem.setup": lambda: {"self": problem(), "corrector": argument(CORRECTOR, OBJECT)},
    "solver.Row.branch_impact": lambda: {"self": row(), "curve": argument(row().curves[0], OBJECT)},
    "solver.Row.branch_motions": lambda: {"self": row(), "curve": argument(row().curves[0], OBJECT)},
    "solver.RowSolutions.take": lambda: {
        "self": solver.enumerate_row(model(), "omega", GRID),
        "indices": argument(
            np.array([0, 3]),
            (
                None,
                "ab",
                1,
                1.5,
                [0.0],
                [7],
                [-1],
                [True],
                [None],
                [[0]],
                {},
                np.ma.masked_array([0, 1], [False, True]),
            ),
        ),
    },
    "solver.all_solutions": lambda: {
        "system": argument(model(), OBJECT),
        "omega": argument(0.6, POSITIVE),
        "amplitude_max": argument(100.0, POSITIVE),
    },
    "solver.free_vibration": lambda: {
        "system": argument(model(), OBJECT),
        "highest": argument(3.0 * GRID + 1.0, array(3.0 * GRID + 1.0, 0.0 * GRID, empty=True)),
        "order": argument(2, (*COUNT, 0, 65)),
        "mode": argument(1, (*COUNT, 2)),
    },
    "solver.backbone": lambda: {
        "model": argument(model(), (*OBJECT, model().replace(f_pm=0.0)), "f_pm"),
        "amplitudes": argument(GRID, array(GRID, -GRID, empty=True)),
    },
    "solver.enumerate_row": lambda: (
        about(ends=False)
        | {
            "grid": argument(GRID, array(GRID, -GRID, 0.0 * GRID, empty=True), "omega"),
            "amplitude_max": argument(100.0, POSITIVE),
        }
    ),
    "solver.first_order_problem": about,
    "solver.sweep_row": lambda: (
        about(ends=False)
        | {
            "grid": argument(GRID, array(GRID, -GRID[::-1], GRID[::-1], 0.0 * GRID, GRID[:1]), "omega"),
            "continuation": argument(STEPS, wrong_settings()),
            "seeds": argument(ProvenSeeds(9), optional((*OBJECT, ProvenSeeds, LiftedSeeds()))),
            "balance": argument(None, optional((*OBJECT, Galerkin, Galerkin(2))), "seeds"),
        }
    ),
    "solver.translations": lambda: {
        "model": argument(model(), OBJECT),
        "omega": argument(0.6, POSITIVE),
        "unknowns": argument(np.ones(3), array(np.ones(3), np.ones(4))),
    },
    "solver.uncondensed_balance": lambda: {
        "model": argument(model(), OBJECT),
        "omega": argument(0.6, POSITIVE),
        "unknowns": argument(np.ones(21), array(np.ones(21), np.ones(20))),
    },
    "solver.solve": lambda: {
        "system": argument(model(), OBJECT),
        "guess": argument([1.0, 0.1, 0.0], array([1.0, 0.1, 0.0], [1.0, 0.1], [1.0])),
        "omega": argument(0.6, POSITIVE),
        "balance": argument(None, optional((*OBJECT, Galerkin))),
        "max_iterations": argument(20, (*COUNT, 0)),
    },
    "solver.Galerkin": lambda: {"order": argument(2, (*COUNT, 0, 65)), "period": argument(1, (*COUNT, 0, 5))},
    "solver.Galerkin.balance_problem": lambda: {
        **{
            name: argument(
                getattr(problem(GALERKIN), name), array(getattr(problem(GALERKIN), name), finite=False, empty=True)
            )
            for name in ("parameters", "parameter_slope")
        },
        "scale": argument(problem(GALERKIN).scale, array(problem(GALERKIN).scale, -problem(GALERKIN).scale)),
    },
    "solver.Galerkin.degree": lambda: {
        "self": GALERKIN,
        **balance_arguments(GALERKIN),
        "grid": argument(GRID, array(GRID, empty=True)),
    },
    "solver.Galerkin.displacement": lambda: {
        "self": GALERKIN,
        "motion": argument(MOTION, array(MOTION, [1.0] * 3)),
        "angle": argument(GRID, array(GRID, any_shape=True)),
    },
    "solver.Galerkin.extremes": lambda: {
        "self": GALERKIN,
        "motions": argument(MOTION, array(MOTION, [1.0] * 3, 1.0, finite=False, any_shape=True)),
    },
    "solver.Galerkin.lifted": lambda: {
        "self": GALERKIN,
        "motions": argument(np.ones(3), array(np.ones(3), [1.0] * 2, 1.0, finite=False, any_shape=True)),
    },
    "solver.Galerkin.linear_solution": lambda: {
        "self": GALERKIN,
        **balance_arguments(GALERKIN),
        "p": argument(0.6, NUMBER),
    },
    "solver.Galerkin.problem": lambda: {"self": GALERKIN, **about()},
}

#: Calls over other axes and with other systems: what is called, and with what.
FURTHER = {
    "a coupling": (
        "solver.first_order_problem",
        lambda: over("kappa") | {"omega": argument(0.6, (None, *WRONG_OMEGA))},
    ),
    "a backlash": (
        "solver.enumerate_row",
        lambda: {
            "system": argument(model(), OBJECT),
            "axis": argument("b", NAME),
            "grid": argument(GRID, array(GRID, -GRID, empty=True), "b"),
            "omega": argument(0.6, (None, *WRONG_OMEGA)),
        },
    ),
    "a row of damping": (
        "solver.sweep_row",
        lambda: {
            "system": argument(model(), OBJECT),
            "axis": argument("xi_mesh", NAME),
            "grid": argument(GRID[:3], array(GRID[:3], -GRID[2::-1]), "xi_mesh"),
            "omega": argument(0.6, (None, *WRONG_OMEGA)),
        },
    ),
    "a gap": (
        "solver.Galerkin.problem",
        lambda: over("gap", system=stop) | {"self": GALERKIN, "omega": argument(0.6, (None, *WRONG_OMEGA))},
    ),
}
