"""The dimensionless model against the dimensional one, whose forces are derived from Lambda_n by virtual work.

docs/physics.md, section 1: the generalised contact force on every coordinate is -F_n dLambda_n/dq. The gradient is
taken here by complex steps from Lambda_n itself, so that no force is written down twice.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver import Model, sweep_row, translations
from solver.contact.dead_zone import dead_zone
from tests.conftest import consistent
from tests.solver.strategies import models

SEEDS = st.integers(0, 2**32 - 1)


@dataclass
class Pair:
    """A bevel gear pair in SI units. Coordinates are (X1, Y1, Z1, X2, Y2, Z2, theta1, theta2)."""

    mass: np.ndarray
    inertia: np.ndarray
    radius: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    torque: np.ndarray
    mesh_stiffness: float
    mesh_damping: float
    stiffness_terms: list  # (A_kl, Phi_kl)
    error_terms: list  # (A_l, Phi_l)
    half_backlash: float
    reference_length: float
    mesh_frequency: float
    pitch_cone_angle: float
    pressure_angle: float

    @classmethod
    def random(cls, seed):
        draw = np.random.default_rng(seed).uniform
        k_m = draw(1e8, 8e8)
        return cls(
            mass=draw(0.3, 3.0, 2),
            inertia=draw(2e-4, 5e-3, 2),
            radius=draw(0.02, 0.09, 2),
            damping=draw(50.0, 900.0, 6),
            stiffness=draw(5e7, 9e8, 6),
            torque=draw(20.0, 400.0, 2),
            mesh_stiffness=k_m,
            mesh_damping=draw(200.0, 2000.0),
            stiffness_terms=[(k_m * draw(0.0, 0.3), draw(-3, 3)) for _ in range(3)],
            error_terms=[(draw(1e-6, 2e-5), draw(-3, 3)) for _ in range(3)],
            half_backlash=draw(1e-5, 1e-4),
            reference_length=draw(1e-5, 1e-4),
            mesh_frequency=draw(2e3, 4e4),
            pitch_cone_angle=draw(10.0, 80.0),
            pressure_angle=draw(14.0, 30.0),
        )

    @property
    def normal(self):
        cone, pressure = np.radians(self.pitch_cone_angle), np.radians(self.pressure_angle)
        return np.array([np.cos(cone) * np.sin(pressure), np.sin(cone) * np.sin(pressure), np.cos(pressure)])

    def mesh_displacement(self, coordinates, error=0.0):
        """Lambda_n; complex coordinates are allowed."""
        a1, a2, a3 = self.normal
        x1, y1, z1, x2, y2, z2, turn1, turn2 = coordinates
        translation = a1 * (x1 - x2) - a2 * (y1 - y2) - a3 * (z1 - z2)
        return translation + a3 * (self.radius[0] * turn1 - self.radius[1] * turn2) - error

    def error(self, time, order):
        """The transmission error e_n, or its time derivative of an order."""
        total = 0.0
        for l, (amplitude, phase) in enumerate(self.error_terms, start=1):
            rate = l * self.mesh_frequency
            total += amplitude * rate**order * np.cos(rate * time + phase + order * np.pi / 2.0)
        return total

    def gradient(self):
        steps = 1e-30j * np.eye(8)
        return np.array([self.mesh_displacement(step).imag / 1e-30 for step in steps])

    def accelerations(self, place, speed, time):
        """Second derivatives of the eight coordinates, and Lambda_n with its first two derivatives."""
        gradient = self.gradient()
        gap = self.mesh_displacement(place, self.error(time, 0))
        rate = gradient @ speed - self.error(time, 1)
        stiffness = self.mesh_stiffness + sum(
            a * np.cos(l * self.mesh_frequency * time + phase)
            for l, (a, phase) in enumerate(self.stiffness_terms, start=1)
        )
        contact = stiffness * dead_zone(gap, self.half_backlash) + self.mesh_damping * rate
        supports = self.damping * speed[:6] + self.stiffness * place[:6]
        drive = np.array([self.torque[0], -self.torque[1]])
        forces = np.concatenate([-supports, drive]) - contact * gradient
        second = forces / np.concatenate([np.repeat(self.mass, 3), self.inertia])
        return second, gap, rate, gradient @ second - self.error(time, 2)

    @property
    def equivalent_mass(self):
        (j1, j2), (r1, r2) = self.inertia, self.radius
        return j1 * j2 / (r1**2 * j2 + r2**2 * j1)

    @property
    def frequency_unit(self):
        return np.sqrt(self.mesh_stiffness / self.equivalent_mass)

    def dimensionless(self):
        """The same pair by the formulas of docs/physics.md, section 2."""
        unit, length, mass = self.frequency_unit, self.reference_length, np.repeat(self.mass, 3)
        (j1, j2), (r1, r2), (t1, t2) = self.inertia, self.radius, self.torque
        a3, m_e = self.normal[2], self.equivalent_mass
        (alpha, alpha_phase), *alphas = [(a / self.mesh_stiffness, phase) for a, phase in self.stiffness_terms]
        (f_e, f_e_phase), *errors = [(a / length, phase) for a, phase in self.error_terms]
        return Model(
            b=self.half_backlash / length,
            alpha=alpha,
            alpha_phase=alpha_phase,
            alpha_harmonics=alphas,
            f_e=f_e,
            f_e_phase=f_e_phase,
            f_e_harmonics=errors,
            f_pm=a3 * m_e * (r1 * t1 / j1 + r2 * t2 / j2) / (self.mesh_stiffness * length),
            kappa=self.mesh_stiffness / (self.mass * unit**2),
            xi_mesh=self.mesh_damping / (2.0 * m_e * unit),
            xi_translation=self.mesh_damping / (2.0 * self.mass * unit),
            xi_support=self.damping / (2.0 * mass * unit),
            k_support=self.stiffness / (mass * unit**2),
            pitch_cone_angle=self.pitch_cone_angle,
            pressure_angle=self.pressure_angle,
            translation_coupling="geometric",
            rotation_coupling="geometric",
            variation_translation=1.0,
            variation_rotation=1.0,
        )


def model_accelerations(model, omega, tau, place, speed):
    """y'' of M y'' + C y' + K y + (h_t k_t + h_r k_r) f(lambda) = e_7 load."""
    mass, damping, stiffness = model.matrices()
    translation, rotation = model.mesh_vectors()
    s = model.stiffness_variation(omega * tau)
    load = model.load_harmonics(omega, 3)
    right = -damping @ speed - stiffness @ place
    right -= (
        translation * (1.0 + model.variation_translation * s) + rotation * (1.0 + model.variation_rotation * s)
    ) * dead_zone(place[6], model.b)
    right[6] += sum((load[k] * np.exp(1j * k * omega * tau)).real for k in range(4))
    return np.linalg.solve(mass, right)


