"""Rows against the bifurcation curves of their plane: what is on either side of a curve is what the curve says.

Curves are traced from the events of a few rows. The rows that are looked at are others: their motions are classified by
multipliers, one by one, and know nothing of curves. Between two neighbouring places of a branch

    det(M + I) changes its sign as often as a period doubling is crossed;
    N, the number of multipliers outside the unit circle, changes by one at a period doubling and where a real one
    passes +1 (det(M - I) changes its sign: no event of branches), and by two at a Neimark-Sacker,

and nothing else changes either. No motion is left out but those with a multiplier within the tolerance of the circle,
which are stored as undecided.
"""

from collections import Counter
from typing import NamedTuple

import numpy as np
import pytest

from solver import Continuation, Event, Model, sweep_row
from solver.boundaries import BIFURCATIONS, boundary_curves, row_events
from solver.continuation.on_curve import curve_crossings
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.galerkin import Galerkin
from solver.rows.seeds import LiftedSeeds
from solver.stability import Instability, classify, multipliers
from solver.stability.assessment import TOLERANCE
from tests.conftest import MODELS, slow_but

OMEGA = (0.3, 2.0)
RANGES = {
    "f_e": (0.05, 0.5),
    "alpha": (0.05, 0.5),
    "alpha_phase": (-3.1, 3.1),
    "f_pm": (0.3, 1.0),
    "b": (0.1, 1.2),
    "xi_mesh": (0.01, 0.1),
    "xi_support": (0.002, 0.05),
}
#: How close a motion of a curve is to that of the branch which it crosses there, in the motion's own unit.
SAME = 1e-6


class Plane(NamedTuple):
    """Gear, both axes, the frequency where neither is that, and the order of the balance."""

    gear: str
    sweep: str
    parameter: str
    omega: float | None = None
    order: int = 1

    @property
    def balance(self):
        return DescribingFunction() if self.order == 1 else Galerkin(self.order)

    def at(self, value: float) -> Model:
        return MODELS[self.gear](**{self.parameter: value})

    @property
    def span(self) -> tuple[float, float]:
        return OMEGA if self.sweep == "omega" else RANGES[self.sweep]

    def row(self, value: float, columns: int):
        seeds = None if self.order == 1 else LiftedSeeds(41)
        grid = np.linspace(*self.span, columns)
        return sweep_row(self.at(value), self.sweep, grid, omega=self.omega, balance=self.balance, seeds=seeds)

    def curves(self, rows: int = 16):
        starts = []
        for value in np.linspace(*RANGES[self.parameter], rows):
            starts += row_events(self.row(value, 60).curves, value, BIFURCATIONS)
        axes = self.sweep, self.parameter, self.span, RANGES[self.parameter]
        return boundary_curves(MODELS[self.gear](), *axes, starts, omega=self.omega, balance=self.balance)


PLANES = [
    *(Plane(gear, "omega", axis) for gear in MODELS for axis in RANGES),
    *(Plane(gear, "f_e", "b", omega) for gear in ("published", "antiphase") for omega in (0.6, 1.5)),
    Plane("antiphase", "alpha", "f_e", 0.55),
    *(Plane(gear, "omega", axis, None, 3) for gear in MODELS for axis in ("f_e", "alpha")),
    Plane("antiphase", "omega", "f_e", None, 5),
]
#: Every gear, every kind of axis, and every order.
ORDINARY = [
    *(Plane(gear, "omega", "f_e") for gear in MODELS),
    Plane("published", "omega", "b"),
    Plane("antiphase", "omega", "xi_mesh"),
    Plane("published", "f_e", "b", 0.6),
    Plane("antiphase", "alpha", "f_e", 0.55),
    Plane("published", "omega", "f_e", None, 3),
    Plane("antiphase", "omega", "alpha", None, 3),
]


class Crossing(NamedTuple):
    """Where a curve meets a row."""

    kind: Event
    motion: np.ndarray
    x: float


def crossings(curves, value) -> list[Crossing]:
    return [Crossing(curve.kind, y[:3], y[3]) for curve in curves for y in curve.crossings([value])[1]]


class Passed(NamedTuple):
    """Places along a branch, in order: axis values (k,), motions (k, n), multipliers (k, m), which crossings lie there,
    and whether the place is one between crossings at which everything is decided, (k,)."""

    x: np.ndarray
    motions: np.ndarray
    multipliers: np.ndarray
    crossed: list[list[int]]
    decided: np.ndarray


