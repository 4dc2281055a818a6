"""Quantities of a balance's motions against sampling of their own waveform, and against direct integration."""

import dataclasses
import math

import numpy as np
import pytest

from solver import Model, ParameterError, all_solutions, solve
from solver.contact.quantities import Quantities
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.galerkin import Galerkin
from solver.harmonic.quantities import balance_quantities
from solver.harmonic.uncondensed import translations
from solver.model.contact_system import gear_system
from solver.timedomain import measure, motion_quantities, orbit_state, shoot
from tests.conftest import antiphase, consistent, published

SAMPLES = 20_000
THETA = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES

UNEQUAL = consistent(
    kappa=(0.4, 0.7), xi_translation=(0.0125, 0.03), xi_support=(0.01, 0.02, 0.03, 0.01, 0.05, 0.02), b=0.6, f_pm=0.3
)


def first_order(model: Model, omega: float) -> np.ndarray:
    """All motions at one frequency, (S, 3)."""
    found = all_solutions(model, omega)
    return np.column_stack([found.mean, found.cos, found.sin])


def wave(parts) -> np.ndarray:
    """Values on the grid of (mean, cosine, sine)."""
    return parts[0] + parts[1] * np.cos(THETA) + parts[2] * np.sin(THETA)


def sampled(model: Model, omega: float, motion) -> Quantities:
    """First order by a grid of phases, the supports from the balance of all seven degrees of freedom."""
    deflection, parts = wave(motion), translations(model, omega, motion)
    speed = omega * (motion[2] * np.cos(THETA) - motion[1] * np.sin(THETA))
    force = np.maximum(deflection - model.b, 0.0) + np.minimum(deflection + model.b, 0.0)
    force = force * (1.0 + model.variation_translation * model.stiffness_variation(THETA))
    psi = deflection - sum(model.direction[j] * wave(parts[:, j]) for j in range(6))
    psi += sum(a * np.cos(l * THETA + phase) for l, (a, phase) in enumerate(model.error_harmonics(), 1))
    supports = []
    for j in range(6):
        cosine, sine, drag = parts[1, j], parts[2, j], 2.0 * model.xi_support[j] * omega
        spring = wave(model.k_support[j] * parts[:, j])
        force_on_it = spring + wave([0.0, drag * sine, -drag * cosine])
        supports.append(np.max(np.abs(force_on_it)) / model.kappa[j // 3])
    free = np.abs(deflection) <= model.b
    meet = np.flatnonzero(np.roll(free, 1) & ~free)
    return Quantities(
        deflection.min(),
        deflection.max(),
        deflection.mean(),
        deflection.std(),
        np.ptp(deflection),
        psi.min(),
        psi.max(),
        psi.std(),
        np.ptp(psi),
        force.max() * model.rotation / model.f_pm,
        free.mean(),
        np.max(np.abs(speed[meet]), initial=0.0),
        max(supports),
    )


@pytest.mark.parametrize(
    "model, omega",
    [
        (published(), 0.6),
        (published(alpha=0.4, alpha_phase=0.7, f_pv=0.2), 1.226),
        (antiphase(), 1.3),
        (UNEQUAL, 0.55),
        (published(b=0.0), 0.6),
        (consistent(alpha_harmonics=((0.1, 0.3),), f_e_harmonics=((0.05, 1.0), (0.02, 0.4)), f_e=0.5), 1.6),
    ],
)
def test_first_order_is_its_own_waveform(model, omega):
    motions = first_order(model, omega)
    found = balance_quantities(DescribingFunction(), model, "omega", np.full(len(motions), omega), motions)
    for motion, row in zip(motions, found, strict=True):
        expected = sampled(model, omega, motion)
        for name, value in dataclasses.asdict(Quantities(*row)).items():
            rough = {"contact_loss": 2e-4, "impact_velocity": 1e-3}.get(name, 2e-7)
            assert value == pytest.approx(getattr(expected, name), abs=rough), name


def agree(found, exact: Quantities, tolerances):
    for name, value in dataclasses.asdict(Quantities(*found)).items():
        assert value == pytest.approx(getattr(exact, name), abs=tolerances.get(name, tolerances["others"])), name


@pytest.mark.parametrize(
    "model, omega", [(published(), 0.9), (antiphase(f_e=0.35), 0.5), (UNEQUAL.replace(f_pm=1.0), 0.6)]
)
def test_order_15_is_direct_integration(model, omega):
    balance = Galerkin(15)
    motion = solve(model, first_order(model, omega)[0], omega, balance=balance).motion
    system = gear_system(model)
    orbit = shoot(system, omega, orbit_state(system, omega, motion))
    exact, _ = motion_quantities(model, omega, orbit.state)
    assert exact.contact_loss == 0.0 and exact.rms > 0.05
    agree(balance_quantities(balance, model, "omega", omega, motion), exact, {"others": 1e-6})


def test_with_contact_loss_errors_fall_with_the_order():
    model, omega, system, errors = published(f_e=0.3), 0.7, gear_system(published(f_e=0.3)), []
    for order in (5, 15, 45):
        balance = Galerkin(order)
        motion = solve(model, first_order(model, omega)[0], omega, balance=balance).motion
        orbit = shoot(system, omega, orbit_state(system, omega, motion))
        exact, _ = motion_quantities(model, omega, orbit.state)
        assert exact.contact_loss > 0.05 and exact.impact_velocity > 0.1
        found = balance_quantities(balance, model, "omega", omega, motion)
        errors.append(np.max(np.abs(found - dataclasses.astuple(exact))))
    # f has kinks: Lambda_k falls with k^-4, and a force at most by k^-2.
    assert errors[0] < 2e-3 and errors[1] < 2e-4 and errors[2] < 1e-5


def test_a_motion_of_two_periods():
    model = published(
        translation_coupling=0.0,
        rotation_coupling=1.0,
        variation_rotation=1.0,
        alpha_phase=math.pi,
        alpha_harmonics=((0.1, math.pi), (0.05, math.pi)),
        f_e=0.01,
        f_e_harmonics=((0.004, 0.0), (0.002, 0.0)),
        f_pm=0.1,
    )
    omega, system, balance = 1.8, gear_system(model), Galerkin(15, 2)
    orbit = shoot(system, omega, [1.2, 0.1], 2)
    if orbit.minimal_period != 2:
        orbit = shoot(system, omega, [0.95, 0.2], 2)
    harmonics = measure(system, omega, orbit.state, 2, divisor=2, order=30).harmonics
    guess = np.concatenate([[harmonics[0].real], np.column_stack([harmonics.real, -harmonics.imag])[1:].ravel()])
    solved = solve(model, guess, omega, balance=balance)
    exact, _ = motion_quantities(model, omega, orbit.state, 2)
    assert orbit.minimal_period == 2 and exact.contact_loss > 0.05 and solved.distance < 1e-4
    rough = {"dynamic_factor": 1e-3, "contact_loss": 1e-3, "impact_velocity": 1e-3, "others": 2e-5}
    agree(balance_quantities(balance, model, "omega", omega, solved.motion), exact, rough)


def test_the_sign_of_the_load_changes_nothing_but_signs():
    model, motion = published(f_e=0.3), np.array([1.2, 0.5, -0.4])
    mirrored = model.replace(f_pm=-0.5, f_e_phase=np.pi)
    one, other = (
        Quantities(*balance_quantities(DescribingFunction(), m, "omega", 0.7, u))
        for m, u in ((model, motion), (mirrored, -motion))
    )
    assert (other.lowest, other.highest) == pytest.approx((-one.highest, -one.lowest))
    for name in ("rms", "dynamic_factor", "contact_loss", "impact_velocity", "error_rms", "support_force"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-12), name


def test_shapes_other_axes_and_motions_that_are_none():
    model, balance = published(), DescribingFunction()
    motions = np.full((2, 3, 3), np.nan)
    motions[:, 0] = [1.6, 0.1, 0.2]
    found = balance_quantities(balance, model, "f_e", [[0.1], [0.3]], motions, 0.8)
    assert found.shape == (2, 3, 13) and np.all(np.isnan(found[:, 1:])) and np.all(np.isfinite(found[:, 0]))
    for row, f_e in zip(found[:, 0], (0.1, 0.3), strict=True):
        alone = balance_quantities(balance, model.replace(f_e=f_e), "omega", 0.8, motions[0, 0])
        np.testing.assert_allclose(row, alone, rtol=1e-13)
    assert math.isnan(
        Quantities(*balance_quantities(balance, published(f_pm=0.0), "omega", 0.8, motions[0, 0])).dynamic_factor
    )
    undamped = published(k_support=0.25, xi_support=0.0)
    resonant = Quantities(*balance_quantities(balance, undamped, "omega", 0.5, motions[0, 0]))
    assert math.isnan(resonant.support_force) and math.isnan(resonant.error_rms)
    assert resonant.rms == pytest.approx(math.hypot(0.1, 0.2) / math.sqrt(2.0), rel=1e-12)
    for arguments, name in (
        ((balance, model, "omega", 0.8, [1.0, 2.0]), "motions"),
        ((balance, "gear", "omega", 0.8, motions[0, 0]), "system"),
        ((balance, model, "speed", 0.8, motions[0, 0]), "axis"),
        ((None, model, "omega", 0.8, motions[0, 0]), "balance"),
    ):
        with pytest.raises(ParameterError, match=f"^{name} ="):
            balance_quantities(*arguments)