def compare(pair, place, speed, time):
    """Accelerations of (x, lambda) from the dimensional pair, made dimensionless, and from the model."""
    unit, length = pair.frequency_unit, pair.reference_length
    second, gap, rate, gap_second = pair.accelerations(place, speed, time)
    expected = np.append(second[:6], gap_second) / (length * unit**2)
    found = model_accelerations(
        pair.dimensionless(),
        pair.mesh_frequency / unit,
        unit * time,
        np.append(place[:6], gap) / length,
        np.append(speed[:6], rate) / (length * unit),
    )
    return found, expected


@given(SEEDS)
def test_accelerations_are_those_of_virtual_work(seed):
    pair = Pair.random(seed)
    draw = np.random.default_rng(seed + 1).uniform
    unit, length = pair.frequency_unit, pair.reference_length
    for _ in range(5):
        place, speed = draw(-3, 3, 8) * length, draw(-3, 3, 8) * length * unit
        place[6:] /= pair.radius
        speed[6:] /= pair.radius
        found, expected = compare(pair, place, speed, draw(0.0, 1.0) * 1e-3)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * max(1.0, np.max(np.abs(expected))))


def test_all_three_contact_regimes_are_reached():
    pair = Pair.random(7)
    a3 = pair.normal[2]
    for side in (1.0, 0.0, -1.0):
        place = np.zeros(8)
        place[6] = side * 3.0 * pair.half_backlash / (a3 * pair.radius[0])
        _, gap, *_ = pair.accelerations(place, np.zeros(8), 0.0)
        assert np.sign(dead_zone(gap, pair.half_backlash)) == side
        found, expected = compare(pair, place, np.zeros(8), 0.0)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * max(1.0, np.max(np.abs(expected))))


def test_matrices_and_mesh_vectors_are_those_probed_from_the_dimensional_pair():
    """Column by column, from unit changes of the state of a pair in free flight, of constant stiffness and no error."""
    pair = Pair.random(11)
    pair.stiffness_terms, pair.error_terms = [(0.0, 0.0)], [(0.0, 0.0)]
    model, unit, length, a3 = pair.dimensionless(), pair.frequency_unit, pair.reference_length, pair.normal[2]
    mass, damping, stiffness = model.matrices()
    translation, rotation = model.mesh_vectors()
    gradient = pair.gradient()

    def second(place, speed):
        """(x'', lambda'') at dimensionless (x, lambda) and their speeds; theta1 makes lambda what it shall be."""

        def physical(state):
            q = np.append(state[:6], [0.0, 0.0]) * length
            q[6] = (state[6] * length - gradient @ q) / (a3 * pair.radius[0])
            return q

        result, _, _, gap = pair.accelerations(physical(place), physical(speed) * unit, 0.0)
        return np.append(result[:6], gap) / (length * unit**2)

    zero, flight = np.zeros(7), np.linspace(0.1, 0.7, 7)
    rest = mass @ second(zero, zero)
    np.testing.assert_allclose(rest, model.f_pm * np.eye(7)[6], rtol=0, atol=1e-12)
    for column in range(7):
        unit_vector = np.eye(7)[column]
        shift = 0.5 * model.b * unit_vector if column == 6 else unit_vector
        np.testing.assert_allclose(
            rest - mass @ second(zero, unit_vector), damping[:, column], rtol=0, atol=1e-11, err_msg="C"
        )
        np.testing.assert_allclose(
            rest - mass @ second(shift, zero), stiffness[:, column], rtol=0, atol=1e-11, err_msg="K"
        )
    touching = zero.copy()
    touching[6] = model.b + 1.0
    np.testing.assert_allclose(
        rest - mass @ second(touching, zero), translation + rotation, rtol=0, atol=1e-11, err_msg="h"
    )
    # M itself: the inertia that answers to an acceleration, from kinetic energy and the definition of lambda.
    np.testing.assert_allclose(mass[6], [*(-gradient[:6]), 1.0], rtol=0, atol=1e-15)
    np.testing.assert_array_equal(mass[:6], np.eye(7)[:6])
    assert np.all(np.isfinite(second(flight, flight)))


