"""Gear pairs in SI units: a hand-worked example, the Lagrangian, round trips, blanks, and fits of a mesh cycle."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from solver import Blank, GearPair, ParameterError, Scales, fit_cycle
from solver.contact.dead_zone import dead_zone
from tests.solver.model.test_virtual_work import model_accelerations

SEEDS = st.integers(0, 2**32 - 1)
STEP = 1e-30


def hand_worked(**changes) -> GearPair:
    values = dict(
        teeth=(20, 40),
        module=0.005,
        shaft_angle=90.0,
        pressure_angle=20.0,
        face_width=0.03,
        mass=(2.0, 5.0),
        inertia=(0.002, 0.016),
        support_stiffness=2e8,
        support_damping=1000.0,
        mesh_stiffness=4e8,
        mesh_damping_ratio=0.05,
        half_backlash=50e-6,
        torque=200.0,
        mesh_stiffness_harmonics=[(8e7, 0.5)],
        error_harmonics=[(1e-5, 0.25), (2e-6, -1.0)],
        torque_fluctuation=20.0,
    )
    return GearPair(**{**values, **changes})


def random_pair(seed) -> GearPair:
    draw = np.random.default_rng(seed).uniform
    teeth = np.random.default_rng(seed + 1).integers(10, 60, 2).tolist()
    k_m = draw(1e8, 8e8)
    return GearPair(
        teeth=teeth,
        module=draw(2e-3, 8e-3),
        shaft_angle=draw(40.0, 150.0),
        pressure_angle=draw(14.0, 30.0),
        face_width=draw(4e-3, 8e-3),
        mass=draw(0.3, 5.0, 2),
        inertia=draw(2e-4, 2e-2, 2),
        support_stiffness=draw(5e7, 9e8, 6),
        support_damping=draw(50.0, 2000.0, 6),
        mesh_stiffness=k_m,
        mesh_damping_ratio=draw(0.02, 0.15),
        half_backlash=draw(1e-5, 1e-4),
        torque=draw(20.0, 400.0),
        load_torque=draw(20.0, 400.0),
        mesh_stiffness_harmonics=[(k_m * draw(0.0, 0.3), draw(-3, 3)) for _ in range(3)],
        error_harmonics=[(draw(1e-6, 2e-5), draw(-3, 3)) for _ in range(3)],
        torque_fluctuation=draw(0.0, 50.0),
        reference_length=draw(1e-5, 1e-4),
    )


def test_every_number_of_a_hand_worked_example():
    """u = 2 at a right angle: tan delta_1 = 1/2, sin = 0.4472136, cos = 0.8944272."""
    pair = hand_worked()
    assert pair.ratio == 2.0
    assert pair.cone_angles == pytest.approx((26.56505118, 63.43494882), rel=1e-9)
    assert pair.cone_distance == pytest.approx(0.05 / 0.4472135955, rel=1e-9)  # 0.1118034 m
    # r_1 = 0.05 - 0.015 x 0.4472136, r_2 = 0.1 - 0.015 x 0.8944272
    assert pair.mean_radii == pytest.approx([0.0432917961, 0.0865835921], rel=1e-9)
    # 1/m_e = r_1^2/J_1 + r_2^2/J_2 = 0.93708980 + 0.46854490 = 1.40563471
    assert pair.equivalent_mass == pytest.approx(0.7114223890, rel=1e-8)
    assert pair.frequency_unit == pytest.approx(23711.893261, rel=1e-9)  # sqrt(4e8/0.7114224)
    assert pair.mesh_damping == pytest.approx(1686.917175, rel=1e-9)  # 2 x 0.05 x 0.7114224 x 23711.89
    assert pair.torques == pytest.approx((200.0, 400.0))
    model = pair.model()
    assert (model.b, model.alpha, model.alpha_phase) == pytest.approx((1.0, 0.2, 0.5))
    assert (model.f_e, model.f_e_phase, *model.f_e_harmonics[0]) == pytest.approx((0.2, 0.25, 0.04, -1.0))
    # cos 20 degrees x 200/0.0432918/(4e8 x 5e-5) = 0.9396926 x 4619.813/20000
    assert model.f_pm == pytest.approx(0.2170602, rel=1e-6)
    # cos 20 degrees x 0.7114224 x 0.0432918 x 20/0.002/20000
    assert model.f_pv == pytest.approx(0.01447068, rel=1e-6)
    assert model.kappa == pytest.approx((0.3557111945, 0.1422844778), rel=1e-8)
    assert model.xi_translation == pytest.approx((0.0177855597, 0.0071142239), rel=1e-8)
    # 2e8/(2 x 5.62256e8), 2e8/(5 x 5.62256e8); Omega_n^2 = 4e8/0.7114224 = 5.622539e8
    assert model.k_support[::3] == pytest.approx((0.1778555972, 0.0711422389), rel=1e-8)
    assert model.xi_support[::3] == pytest.approx((1000 / (4 * 23711.893261), 1000 / (10 * 23711.893261)), rel=1e-9)
    assert (model.pitch_cone_angle, model.sigma) == pytest.approx((26.56505118, 1.0), rel=1e-9)
    assert model.rotation == pytest.approx(0.8830222216, rel=1e-9)
    table = Scales(pair).table
    # 23711.9/20 rad/s x 30/pi; 23711.9/(2 pi); 200 N m/0.2170602
    assert table["omega"].shown == pytest.approx(11321.6, rel=1e-5)
    assert table["mesh_frequency"].shown == pytest.approx(3773.87, rel=1e-5)
    assert table["f_pm"].shown == pytest.approx(921.403, rel=1e-5)
    # 5e-5 m x 23711.9 rad/s; 4e8 N/m x 5e-5 m
    assert (table["velocity"].shown, table["force"].shown) == pytest.approx((1.18559466, 20000.0), rel=1e-8)
    assert (table["b"].shown, table["f_e"].shown, table["alpha"].shown) == pytest.approx((50.0, 50.0, 400.0))


# From energies, by differentiation


def mesh_displacement(pair: GearPair, q):
    """Lambda_n of (X1, Y1, Z1, X2, Y2, Z2, theta1, theta2) without the error, complex coordinates allowed.

    The unit normal is put together from the pair of directions that span the common tangent plane of the pitch cones.
    """
    cone, pressure = np.radians(pair.cone_angles[0]), np.radians(pair.pressure_angle)
    across = np.array([np.cos(cone), np.sin(cone), 0.0])
    normal = np.sin(pressure) * across + np.cos(pressure) * np.array([0.0, 0.0, 1.0])
    apart = np.array([q[0] - q[3], -(q[1] - q[4]), -(q[2] - q[5])])
    first, second = pair.mean_radii
    return normal @ apart + normal[2] * (first * q[6] - second * q[7])


def gradient(function, at):
    return np.array([function(at + 1j * STEP * unit).imag / STEP for unit in np.eye(len(at))])


def hessian(function, count):
    """Of a quadratic form: complex step of central differences, which are exact for it."""
    rows = []
    for unit in np.eye(count):
        rows.append(0.5 * (gradient(function, unit + 0j) - gradient(function, -unit + 0j)))
    return np.array(rows)


def lagrangian(pair: GearPair):
    """Mass, support damping and support stiffness (8, 8), and the gradient of Lambda_n, from T, dissipation and V."""
    masses = [*np.repeat(pair.mass, 3), *pair.inertia]
    mass = hessian(lambda v: 0.5 * sum(m * w**2 for m, w in zip(masses, v, strict=True)), 8)
    damping = hessian(lambda v: 0.5 * sum(c * w**2 for c, w in zip(pair.support_damping, v[:6], strict=True)), 8)
    stiffness = hessian(lambda q: 0.5 * sum(k * w**2 for k, w in zip(pair.support_stiffness, q[:6], strict=True)), 8)
    return mass, damping, stiffness, gradient(lambda q: mesh_displacement(pair, q), np.zeros(8, complex))


def c_h(pair):
    """2 xi_h m_e Omega_n = 2 xi_h sqrt(k_m m_e), m_e from the rotations' share of the mesh's mobility over a3^2."""
    _, _, _, n = lagrangian(pair)
    mobility = sum(n[6 + g] ** 2 / pair.inertia[g] for g in (0, 1)) / np.cos(np.radians(pair.pressure_angle)) ** 2
    return 2.0 * pair.mesh_damping_ratio * np.sqrt(pair.mesh_stiffness / mobility), 1.0 / mobility


@given(SEEDS)
def test_the_dimensionless_set_is_that_of_the_lagrangian(seed):
    """The eight equations, multiplied by the transformation to (x, lambda), rescaled, against the model's matrices."""
    pair = random_pair(seed)
    mass, damping, stiffness, n = lagrangian(pair)
    mesh_damping, m_e = c_h(pair)
    unit = np.sqrt(pair.mesh_stiffness / m_e)
    # Rows of M8^-1 forces: translations as they are, and psi'' = the rotations' part of n . q''.
    mobility = np.linalg.inv(mass)
    rows = np.vstack([np.eye(8)[:6], np.r_[np.zeros(6), n[6:]]])
    model = pair.model()
    model_mass, model_damping, model_stiffness = model.matrices()
    translation, rotation = model.mesh_vectors()
    # lambda = n . q: in the last row lambda'' - d . x'' = psi''.
    np.testing.assert_allclose(model_mass[6], np.r_[-n[:6], 1.0], rtol=0, atol=1e-14)
    contact = rows @ mobility @ n
    np.testing.assert_allclose(translation + rotation, contact * pair.mesh_stiffness / unit**2, rtol=1e-11, atol=1e-14)
    np.testing.assert_allclose(model_damping[:, 6], contact * mesh_damping / unit, rtol=1e-11, atol=1e-14)
    np.testing.assert_allclose(model_damping[:6, :6], (mobility @ damping)[:6, :6] / unit, rtol=1e-11, atol=1e-14)
    scaled = (mobility @ stiffness)[:6, :6] / unit**2
    np.testing.assert_allclose(model_stiffness[:6, :6], scaled, rtol=1e-11, atol=1e-14)
    # Virtual work of the torques; and -e'' on the right-hand side of lambda = n . q - e.
    scale = pair.length_unit * unit**2
    work = [
        gradient(lambda q: drive * q[6] - load * q[7], np.zeros(8, complex))
        for drive, load in (pair.torques, (pair.torque_fluctuation, 0.0))
    ]
    mean, varying = (float((rows @ mobility @ force)[6]) / scale for force in work)
    omega = 0.7
    expected = np.zeros(4, complex)
    expected[0], expected[1] = mean, varying
    for l, (amplitude, phase) in enumerate(pair.error_harmonics, start=1):
        expected[l] += amplitude * (l * omega * unit) ** 2 * np.exp(1j * phase) / scale
    np.testing.assert_allclose(model.load_harmonics(omega, 3), expected, rtol=1e-11, atol=1e-14)


