"""Whether the solutions that are known at a point can be all, by the degree of the balance, and one that is missing.

The dead zone between two flanks of equal stiffness is a bounded change of a linear force, so the signs of det J over
all solutions at a point add up to the sign of the linear system's determinant. Where they do not, a solution is missing
or lies above the amplitude ceiling.
"""

import dataclasses

import numpy as np

from solver.continuation.solution_curve import EndReason
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import dead_zone_ends
from solver.model.parameter_path import place_on
from solver.rows.span import RowSpan

__all__ = ["grown_solution", "missing_degree"]

#: Of the backlash while it grows from 0, in units of its final value.
_STEP = 0.25


def missing_degree(span: RowSpan, grid: np.ndarray, met) -> np.ndarray:
    """Whether the signs of det J over the solutions at each grid value fail to add up to the linear system's sign.

    Where no degree is known, as of a contact with one flank, nothing is missing.

    Parameters
    ----------
    span : RowSpan
    grid : (X,) array
    met : sequence of Crossings
        What every curve passes there.

    Returns
    -------
    (X,) bool array
    """
    degree = np.zeros(grid.size, dtype=np.int64)
    for crossing in met:
        np.add.at(degree, crossing.column, 2 * crossing.stable.astype(np.int64) - 1)
    expected = span.balance.degree(span.problem, grid)
    return np.isfinite(expected) & (degree != expected)


def grown_solution(span: RowSpan, p: float) -> np.ndarray | None:
    """A solution at p, by continuing the backlash from 0; None if that leads above the amplitude ceiling.

    Gaps grow from 0 in proportion; where the force is not linear without them, as of one flank, there is none.
    """
    system, omega = place_on(span.axis, p, span.system, span.omega)
    low, high = (float(end) for end in dead_zone_ends(system, "omega", np.array(0.0)))
    if isinstance(system, ContactSystem) and not system.bounded_change:
        return None
    axis, end = ("b", system.b) if isinstance(system, Model) else ("gap_scale", 1.0)
    problem = span.balance.problem(system, axis, 0.0, end or 1.0, omega)
    degree, unknowns = span.balance.linear_solution(problem, 0.0)
    if degree == 0.0 or not np.all(np.isfinite(unknowns)):
        return None
    if high - low > 0.0:
        strides = dataclasses.replace(span.continuation, parameter_step=_STEP)
        curve = strides.trace(problem, np.append(unknowns, 0.0), 0.0, end)
        if curve.ends[1] is not EndReason.RANGE_LEFT or curve.points[-1, -1] != end:
            return None
        unknowns = curve.points[-1, :-1]
    return np.append(unknowns, p)