def test_load_of_balanced_torques_is_the_static_force():
    pair = Pair.random(3)
    pair.torque = 250.0 * pair.radius / pair.radius[0]
    expected = pair.normal[2] * 250.0 / pair.radius[0] / (pair.mesh_stiffness * pair.reference_length)
    assert pair.dimensionless().f_pm == pytest.approx(expected, rel=1e-13)


@given(
    models(
        translation_coupling="geometric",
        rotation_coupling="geometric",
        xi_mesh=0.05,
        kappa=(0.4, 0.7),
        xi_translation=(0.02, 0.035),
        alpha=0.0,
        alpha_harmonics=(),
        variation_translation=1.0,
        variation_rotation=1.0,
    ),
    SEEDS,
)
def test_power_balance_of_a_consistent_pair(model, seed):
    """Change of kinetic and elastic energy = power of the load - what the dampers take, at any state."""
    draw = np.random.default_rng(seed).uniform
    place, speed, tau, omega = draw(-2, 2, 7), draw(-2, 2, 7), draw(0, 10), draw(0.1, 2.0)
    second = model_accelerations(model, omega, tau, place, speed)
    weight, c, d = 1.0 / np.repeat(model.kappa, 3), model.rotation, model.direction
    load = model.load_harmonics(omega, 3)
    load = sum((load[k] * np.exp(1j * k * omega * tau)).real for k in range(4))
    turning, turning_second = speed[6] - d @ speed[:6], second[6] - d @ second[:6]
    kinetic = np.sum(weight * speed[:6] * second[:6]) + turning * turning_second / c
    elastic = np.sum(weight * np.array(model.k_support) * place[:6] * speed[:6])
    elastic += dead_zone(place[6], model.b) * speed[6]
    taken = np.sum(weight * 2.0 * np.array(model.xi_support) * speed[:6] ** 2) + 2.0 * model.xi_mesh * speed[6] ** 2
    assert kinetic + elastic == pytest.approx(load * turning / c - taken, abs=1e-11)


@pytest.mark.parametrize("omega", [0.4, 0.62, 1.5])
def test_mean_power_of_a_solution_is_what_the_dampers_take(omega):
    model = consistent(alpha=0.0, xi_translation=0.025, f_e=0.4)
    row = sweep_row(model, "omega", [0.3, omega, 1.9])
    assert row.n_solutions[1] >= 1
    for mean, cosine, sine in zip(row.mean[1], row.cos[1], row.sin[1], strict=True):
        if np.isnan(mean):
            continue
        x = translations(model, omega, (mean, cosine, sine))
        x, mesh = x[1] - 1j * x[2], cosine - 1j * sine
        turning = 1j * omega * (mesh - model.direction @ x)
        given_in = 0.5 * (np.conj(turning) * model.load_harmonics(omega)[1]).real / model.rotation
        in_supports = np.sum(np.array(model.xi_support) * np.abs(omega * x) ** 2) / 0.5
        taken = in_supports + model.xi_mesh * abs(omega * mesh) ** 2
        assert given_in == pytest.approx(taken, rel=1e-9)


def test_signs_inside_the_direction_drop_out_at_the_mesh():
    """Beyond a right angle the radial component turns its sign: the translations do too, lambda does not feel it."""
    model, turned = consistent(pitch_cone_angle=30.0), consistent(pitch_cone_angle=150.0)
    signs = np.array([-1.0, 1.0, 1.0, -1.0, 1.0, 1.0])
    np.testing.assert_allclose(turned.direction, signs * model.direction, rtol=0, atol=1e-15)
    row, other = sweep_row(model, "omega", [0.3, 0.6, 1.6]), sweep_row(turned, "omega", [0.3, 0.6, 1.6])
    for name in ("mean", "cos", "sin"):
        np.testing.assert_allclose(getattr(row, name), getattr(other, name), rtol=0, atol=1e-11)
    found = [translations(m, 0.6, (r.mean[1, 0], r.cos[1, 0], r.sin[1, 0])) for m, r in ((model, row), (turned, other))]
    np.testing.assert_allclose(found[1], signs * found[0], rtol=0, atol=1e-11)
