"""What the numbers of a plan mean in physical units."""

from pipeline.plan.plan import Plan
from solver import GearPair, Scales
from solver.model.checks import instance_of

__all__ = ["cycle_note", "gear_of", "scales_of"]


def gear_of(plan: Plan) -> GearPair | None:
    """The gear pair in SI units of a plan; None where the plan is dimensionless."""
    return None if plan.physical is None else GearPair(**plan.physical["gear"])


def scales_of(plan: Plan) -> Scales | None:
    """What dimensionless values of a plan mean in physical units; None where the plan is dimensionless.

    Raises
    ------
    solver.ParameterError
        If it is no plan.
    """
    instance_of("plan", plan, Plan)
    gear = gear_of(plan)
    return None if gear is None else Scales(gear)


def cycle_note(plan: Plan) -> list[str]:
    """One line on how well a mesh cycle was fitted, where there is one."""
    cycle = None if plan.physical is None else plan.physical["mesh_cycle"]
    if cycle is None:
        return []
    parts = []
    for name, unit, size in (("stiffness", "N/um", 1e6), ("error", "um", 1e-6)):
        if (fit := cycle[name]) is not None:
            count = len(fit["harmonics"])
            parts.append(f"{name} residual {fit['rms'] / size:.3g} {unit} rms, {fit['largest'] / size:.3g} at most")
    return [f"mesh cycle of {cycle['points']} points fitted with {count} harmonics: {'; '.join(parts)}"]
