"""The flows of the zones against the equations of motion, against each other and as their tolerance falls."""

import math

import numpy as np
import pytest
from numpy.polynomial import polynomial

from solver.flow.switched_system import SWITCHED_SYSTEM, loaded_system
from solver.flow.tabulation import MOST_INTERVALS, zone_flows
from solver.flow.zone_flows import COEFFICIENTS, ZONE_FLOWS, ZoneFlows, new_flows
from solver.kernels import types
from solver.kernels.compile import kernel
from solver.model.contact_system import ContactSystem, gear_system
from tests.conftest import antiphase, published
from tests.solver.timedomain.systems import flying_mass, full_gear_system, mathieu

_F, _I = types.float64, types.int64


@kernel(ZONE_FLOWS(SWITCHED_SYSTEM, _F, ZONE_FLOWS))
def tabulated(system, tolerance, flows):
    """`zone_flows` in tables that may have been used."""
    return zone_flows(system, tolerance, flows)


@kernel(ZONE_FLOWS(SWITCHED_SYSTEM, _I))
def room(system, intervals):
    """`new_flows`."""
    return new_flows(system, intervals)


def flows_of(system, omega, tolerance=1e-12) -> ZoneFlows:
    """Fresh tables."""
    loaded = loaded_system(system, omega)
    return tabulated(loaded, tolerance, room(loaded, 1))


SYSTEMS = {
    "antiphase": gear_system(antiphase(alpha_harmonics=[[0.1, 0.7]], f_e_harmonics=[[0.05, 0.2]], kappa=[0.4, 0.6])),
    "seven": full_gear_system(published(xi_support=(0.01, 0.02, 0.03) * 2)),
    "stop": flying_mass(0.4, damping=0.1),
}


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("zone", [1, 0, -1])
def test_a_combination_of_columns_obeys_the_equations(name, zone):
    """M y'' + C y' + K y + [h + h_v s] (lambda - offset) = load, at any time of any interval."""
    system, omega, n = SYSTEMS[name], 0.83, SYSTEMS[name].degrees
    if zone < 0 and not system.two_sided:
        return
    flows = flows_of(system, omega)
    count, half, rng = flows.count[0], flows.half[0], np.random.default_rng(zone + 5)
    loads = system.load_harmonics(omega, len(system.inertial_load) - 1)
    offset = {1: system.front_gap, 0: 0.0, -1: -system.back_gap}[zone]
    for k in range(count):
        m, u = rng.normal(size=2 * n), rng.uniform(-1.0, 1.0)
        series = np.einsum("jcr,c->jr", flows.forward[(zone % 3) * count + k], np.append(m, 1.0))[:, : 2 * n]
        state, rate = polynomial.polyval(u, series), polynomial.polyval(u, polynomial.polyder(series)) / half
        time = (2 * k + 1 + u) * half
        np.testing.assert_allclose(rate[:n], state[n:], atol=1e-10)
        s = sum(size * np.cos(l * omega * time + p) for l, (size, p) in enumerate(system.stiffness_harmonics, 1))
        load = sum(np.real(f * np.exp(1j * l * omega * time)) for l, f in enumerate(loads))
        contact = (system.force + system.varying_force * s) * (system.contact @ state[:n] - offset) * abs(zone)
        residual = system.mass @ rate[n:] + system.damping @ state[n:] + system.stiffness @ state[:n] + contact - load
        np.testing.assert_allclose(residual, 0.0, atol=1e-9)


