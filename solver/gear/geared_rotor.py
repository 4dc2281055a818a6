"""Pinion and wheel on flexible supports, with shafts and what they drive: a geared rotor along its line of action.

Each gear moves along the line of action by y_g on its support and turns by theta_g; at the far end of its shaft there
may be one more inertia. With arcs u = R theta, base radii R and J = I/R^2,

    m_g y_g'' + c_g y_g' + k_g y_g = -+ [k_m(t) f(lambda) + c_m lambda']
    J u'' + shafts = torques/R -+ the same at both gears
    lambda = u_1 - u_2 + y_1 - y_2 - e(t)

The whole train may turn freely, which no force between its parts feels: only differences of neighbouring arcs enter,
r = T u, with T M_u^-1 T^T the inverse of their mass matrix. The error e goes over to the right-hand side, where it acts
on r as an inertial load. Without supports and shafts one coordinate is left, the spur pair (Kahraman and Singh 1991, J.
Sound Vib. 144(3), 469-506; docs/physics.md, section 9).
"""

from collections.abc import Sequence

import numpy as np

from solver.model.checks import ParameterError, finite_number, finite_numbers
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Harmonics, harmonic_pairs

__all__ = ["equivalent_mass", "geared_rotor"]

Two = Sequence[float]


def equivalent_mass(inertia: Two, base_radius: Two) -> float:
    """m_e of both gears along the line of action: 1/m_e = R_1^2/I_1 + R_2^2/I_2.

    Raises
    ------
    ParameterError
        If they are not two numbers above 0 each.
    """
    inertia, radius = (
        np.array(finite_numbers(name, value, 2, above=0.0))
        for name, value in (("inertia", inertia), ("base_radius", base_radius))
    )
    return float(1.0 / np.sum(radius**2 / inertia))


