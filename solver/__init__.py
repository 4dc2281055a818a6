"""Steady motions of a straight bevel gear pair with backlash: pure numerics, importable on its own.

Boundary curves in two parameters are in `solver.boundaries`, which is imported on its own: its kernels are many.
"""

from solver.contact.impact import (
    ImpactState,
    domain_code,
    domain_label,
    domain_labels,
    domain_parts,
    impact_state,
    label_parts,
)
from solver.continuation.continuation import Continuation, Curve, EndReason, Event, Problem
from solver.continuation.correctors import Broyden, Newton
from solver.continuation.problem import Balance
from solver.enumeration.solutions import Above, Proof, RowSolutions, Solutions, all_solutions, enumerate_row
from solver.gear.blank import Blank
from solver.gear.mesh_cycle import CycleFit, fit_cycle
from solver.gear.pair import GearPair
from solver.gear.scales import Scale, Scales
from solver.harmonic.backbone import Backbone, backbone
from solver.harmonic.describing_function import DescribingFunction, first_order_problem
from solver.harmonic.uncondensed import translations, uncondensed_balance
from solver.model.checks import ParameterError
from solver.model.contact_system import ContactSystem, gear_system
from solver.model.gear_model import GEOMETRIC, SCALAR_PARAMETERS, Model
from solver.rows.row import Row, sweep_row
from solver.rows.seeds import LinearSeeds, ProvenSeeds, RowError

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
