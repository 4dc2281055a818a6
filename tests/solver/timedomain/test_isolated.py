"""Branches that a row lacks, found from attractors: against rows that have them, shooting and integration."""

import numpy as np
import pytest

from solver import ContactSystem, Event, Galerkin, LiftedSeeds, LinearSeeds, solve, sweep_row
from solver.rows.phases import shifted
from solver.stability import Instability, assess
from solver.timedomain import AttractorKind, find_attractors, isolated_branches, orbit_state, shoot
from tests.cases.kahraman_singh import SPUR
from tests.conftest import published

#: Between two springs four times as stiff as its own, off the middle.
HELD = ContactSystem([[1.0]], [[0.07]], [[0.3]], [1.0], [4.0], 1.0, 1.0, load=[[0.55], [0.17]])


def folds(curve):
    return np.sort(curve.points[curve.event == Event.FOLD, -1])


def coarse(system, order, low, high, seeds=None):
    seeds = LiftedSeeds(5) if seeds is None else seeds
    return sweep_row(system, "omega", np.linspace(low, high, 12), balance=Galerkin(order), seeds=seeds)


@pytest.mark.parametrize("seeds", [LinearSeeds(), LiftedSeeds(5)])
def test_an_isola_that_a_coarse_row_misses_is_that_of_a_fine_one(seeds):
    fine = sweep_row(HELD, "omega", np.linspace(0.5, 1.4, 12), balance=Galerkin(5), seeds=LiftedSeeds(40))
    (expected,) = [curve for curve in fine.curves if curve.closed]
    row = coarse(HELD, 5, 0.5, 1.4, seeds)
    assert not any(curve.closed for curve in row.curves)
    values = np.linspace(0.5, 1.4, 10)
    found = isolated_branches(row, values)
    (isola,) = [branch for branch in found.branches if branch.period == 1]
    assert isola.isolated and not isola.joined
    np.testing.assert_allclose(folds(isola.curve), folds(expected), rtol=0, atol=1e-9)
    assert found.attractors.kind[isola.cell, isola.slot] == AttractorKind.PERIOD_1
    # Nothing is left over for the row that has it.
    assert not [b for b in isolated_branches(fine, values, attractors=found.attractors).branches if b.period == 1]


def test_motions_of_two_periods_that_leave_the_row_at_period_doublings():
    row = coarse(HELD, 5, 0.5, 1.4)
    (branch,) = [b for b in isolated_branches(row, np.linspace(1.15, 1.25, 3)).branches if b.period == 2]
    assert branch.joined and not branch.isolated
    doublings = np.concatenate([c.points[c.event == Event.PERIOD_DOUBLING, -1] for c in row.curves])
    # It is followed to the last step before its subharmonics vanish: they fall like the square root of the distance.
    np.testing.assert_allclose(np.sort(branch.curve.points[[0, -1], -1]), np.sort(doublings), rtol=0, atol=0.03)


def test_motions_of_four_periods_leave_those_of_two():
    system = ContactSystem(
        [[1.0]], [[0.1]], [[0.0]], [1.0], [1.0], 1.0, 1.0, [1.0], ((0.1, 0.0),), [[0.18]], [[0.0], [0.2]]
    )
    row = coarse(system, 9, 1.2, 2.4)
    found = isolated_branches(row, np.linspace(1.4, 1.8, 5)).branches
    (twice,) = [b for b in found if b.period == 2 and np.any(b.curve.event == Event.PERIOD_DOUBLING)]
    (four,) = [b for b in found if b.period == 4]
    assert four.joined
    doublings = twice.curve.points[twice.curve.event == Event.PERIOD_DOUBLING, -1]
    np.testing.assert_allclose(np.sort(four.curve.points[[0, -1], -1]), np.sort(doublings), rtol=0, atol=0.01)


def test_two_periods_of_the_spur_pair():
    """docs/physics.md, section 9: at 1.8 half order 0.18730, order one 0.02828, lambda 0.90521 to 1.28247."""
    row = coarse(SPUR, 9, 1.2, 2.2)
    (branch,) = isolated_branches(row, [1.8]).branches
    assert branch.period == 2 and branch.isolated
    distance = np.abs(branch.curve.points[:, -1] - 1.8)
    motions = [branch.curve.points[i, :-1] for i in np.argsort(distance)[:8]]
    solutions = np.array([solve(SPUR, motion, 1.8, balance=branch.balance).motion for motion in motions])
    kinds = assess(SPUR, "omega", np.full(8, 1.8), solutions, balance=branch.balance).kind
    motion, *others = solutions[kinds == Instability.NONE]
    assert all(min(np.max(np.abs(shifted(o, k, 2) - motion)) for k in (0, 1)) < 1e-9 for o in others)
    assert np.hypot(*motion[1:3]) == pytest.approx(0.18730, abs=1e-5)
    assert np.hypot(*motion[3:5]) == pytest.approx(0.02828, abs=1e-5)
    low, high = branch.balance.extremes(motion)
    np.testing.assert_allclose((low, high), (0.90521, 1.28247), rtol=0, atol=2e-5)
    # Both ends of it, by another method.
    points, ends = branch.curve.points[branch.curve.stable == 1], folds(branch.curve)
    for fold in ends:
        *motion, omega = points[np.argmin(np.abs(np.abs(points[:, -1] - fold) - 0.01))]
        orbit = shoot(SPUR, omega, orbit_state(SPUR, omega, motion, 2), 2, order=2)
        assert orbit.minimal_period == 2 and 0.5 < orbit.largest_multiplier < 1.0
        np.testing.assert_allclose(
            np.abs(orbit.harmonics[1:]), np.hypot(motion[1:5:2], motion[2:5:2]), rtol=0, atol=1e-5
        )
    kinds = find_attractors(SPUR, "omega", [1.9, 2.05]).kind
    assert [AttractorKind.PERIOD_2 in kind for kind in kinds] == [True, False]


def test_a_bevel_pair_over_another_axis():
    """Beside the 1T of the map, at (Omega, f_e) = (0.7367924528, 0.4661016949), docs/physics.md, section 9."""
    row = sweep_row(
        published(), "f_e", np.linspace(0.4, 0.5, 6), omega=0.7367924528, balance=Galerkin(5), seeds=LiftedSeeds(6)
    )
    found = isolated_branches(row, [0.4661016949], omega=0.7367924528)
    (branch,) = [b for b in found.branches if b.period == 2]
    extremes = branch.balance.extremes(branch.curve.points[:, :-1])
    there = np.argmin(np.hypot(extremes[0] + 0.4646, extremes[1] - 2.9243))
    np.testing.assert_allclose((extremes[0][there], extremes[1][there]), (-0.4646, 2.9243), rtol=0, atol=0.05)
    assert branch.curve.points[there, -1] == pytest.approx(0.4661, abs=0.01)


def test_what_the_order_cannot_represent_is_said():
    """A stop this stiff asks for more harmonics than one."""
    stiff = ContactSystem([[1.0]], [[0.05]], [[0.2]], [1.0], [40.0], 0.5, 0.5, load=[[0.12], [0.3]])
    found = isolated_branches(coarse(stiff, 1, 0.5, 2.5), np.linspace(0.5, 2.5, 8))
    assert any("no solution of order 1" in note for note in found.notes)
