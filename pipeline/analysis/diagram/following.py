"""A row followed up from rest, and down from where that ended."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.analysis.attractors.options import limits_of
from pipeline.analysis.attractors.queries import hysteresis_intervals
from pipeline.analysis.diagram.options import Way
from pipeline.plan.numerics import System, row_system, sweep_axis
from pipeline.plan.plan import Plan
from solver.timedomain import AttractorKind, AttractorSearch, SlowRun, slow_run

__all__ = ["DIRECTIONS", "Followed", "follow"]

#: In the order in which they are run.
DIRECTIONS = ("up", "down")
#: Two motions are one where extremes and RMS differ by no more than this share of their range; without a period, where
#: these are averages and extremes of so many periods only, by the second.
_ALIKE, _APERIODIC = 1e-3, 0.1


@dataclass(frozen=True, eq=False)
class Followed:
    """What was met along a row.

    Parameters
    ----------
    plan : Plan
    way : Way
    runs : dict of str to SlowRun
        "up" and "down", each in its own order.
    """

    plan: Plan
    way: Way
    runs: dict[str, SlowRun]

    @property
    def system(self) -> System:
        """The system of the row, to be varied along the swept parameter."""
        return row_system(self.plan, self.way.value)

    @cached_property
    def hysteresis(self) -> np.ndarray:
        """Ends (i, 2) of the stretches where another motion is met downwards than upwards.

        A stretch ends where one of the two jumped, if it did on the step there.
        """
        up, down = self.runs["up"], self.runs["down"]
        kinds = up.kind, down.kind[::-1]
        names = ("lowest", "highest", "rms")
        numbers = [np.stack([run.quantities[name] for name in names]) for run in (up, down)]
        numbers[1] = numbers[1][:, ::-1]
        size = np.fmax(numbers[0][1] - numbers[0][0], numbers[1][1] - numbers[1][0])
        apart = np.max(np.abs(numbers[1] - numbers[0]), axis=0)
        aperiodic = np.maximum(*kinds) > AttractorKind.PERIOD_LONGER
        differs = apart > np.where(aperiodic, _APERIODIC, _ALIKE) * size
        differs |= np.isnan(numbers[0][0]) != np.isnan(numbers[1][0])
        ends = hysteresis_intervals(up.values, differs)
        jumps = np.concatenate([run.jumps[np.isfinite(run.jumps)] for run in (up, down)])
        half = 0.5 * np.max(np.diff(up.values))
        for stretch in ends:
            for side in range(2):
                near = jumps[np.abs(jumps - stretch[side]) <= half]
                if near.size:
                    stretch[side] = near[np.argmin(np.abs(near - stretch[side]))]
        return ends


def follow(plan: Plan, way: Way) -> Followed:
    """Follow a row up and down.

    Parameters
    ----------
    plan : Plan
        Of a plane.
    way : Way
    """
    sweep, columns = sweep_axis(plan), np.array(way.columns)
    omega = plan.frequency(way.value)
    transient, watched = limits_of(way.max_periods)
    search = AttractorSearch(transient=transient, watched=watched)
    system = row_system(plan, way.value)
    up = slow_run(system, sweep, columns, omega=omega, search=search)
    last = up.state[-1]
    # Nothing is left to go on from where the motion has become unbounded.
    state = None if np.isnan(last).all() else last[np.isfinite(last)]
    down = slow_run(system, sweep, columns[::-1], omega=omega, state=state, search=search)
    return Followed(plan, way, {"up": up, "down": down})
