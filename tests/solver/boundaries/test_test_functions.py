"""Rows of period doublings, Neimark-Sackers and folds: against eigenvalues, and their derivatives."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver import ContactSystem, Event
from solver.boundaries import BIFURCATIONS
from solver.boundaries.bifurcations import characteristic_remainder
from solver.boundaries.contact_angles import FRONT
from solver.boundaries.first_order import FirstOrderProblem
from solver.boundaries.harmonic import HarmonicProblem
from solver.boundaries.problem import Plane
from solver.harmonic.galerkin import Galerkin
from solver.model.parameter_path import place_on
from solver.stability import motion_multipliers
from tests.conftest import consistent

MODEL = consistent(alpha_phase=0.3, f_pv=0.1, alpha_harmonics=((0.1, 0.4),), pressure_angle=21.0)
OMEGA = 1.1
#: Where derivatives are compared: axes and a place.
PLANES = {
    ("omega", "b"): (1.1, 1.0),
    ("alpha", "alpha_phase"): (0.2, 0.3),
    ("kappa", "xi_support"): (0.4, 0.03),
    ("rotation_coupling", "omega"): (0.9, 1.1),
    ("pressure_angle", "variation_rotation"): (21.0, 1.0),
    ("f_e", "omega"): (0.2, 1.1),
    ("k_support", "translation_coupling"): (0.9, 0.8),
}
planes = pytest.mark.parametrize("axes", list(PLANES), ids=" ".join)
ORDERS = {"order 1": None, "order 3": Galerkin(3), "order 2, doubled": Galerkin(2, 2)}
orders = pytest.mark.parametrize("balance", list(ORDERS.values()), ids=list(ORDERS))


def boundary(axes, balance):
    place = PLANES[axes]
    plane = Plane(MODEL, *axes, *((max(value - 0.3, 0.1 * value), value + 0.4) for value in place), OMEGA)
    return FirstOrderProblem(plane) if balance is None else HarmonicProblem(plane, balance)


def motions(axes, balance, kind, count=12):
    """Problems and y of motions of a plane, those that lose contact among them."""
    rng, found = np.random.default_rng(5), boundary(axes, balance)
    for _ in range(count):
        u = rng.normal(size=found.unknowns) / (1.0 + np.arange(found.unknowns) // 2)
        point, kappa = np.concatenate([u, PLANES[axes]]), rng.uniform(-1.0, 1.0)
        if balance is None:
            for contact in found.zones(kind, point):
                y = found.lift(kind, contact, point)
                y = np.insert(y, 5, kappa) if kind is Event.NEIMARK_SACKER else y
                yield found, found.problem(kind, contact), y
        else:
            y = np.insert(point, -2, kappa) if kind is Event.NEIMARK_SACKER else point
            yield found, found.problem(kind, None), y


def rows(problem, y):
    residual, jacobian = np.empty(problem.unknowns), np.empty((problem.unknowns, y.size))
    problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
    return residual, jacobian


def differences(problem, y, step):
    columns = [(rows(problem, y + step * e)[0] - rows(problem, y - step * e)[0]) / (2.0 * step) for e in np.eye(y.size)]
    return np.transpose(columns)


# The characteristic polynomial ---------------------------------------------------------------------------------------


@given(st.integers(1, 7), st.integers(0, 2**32 - 1), st.floats(-1.0, 1.0))
def test_the_remainder_is_that_of_the_characteristic_polynomial(n, seed, kappa):
    matrix = np.random.default_rng(seed).normal(size=(2 * n, 2 * n)) / np.sqrt(2 * n)
    found = characteristic_remainder(matrix.copy(), kappa)

    def remainder(at):
        left = np.polydiv(np.poly(matrix), [1.0, -2.0 * at, 1.0])[1]
        return np.array([left[-1], left[-2] if left.size > 1 else 0.0])

    size = np.sum(np.abs(np.poly(matrix)))
    np.testing.assert_allclose(found[:2], remainder(kappa), rtol=0, atol=1e-12 * size)
    # Of degree n in kappa at most: Richardson's extrapolation leaves rounding.
    wide, narrow = ((remainder(kappa + h) - remainder(kappa - h)) / (2.0 * h) for h in (2e-3, 1e-3))
    np.testing.assert_allclose(found[2:], (4.0 * narrow - wide) / 3.0, rtol=0, atol=1e-7 * size)


@given(st.integers(2, 7), st.integers(0, 2**32 - 1), st.floats(0.0, np.pi))
def test_it_vanishes_for_multipliers_on_the_circle(n, seed, phi):
    rng = np.random.default_rng(seed)
    matrix = np.diag(rng.uniform(-0.9, 0.9, 2 * n))
    matrix[:2, :2] = [[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]]
    turn = np.linalg.qr(rng.normal(size=(2 * n, 2 * n)))[0]
    turned = turn @ matrix @ turn.T
    np.testing.assert_allclose(characteristic_remainder(turned.copy(), np.cos(phi))[:2], 0.0, atol=1e-12)
    assert np.max(np.abs(characteristic_remainder(turned.copy(), np.cos(phi + 0.3))[:2])) > 1e-6
    matrix[:2, :2] = np.diag([-1.0, 0.3])
    r_0, r_1, _, _ = characteristic_remainder(turn @ matrix @ turn.T, -1.0)
    assert abs(r_0 - r_1) < 1e-12


# The rows ------------------------------------------------------------------------------------------------------------


@planes
@orders
def test_rows_are_the_characteristic_polynomial_of_the_motions_multipliers(axes, balance):
    for kind in BIFURCATIONS:
        for found, problem, y in motions(axes, balance, kind):
            u, (x, p) = y[: found.unknowns], y[-2:]
            model, omega = place_on(axes[1], p, *place_on(axes[0], x, MODEL, OMEGA))
            multipliers = motion_multipliers(model, omega, u, 1 if balance is None else balance.period)
            size, residual = np.prod(1.0 + np.abs(multipliers)), rows(problem, y)[0]
            if kind is Event.PERIOD_DOUBLING:
                expected = np.prod(1.0 + multipliers).real
                assert abs(residual[-1] - expected) < 1e-9 * size
            else:
                z = np.exp(1j * np.arccos(y[-3]))
                assert abs(residual[-2] + residual[-1] * z - np.prod(z - multipliers)) < 1e-9 * size


@orders
@planes
@pytest.mark.parametrize("kind", BIFURCATIONS)
def test_derivatives_are_those_of_differences(axes, balance, kind):
    """Of two steps other than the rows' own, extrapolated."""
    for _, problem, y in motions(axes, balance, kind):
        jacobian = rows(problem, y)[1]
        wide, narrow = differences(problem, y, 4e-6), differences(problem, y, 2e-6)
        size = 1.0 + np.max(np.abs(jacobian), axis=1, keepdims=True)
        # Next to a grazing differences of any step are worse than what they are compared with.
        close = np.max(np.abs(narrow - wide) / size) < 1e-6
        assert np.max(np.abs(jacobian - (4.0 * narrow - wide) / 3.0) / size) < (1e-7 if close else 1e-3)


