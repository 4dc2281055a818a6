"""Poincare map, monodromy matrix and what is measured over a window."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import mathieu_a, mathieu_b

from solver import ParameterError
from solver.model.contact_system import gear_system
from solver.timedomain import Status, advance, growth, integrate, measure, monodromy
from tests.conftest import antiphase, published
from tests.solver.timedomain.systems import mathieu, oscillator

OMEGA, PERIOD = 0.6, 2.0 * np.pi / 0.6
START = np.array([-0.5, 0.2, 0.0, 1.3])


def test_sections_are_those_of_the_integrated_motion():
    system = gear_system(published())
    sections = advance(system, OMEGA, [START, 2.0 * START], 4)
    assert sections.status.tolist() == [0, 0]
    for row, start in enumerate((START, 2.0 * START)):
        for count in range(4):
            end = integrate(system, OMEGA, start, 0.0, (count + 1) * PERIOD).states[-1]
            np.testing.assert_allclose(sections.states[row, count], end, atol=1e-8)


def test_extremes_and_harmonics_are_those_of_the_motion():
    system = gear_system(antiphase())
    omega = 1.3
    found = measure(system, omega, START, 4, divisor=2, order=5, tolerance=1e-13)
    trajectory = integrate(system, omega, START, 0.0, 8.0 * np.pi / omega, tolerance=1e-13)
    fine = trajectory.displacement(np.linspace(0.0, trajectory.times[-1], 40001))
    assert found.switches == trajectory.switch_times.size > 2
    assert found.lowest == pytest.approx(fine.min(), abs=1e-6) and found.lowest <= fine.min() + 1e-12
    assert found.highest == pytest.approx(fine.max(), abs=1e-6) and found.highest >= fine.max() - 1e-12
    np.testing.assert_allclose(found.state, trajectory.states[-1], atol=1e-10)
    for k in range(6):
        parts = [
            sum(
                quad(lambda t: float(trajectory.displacement(t)) * wave(0.5 * k * omega * t), a, b, epsabs=1e-12)[0]
                for a, b in zip(trajectory.times[:-1], trajectory.times[1:], strict=True)
                if b > a
            )
            for wave in (np.cos, np.sin)
        ]
        expected = (parts[0] - 1j * parts[1]) * (0.5 if k == 0 else 1.0) * omega / (4.0 * np.pi)
        assert found.harmonics[k] == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("model, omega", [(published(), 0.6), (antiphase(), 1.3)])
def test_monodromy_is_the_derivative_of_the_flow(model, omega):
    system = gear_system(model)
    end, matrix, status = monodromy(system, omega, START)
    assert status is Status.COMPLETE
    step = 1e-6
    for j in range(4):
        shift = step * np.eye(4)[j]
        ends = advance(system, omega, [START + shift, START - shift], 1, tolerance=1e-14).states[:, 0]
        np.testing.assert_allclose(matrix[:, j], (ends[0] - ends[1]) / (2.0 * step), atol=1e-7)


@pytest.mark.parametrize("periods", [1, 3])
def test_volume_shrinks_as_damping_says(periods):
    # Liouville: det = exp(-trace(M^-1 C) time), whatever the contact does.
    system = gear_system(published())
    _, matrix, _ = monodromy(system, OMEGA, START, periods, tolerance=1e-14)
    trace = np.trace(np.linalg.solve(system.mass, system.damping))
    assert np.linalg.det(matrix) == pytest.approx(np.exp(-trace * periods * PERIOD), rel=1e-10)


@pytest.mark.parametrize("q", [0.3, 2.0, 5.0])
def test_transition_curves_of_the_mathieu_equation(q):
    # On its characteristic curves a multiplier over the period pi is +1 (even orders) or -1 (odd ones).
    for order in range(4):
        for curve in [mathieu_a] + [mathieu_b] * (order > 0):
            _, matrix, _ = monodromy(mathieu(float(curve(order, q)), q), 2.0, [0.0, 0.0], tolerance=1e-15)
            assert np.trace(matrix) == pytest.approx(2.0 * (-1) ** order, abs=2e-9)


def test_growth_is_the_rate_at_which_neighbours_part():
    system = gear_system(antiphase())
    logarithms, end, status = growth(system, 1.3, START, 6, direction=[1.0, 0.0, 0.0, 0.0])
    assert status is Status.COMPLETE
    shift = np.array([1e-7, 0.0, 0.0, 0.0])
    pair = advance(system, 1.3, [START, START + shift], 6, tolerance=1e-14).states[:, -1]
    np.testing.assert_allclose(pair[0], end, atol=1e-7)
    assert np.sum(logarithms) == pytest.approx(np.log(np.linalg.norm(pair[1] - pair[0]) / 1e-7), abs=1e-3)


def test_growth_of_a_linear_oscillator_is_its_damping():
    logarithms, _, _ = growth(oscillator(0.05), 1.0, [0.0, 0.0], 400)
    assert logarithms.mean() == pytest.approx(-0.05 * 2.0 * np.pi, rel=1e-2)


def test_a_ceiling_ends_a_motion_and_leaves_the_others():
    system = mathieu(1.0, 0.3)
    sections = advance(system, 2.0, [[1.0, 0.0], [0.0, 0.0]], 60, ceiling=100.0)
    assert sections.status.tolist() == [Status.CEILING, Status.COMPLETE]
    assert np.isnan(sections.states[0, -1]).all() and np.all(sections.states[1] == 0.0)
    failed = measure(system, 2.0, [1.0, 0.0], 60, ceiling=100.0)
    assert failed.status is Status.CEILING and np.isnan(failed.lowest)


@pytest.mark.parametrize(
    "call, name",
    [
        (lambda s: advance(s, 0.6, START, 0), "periods"),
        (lambda s: advance(s, 0.6, START[:3], 1), "states"),
        (lambda s: measure(s, 0.6, START, 1, divisor=1.5), "divisor"),
        (lambda s: measure(s, 0.6, START, 1, order=-1), "order"),
        (lambda s: advance(s, np.inf, START, 1), "omega"),
        (lambda s: growth(s, 0.6, START, True), "periods"),
    ],
)
def test_bad_input_is_named(call, name):
    with pytest.raises(ParameterError, match=f"^{name} ="):
        call(gear_system(published()))
