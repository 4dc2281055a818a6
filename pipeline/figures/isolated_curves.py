"""Branches that rows lack, followed from attractors, in the figure of a row's curves: lines of a dash and two dots."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from pipeline import store
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.plane.stored import StoredPlane
from solver import ImpactState
from solver.stability.instability import LEFT_TO_FOLDS

__all__ = ["IsolatedCurves", "isolated_curves_at"]

#: Steady motions, and unstable ones, which are paler.
_LINE, _UNSTABLE = {"linestyle": (0, (4.5, 1, 1, 1, 1, 1)), "linewidth": 1.1, "zorder": 3.5}, 0.45
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class IsolatedCurves:
    """Points of the branches that one row lacks, branch by branch.

    Parameters
    ----------
    points : dict
        Name -> (point,) array: "position" on the sweep axis, "branch", "period", "impact", "steady", and quantities.
    """

    points: dict[str, np.ndarray]

    def extent(self, name: str) -> tuple[float, float]:
        """Least and largest value of a quantity; nan where there is no branch."""
        values = self.points[name]
        return (np.fmin.reduce(values), np.fmax.reduce(values)) if values.size else (np.nan, np.nan)

    def draw(self, axes: Axes, name: str) -> None:
        """Every branch, in the colour of its impact state."""
        points = self.points
        traits = np.stack([points["branch"], points["impact"], points["steady"]], axis=-1)
        edges = np.flatnonzero(np.any(np.diff(traits, axis=0) != 0, axis=1)) + 1
        place = np.column_stack([points["position"], points[name]])
        lines, colours = [], []
        for part in np.split(np.arange(len(place)), edges):
            if not part.size:
                continue
            following = min(part[-1] + 1, len(place) - 1)
            # On to the next part of the same branch.
            whole = np.append(part, following) if points["branch"][following] == points["branch"][part[0]] else part
            lines.append(place[whole])
            colour = hex_colour(state_colour(ImpactState(int(points["impact"][part[0]])).symbol))
            colours.append((colour, 1.0 if points["steady"][part[0]] else _UNSTABLE))
        axes.add_collection(LineCollection(lines, colors=colours, **_LINE), autolim=False)

    @property
    def keys(self) -> dict[str, Line2D]:
        """Text and key for the legend; none where there is no branch."""
        periods = np.unique(self.points["period"]).tolist()
        if not periods:
            return {}
        style = {name: _LINE[name] for name in ("linestyle", "linewidth")}
        return {"from attractors (pale: unstable)": Line2D([], [], color="0.3", **style)}


def isolated_curves_at(plane: StoredPlane, value: float, names: tuple[str, ...]) -> IsolatedCurves | None:
    """The branches that the row of a value lacks; None where that is no row from whose attractors they were sought.

    Parameters
    ----------
    plane : StoredPlane
    value : float
        Of the row parameter.
    names : tuple of str
        Quantities.
    """
    if not store.exists(plane.path / "isolated"):
        return None
    # It takes a while to load, and most planes have none.
    from pipeline.analysis.attractors.isolated import isolated_near, read_isolated

    found = read_isolated(plane.path)
    if found is None:
        return None
    axis = plane.plan.parameter
    here = isolated_near(found, plane.plan, value)
    if abs(here[f"isolated_row_{axis.name}"].values[0] - value) > _SAME * (axis.high - axis.low):
        return None
    points = {name: here[name].values for name in (*names, "branch", "period", "impact")}
    points["position"] = here[f"isolated_{plane.plan.sweep.name}"].values
    points["steady"] = (here["stable"].values == 1) & np.isin(here["instability"].values, LEFT_TO_FOLDS)
    return IsolatedCurves(points)
