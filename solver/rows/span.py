"""What is continued in a row: one balance of one system over one axis, and how its branches are traced."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.continuation.continuation import Continuation, Curve, EndReason, Problem
from solver.continuation.on_curve import Crossings, Known, curve_crossings
from solver.continuation.problem import Balance
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model

__all__ = ["BROKEN", "RowError", "RowSpan", "ends_for", "ends_notes", "runs"]


class RowError(ArithmeticError):
    """A row is impossible as it is asked for; the message says why."""


@dataclass(frozen=True)
class RowSpan:
    """What is continued in a row.

    Parameters
    ----------
    balance : Balance
    system : Model or ContactSystem
    axis : str
        One of `solver.model.packing.AXES`, or of `SYSTEM_AXES` for a ContactSystem.
    low, high : float
        Range of the axis.
    omega : float or None
        The frequency, None where it is the axis.
    continuation : Continuation
    """

    balance: Balance
    system: Model | ContactSystem
    axis: str
    low: float
    high: float
    omega: float | None
    continuation: Continuation

    @cached_property
    def problem(self) -> Problem:
        """The balance over the axis."""
        return self.balance.problem(self.system, self.axis, self.low, self.high, self.omega)

    def corrected(self, starts: np.ndarray, iterations: int = 20) -> np.ndarray:
        """What Newton's method reaches from starts y = (u, p) at the same p, (k, n + 1); nan where nothing."""
        solutions = self.problem.corrected_all(starts, self.continuation.corrector, max_iterations=iterations)
        solutions[np.linalg.norm(solutions[:, 1:-1], axis=1) > self.continuation.amplitude_max] = np.nan
        return solutions

    def traced(self, start: np.ndarray) -> Curve:
        """The whole branch through a solution y = (u, p), however it ends; fewer than two points if it has none."""
        if start[-1] in (self.low, self.high):
            heading = 1 if start[-1] == self.low else -1
            return self.continuation.trace(self.problem, start, self.low, self.high, heading)
        return self.continuation.trace_both_ways(self.problem, start, self.low, self.high)

    def crossings(self, curve: Curve, grid: np.ndarray, known: Known | None = None) -> Crossings:
        """Where one of the row's branches meets ascending grid values (X,), at which solutions may be known."""
        return curve_crossings(self.problem, curve, grid, self.continuation, known)

    def described(self, y: np.ndarray) -> str:
        """A solution y = (u, p) in words, for notes."""
        return f"{self.axis} = {y[-1]:.9g} with mean {y[0]:.6g}"


#: Why a branch ends although it goes on: its steps became too small, or its room ran out.
BROKEN = (EndReason.STEP_TOO_SMALL, EndReason.ITERATION_LIMIT)


def ends_for(curves: Iterable[Curve], reason: EndReason) -> list[np.ndarray]:
    """The points (n + 1,) at which branches end for one reason."""
    return [
        curve.points[index]
        for curve in curves
        for end, index in zip(curve.ends, (0, -1), strict=True)
        if end is reason and len(curve.points)
    ]


def ends_notes(span: RowSpan, curves: Iterable[Curve]) -> list[str]:
    """A sentence for every reason why branches of a row break off."""
    sentences = []
    for reason in BROKEN:
        ends = ends_for(curves, reason)
        if ends:
            more = f" and at {len(ends) - 1} more ends of branches" if len(ends) > 1 else ""
            sentences.append(f"{reason.sentence} It happened at {span.described(ends[0])}{more}.")
    return sentences


def runs(flags: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(first), int(last) - 1) for first, last in zip(edges[::2], edges[1::2], strict=True)]
