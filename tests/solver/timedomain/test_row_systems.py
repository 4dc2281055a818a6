"""States to start from: at rest, on motions of a map, at random."""

import numpy as np
import pytest

from solver import gear_system, sweep_row
from solver.timedomain import advance, orbit_state
from solver.timedomain.row_systems import motion_states, random_states, row_systems
from tests.conftest import MODELS, consistent, published
from tests.solver.flow.test_loads import TWO

COLUMNS = np.linspace(0.5, 1.5, 9)


@pytest.mark.parametrize("model", [published(f_e=0.0, alpha=0.0), consistent(f_e=0.0, alpha=0.0)])
def test_without_excitation_a_pair_stays_at_rest(model):
    row = row_systems(model, "omega", COLUMNS, None)
    for state, omega in zip(row.rest, COLUMNS, strict=True):
        np.testing.assert_allclose(advance(gear_system(model), omega, state, 3).states[0, -1], state, atol=1e-9)


@pytest.mark.parametrize("name", MODELS)
def test_states_of_motions_are_those_of_the_sampled_force(name):
    """`orbit_state` samples the force 4096 times and solves in another order."""
    model = MODELS[name]()
    found = sweep_row(model, "omega", COLUMNS)
    cosine, sine = found.amplitude * np.cos(found.phase), found.amplitude * np.sin(found.phase)
    motions = np.stack([found.mean, cosine, sine], axis=-1)
    states = motion_states(row_systems(model, "omega", COLUMNS, None), motions, 1)
    assert np.array_equal(np.isnan(states[:, :, 0]), np.isnan(found.mean))
    for i, s in np.argwhere(np.isfinite(found.mean)):
        wanted = orbit_state(gear_system(model), COLUMNS[i], motions[i, s])
        # Sixty-four samples leave harmonics of the kink in the force.
        np.testing.assert_allclose(states[i, s], wanted, rtol=5e-3, atol=5e-3)


def test_states_of_subharmonic_motions_of_a_contact_system():
    motion = [0.9, 0.3, -0.2, 0.1, 0.05, 0.02, -0.01]
    states = motion_states(row_systems(TWO, "omega", np.array([0.7, 0.9]), None), np.tile(motion, (2, 1, 1)), 2)
    for state, omega in zip(states[:, 0], (0.7, 0.9), strict=True):
        np.testing.assert_allclose(state, orbit_state(TWO, omega, motion, 2), rtol=5e-3, atol=5e-3)


def test_random_states_fill_the_box_and_belong_to_the_cell():
    row = row_systems(published(), "omega", COLUMNS, None)
    keys = np.arange(100, 100 + COLUMNS.size, dtype=np.uint64)
    states = random_states(row, keys, 4000)
    widths = np.repeat(row.box, 2, axis=1)
    assert np.all(np.abs(states) <= widths[:, None])
    unit = states / widths[:, None]
    # Mean and spread of uniform numbers, within five standard errors.
    assert np.max(np.abs(unit.mean(axis=1))) < 5.0 / np.sqrt(3.0 * 4000)
    np.testing.assert_allclose(unit.std(axis=1), 1.0 / np.sqrt(3.0), atol=0.02)
    correlation = np.corrcoef(unit.reshape(-1, 4).T) - np.eye(4)
    assert np.max(np.abs(correlation)) < 5.0 / np.sqrt(unit.shape[0] * 4000)
    alone = random_states(row_systems(published(), "omega", COLUMNS[3:4], None), keys[3:4], 10)
    assert np.array_equal(alone[0], states[3, :10])
    assert not np.array_equal(states[3] / widths[3], states[4] / widths[4])


def test_the_box_is_what_is_written_down():
    model = published()
    row = row_systems(model, "omega", np.array([0.8]), None)
    system = gear_system(model)
    closed = system.stiffness + np.outer(system.force, system.contact)
    loads = np.abs(system.load_harmonics(0.8, 1)).sum(axis=0)
    reach = 3.0 * model.b + max(model.b, np.max(np.abs(np.linalg.solve(closed, loads))))
    slowest = np.sqrt(np.min(np.abs(np.linalg.eigvals(np.linalg.inv(system.mass) @ closed))))
    np.testing.assert_allclose(row.box[0], [reach, reach * min(0.8, slowest)], rtol=1e-12)
