"""The geared rotor against equations of motion in absolute coordinates, and against the spur pair."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import ParameterError, geared_rotor, spur_pair
from solver.gear.geared_rotor import equivalent_mass

TWO = st.tuples(st.floats(0.5, 3.0), st.floats(0.5, 3.0))
ERRORS = [(0.1, 0.3), (0.05, -1.0)]


def absolute(p, frequency, l, torque, error):
    """Amplitude of lambda of the linear rotor in contact, from coordinates y1, y2 and the angles of all inertias.

    A torque on the driver, and the error's kinematic motion e of the mesh: lambda = w . q - e.
    """
    inertias = [p["far_inertia"][0], *p["inertia"], p["far_inertia"][1]]
    M = np.diag([*p["mass"], *inertias])
    w = np.array([1.0, -1.0, 0.0, p["base_radius"][0], -p["base_radius"][1], 0.0])
    K, C = np.diag([*p["support_stiffness"], 0, 0, 0, 0]), np.diag([*p["support_damping"], 0, 0, 0, 0])
    for (a, b), k, c in zip(((2, 3), (4, 5)), p["shaft_stiffness"], p["shaft_damping"], strict=True):
        twist = np.zeros(6)
        twist[[a, b]] = 1.0, -1.0
        K, C = K + k * np.outer(twist, twist), C + c * np.outer(twist, twist)
    mesh = p["mesh_stiffness"] + 1j * l * frequency * p["mesh_damping"]
    Z = K - (l * frequency) ** 2 * M + 1j * l * frequency * C + mesh * np.outer(w, w)
    right = mesh * error * w
    right[2] += torque
    return w @ np.linalg.solve(Z, right) - error


@settings(max_examples=20, deadline=None)
@given(*(TWO,) * 8, st.floats(0.4, 2.5))
def test_the_linear_response_is_that_of_absolute_coordinates(i, r, m, k, far, shaft, c, d, frequency):
    p = dict(inertia=i, base_radius=r, mass=m, support_stiffness=k, far_inertia=far, shaft_stiffness=shaft)
    p |= dict(support_damping=c, shaft_damping=d, mesh_stiffness=2.0, mesh_damping=0.3)
    rotor = geared_rotor(**p, half_backlash=0.0, torque=0.7, error_harmonics=ERRORS, torque_harmonics=[(0.2, 0.9)])
    assert rotor.degrees == 5
    loads = rotor.load_harmonics(frequency, 2)
    for l, (amplitude, phase) in enumerate(ERRORS, start=1):
        closed = rotor.dynamic_stiffness(l * frequency) + np.outer(rotor.force, rotor.contact)
        found = rotor.contact @ np.linalg.solve(closed, loads[l])
        torque = 0.2 * np.exp(0.9j) if l == 1 else 0.0
        wanted = absolute(p, frequency, l, torque, amplitude * np.exp(1j * phase))
        assert abs(found - wanted) < 1e-10 * max(abs(wanted), 1.0)
    # At rest the mesh carries the torque.
    static = np.linalg.solve(rotor.stiffness + np.outer(rotor.force, rotor.contact), loads[0].real)
    assert 2.0 * rotor.contact @ static == pytest.approx(0.7 / r[0], rel=1e-10)


def test_on_rigid_supports_it_is_the_spur_pair():
    """With I_1/R_1^2 = 2, I_2/R_2^2 = 3: m_e = 6/5; in units of k_m = 30 and omega_n = 5 the same numbers."""
    me, stiffness, gap = equivalent_mass([0.5, 3.0], [0.5, 1.0]), 30.0, 2e-3
    assert me == pytest.approx(1.2)
    harmonics = [(0.2, 0.4)]
    rotor = geared_rotor(
        [0.5, 3.0],
        [0.5, 1.0],
        stiffness,
        2.0 * 0.05 * me * 5.0,
        gap,
        0.1 * stiffness * gap * 0.5,
        stiffness_harmonics=harmonics,
        error_harmonics=[(0.01 * gap, 0.7)],
    )
    pair = spur_pair(0.05, 1.0, 0.1, stiffness_harmonics=harmonics, error_harmonics=[(0.01, 0.7)])
    assert rotor.degrees == 1 and rotor.front_gap == gap and rotor.stiffness_harmonics == pair.stiffness_harmonics
    np.testing.assert_allclose(rotor.mass / me, pair.mass, rtol=1e-13)
    np.testing.assert_allclose(rotor.damping / (me * 5.0), pair.damping, rtol=1e-13)
    np.testing.assert_allclose(rotor.force / stiffness, pair.force, rtol=1e-13)
    np.testing.assert_allclose(rotor.load_harmonics(4.0, 1) / stiffness / gap, pair.load_harmonics(0.8, 1), rtol=1e-13)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"mass": [1.0, 0.0]}, "mass[1]"),
        ({"mass": None}, "mass"),
        ({"support_damping": -1.0}, "support_damping"),
        ({"shaft_stiffness": [1.0, 1.0]}, "far_inertia"),
        ({"inertia": [1.0]}, "inertia"),
        ({"mesh_stiffness": 0.0}, "mesh_stiffness"),
        ({"half_backlash": -1e-9}, "half_backlash"),
        ({"torque_harmonics": 1.0}, "torque_harmonics"),
    ],
)
def test_wrong_values_are_named(changes, name):
    right = dict(inertia=1.0, base_radius=1.0, mesh_stiffness=1.0, mesh_damping=0.1, half_backlash=1.0, torque=0.1)
    right |= dict(mass=1.0, support_stiffness=2.0, support_damping=0.1)
    with pytest.raises(ParameterError) as caught:
        geared_rotor(**{**right, **changes})
    assert caught.value.name == name
