"""What is allowed but worth a line before a run."""

from pipeline.plan import Plan, outer_planes

__all__ = ["warnings"]


def warnings(plan: Plan) -> list[str]:
    """What is allowed but worth a line: stiffness that turns negative, and mesh damping that breaks the physics."""
    from pipeline.sweep import model_at

    lines = []
    corners = [
        model_at(plane, row, column)
        for plane in outer_planes(plan)
        for row in (plan.parameter.low, plan.parameter.high)
        for column in (plan.sweep.low, plan.sweep.high)
    ]
    lowest = min(model.lowest_stiffness() for model in corners)
    if lowest < 0.0:
        lines.append(f"the mesh stiffness falls to {lowest:.3g} of its mean somewhere in this plane: below 0 is unphysical")
    model = corners[0]
    ratios = tuple(xi / model.xi_mesh for xi in model.xi_translation) if model.xi_mesh > 0.0 else model.kappa
    if any(abs(ratio - kappa) > 1e-9 for ratio, kappa in zip(ratios, model.kappa, strict=True)):
        shown, wanted = (", ".join(f"{value:g}" for value in dict.fromkeys(values)) for values in (ratios, model.kappa))
        moved = [f" at {axis.name} = {axis.low:g}" for axis in plan.axes if axis.name in ("xi_mesh", "xi_translation", "kappa")]
        hint = "; plane.parameter.name=mesh_damping moves both" if "xi_mesh" in (axis.name for axis in plan.axes) else ""
        lines.append(
            f"gear.xi_translation/gear.xi_mesh = {shown}{''.join(moved)} differs from gear.kappa = {wanted}: "
            f"one mesh force would make them equal{hint}"
        )
    if plan.physical is not None:
        from pipeline.physical import cycle_note

        lines += cycle_note(plan)
    if plan.parameter2 is not None:
        lines.append("a volume has no boundaries of its own: plane.layer=VALUE takes out the plane of one layer, which has")
    return lines
