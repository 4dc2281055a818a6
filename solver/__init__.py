"""Steady motions of a straight bevel gear pair with backlash: pure numerics, importable on its own.

Boundary curves in two parameters are in `solver.boundaries`, which is imported on its own: its kernels are many.
"""

from solver.backbone import Backbone, backbone
from solver.blank import Blank
from solver.branches import LinearSeeds, ProvenSeeds, RowError
from solver.contact_system import ContactSystem, gear_system
from solver.continuation import Continuation, Curve, EndReason, Event, Problem
from solver.correctors import Broyden, Newton
from solver.enumeration import Above, Proof, RowSolutions, Solutions, all_solutions, enumerate_row
from solver.errors import ParameterError
from solver.gear import GearPair
from solver.harmonic.first_order import DescribingFunction, first_order_problem
from solver.harmonic.uncondensed import translations, uncondensed_balance
from solver.impact import ImpactState, domain_code, domain_label, domain_labels, domain_parts, impact_state, label_parts
from solver.mesh_cycle import CycleFit, fit_cycle
from solver.model import GEOMETRIC, SCALAR_PARAMETERS, Model
from solver.problem import Balance
from solver.row import Row, sweep_row
from solver.scales import Scale, Scales

__all__ = [
    "GEOMETRIC",
    "SCALAR_PARAMETERS",
    "Above",
    "Balance",
    "Backbone",
    "Blank",
    "Broyden",
    "ContactSystem",
    "Continuation",
    "Curve",
    "CycleFit",
    "DescribingFunction",
    "EndReason",
    "Event",
    "GearPair",
    "LinearSeeds",
    "ImpactState",
    "Model",
    "Newton",
    "ParameterError",
    "Problem",
    "ProvenSeeds",
    "Proof",
    "Row",
    "RowError",
    "RowSolutions",
    "Scale",
    "Scales",
    "Solutions",
    "all_solutions",
    "backbone",
    "domain_code",
    "domain_label",
    "domain_labels",
    "domain_parts",
    "enumerate_row",
    "first_order_problem",
    "fit_cycle",
    "gear_system",
    "impact_state",
    "label_parts",
    "sweep_row",
    "translations",
    "uncondensed_balance",
]