@given(SEEDS)
def test_the_identities_hold_by_construction(seed):
    pair = random_pair(seed)
    model = pair.model()
    assert model.kappa == pytest.approx(pair.equivalent_mass / np.array(pair.mass), rel=1e-12)
    assert model.xi_translation == pytest.approx(model.xi_mesh * np.array(model.kappa), rel=1e-12)
    assert model.direction[:3] @ model.direction[:3] == pytest.approx(1.0, rel=1e-12)
    assert model.rotation == pytest.approx(model.direction[2] ** 2, rel=1e-12)
    (j1, j2), (r1, r2), (t1, t2) = pair.inertia, pair.mean_radii, pair.torques
    m_e = j1 * j2 / (r1**2 * j2 + r2**2 * j1)
    load = pair.tangential * m_e * (r1 * t1 / j1 + r2 * t2 / j2) / (pair.mesh_stiffness * pair.length_unit)
    assert model.f_pm == pytest.approx(load, rel=1e-12)
    balanced = dataclasses.replace(pair, load_torque=None)
    assert balanced.model().f_pm == pytest.approx(
        pair.tangential * t1 / r1 / (pair.mesh_stiffness * pair.length_unit), rel=1e-12
    )
    # tan delta_1 = sin Sigma/(u + cos Sigma), and both cones share the cone distance.
    distances = 0.5 * pair.module * np.array(pair.teeth) / np.sin(np.radians(pair.cone_angles))
    assert distances[0] == pytest.approx(distances[1], rel=1e-12)
    assert sum(pair.cone_angles) == pytest.approx(pair.shaft_angle)


