"""What may be asked of the stage, checked before anything is computed, and the settings of the solver that it means."""

import math
import numbers

import numpy as np

from pipeline.analysis.attractors.grid import Grid, chosen
from pipeline.config.schema import Attractors
from pipeline.errors import ConfigurationError, refused
from pipeline.plan.axes import Axis
from pipeline.plan.plan import Plan

__all__ = ["check_box", "check_options", "grid_of", "keys_of", "limits_of", "search_of"]

#: Attractors that are told apart in one cell.
_ROOM = 8


def check_options(options: Attractors, plan: Plan) -> None:
    """Raise ConfigurationError, one line, unless these settings are allowed for this plane."""
    for key, axis in (("columns", plan.sweep), ("rows", plan.parameter)):
        _check_chosen(f"attractors.{key}", getattr(options, key), axis)
    if options.branches and (options.points is not None or plan.parameter2 is not None):
        raise ConfigurationError("attractors.branches is not allowed for a volume or with attractors.points")
    if options.points is None:
        if options.box is not None:
            raise ConfigurationError("attractors.box is not allowed without attractors.points")
        return
    if plan.parameter2 is not None:
        raise ConfigurationError("attractors.points is not allowed for a volume: plane.layer=VALUE takes out a plane")
    axes = (plan.sweep, plan.parameter)
    names = f"[{axes[0].name}, {axes[1].name}]"
    if not isinstance(options.points, list) or not options.points:
        raise refused("attractors.points", options.points, f"null or a list of {names}")
    for point in options.points:
        if not _is_pair(point) or not all(_inside(value, axis) for value, axis in zip(point, axes, strict=True)):
            allowed = ", ".join(f"{axis.name} = {axis.low:g} ... {axis.high:g}" for axis in axes)
            raise refused("attractors.points", point, f"{names} within {allowed}")
    if options.starts < 1:
        raise refused("attractors.starts", options.starts, "at least 1 where attractors.points are given")
    check_box(options.box)


def check_box(box) -> None:
    """Raise ConfigurationError unless these are ranges of lambda and of its speed, or None."""
    if box is not None and not (_is_pair(box) and all(_is_pair(ends) and ends[0] < ends[1] for ends in box)):
        raise refused("attractors.box", box, "null or [[lambda low, high], [speed low, high]], low below high")


def _check_chosen(key: str, value, axis: Axis) -> None:
    allowed = f"null, a whole number from 1 to {axis.num}, or a list of values within {axis.low:g} ... {axis.high:g}"
    if value is None:
        return
    if isinstance(value, list):
        if not value or not all(_inside(one, axis) for one in value):
            raise refused(key, value, allowed)
    elif isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= axis.num:
        raise refused(key, value, allowed)


def _is_pair(value) -> bool:
    return isinstance(value, list) and len(value) == 2 and (all(map(_is_number, value)) or all(map(_is_pair, value)))


def _is_number(value) -> bool:
    return isinstance(value, numbers.Real) and not isinstance(value, bool) and math.isfinite(value)


def _inside(value, axis: Axis) -> bool:
    return _is_number(value) and axis.low <= value <= axis.high


def grid_of(plan: Plan, options: Attractors) -> Grid:
    """The cells that are integrated."""
    return Grid(plan, chosen(plan.parameter, options.rows), chosen(plan.sweep, options.columns), _ROOM)


def search_of(options: Attractors):
    """The solver's settings."""
    from solver.timedomain import AttractorSearch

    transient, watched = limits_of(options.max_periods)
    return AttractorSearch(starts=options.starts, transient=transient, watched=watched, room=_ROOM)


def limits_of(max_periods: int) -> tuple[int, int]:
    """The periods that a start may take: for settling, and for the watch over the Lyapunov exponent, in the proportion
    of the solver's own settings."""
    from solver.timedomain import AttractorSearch

    usual = AttractorSearch()
    transient = max_periods * usual.transient // (usual.transient + usual.watched)
    return transient, max_periods - transient


def keys_of(grid: Grid, row: int, seed: int) -> np.ndarray:
    """Seeds of the random states of the cells of a row, (X,) uint64: by the cell's place in its plane and the seed.

    A cell has the same ones whatever other cells are integrated, and a layer of a volume those of its plane alone.
    """
    cells = grid.rows[row % len(grid.rows)] * grid.plan.sweep.num + np.array(grid.columns, dtype=np.uint64)
    with np.errstate(over="ignore"):
        # Seeds that are near give keys that are far apart.
        return np.random.SeedSequence(seed).generate_state(1, np.uint64) + cells
