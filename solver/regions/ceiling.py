"""Where a branch passes the amplitude ceiling: a boundary of what is counted, though nothing happens to the motion.

Towards parametric resonance branches run to infinite amplitude. Solutions above the ceiling do not count, so that the
label changes where lambda_a = ceiling: a curve of the plane like a fold or a grazing.
"""

from dataclasses import dataclass

import numpy as np

from solver.boundaries.curve import BoundaryCurve, assembled
from solver.boundaries.first_order import FirstOrderProblem
from solver.boundaries.problem import Contact, Plane
from solver.boundaries.tracer import Tracer
from solver.continuation.continuation import Continuation, Event, Problem
from solver.model.parameters import LEVEL

__all__ = ["ceiling_curve"]


@dataclass(frozen=True)
class _CeilingProblem(FirstOrderProblem):
    """The ceiling in place of a grazing; both flanks may be crossed or not, as along folds."""

    ceiling: float

    def problem(self, kind: Event, contact: Contact) -> Problem:
        problem = super().problem(kind, contact)
        problem.parameters[LEVEL] = self.ceiling
        problem.scale[:3] = self.ceiling
        return problem


def ceiling_curve(plane: Plane, ceiling: float, point: np.ndarray) -> BoundaryCurve | None:
    """The curve lambda_a = ceiling through a point.

    Parameters
    ----------
    plane : Plane
    ceiling : float
        Amplitude.
    point : (5,) array
        lambda_m, lambda_c, lambda_s, x, p of a solution next to it.

    Returns
    -------
    BoundaryCurve or None
        Of kind NONE, as nothing happens to the motion; None if none could be followed.
    """
    problem = _CeilingProblem(plane, float(ceiling))
    chain = Tracer(problem, Event.NONE, Continuation()).boundary(point)
    return None if chain is None else assembled(problem, Event.NONE, chain.directed())