def test_motion_of_the_dimensional_pair_is_that_of_the_model():
    pair = dataclasses.replace(random_pair(5), torque_fluctuation=0.0)
    mass, damping, stiffness, n = lagrangian(pair)
    mesh_damping, m_e = c_h(pair)
    unit, length, omega = np.sqrt(pair.mesh_stiffness / m_e), pair.length_unit, 0.6
    rate, torques = omega * unit, np.r_[np.zeros(6), pair.torques[0], -pair.torques[1]]

    def wave(harmonics, time, order):
        terms = (
            a * (l * rate) ** order * np.cos(l * rate * time + p + order * np.pi / 2)
            for l, (a, p) in enumerate(harmonics, start=1)
        )
        return sum(terms)

    def motion(time, y):
        gap, speed = n @ y[:8] - wave(pair.error_harmonics, time, 0), n @ y[8:] - wave(pair.error_harmonics, time, 1)
        k = pair.mesh_stiffness + wave(pair.mesh_stiffness_harmonics, time, 0)
        force = k * dead_zone(gap, pair.half_backlash) + mesh_damping * speed
        return np.r_[y[8:], np.linalg.solve(mass, torques - damping @ y[8:] - stiffness @ y[:8] - force * n)]

    model, end = pair.model(), 15.0
    start = np.zeros(16)
    begin = np.r_[np.zeros(6), -wave(pair.error_harmonics, 0.0, 0) / length]
    speeds = np.r_[np.zeros(6), -wave(pair.error_harmonics, 0.0, 1) / (length * unit)]
    settings = dict(method="DOP853", rtol=1e-9)
    physical = solve_ivp(motion, (0.0, end / unit), start, atol=1e-9 * length, **settings)
    scaled = solve_ivp(
        lambda tau, y: np.r_[y[7:], model_accelerations(model, omega, tau, y[:7], y[7:])],
        (0.0, end),
        np.r_[begin, speeds],
        atol=1e-9,
        **settings,
    )
    place = physical.y[:8, -1]
    gap = n @ place - wave(pair.error_harmonics, end / unit, 0)
    assert np.ptp(scaled.y[6]) > 1.0
    np.testing.assert_allclose(np.r_[place[:6], gap] / length, scaled.y[:7, -1], rtol=0, atol=1e-5)


