"""The recurrence against the equations of motion themselves, and its two widths against each other."""

import numpy as np
import pytest
from numpy.polynomial import polynomial

from solver.flow.deviations import BLOCKS, carry_deviations, new_block_series
from solver.flow.switched_system import SWITCHED_SYSTEM, SwitchedSystem, loaded_system
from solver.flow.taylor import MOTION_ORDER, column_at, column_sizes, motion_series, new_series, reach
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.contact_system import gear_system
from tests.conftest import antiphase

_F, _I = types.float64, types.int64


@kernel(_F(SWITCHED_SYSTEM, _I, _F, ARRAY, MATRIX, ARRAY))
def advanced(system, zone, time, state, y, end):
    """Series, and state at the end, of a step; its length."""
    series = new_series(system.vectors.shape[1])
    motion_series(system, zone, time, state, series)
    size, last, previous = column_sizes(state, series)
    step = reach(1e-13 * size, last, previous, MOTION_ORDER)
    column_at(series, step, end)
    y[:, :] = series.y
    return step


@kernel(types.boolean(SWITCHED_SYSTEM, _I, _F, _F, BLOCKS))
def carried(system, zone, begin, end, states):
    """Deviations carried from one time to another."""
    series = new_block_series(system.vectors.shape[1], 4 * states.shape[0])
    return carry_deviations(system, zone, begin, end, np.empty(0), states, series)


@pytest.fixture(scope="module")
def pair():
    model = antiphase(alpha_harmonics=[[0.1, 0.7]], f_e_harmonics=[[0.05, 0.2]], kappa=[0.4, 0.6])
    return gear_system(model)


@pytest.mark.parametrize("zone", [-1, 0, 1])
def test_a_motion_obeys_the_equations(pair, zone):
    """M y'' + C y' + K y + [h + h_v s] (lambda - offset) = load, at times within the step."""
    omega, begin, n = 0.83, 1.7, pair.degrees
    state, y, end = np.random.default_rng(zone + 5).normal(size=2 * n), np.empty((MOTION_ORDER + 1, n)), np.empty(2 * n)
    step = advanced(loaded_system(pair, omega), zone, begin, state, y, end)
    assert 0.1 < step < 10.0
    offset = zone * pair.front_gap
    for time in np.linspace(0.0, step, 5):
        u, v, a = (polynomial.polyval(time, polynomial.polyder(y, m)) for m in range(3))
        s = sum(
            size * np.cos(l * omega * (begin + time) + p) for l, (size, p) in enumerate(pair.stiffness_harmonics, 1)
        )
        loads = pair.load_harmonics(omega, len(pair.inertial_load) - 1)
        load = sum(np.real(f * np.exp(1j * l * omega * (begin + time))) for l, f in enumerate(loads))
        contact = (pair.force + pair.varying_force * s) * (pair.contact @ u - offset) * abs(zone)
        residual = pair.mass @ a + pair.damping @ v + pair.stiffness @ u + contact - load
        np.testing.assert_allclose(residual, 0.0, atol=1e-9)
    np.testing.assert_allclose(end, [*u, *v], rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("zone", [-1, 0, 1])
def test_deviations_in_blocks_are_motions_without_load(pair, zone):
    loaded, begin, n = loaded_system(pair, 0.83), 1.7, pair.degrees
    # No load and no gaps: the motion obeys the equation of its deviations.
    free = SwitchedSystem(loaded.numbers * [1, 0, 0, 1, 1, 1, 1, 1], *loaded[1:4], np.zeros((2, n)))
    states = np.random.default_rng(zone + 5).normal(size=(2, 2 * n, 4))
    end = np.empty(2 * n)
    for block, column in np.ndindex(2, 4):
        step = advanced(free, zone, begin, states[block, :, column].copy(), np.empty((MOTION_ORDER + 1, n)), end)
        ends = states.copy()
        assert carried(loaded, zone, begin, begin + step, ends)
        np.testing.assert_allclose(ends[block, :, column], end, rtol=1e-10, atol=1e-11)