def geared_rotor(
    inertia: Two,
    base_radius: Two,
    mesh_stiffness: float,
    mesh_damping: float,
    half_backlash: float,
    torque: float,
    *,
    mass: Two | None = None,
    support_stiffness: Two | None = None,
    support_damping: Two | None = None,
    far_inertia: Two | None = None,
    shaft_stiffness: Two | None = None,
    shaft_damping: Two | None = None,
    stiffness_harmonics: Harmonics = (),
    error_harmonics: Harmonics = (),
    torque_harmonics: Harmonics = (),
    **law: float,
) -> ContactSystem:
    """A geared rotor in any consistent units; values of two are the pinion's and the wheel's.

    Parameters
    ----------
    inertia, base_radius : (2,)
        I and R, > 0.
    mesh_stiffness, mesh_damping : float
        Mean k_m > 0 and c_m >= 0 along the line of action.
    half_backlash : float
        Along the line of action, >= 0.
    torque : float
        Of the driver: at the pinion, or at the far end of its shaft. The load's is in balance with it.
    mass, support_stiffness, support_damping : (2,), optional
        Of the supports along the line of action, mass and stiffness > 0, damping >= 0; all of them, or none for rigid
        supports.
    far_inertia, shaft_stiffness, shaft_damping : (2,), optional
        Inertias at the far ends of the shafts, > 0, and the shafts' torsional stiffness > 0 and damping >= 0; all of
        them or none.
    stiffness_harmonics, error_harmonics, torque_harmonics : sequence of (amplitude, phase)
        Of harmonics 1, 2, ... of the stiffness over its mean, of e and of the driver's torque; phases in rad.
    **law : float
        What else the contact does: `back_stiffness`, `contact_dashpot` of `ContactSystem`.

    Returns
    -------
    ContactSystem
        Coordinates: y_1, y_2 where supports are flexible, then the differences r of neighbouring arcs along the train,
        among them u_1 - u_2 - e.

    Raises
    ------
    ParameterError
        Naming the parameter, its value and what is allowed.

    Examples
    --------
    >>> rotor = geared_rotor([1.0, 2.0], [1.0, 1.0], 1.0, 0.1, 1.0, 0.2, mass=[1.0, 1.0],
    ...     support_stiffness=[2.0, 2.0], support_damping=[0.05, 0.05])
    >>> rotor.degrees, rotor.contact.tolist()
    (3, [1.0, -1.0, 1.0])
    """
    J, radius = _of_two("inertia", inertia, above=0.0), _of_two("base_radius", base_radius, above=0.0)
    stiffness = finite_number("mesh_stiffness", mesh_stiffness, above=0.0)
    damping = finite_number("mesh_damping", mesh_damping, at_least=0.0)
    gap = finite_number("half_backlash", half_backlash, at_least=0.0)
    arcs, far = J / radius**2, None
    supports = _together(
        mass=(mass, {"above": 0.0}),
        support_stiffness=(support_stiffness, {"above": 0.0}),
        support_damping=(support_damping, {"at_least": 0.0}),
    )
    shafts = _together(
        far_inertia=(far_inertia, {"above": 0.0}),
        shaft_stiffness=(shaft_stiffness, {"above": 0.0}),
        shaft_damping=(shaft_damping, {"at_least": 0.0}),
    )
    if shafts is not None:
        far, *shafts = (part / radius**2 for part in shafts)
        arcs = np.array([far[0], *arcs, far[1]])
    # Differences of neighbouring arcs; the mesh is between the two gears.
    differences = -np.diff(np.eye(arcs.size), axis=0)
    turning = np.linalg.inv(differences / arcs @ differences.T)
    mesh, turns = (arcs.size - 1) // 2, arcs.size - 1
    held = 0 if supports is None else 2
    n = held + turns
    M, C, K = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    M[held:, held:] = turning
    contact = np.zeros(n)
    contact[held + mesh] = 1.0
    if supports is not None:
        contact[:2] = 1.0, -1.0
        for matrix, part in ((M, supports[0]), (K, supports[1]), (C, supports[2])):
            matrix[:2, :2] = np.diag(part)
    if shafts is not None:
        for matrix, part in zip((K, C), shafts, strict=True):
            matrix[[held, n - 1], [held, n - 1]] = part
    C += damping * np.outer(contact, contact)
    # What the driver's force and the load's, which balances its mean, do to the differences.
    driver = turning @ (differences[:, 0] / arcs[0])
    both = driver - turning @ (differences[:, -1] / arcs[-1])
    torques = harmonic_pairs("torque_harmonics", torque_harmonics)
    load = np.zeros((len(torques) + 1, n), dtype=complex)
    load[0, held:] = both * finite_number("torque", torque) / radius[0]
    for l, (amplitude, phase) in enumerate(torques, start=1):
        load[l, held:] = driver * amplitude / radius[0] * np.exp(1j * phase)
    errors = harmonic_pairs("error_harmonics", error_harmonics)
    inertial = np.zeros((len(errors) + 1, n), dtype=complex)
    for l, (amplitude, phase) in enumerate(errors, start=1):
        inertial[l, held:] = turning[:, mesh] * amplitude * np.exp(1j * phase)
    force = stiffness * contact
    harmonics = harmonic_pairs("stiffness_harmonics", stiffness_harmonics)
    return ContactSystem(M, C, K, contact, force, gap, gap, force, harmonics, load, inertial, **law)


def _of_two(name: str, value, **bounds: float) -> np.ndarray:
    return np.array(finite_numbers(name, value, 2, **bounds))


def _together(**given) -> list[np.ndarray] | None:
    """Values of two that are all there, as arrays; None where none is."""
    missing = [name for name, (value, _) in given.items() if value is None]
    if len(missing) == len(given):
        return None
    if missing:
        others = ", ".join(name for name in given if name not in missing)
        raise ParameterError(missing[0], None, f"given, as {others} is")
    return [_of_two(name, value, **bounds) for name, (value, bounds) in given.items()]