@given(SEEDS, st.floats(0.01, 100.0))
def test_round_trips(seed, value):
    pair = random_pair(seed)
    scales = Scales(pair)
    for name in scales.table:
        assert scales.dimensionless(name, scales.physical(name, value)) == pytest.approx(value, rel=1e-14)
    # The physical value of each of the model's parameters is that of the pair.
    model, ends = (
        pair.model(),
        {
            "b": pair.half_backlash,
            "f_e": pair.error_harmonics[0][0],
            "alpha": pair.mesh_stiffness_harmonics[0][0],
            "f_pm": pair.torque,
            "f_pv": pair.torque_fluctuation,
            "xi_mesh": pair.mesh_damping,
        },
    )
    for name, number in ends.items():
        assert scales.physical(name, getattr(model, name)) == pytest.approx(number, rel=1e-12, abs=1e-14)
    assert scales.physical("k_support", model.k_support[0]) == pytest.approx(pair.support_stiffness[0], rel=1e-12)
    assert scales.physical("xi_support", model.xi_support[0]) == pytest.approx(pair.support_damping[0], rel=1e-12)
    # Teeth meet z_1 times a turn of the pinion.
    turns = scales.physical("omega", value) / (2 * np.pi)
    assert scales.physical("mesh_frequency", value) == pytest.approx(pair.teeth[0] * turns, rel=1e-12)
    # And a pair made again from what a plan keeps is the same one.
    assert GearPair(**dataclasses.asdict(pair)) == pair


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("teeth", (20, 0)),
        ("teeth", (20.0, 20)),
        ("teeth", (20,)),
        ("teeth", (True, 20)),
        ("module", 0.0),
        ("shaft_angle", 0.0),
        ("shaft_angle", 180.0),
        ("pressure_angle", 90.0),
        ("face_width", 0.12),
        ("face_width", -1.0),
        ("mass", (1.0, 0.0)),
        ("inertia", (1.0, 1.0, 1.0)),
        ("support_stiffness", 0.0),
        ("support_damping", -1.0),
        ("mesh_stiffness", -1.0),
        ("mesh_stiffness_harmonics", [(4.1e8, 0.0)]),
        ("mesh_damping_ratio", -0.1),
        ("half_backlash", -1e-6),
        ("error_harmonics", [(1.0,)]),
        ("torque", np.nan),
        ("reference_length", 0.0),
    ],
)
def test_impossible_pairs(name, value):
    with pytest.raises(ParameterError) as error:
        hand_worked(**{name: value})
    assert error.value.name.split("[")[0] == name