@pytest.mark.parametrize("name", SYSTEMS)
def test_gamma_is_the_inverse_of_phi_and_maps_join_the_intervals(name):
    flows, n = flows_of(SYSTEMS[name], 0.83), SYSTEMS[name].degrees
    count, size, rng = flows.count[0], 2 * n, np.random.default_rng(2)
    for row in range(count * (3 if SYSTEMS[name].two_sided else 2)):
        powers = rng.uniform(-1.0, 1.0) ** np.arange(COEFFICIENTS)
        phi = np.einsum("j,jcr->rc", powers, flows.forward[row])[:size, :size]
        gamma = np.einsum("j,jcr->rc", powers, flows.backward[row])[:size, :size]
        np.testing.assert_allclose(gamma @ phi, np.eye(size), atol=1e-10)
        if row % count == count - 1:
            continue
        m = rng.normal(size=size + 1)
        m[-1] = 1.0
        end = m @ flows.leave[row]
        np.testing.assert_allclose(
            np.append(end[:size], 1.0) @ flows.entry[row + 1], m @ flows.step[row], rtol=1e-12, atol=1e-12
        )


def test_both_bases_are_one_polynomial_and_hulls_bound_it():
    flows, at = flows_of(SYSTEMS["antiphase"], 0.83), np.linspace(-1.0, 1.0, 201)
    basis = np.array([_bernstein(i, 0.5 * (at + 1.0)) for i in range(COEFFICIENTS)])
    rows = 3 * flows.count[0]
    powers, hulls = (table[:rows] @ part for table, part in ((flows.contact, _powers(at)), (flows.bernstein, basis)))
    np.testing.assert_allclose(hulls, powers, rtol=1e-12, atol=1e-12)


def _powers(at):
    return at ** np.arange(COEFFICIENTS)[:, None]


def _bernstein(i, x):
    return math.comb(COEFFICIENTS - 1, i) * x**i * (1.0 - x) ** (COEFFICIENTS - 1 - i)


def test_intervals_grow_more_as_the_tolerance_falls_and_errors_follow_it():
    system, exact = SYSTEMS["antiphase"], _period_map(flows_of(SYSTEMS["antiphase"], 0.83, 1e-15))
    counts, errors = [], []
    for tolerance in (1e-4, 1e-7, 1e-10):
        flows = flows_of(system, 0.83, tolerance)
        counts.append(int(flows.count[0]))
        errors.append(np.max(np.abs(_period_map(flows) - exact)) / tolerance)
    assert counts == sorted(set(counts)) and all(1e-4 < error < 20.0 for error in errors)


def _period_map(flows):
    """The affine map of a period in contact, as a matrix with a last row (0, 1)."""
    count, size = int(flows.count[0]), flows.backward.shape[2]

    def square(columns):
        matrix = np.eye(size + 1)
        matrix[:size] = columns[:, :size].T
        return matrix

    whole = square(flows.entry[count])
    for row in range(count, 2 * count - 1):
        whole = square(flows.step[row]) @ whole
    return square(flows.leave[2 * count - 1]) @ whole


def test_used_tables_give_the_same_bits():
    first, other = (
        loaded_system(gear_system(model), omega) for model, omega in ((published(), 0.3), (antiphase(), 1.3))
    )
    fresh = tabulated(other, 1e-10, room(other, 1))
    used = tabulated(other, 1e-10, tabulated(first, 1e-12, room(first, 1)))
    rows, count = 3 * fresh.count[0], fresh.count[0]
    assert used.contact.shape[0] > rows
    for name in ("forward", "backward", "contact", "bernstein", "entry", "leave"):
        np.testing.assert_array_equal(getattr(used, name)[:rows], getattr(fresh, name)[:rows])
    np.testing.assert_array_equal(used.stiffness[:count], fresh.stiffness[:count])


def test_a_linear_system_has_one_zone_and_its_monodromy_matrix():
    flows = flows_of(mathieu(1.0, 0.3), 2.0)
    assert np.all(np.isinf(flows.limits[1]))
    matrix = _period_map(flows)[:2, :2]
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=1e-11)


def test_a_period_that_needs_too_many_intervals_is_told():
    stiff = ContactSystem([[1.0]], [[0.0]], [[1e12]], [1.0], [1.0], 1.0)
    assert flows_of(stiff, 1.0).count[0] == 0
    assert 0 < flows_of(ContactSystem([[1.0]], [[0.0]], [[1e4]], [1.0], [1.0], 1.0), 1.0).count[0] < MOST_INTERVALS
