"""What the numbers of a plan mean in physical units."""

from pipeline.plan.plan import Plan
from solver import GearPair, Scales
from solver.gear.scales import SystemScales
from solver.model.checks import instance_of

__all__ = ["cycle_note", "gear_of", "scales_from", "scales_of", "teeth_note"]

#: N per m of face width from which on ISO 6336 holds.
_LEAST_LOAD = 1e5


def gear_of(plan: Plan) -> GearPair | None:
    """The gear pair in SI units of a plan; None where the plan is dimensionless."""
    return None if plan.physical is None else GearPair(**plan.physical["gear"])


def scales_from(physical: dict | None) -> Scales | SystemScales | None:
    """Scales from what a plan keeps of physical units; None where it has none."""
    if physical is None:
        return None
    return Scales(GearPair(**physical["gear"])) if "gear" in physical else SystemScales(**physical)


def scales_of(plan: Plan) -> Scales | SystemScales | None:
    """What dimensionless values of a plan mean in physical units; None where the plan is dimensionless.

    Raises
    ------
    solver.ParameterError
        If it is no plan.
    """
    instance_of("plan", plan, Plan)
    return scales_from(plan.physical)


def cycle_note(plan: Plan) -> list[str]:
    """One line on how well a mesh cycle was fitted, where there is one."""
    cycle = None if plan.physical is None else plan.physical.get("mesh_cycle")
    if cycle is None:
        return []
    parts = []
    for name, unit, size in (("stiffness", "N/um", 1e6), ("error", "um", 1e-6)):
        if (fit := cycle[name]) is not None:
            count = len(fit["harmonics"])
            parts.append(f"{name} residual {fit['rms'] / size:.3g} {unit} rms, {fit['largest'] / size:.3g} at most")
    return [f"mesh cycle of {cycle['points']} points fitted with {count} harmonics: {'; '.join(parts)}"]


def teeth_note(plan: Plan) -> list[str]:
    """One line on the mesh stiffness that was computed from the teeth, where it was."""
    drawn = None if plan.physical is None else plan.physical.get("teeth")
    if drawn is None:
        return []
    line = f"contact ratio {drawn['contact_ratio']:.4g}, mesh stiffness {drawn['stiffness'] / 1e6:.4g} N/um"
    if drawn["harmonics"] is None:
        gear = gear_of(plan)
        load = abs(gear.torque) / (gear.mean_radii[0] * gear.face_width)
        low = f"; it holds from 100 N/mm of the face width on, and the load is {load / 1e3:.3g} N/mm"
        return [f"teeth by ISO 6336: {line}{low if load < _LEAST_LOAD else ''}"]
    amplitudes = ", ".join(f"{amplitude / 1e6:.3g}" for amplitude, _ in drawn["harmonics"])
    estimate = drawn["estimate"]
    beside = "" if estimate is None else f" (ISO 6336 estimates {estimate / 1e6:.3g} N/um)"
    outside = [name for name, fits in zip(("pinion", "gear"), drawn["bodies_fit"], strict=True) if not fits]
    limits = (
        f"; outside the range of the fit for bodies, at whose end it is taken: {', '.join(outside)}" if outside else ""
    )
    return [f"teeth from geometry: {line}{beside}, harmonics {amplitudes} N/um{limits}"]
