"""What cases read of branches, and how they draw them."""

import numpy as np
from matplotlib.axes import Axes

from solver import Curve, Event, Galerkin, LiftedSeeds, Row, sweep_row
from solver.stability import Instability, assess

__all__ = ["INK", "SUBHARMONIC", "draw_branch", "draw_row", "folds", "galerkin_row", "largest"]

#: Colours of branches of one forcing period, and of several.
INK, SUBHARMONIC = "#1a1a1a", "#1f4e8c"


def galerkin_row(system, low: float, high: float, order: int, seeds: int = 30) -> Row:
    """A row over the frequency at order H."""
    grid = np.linspace(low, high, 30)
    return sweep_row(system, "omega", grid, balance=Galerkin(order), seeds=LiftedSeeds(seeds))


def folds(*curves: Curve) -> list[float]:
    """Frequencies of the folds of branches, ascending."""
    return sorted(float(p) for curve in curves for p in curve.points[curve.event == Event.FOLD, -1])


def largest(curve: Curve, values: np.ndarray) -> tuple[float, float]:
    """The largest of values (k,) at the points of a branch, between points, and the frequency where it is."""
    at = int(np.argmax(values))
    here = slice(at - 2, at + 3)
    arc = curve.arclength[here] - curve.arclength[at]
    value, place = (np.polyfit(arc, numbers[here], 4) for numbers in (values, curve.points[:, -1]))
    turns = np.roots(np.polyder(value))
    inside = [turn.real for turn in turns if abs(turn.imag) < 1e-9 and arc[0] < turn.real < arc[-1]]
    top = max(inside, key=lambda turn: np.polyval(value, turn))
    return float(np.polyval(value, top)), float(np.polyval(place, top))


def draw_branch(axes: Axes, system, balance: Galerkin, curve: Curve, colour: str = INK) -> None:
    """The largest lambda along a branch over the frequency, dashed where it is unstable."""
    omega, motions = curve.points[:, -1], curve.points[:, :-1]
    highest = balance.extremes(motions)[1]
    found = assess(system, "omega", omega, motions, balance=balance, static=curve.stable)
    unstable = found.kind != Instability.NONE
    edges = np.flatnonzero(np.diff(unstable.astype(int))) + 1
    for part in np.split(np.arange(omega.size), edges):
        # With the next point, so that no gap is left.
        part = np.append(part, min(part[-1] + 1, omega.size - 1))
        axes.plot(
            omega[part],
            highest[part],
            color=colour,
            linewidth=1.3 if not unstable[part[0]] else 0.9,
            linestyle="-" if not unstable[part[0]] else (0, (3, 2)),
        )


def draw_row(axes: Axes, row: Row) -> None:
    """All branches of a row over the frequency."""
    for curve in row.curves:
        draw_branch(axes, row.system, row.balance, curve)
    axes.set(xlabel="Ω", ylabel="largest displacement", xlim=(row.grid[0], row.grid[-1]))
