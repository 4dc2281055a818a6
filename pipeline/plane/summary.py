"""What a stored plane is, in a few lines."""

from collections.abc import Iterable

import numpy as np

from pipeline.plane.stored import StoredPlane
from solver import domain_label

__all__ = ["summary_of"]


def summary_of(plane: StoredPlane, groups: Iterable[str]) -> list[str]:
    """Lines on the axes, the balance, the rows and labels of a plane, and the names of its groups."""
    plan = plane.plan
    shown = [domain_label(int(code)) for code in np.unique(plane.domain) if code]
    axes = [f"{axis.name} from {axis.low:g} to {axis.high:g} ({axis.num} values)" for axis in plan.axes]
    lines = {
        "plane": " over ".join(axes),
        "solved at": plan.order_text,
        "rows": f"{int(np.sum(plane.complete))} of {plan.parameter.num} complete",
        "labels": ", ".join(shown) or "none",
        "groups": ", ".join(sorted(groups)),
        "store": str(plane.path),
    }
    return [f"  {name:9} {text}" for name, text in lines.items()]
