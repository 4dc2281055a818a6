"""Steady motions of a straight bevel gear pair with backlash: pure numerics, importable on its own."""

from solver.backbone import Backbone, backbone
from solver.boundaries import BoundaryCurve, SpecialPoint, boundary_curves, missed_events, row_events
from solver.continuation import Continuation, Curve, EndReason, Event, Problem
from solver.correctors import Broyden, Newton
from solver.errors import ParameterError
from solver.harmonic.first_order import first_order_problem
from solver.harmonic.uncondensed import translations, uncondensed_balance
from solver.impact import ImpactState, domain_code, domain_label, domain_labels, impact_state
from solver.model import GEOMETRIC, SCALAR_PARAMETERS, Model
from solver.row import Row, RowError, sweep_row

__all__ = [
    "GEOMETRIC",
    "SCALAR_PARAMETERS",
    "Backbone",
    "BoundaryCurve",
    "Broyden",
    "Continuation",
    "Curve",
    "EndReason",
    "Event",
    "ImpactState",
    "Model",
    "Newton",
    "ParameterError",
    "Problem",
    "Row",
    "RowError",
    "SpecialPoint",
    "backbone",
    "boundary_curves",
    "domain_code",
    "domain_label",
    "domain_labels",
    "first_order_problem",
    "impact_state",
    "missed_events",
    "row_events",
    "sweep_row",
    "translations",
    "uncondensed_balance",
]
