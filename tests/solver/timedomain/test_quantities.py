"""Quantities of motions against all seven degrees of freedom, integrated by SciPy and looked at on a fine grid."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from solver import Model, ParameterError
from solver.contact.quantities import Quantities, Slot
from solver.model.contact_system import ContactSystem, gear_system, support_kinds
from solver.model.packing import packed
from solver.timedomain import Status, advance, shoot
from solver.timedomain.gauge import gauge_at
from solver.timedomain.quantities import motion_quantities
from tests.conftest import antiphase, consistent, published
from tests.solver.timedomain.systems import first_order_state, full_gear_system

SAMPLES = 4001

#: Gears of other masses and supports; a spur pair, whose bearings the contact does not reach.
UNEQUAL = consistent(
    kappa=(0.4, 0.7),
    xi_translation=(0.0125, 0.03),
    xi_support=(0.01, 0.02, 0.01) * 2,
    b=0.6,
    alpha_harmonics=((0.1, 0.3),),
    f_e_harmonics=((0.05, 0.7),),
)
SPUR = consistent(
    translation_coupling=0.0,
    rotation_coupling=1.0,
    variation_rotation=1.0,
    xi_mesh=0.05,
    alpha=0.2,
    alpha_phase=math.pi,
    alpha_harmonics=((0.1, math.pi), (0.05, math.pi)),
    f_e=0.01,
    f_e_harmonics=((0.004, 0.0), (0.002, 0.0)),
    f_pm=0.1,
)


def settled(model: Model, omega: float, periods: int = 1, start=None, separate=False):
    """State of `gear_system(model)` on the attractor that a motion at rest, closed by its load, comes to."""
    system = gear_system(model, separate=separate)
    state = np.zeros(2 * system.degrees)
    state[system.degrees - 1] = model.b + 0.5
    orbit = shoot(system, omega, advance(system, omega, state if start is None else start, 600).states[0, -1], periods)
    assert orbit.stable
    return orbit.state


def sampled(model: Model, omega: float, state, periods: int) -> Quantities:
    """By SciPy from a state of the separate system: extremes and integrals of a grid of times."""
    full, apart = full_gear_system(model), gear_system(model, separate=True)
    member, share = support_kinds(model, separate=True)
    start, n = np.zeros(14), apart.degrees
    reached = member >= 0
    start[:6][reached] = (share * state[member])[reached]
    start[7:13][reached] = (share * state[n + member])[reached]
    start[6], start[13] = state[n - 1], state[-1]
    inverse, loads = np.linalg.inv(full.mass), full.load_harmonics(omega, len(full.inertial_load) - 1)

    def field(time, z):
        load = sum((part * np.exp(1j * l * omega * time)).real for l, part in enumerate(loads))
        s = model.stiffness_variation(omega * time)
        force = (full.force + full.varying_force * s) * full.contact_force(z[6])
        return np.concatenate([z[7:], inverse @ (load - full.damping @ z[7:] - full.stiffness @ z[:7] - force)])

    stop = 2.0 * np.pi / omega * periods
    times = np.linspace(0.0, stop, SAMPLES)
    z = solve_ivp(
        field, (0.0, stop), start, method="DOP853", rtol=1e-10, atol=1e-11, t_eval=times, max_step=stop / 200 / periods
    ).y
    weights = np.ones(SAMPLES)
    weights[[0, -1]] = 0.5
    weights /= weights.sum()

    def spread(values):
        return math.sqrt(weights @ (values - weights @ values) ** 2)

    deflection, speed = z[6], z[13]
    error = sum(a * np.cos(l * omega * times + phase) for l, (a, phase) in enumerate(model.error_harmonics(), 1))
    psi = deflection - model.direction @ z[:6] + error
    force = (1.0 + model.variation_translation * model.stiffness_variation(omega * times)) * full.contact_force(
        deflection
    )
    supports = np.array(model.k_support)[:, None] * z[:6] + 2.0 * np.array(model.xi_support)[:, None] * z[7:13]
    supports /= np.repeat(model.kappa, 3)[:, None]
    free = np.abs(deflection) <= model.b
    meet = np.flatnonzero(free[:-1] & ~free[1:])
    return Quantities(
        deflection.min(),
        deflection.max(),
        weights @ deflection,
        spread(deflection),
        np.ptp(deflection),
        psi.min(),
        psi.max(),
        spread(psi),
        np.ptp(psi),
        force.max() * model.rotation / model.f_pm,
        np.mean(free),
        np.max(np.abs(speed[meet]), initial=0.0),
        np.max(np.abs(supports[reached]), initial=0.0),
    )


def agree(found: Quantities, expected: Quantities):
    """Within what a grid of so many times leaves open: extremes by its square, times of switches by itself."""
    rough = {"dynamic_factor": 2e-5, "contact_loss": 1e-3, "impact_velocity": 1e-2, "support_force": 1e-5}
    for name, value in dataclasses.asdict(found).items():
        assert value == pytest.approx(getattr(expected, name), abs=rough.get(name, 5e-6)), name


@pytest.mark.parametrize(
    "model, omega",
    [(published(), 0.9), (UNEQUAL, 0.55), (antiphase(f_e=0.35), 0.5), (SPUR, 0.5), (published(b=0.0), 0.6)],
)
def test_stable_motions_are_those_of_seven_degrees_of_freedom(model, omega):
    state = settled(model, omega, separate=True)
    found, status = motion_quantities(model, omega, state)
    assert status is Status.COMPLETE
    agree(found, sampled(model, omega, state, 1))


def test_a_motion_of_several_periods_need_not_be_periodic():
    model = published()
    system, state = first_order_state(model, 0.6)
    found, _ = motion_quantities(model, 0.6, state, 3)
    assert found.contact_loss > 0.3 and found.impact_velocity > 0.5
    agree(found, sampled(model, 0.6, state, 3))


def test_merged_supports_are_told_apart_on_orbits_and_nowhere_else():
    omega = 0.55
    state, apart = settled(UNEQUAL, omega), settled(UNEQUAL, omega, separate=True)
    assert state.size < apart.size
    merged, expected = (motion_quantities(UNEQUAL, omega, part)[0] for part in (state, apart))
    for name, value in dataclasses.asdict(merged).items():
        assert value == pytest.approx(getattr(expected, name), abs=1e-8), name
    off, _ = motion_quantities(UNEQUAL, omega, 1.1 * state)
    assert math.isnan(off.support_force) and off.dynamic_factor > 1.0


def test_known_digits_of_the_spur_pair():
    # docs/physics.md, section 9: the motion at 0.5, and the 2T motion beside 1T at 1.8.
    found, _ = motion_quantities(SPUR, 0.5, settled(SPUR, 0.5))
    assert (found.mean, found.lowest, found.highest) == pytest.approx((1.09286, 0.95104, 1.24239), abs=6e-6)
    assert found.support_force == 0.0 and 0.15 < found.contact_loss < 0.25
    double, _ = motion_quantities(SPUR, 1.8, settled(SPUR, 1.8, 2, [1.2, 0.1]), 2)
    single, _ = motion_quantities(SPUR, 1.8, settled(SPUR, 1.8, 1, [1.0925, 0.0]))
    assert (double.lowest, double.highest) == pytest.approx((0.90521, 1.28247), abs=1e-5)
    assert (single.lowest, single.highest) == pytest.approx((1.06818, 1.11706), abs=1e-5)


def test_without_contact_loss_the_force_is_that_of_a_spring():
    # Static closed contact of constant stiffness: the force is the static one, and nothing varies.
    model = published(alpha=0.0, f_e=0.0)
    system = gear_system(model)
    closed = system.stiffness + np.outer(system.force, system.contact)
    rest = np.linalg.solve(closed, system.load[0].real + model.b * system.force)
    found, _ = motion_quantities(model, 0.7, np.concatenate([rest, np.zeros(system.degrees)]))
    assert found.dynamic_factor == pytest.approx(1.0, abs=1e-12)
    assert found.rms < 1e-12 and found.error_peak_to_peak < 1e-12 and found.contact_loss == 0.0
    assert found.support_force == pytest.approx(np.max(np.abs(model.direction)) * model.f_pm / model.rotation)


def test_slots_are_the_fields():
    assert [slot.name.lower() for slot in Slot] == [field.name for field in dataclasses.fields(Quantities)]


def test_bad_input_is_named():
    for call, name in (
        (lambda: motion_quantities(published(), 0.6, np.zeros(3)), "state"),
        (lambda: motion_quantities(published(), 0.6, np.zeros(4), 0), "periods"),
        (lambda: motion_quantities(published(), -1.0, np.zeros(4)), "omega"),
        (lambda: motion_quantities("gear", 0.6, np.zeros(4)), "system"),
    ):
        with pytest.raises(ParameterError, match=f"^{name} ="):
            call()


@pytest.mark.parametrize("axis, value", [("k_support", 1.3), ("f_e", 0.3), ("pressure_angle", 25.0), ("f_pm", 0.2)])
@pytest.mark.parametrize("separate", [False, True])
def test_what_is_read_moves_with_the_axis(axis, value, separate):
    along = gauge_at(*packed(UNEQUAL, axis, 0.7, 1, 1), value, separate)
    there = gauge_at(*packed(UNEQUAL.replace(**{axis: value}), "omega", None, 1, 1), 0.7, separate)
    for one, other in zip(along, there, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14)
    model = UNEQUAL.replace(**{axis: value})
    assert along.seen.size == gear_system(model, separate=separate).degrees
    # With one stiffness of all supports, those of the gears' inner pairs still differ in damping and mass.
    assert along.numbers[2] == float(separate) and (along.supports.size > 0) == separate


def test_of_another_system_only_its_displacement_is_read():
    spring = ContactSystem([[1.0]], [[0.1]], [[0.0]], [1.0], [1.0], 1.0, 1.0, load=[[0.5], [0.3]])
    found = gauge_at(*packed(spring, "omega", None, 1, 1), 0.6, False)
    assert found.seen.size == found.supports.size == 0 and found.numbers[1] == 0.0
