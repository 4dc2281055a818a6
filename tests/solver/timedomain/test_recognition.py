"""What is known of an attractor, and whether motions that are recognised do end on it."""

import numpy as np
import pytest

from solver import gear_system
from solver.model.contact_system import reduced
from solver.timedomain import AttractorKind, AttractorSearch, advance, monodromy, settle, shoot
from solver.timedomain.row_search import RowSearch
from solver.timedomain.row_systems import random_states, row_systems
from tests.conftest import MODELS, published


def _searched(model, omega, search):
    """The search of one cell after its random starts, with what is known of it."""
    systems = row_systems(model, "omega", np.array([omega]), None)
    row = RowSearch(systems, search, 0)
    row.start(np.empty((1, 0, systems.size)), random_states(systems, np.zeros(1, np.uint64), search.starts), 1)
    return row, row.known[0]


@pytest.mark.parametrize(
    "changes, omega, period",
    [({}, 1.0, 1), (dict(f_e=0.4661016949), 0.7367924528, 2), (dict(f_e=0.1949152542), 1.3622641509, 4)],
)
def test_norms_solve_the_periodic_lyapunov_equation(changes, omega, period):
    model = published(**changes)
    row, known = _searched(model, omega, AttractorSearch(starts=30))
    (slots,) = np.nonzero(row.kind[0] == period)
    assert slots.size
    weights = np.diag(np.repeat([1.0, omega**-2], row.size(0) // 2))
    for slot in slots:
        for j in range(period):
            matrix, after = known.matrices[slot, j], known.norms[slot, (j + 1) % period]
            np.testing.assert_allclose(known.norms[slot, j] - matrix.T @ after @ matrix, weights, rtol=0, atol=1e-8)
            end, derivative, _ = monodromy(gear_system(model), omega, known.points[slot, j])
            np.testing.assert_allclose(derivative, matrix, rtol=0, atol=1e-7)
            np.testing.assert_allclose(end, known.points[slot, (j + 1) % period], rtol=0, atol=1e-8)
        orbit = shoot(gear_system(model), omega, known.points[slot, 0], period)
        assert orbit.minimal_period == period
        assert known.rates[slot, 0] == pytest.approx(np.log(orbit.largest_multiplier) / period, abs=1e-7)


@pytest.mark.parametrize("seed", range(6))
def test_recognised_motions_end_where_they_were_said_to(seed):
    """Each of them is followed on, ten times as long and longer, by the map alone."""
    rng, judged = np.random.default_rng(seed), 0
    for trial in range(6):
        changes = dict(f_e=rng.uniform(0.02, 0.5), b=rng.uniform(0.2, 1.5), alpha=rng.uniform(0.0, 0.5))
        model = MODELS[list(MODELS)[trial % 3]](**{name: float(value) for name, value in changes.items()})
        omega = float(rng.uniform(0.3, 2.2))
        systems = row_systems(model, "omega", np.array([omega]), None)
        states = random_states(systems, np.array([1000 * seed + trial], np.uint64), 12)[0]
        found, slots = settle(model, omega, states)
        system = reduced(gear_system(model))
        ends = advance(system, omega, states, 4000).states
        for slot, sections in zip(slots.tolist(), ends, strict=True):
            kind = AttractorKind(int(found.kind[0, slot])) if slot >= 0 else AttractorKind.NONE
            # Slower than this there is nothing to see after 4000 periods.
            fast = found.lyapunov[0, slot] * 2.0 * np.pi / omega < -5e-3
            if not kind.periodic or not fast:
                continue
            judged += 1
            orbit = advance(system, omega, found.state[0, slot], 8).states[0]
            assert np.min(np.max(np.abs(orbit - sections[-1]), axis=1)) < 1e-6, (model, omega)
    assert judged > 30