@planes
@pytest.mark.parametrize("balance", [Galerkin(1), Galerkin(3), Galerkin(2, 2)], ids=repr)
def test_the_row_of_folds_has_the_sign_of_the_determinant(axes, balance):
    signs = set()
    for found, problem, y in motions(axes, balance, Event.FOLD):
        residual, jacobian = rows(problem, y)
        n = found.unknowns
        signs.add(np.sign(residual[-1]))
        assert np.sign(residual[-1]) == np.sign(np.linalg.det(jacobian[:n, :n]))
        wide, narrow = differences(problem, y, 4e-6), differences(problem, y, 2e-6)
        size = 1.0 + np.max(np.abs(jacobian), axis=1, keepdims=True)
        close = np.max(np.abs(narrow - wide) / size) < 1e-6
        assert np.max(np.abs(jacobian - (4.0 * narrow - wide) / 3.0) / size) < (1e-7 if close else 1e-3)
    # 0 without contact, which leaves the mean open.
    assert signs >= {-1.0, 1.0}


def test_any_contact_system_has_bifurcations():
    """An oscillator with a one-sided spring: its axes are other ones, and no flank lies behind."""
    system = ContactSystem(
        mass=[[1.0]],
        damping=[[0.1]],
        stiffness=[[1.0]],
        contact=[1.0],
        force=[0.5],
        varying_force=[0.5],
        front_gap=0.4,
        load=[[0.2], [0.7]],
        stiffness_harmonics=((0.3, 0.2),),
    )
    plane = Plane(system, "omega", "alpha", (0.5, 2.0), (0.0, 0.6))
    found, rng = HarmonicProblem(plane, Galerkin(3)), np.random.default_rng(2)
    for _ in range(10):
        u = rng.normal(size=7) / (1.0 + np.arange(7) // 2)
        y = np.array([*u, 1.3, 0.25])
        problem = found.problem(Event.PERIOD_DOUBLING, None)
        residual, jacobian = rows(problem, y)
        multipliers = motion_multipliers(replace(system, stiffness_harmonics=((0.25, 0.2),)), 1.3, u)
        assert abs(residual[-1] - np.prod(1.0 + multipliers).real) < 1e-9
        np.testing.assert_allclose(
            jacobian[:, -2:],
            differences(problem, y, 3e-6)[:, -2:],
            rtol=0,
            atol=1e-6 * (1.0 + np.max(np.abs(jacobian))),
        )


def test_a_load_and_with_the_angles_held_a_gap_are_not_felt():
    for axes, kind in itertools.product((("omega", "b"), ("f_e", "omega")), BIFURCATIONS):
        count = 2 if kind is Event.NEIMARK_SACKER else 1
        for _, problem, y in motions(axes, None, kind):
            _, jacobian = rows(problem, y)
            quiet, other = (-1, -2) if axes[1] == "b" else (-2, -1)
            assert np.all(jacobian[-count:, quiet] == 0.0) and np.all(jacobian[-count:, other] != 0.0)


def test_angles_many_turns_away_are_those_of_no_motion():
    _, problem, y = next(
        one for one in motions(("omega", "b"), None, Event.PERIOD_DOUBLING) if abs(one[2][FRONT]) < 1.0
    )
    assert np.isfinite(rows(problem, y)[0][-1])
    y[FRONT] = 30.0
    assert np.isnan(rows(problem, y)[0][-1])