def along_branches(plane, value, row, met):
    """Every branch of a row: its own points, the grid values and the crossings."""
    model, shown = plane.at(value), [0, *plane.balance.fundamental]
    problem = plane.balance.problem(model, plane.sweep, *plane.span, plane.omega)
    for curve in row.curves:
        values = np.unique(np.concatenate([row.grid, [one.x for one in met], curve.points[:, -1]]))
        columns, motions, *_ = curve_crossings(problem, curve, values, Continuation())
        x = values[columns]
        found = multipliers(model, plane.sweep, x, motions, omega=plane.omega)
        crossed = [
            [i for i, one in enumerate(met) if one.x == at and np.max(np.abs(one.motion - motion[shown])) < SAME]
            for at, motion in zip(x, motions, strict=True)
        ]
        near = np.min(np.abs(np.abs(found) - 1.0), axis=1) <= TOLERANCE
        yield Passed(x, motions, found, crossed, ~near & ~np.array([bool(here) for here in crossed]))


def check_neighbours(passed: Passed, met: list[Crossing], case) -> int:
    """Any two neighbouring places of a branch differ as the curves between them say; how many pairs there are."""
    outside = np.sum(np.abs(passed.multipliers) > 1.0, axis=1)
    minus, plus = (np.prod(passed.multipliers - at, axis=1).real < 0.0 for at in (-1.0, 1.0))
    # Two at a time: pairs, and what is beyond -1 or +1 less one if that is an odd number.
    twos = (outside - minus - plus) // 2
    places = np.flatnonzero(passed.decided)
    for i, j in zip(places, places[1:], strict=False):
        kinds = Counter(met[crossing].kind for k in range(i, j) for crossing in passed.crossed[k])
        doublings, tori = kinds[Event.PERIOD_DOUBLING], kinds[Event.NEIMARK_SACKER]
        singles, change = doublings + (plus[i] != plus[j]), abs(twos[i] - twos[j])
        at = (*case, passed.x[i], passed.x[j], passed.motions[i], kinds)
        assert (minus[i] != minus[j]) == (doublings % 2 == 1), at
        assert change <= tori + singles, at
        assert singles or (change - tori) % 2 == 0, at
    return places.size - 1


def check_cells(passed: Passed, row, case) -> int:
    """The row's own cells are what their multipliers say; how many of them a branch passes."""
    cells = 0
    for column in np.flatnonzero(np.isin(row.grid, passed.x)):
        for place in np.flatnonzero(passed.x == row.grid[column]):
            gaps = np.max(np.abs(row.motions[column] - passed.motions[place]), axis=1)
            nearest = np.nanargmin(gaps)
            assert gaps[nearest] < SAME, (*case, passed.x[place])
            (expected,) = classify(passed.multipliers[[place]], row.stable[column, [nearest]])
            kind = row.instability[column, nearest]
            assert kind == expected or Instability.UNDECIDED in (kind, expected), (*case, passed.x[place])
            cells += 1
    return cells


def check_row(plane: Plane, curves, value, row) -> tuple[int, int]:
    """A row against the curves of its plane: crossings, and cells."""
    met, case, cells, pairs = crossings(curves, value), (plane, value), 0, 0
    seen = Counter()
    for passed in along_branches(plane, value, row, met):
        pairs += check_neighbours(passed, met, case)
        cells += check_cells(passed, row, case)
        seen.update(i for here in passed.crossed for i in here)
    # Every crossing lies on one branch, and the row has located it by itself.
    assert seen == Counter(range(len(met))), (*case, [one for i, one in enumerate(met) if seen[i] != 1])
    located, shown = row_events(row.curves, value, BIFURCATIONS), [0, *plane.balance.fundamental]
    for one in met:
        gaps = [np.max(np.abs(y[shown] - one.motion)) for kind, y in located if kind == one.kind and len(y)]
        assert np.sum(np.array(gaps) < SAME) == 1, (*case, one)
    assert len(located) == len(met), case
    assert pairs >= cells
    return len(met), cells


@pytest.mark.costly
@pytest.mark.parametrize(("plane",), slow_but([(plane,) for plane in ORDINARY], [(plane,) for plane in PLANES]))
def test_rows_are_what_curves_say(plane):
    low, high = RANGES[plane.parameter]
    values = np.random.default_rng(3).uniform(low, high, 3)
    curves, totals = plane.curves(), np.zeros(2, dtype=int)
    for value in [0.4, *values] if plane.parameter == "f_e" else values:
        totals += check_row(plane, curves, value, plane.row(value, 150))
    met, cells = totals
    assert cells > 400 and (met > 1 or plane.omega or plane.gear == "consistent")
