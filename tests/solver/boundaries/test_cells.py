"""Cells of rows against the bifurcation curves of their plane: two neighbours on a branch differ where a curve passes.

Curves are traced from the events of a few rows. The rows that are looked at are others: their cells are classified by
multipliers, motion by motion, and know nothing of curves.
"""

from typing import NamedTuple

import numpy as np
import pytest

from solver import Continuation, Model, sweep_row
from solver.boundaries import BIFURCATIONS, boundary_curves, row_events
from solver.continuation.on_curve import curve_crossings
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.galerkin import Galerkin
from solver.rows.seeds import LiftedSeeds
from solver.stability import Instability, motion_multipliers
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
#: What curves separate from the rest. A pair that has left the circle may meet on the real axis beyond +1 and come back
#: by folds, which belong to det J: cells with a multiplier there, or beyond such places, are compared with nothing.
CRITICAL, BEYOND_ONE = (Instability.PERIOD_DOUBLING, Instability.NEIMARK_SACKER), "beyond +1"


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


def _beyond_one(plane, value, x, motion) -> bool:
    model, omega = plane.at(value), plane.omega or x
    if plane.sweep != "omega":
        model = model.replace(**{plane.sweep: float(x)})
    multipliers = motion_multipliers(model, omega, motion)
    return bool(np.any((multipliers.imag == 0.0) & (multipliers.real > 1.0)))


def along_branches(plane, value, row, crossed):
    """For every branch of a row what it passes, in order: kinds of its cells, and None where a curve crosses it.

    Between its cells also BEYOND_ONE, where that holds at a point of the branch. `crossed` (c, 4) are lambda_m,
    lambda_c, lambda_s and the axis value of the crossings.
    """
    shown = [0, *plane.balance.fundamental]
    problem = plane.balance.problem(plane.at(value), plane.sweep, *plane.span, plane.omega)
    for curve in row.curves:
        values = np.unique(np.concatenate([row.grid, crossed[:, -1], curve.points[:, -1]]))
        columns, motions, *_ = curve_crossings(problem, curve, values, Continuation())
        passed = []
        for x, motion in zip(values[columns], motions, strict=True):
            here = crossed[crossed[:, -1] == x, :-1]
            passed += [None] * int(np.sum(np.max(np.abs(here - motion[shown]), axis=1) < 1e-6))
            if x not in row.grid:
                passed += [BEYOND_ONE] * _beyond_one(plane, value, x, motion)
            for column in np.flatnonzero(row.grid == x):
                gaps = np.max(np.abs(row.motions[column] - motion), axis=1)
                assert np.nanmin(gaps) < 1e-6
                kind = Instability(row.instability[column, np.nanargmin(gaps)])
                passed.append(kind if kind in CRITICAL or not _beyond_one(plane, value, x, motion) else BEYOND_ONE)
        yield passed


def check(plane: Plane, values, columns: int) -> tuple[int, int]:
    """Crossings, and pairs of neighbouring cells, that were looked at."""
    curves, met, cells = plane.curves(), 0, 0
    for value in values:
        row, found = plane.row(value, columns), 0
        crossed = np.concatenate([np.empty((0, 5)), *(curve.crossings([value])[1] for curve in curves)])[:, :4]
        for passed in along_branches(plane, value, row, crossed):
            found += passed.count(None)
            known = [i for i, kind in enumerate(passed) if kind not in (None, Instability.UNDECIDED)]
            for i, j in zip(known, known[1:], strict=False):
                if BEYOND_ONE in (passed[i], passed[j]):
                    continue
                critical, crossings = [passed[k] in CRITICAL for k in (i, j)], passed[i:j].count(None)
                assert crossings or critical[0] == critical[1], (plane, value, passed, i)
                # Of two that are critical one may lead on into the other kind.
                assert crossings != 1 or any(critical), (plane, value, passed, i)
                cells += 1
        assert found == len(crossed), (plane, value, found, crossed)
        met += found
    return met, cells


@pytest.mark.costly
@pytest.mark.parametrize(("plane",), slow_but([(plane,) for plane in ORDINARY], [(plane,) for plane in PLANES]))
def test_cells_are_what_curves_say(plane):
    low, high = RANGES[plane.parameter]
    values = np.random.default_rng(3).uniform(low, high, 3)
    met, cells = check(plane, [0.4, *values] if plane.parameter == "f_e" else values, 150)
    assert cells > 400 and (met > 1 or plane.omega or plane.gear == "consistent")
