"""Rows, boundaries and regions of systems that are no gear pair, against published figures and against each other."""

import numpy as np
import pytest

from solver import ContactSystem, Galerkin, LiftedSeeds, Proof, enumerate_row, sweep_row
from solver.boundaries import boundary_curves, row_events
from solver.contact.impact import domain_label
from solver.contact.quantities import Slot
from solver.regions.regions import regions
from tests.cases.curves import folds
from tests.cases.kahraman_singh import SPUR
from tests.cases.stop import STOP
from tests.cases.two_stops import TWO_STOPS

SOFT_STOP = ContactSystem([[1.0]], [[0.1]], [[1.0]], [1.0], [10.0], 1.0, load=[[0.1], [0.1]])
#: Pinion and wheel on supports, and their relative rotation; a damper in one support alone, so that no modes are real.
ROTOR = ContactSystem(
    np.diag([1.0, 2.0, 0.5]),
    np.array([[0.08, 0.0, 0.01], [0.0, 0.002, -0.01], [0.01, -0.01, 0.02]]),
    np.diag([1.5, 0.8, 0.0]),
    [1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    1.0,
    1.0,
    [1.0, -1.0, 1.0],
    ((0.2, 0.3),),
    [[0.0, 0.0, 0.2], [0.0, 0.0, 0.05]],
    [[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]],
)


@pytest.mark.parametrize(
    ("system", "low", "high"), [(STOP, 0.9, 1.5), (TWO_STOPS, 0.5, 1.0), (SPUR, 0.3, 2.0), (ROTOR, 0.3, 2.5)]
)
def test_rows_are_proven(system, low, high):
    row = sweep_row(system, "omega", np.linspace(low, high, 120))
    assert not row.notes and np.all(row.certified == 1) and not np.any(row.open)
    assert len(folds(*row.curves)) >= 2
    proven = enumerate_row(system, "omega", row.grid)
    np.testing.assert_array_equal(row.n_solutions, proven.n_solutions)
    np.testing.assert_allclose(row.motions, proven.motions, rtol=0, atol=1e-9)


def test_orders_above_one_leave_the_first_where_springs_hold_a_varying_contact():
    """Nothing is proven there: branches start from single harmonics and from the linear system."""
    held = ContactSystem([[1.0]], [[0.05]], [[0.3]], [1.0], [1.0], 0.5, 0.5, [1.0], ((0.2, 0.0),), load=[[0.2], [0.3]])
    row = sweep_row(held, "omega", np.linspace(0.6, 1.6, 30), balance=Galerkin(5), seeds=LiftedSeeds(30))
    assert np.all(row.n_solutions >= 1) and not np.any(row.open)


def _events(system, axis, values, grid):
    return [
        event for p in values for event in row_events(sweep_row(system.at(axis, p), "omega", grid).curves, float(p))
    ]


@pytest.mark.costly
@pytest.mark.parametrize(
    ("system", "axis", "x_range", "p_range"),
    [
        (SPUR, "mean_load", (0.4, 1.4), (0.4, 2.0)),
        (
            ContactSystem([[1.0]], [[0.1]], [[1.0]], [1.0], [10.0], 1.0, load=[[0.1], [0.1]]),
            "excitation",
            (0.7, 1.6),
            (0.4, 2.0),
        ),
        (TWO_STOPS, "damping", (0.5, 1.0), (0.5, 2.0)),
        (ROTOR, "gap", (0.5, 1.5), (0.1, 1.0)),
    ],
)
def test_regions_have_the_labels_of_rows(system, axis, x_range, p_range):
    grid = np.linspace(*x_range, 60)
    starts = _events(system, axis, np.linspace(*p_range, 9), grid)
    curves = boundary_curves(system, "omega", axis, x_range, p_range, starts)
    found = regions(system, "omega", axis, x_range, p_range, curves)
    assert sum(found.shares.values()) == pytest.approx(1.0) and len(found.labels) > 1
    rng = np.random.default_rng(2)
    for p in rng.uniform(*p_range, 6):
        (slab,) = (part for part in found.slabs if part.slab.low <= p <= part.slab.high)
        row = sweep_row(system.at(axis, p), "omega", grid)
        seen = [domain_label(int(code)) for code in row.domain]
        ordered = [label for label, before in zip(seen, [None, *seen], strict=False) if label != before]
        # A grid may miss what is narrower than its steps, and sees nothing else.
        labels = iter(slab.labels)
        assert all(label in labels for label in ordered)


@pytest.mark.parametrize(
    "axis", ["gap", "gap_scale", "alpha", "alpha_phase", "mean_load", "excitation", "contact_damping"]
)
def test_rows_over_other_axes_pass_the_solutions_of_single_systems(axis):
    grid = np.linspace(0.1, 0.9, 9)
    row = sweep_row(SPUR, axis, grid, omega=0.8)
    assert np.all(row.certified == 1)
    for i, value in enumerate(grid.tolist()):
        single = enumerate_row(SPUR.at(axis, value), "omega", [0.8])
        assert single.proof[0] == Proof.PROVEN and single.n_solutions[0] == row.n_solutions[i]
        count = single.n_solutions[0]
        np.testing.assert_allclose(row.motions[i, :count], single.motions[0, :count], rtol=0, atol=1e-9)


def test_unequal_gaps_shift_a_free_contact():
    """Nothing but the contact knows where lambda is: gaps 1.4 and 0.6 are gaps 1, seen from 0.4 further."""
    shifted = ContactSystem(
        SPUR.mass,
        SPUR.damping,
        SPUR.stiffness,
        [1.0],
        [1.0],
        1.4,
        0.6,
        [1.0],
        SPUR.stiffness_harmonics,
        SPUR.load,
        SPUR.inertial_load,
    )
    grid = np.linspace(0.5, 1.2, 40)
    mine, theirs = sweep_row(shifted, "omega", grid), sweep_row(SPUR, "omega", grid)
    np.testing.assert_allclose(mine.mean, theirs.mean + 0.4, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(mine.impact, theirs.impact)
    np.testing.assert_array_equal(mine.instability, theirs.instability)


@pytest.mark.parametrize(("system", "omega", "share"), [(SPUR, 0.7, 1.0), (STOP, 1.1, 0.0)])
def test_quantities_are_those_of_sampled_motions(system, omega, share):
    row = sweep_row(system, "omega", [omega, 1.001 * omega])
    angle = 2.0 * np.pi * (np.arange(200_000) + 0.5) / 200_000
    variation = sum(a * np.cos(l * angle + p) for l, (a, p) in enumerate(system.stiffness_harmonics, start=1))
    for motion, found in zip(row.motions[0], row.quantities[0], strict=True):
        if np.isnan(motion[0]):
            continue
        place = motion[0] + motion[1] * np.cos(angle) + motion[2] * np.sin(angle)
        force = system.contact_force(place)
        assert found[Slot.LOWEST] == pytest.approx(place.min(), abs=1e-8)
        assert found[Slot.RMS] == pytest.approx(np.std(place), abs=1e-8)
        assert found[Slot.CONTACT_LOSS] == pytest.approx(np.mean(force == 0.0), abs=2e-5)
        meets = np.flatnonzero((force != 0.0) & (np.roll(force, 1) == 0.0))
        speed = np.abs(np.gradient(place, angle) * omega)
        expected = np.max(speed[meets], initial=0.0)
        assert found[Slot.IMPACT_VELOCITY] == pytest.approx(expected, abs=1e-4)
        if share:
            # The mean load 0.1 is the static force.
            assert found[Slot.DYNAMIC_FACTOR] == pytest.approx(
                np.max((1.0 + share * variation) * force) / 0.1, rel=1e-6
            )
        else:
            assert np.isnan(found[Slot.DYNAMIC_FACTOR])
        assert np.isnan(found[Slot.SUPPORT_FORCE])


@pytest.mark.costly
def test_many_degrees_of_freedom_damped_in_no_proportion():
    rng, n = np.random.default_rng(0), 10
    root, contact = rng.normal(size=(n, n)), rng.normal(size=n)
    stiffness = root @ root.T + np.eye(n)
    damping = 0.01 * stiffness + np.diag(0.01 * rng.random(n))
    load = [rng.normal(size=n), rng.normal(size=n)]
    system = ContactSystem(np.eye(n), damping, stiffness, contact, 5.0 * contact, 0.5, 0.5, load=load)
    row = sweep_row(system, "omega", np.linspace(0.5, 5.0, 80))
    assert not row.notes and np.all(row.certified == 1)
    # Order 1 of the other balance is the same where the stiffness does not vary.
    other = sweep_row(system, "omega", np.linspace(0.5, 5.0, 80), balance=Galerkin(1), seeds=LiftedSeeds(30))
    np.testing.assert_array_equal(row.n_solutions, other.n_solutions)
    np.testing.assert_allclose(row.motions, other.motions, rtol=0, atol=1e-7)
