"""Steady motions of a straight bevel gear pair with backlash: pure numerics, importable on its own.

Public names are loaded when they are first used, and kernels when they are first called. Boundary curves in two
parameters are in `solver.boundaries`, regions of the plane in `solver.regions`.
"""

import importlib

_HOMES = {
    "contact.impact": (
        "ImpactState",
        "domain_code",
        "domain_label",
        "domain_labels",
        "domain_parts",
        "impact_state",
        "label_parts",
    ),
    "continuation.continuation": ("Continuation", "Curve", "EndReason", "Event", "Problem"),
    "continuation.correctors": ("Broyden", "Newton"),
    "continuation.problem": ("Balance",),
    "enumeration.solutions": ("Above", "Proof", "RowSolutions", "Solutions", "all_solutions", "enumerate_row"),
    "gear.blank": ("Blank",),
    "gear.geared_rotor": ("geared_rotor",),
    "gear.mesh_cycle": ("CycleFit", "fit_cycle"),
    "gear.pair": ("GearPair",),
    "gear.pitch_cones": ("PitchCones",),
    "gear.scales": ("Scale", "Scales"),
    "gear.spur_pair": ("spur_pair",),
    "gear.stiffness_estimates": ("iso_6336_stiffness", "thumb_stiffness"),
    "gear.teeth": ("GearTeeth",),
    "gear.tooth_stiffness": ("ToothMesh", "bevel_mesh"),
    "harmonic.backbone": ("Backbone", "backbone"),
    "harmonic.describing_function": ("DescribingFunction", "first_order_problem"),
    "harmonic.free_vibration": ("FreeVibration", "FreeVibrationStatus", "free_vibration"),
    "harmonic.galerkin": ("Galerkin",),
    "harmonic.steady": ("SolveStatus", "SteadyMotion", "solve"),
    "harmonic.uncondensed": ("translations", "uncondensed_balance"),
    "model.checks": ("ParameterError",),
    "model.contact_system": ("ContactSystem", "gear_system"),
    "model.gear_model": ("GEOMETRIC", "SCALAR_PARAMETERS", "Model"),
    "rows.row": ("Row", "sweep_row"),
    "rows.seeds": ("LiftedSeeds", "LinearSeeds", "ProvenSeeds"),
    "rows.span": ("RowError",),
}
_HOME_OF = {name: f"solver.{module}" for module, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME_OF)


def __getattr__(name: str):
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(importlib.import_module(_HOME_OF[name]), name)
    return value


def __dir__():
    return sorted({*globals(), *__all__})
