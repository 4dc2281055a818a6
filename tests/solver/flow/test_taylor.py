"""The recurrence of blocks against the integrator's series of one motion, for all zones."""

import numpy as np
import pytest

from solver.flow.switched_system import SWITCHED_SYSTEM, SwitchedSystem
from solver.flow.taylor import BLOCKS, new_series, series_at, state_at, step_length
from solver.kernels import types
from solver.kernels.compile import ARRAY, kernel
from solver.model.contact_system import gear_system
from solver.timedomain import taylor
from tests.conftest import antiphase


@kernel(types.float64(SWITCHED_SYSTEM, types.int64, types.float64, types.boolean, BLOCKS, ARRAY, BLOCKS))
def advanced(system, zone, time, forced, states, motion, ends):
    """Series and states at the end of half the step that may be taken; the step."""
    series = new_series(system.vectors.shape[1], 4 * states.shape[0])
    series_at(system, zone, time, forced, states, series)
    step = 0.5 * step_length(system, forced, 1e-12, states, series)
    state_at(series, step, ends)
    for j in range(motion.shape[0]):
        motion[j] = series.contact[0, j, 0]
    return step


@kernel(types.void(taylor.PACKED, types.int64, types.float64, ARRAY, ARRAY, types.float64, ARRAY))
def plain(packed, zone, time, state, motion, step, end):
    """The integrator's own series of one motion."""
    work = taylor.new_work(packed.vectors.shape[1])
    taylor.series(packed, zone, time, state, work)
    taylor.land(work, step, end)
    for j in range(motion.shape[0]):
        motion[j] = work.contact[j]


@pytest.mark.parametrize("zone", [-1, 0, 1])
def test_a_motion_and_its_deviations(zone):
    model = antiphase(alpha_harmonics=[[0.1, 0.7]], f_e_harmonics=[[0.05, 0.2]], kappa=[0.4, 0.6])
    omega, time = 0.83, 1.7
    packed = taylor.pack(gear_system(model), omega)
    numbers = np.array([*packed.numbers[:5]])
    vectors = packed.vectors.copy()
    system = SwitchedSystem(numbers, packed.matrices, vectors, packed.variation, packed.load)
    random = np.random.default_rng(zone + 5)
    states = random.normal(size=(2, 4, 4))
    motion, ends = np.empty(20), np.empty_like(states)
    step = advanced(system, zone, time, True, states, motion, ends)
    assert 0.1 < step < 10.0
    expected, end = np.empty(20), np.empty(4)
    plain(packed, zone, time, states[0, :, 0].copy(), expected, 0.2, end)
    np.testing.assert_allclose(motion, expected, rtol=1e-11, atol=1e-14)