def test_no_backlash_needs_a_length_and_a_load_needs_a_drive():
    with pytest.raises(ParameterError, match="reference_length"):
        hand_worked(half_backlash=0.0)
    assert hand_worked(half_backlash=0.0, reference_length=5e-5).model().b == 0.0
    with pytest.raises(ParameterError, match="torque = 0.0"):
        hand_worked(torque=0.0, load_torque=5.0)
    assert Scales(hand_worked(torque=0.0)).table["f_pm"].size == pytest.approx(Scales(hand_worked()).table["f_pm"].size)


@pytest.mark.parametrize("sizes", [(0.08, 0.0574, 0.026, 0.02), (0.1, 0.1, 0.03, 0.0), (0.175, 0.12, 0.03, 0.09)])
def test_blanks_by_quadrature(sizes):
    large, small, width, bore = sizes
    blank = Blank(*sizes, density=7800.0)

    def profile(power):
        def ring(s):
            return (0.5 * (large + (small - large) * s / width)) ** power - (0.5 * bore) ** power

        return quad(ring, 0, width)[0]

    assert blank.mass == pytest.approx(7800.0 * np.pi * profile(2), rel=1e-10)
    assert blank.inertia == pytest.approx(7800.0 * np.pi / 2 * profile(4), rel=1e-10)


@pytest.mark.parametrize(
    "sizes", [(0.08, 0.09, 0.02, 0.0), (0.08, 0.06, 0.02, 0.06), (0.08, 0.06, 0.0, 0.0), (0.08, 0.06, 0.02, -1)]
)
def test_impossible_blanks(sizes):
    with pytest.raises(ParameterError):
        Blank(*sizes)


# Mesh cycle


def wave(angle, mean, harmonics):
    return mean + sum(a * np.cos(l * angle + p) for l, (a, p) in enumerate(harmonics, start=1))


@given(SEEDS)
def test_harmonics_are_found_from_uneven_angles(seed):
    generator = np.random.default_rng(seed)
    angle = (np.arange(24) + generator.uniform(-0.4, 0.4, 24)) * 2 * np.pi / 24 % (2 * np.pi)
    harmonics = [(generator.uniform(0.1, 1.0), generator.uniform(-3, 3)) for _ in range(3)]
    generator.shuffle(angle)
    fit = fit_cycle(angle, wave(angle, 5.0, harmonics), 3)
    assert fit.mean == pytest.approx(5.0, abs=1e-12) and fit.largest < 1e-12
    np.testing.assert_allclose(fit.harmonics, harmonics, rtol=0, atol=1e-11)


def test_what_a_fit_leaves_over():
    angle = np.arange(12) * 2 * np.pi / 12
    fit = fit_cycle(angle, wave(angle, 1.0, [(1.0, 0.3), (0.5, 0.0), (0.2, 0.0)]), 2)
    # On an even grid the third harmonic is orthogonal to the others and is left over whole: 0.2 cos(3 theta).
    assert (fit.rms, fit.largest) == pytest.approx((0.2 / np.sqrt(2.0), 0.2), rel=1e-12)


@pytest.mark.parametrize(
    ("angle", "count", "name", "said"),
    [
        (np.arange(6) * 1.0, 3, "count", "at most 2 for 6 points"),
        (np.arange(6) * 1.0, 0, "count", "whole number"),
        (np.arange(8) * 0.9, 1, "angle", "below 2 pi"),
        (np.array([0.0, 1.0, 2.0, 3.0, 3.0, 4.0, 5.0]), 2, "angle", "given once"),
        (np.arange(9) * 0.4, 2, "angle", "half a period"),
        (np.array([0.0, 1.0, np.nan]), 1, "angle", "finite"),
    ],
)
def test_cycles_that_cannot_be_fitted(angle, count, name, said):
    with pytest.raises(ParameterError, match=said) as error:
        fit_cycle(angle, np.zeros(angle.size), count)
    assert error.value.name == name
