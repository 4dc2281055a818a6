"""Wrong calls of boundaries and regions."""

import numpy as np

from solver import Event
from solver.harmonic.galerkin import Galerkin
from tests.public import NAME, NUMBER, OBJECT, POSITIVE, RANGE, argument, array, optional
from tests.solver.calls.subjects import WRONG_OMEGA, divided, model, plane, row, starts, wrong_settings

CALLS = {
    "solver.boundaries.BoundaryCurve.crossings": lambda: {
        "self": plane()[0],
        "values": argument([0.15, 0.2], array([0.15, 0.2], [0.2, 0.15], empty=True)),
        "continuation": argument(None, wrong_settings()),
    },
    "solver.boundaries.BoundaryCurve.distances": lambda: {
        "self": plane()[0],
        "points": argument(plane()[0].points[:2], array(plane()[0].points[:2], np.ones((2, 4)), np.ones(5))),
        "continuation": argument(None, wrong_settings()),
    },
    "solver.boundaries.BoundaryCurve.meets": lambda: {
        "self": plane()[0],
        "points": argument(plane()[0].points[:2], array(plane()[0].points[:2], np.ones((2, 4)), np.ones(5))),
        "continuation": argument(None, wrong_settings()),
    },
    "solver.boundaries.boundary_curves": lambda: {
        "system": argument(model(), OBJECT),
        "x_axis": argument("omega", (*NAME, "f_e"), "p_axis", "omega"),
        "p_axis": argument("f_e", (*NAME, "omega")),
        "x_range": argument((0.5, 0.8), (*RANGE, (0.0, 0.8)), "omega"),
        "p_range": argument((0.1, 0.2), RANGE),
        "starts": argument(
            starts()[:1],
            (
                None,
                1,
                "ab",
                [1],
                [(Event.FOLD,)],
                [(Event.FOLD, None)],
                [("FOLD", np.ones(5))],
                [(99, np.ones(5))],
                [(Event.NONE, np.ones(5))],
                [(Event.FOLD, np.ones(4))],
                [(Event.FOLD, np.full(5, np.nan))],
                [(Event.FOLD, np.full(5, 9.0))],
                [(1.5, np.ones(5))],
            ),
        ),
        "omega": argument(None, WRONG_OMEGA),
        "balance": argument(None, optional((*OBJECT, Galerkin))),
        "continuation": argument(None, wrong_settings()),
    },
    "solver.boundaries.row_events": lambda: {
        "curves": argument(row().curves, (None, 1, "ab", [1], [None], row().curves[0])),
        "parameter": argument(0.2, NUMBER),
        "kinds": argument((Event.FOLD,), (None, 1, "ab", ["FOLD"], [99], [None])),
    },
    "solver.regions.Regions.neighbours": lambda: {"self": divided(), "label": argument("1/0", NAME)},
    "solver.regions.Regions.occurrences": lambda: {
        "self": divided(),
        "label": argument("1/0", NAME),
        "x_window": argument((0.6, 0.7), optional((*RANGE, (0.0, 0.6)))),
    },
    "solver.regions.Regions.thresholds": lambda: {
        "self": divided(),
        "label": argument("1/0", NAME),
        "x_window": argument((0.6, 0.7), optional((*RANGE, (0.0, 0.6)))),
    },
    "solver.regions.Regions.ranges": lambda: {
        "self": divided(),
        "labels": argument(("1/0",), (None, 1, "1/0", ["foo"], [None], [1]), "label"),
    },
    "solver.regions.Regions.within": lambda: {
        "self": divided(),
        "x_window": argument((0.6, 0.7), (*RANGE, (0.0, 0.6))),
        "p_window": argument((0.15, 0.2), optional((*RANGE, (0.0, 0.2)))),
    },
    "solver.regions.regions": lambda: {
        "system": argument(model(), OBJECT),
        "x_axis": argument("omega", (*NAME, "f_e"), "p_axis", "omega"),
        "p_axis": argument("f_e", (*NAME, "omega")),
        "x_range": argument((0.5, 0.8), (*RANGE, (0.0, 0.8)), "omega"),
        "p_range": argument((0.1, 0.2), RANGE),
        "curves": argument(plane(), (None, 1, "ab", [1], [None], plane()[0])),
        "omega": argument(None, WRONG_OMEGA),
        "amplitude_max": argument(100.0, POSITIVE),
    },
}

#: Calls over other axes and with other systems: what is called, and with what.
FURTHER = {
    "boundaries at one frequency": (
        "solver.boundaries.boundary_curves",
        lambda: {
            "system": argument(model(), OBJECT),
            "x_axis": argument("f_e", (*NAME, "b"), "p_axis"),
            "p_axis": argument("b", (*NAME, "f_e")),
            "x_range": argument((0.1, 0.3), RANGE),
            "p_range": argument((0.5, 1.0), (*RANGE, (-1.0, 1.0)), "b"),
            "starts": argument((), (None, 1)),
            "omega": argument(0.6, (None, *WRONG_OMEGA)),
        },
    )
}
