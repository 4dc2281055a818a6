"""The axes of a plane or a volume, from its configuration."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.config.physical import PATHS, value_of
from pipeline.config.schema import Plane
from pipeline.errors import ConfigurationError, refused
from pipeline.plan.kinds import BEVEL, GearKind

__all__ = ["ROLES", "Axis", "axes_of"]

#: The axes of a plane as `conf/plane` names them; the last one makes it a volume.
ROLES = ("sweep", "parameter", "parameter2")


@dataclass(frozen=True)
class Axis:
    """`num` values of one parameter from `low` to `high`, both included."""

    name: str
    low: float
    high: float
    num: int

    @cached_property
    def values(self) -> np.ndarray:
        """The grid, (num,)."""
        return np.linspace(self.low, self.high, self.num)


def axes_of(config: Plane, kind: GearKind, scales) -> dict[str, Axis]:
    """The axes of a plane by role, checked.

    Parameters
    ----------
    config : Plane
    kind : GearKind
        Of the system, which has the parameters that may be an axis.
    scales : solver.Scales or None
        Of a gear in physical units, for ends with a unit.

    Raises
    ------
    ConfigurationError
        Naming the key.
    """
    given = {role: getattr(config, role) for role in ROLES if getattr(config, role) is not None}
    taken: dict[str, str] = {}
    for role, axis in given.items():
        if (other := taken.setdefault(_name(axis, kind), role)) != role:
            raise ConfigurationError(
                f"plane.{role}.name = {axis.name!r} is not allowed: the {other} axis has that name already"
            )
    axes = {role: _axis(role, axis, kind, scales) for role, axis in given.items()}
    cells = math.prod(axis.num for axis in axes.values())
    if cells > config.max_cells:
        raise refused(
            " x ".join(f"plane.{role}.num" for role in axes), cells, f"at most plane.max_cells = {config.max_cells:g}"
        )
    return axes


def _name(axis, kind: GearKind) -> str:
    """The parameter, which may be given by its key."""
    return axis.name.removeprefix(kind.key("")).replace("variation.", "variation_")


def _axis(role: str, axis, kind: GearKind, scales) -> Axis:
    name = _name(axis, kind)
    if name in PATHS and kind is BEVEL and role != "parameter":
        raise ConfigurationError(
            f"plane.{role}.name = {axis.name!r} is not allowed: {name} changes several numbers at once, "
            "so that it can be plane.parameter.name only"
        )
    allowed = ("omega", *kind.axes, *(PATHS if role == "parameter" and kind is BEVEL else ()))
    if name not in allowed:
        raise refused(f"plane.{role}.name", axis.name, f"one of {', '.join(allowed)} with this gear")
    low, high = (value_of(f"plane.{role}.{end}", name, getattr(axis, end), scales) for end in ("min", "max"))
    shown_low, shown_high = (
        typed if isinstance(typed, str) else number for typed, number in ((axis.min, low), (axis.max, high))
    )
    if not np.isfinite(low) or (name == "omega" and low <= 0.0):
        extra = " above 0" if name == "omega" else ""
        raise refused(f"plane.{role}.min", shown_low, f"a finite number{extra}")
    if not np.isfinite(high) or high <= low:
        raise refused(f"plane.{role}.max", shown_high, f"a finite number above plane.{role}.min = {shown_low!r}")
    return Axis(name, low, high, int(axis.num))
