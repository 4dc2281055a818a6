"""Systems whose motions are known, and an integration that shares no code with the solver."""

import numpy as np
from scipy.integrate import solve_ivp

from solver import Model, all_solutions
from solver.model.contact_system import ContactSystem, gear_system
from solver.timedomain import orbit_state


def flying_mass(front=1.0, back=np.inf, damping=0.0) -> ContactSystem:
    """Unit mass, free but for a unit spring behind each gap, without load."""
    return ContactSystem([[1.0]], [[damping]], [[0.0]], [1.0], [1.0], front, back)


def mathieu(a: float, q: float, damping: float = 0.0) -> ContactSystem:
    """y'' + 2 zeta y' + (a - 2 q cos 2 t) y = 0 at omega = 2: a contact without a gap is a linear spring."""
    return ContactSystem(
        [[1.0]], [[damping]], [[0.0]], [1.0], [a], 0.0, 0.0, varying_force=[1.0], stiffness_harmonics=[(-2.0 * q, 0.0)]
    )


def oscillator(damping: float) -> ContactSystem:
    """Linear y'' + 2 zeta y' + y = 0.5 + cos Omega tau."""
    return ContactSystem([[1.0]], [[2.0 * damping]], [[0.0]], [1.0], [1.0], 0.0, 0.0, load=[[0.5], [1.0]])


def full_gear_system(model: Model) -> ContactSystem:
    """The seven degrees of freedom of `Model.matrices`, nothing merged."""
    mass, damping, stiffness = model.matrices()
    translation, rotation = model.mesh_vectors()
    unit = np.eye(7)[6]
    inertial = np.zeros((len(model.error_harmonics()) + 1, 7), dtype=complex)
    for l, (amplitude, phase) in enumerate(model.error_harmonics(), start=1):
        inertial[l] = amplitude * np.exp(1j * phase) * unit
    return ContactSystem(
        mass,
        damping,
        stiffness,
        unit,
        translation + rotation,
        model.b,
        model.b,
        model.variation_translation * translation + model.variation_rotation * rotation,
        model.stiffness_harmonics(),
        [model.f_pm * unit, model.f_pv * unit],
        inertial,
    )


def first_order_state(model: Model, omega: float, which: int = -1):
    """Start from one of the first-order solutions, the largest amplitude unless told otherwise."""
    found = all_solutions(model, omega)
    system = gear_system(model)
    return system, orbit_state(system, omega, [found.mean[which], found.cos[which], found.sin[which]])


def field_of(system: ContactSystem, omega: float):
    """dz/dtau of z = (y, y'), as SciPy's integrators take it."""
    n = system.degrees
    inverse = np.linalg.inv(system.mass)
    order = max(len(system.load), len(system.inertial_load)) - 1
    loads = system.load_harmonics(omega, order)

    def field(time, z):
        variation = sum(
            alpha * np.cos(l * omega * time + phase)
            for l, (alpha, phase) in enumerate(system.stiffness_harmonics, start=1)
        )
        load = sum((loads[l] * np.exp(1j * l * omega * time)).real for l in range(order + 1))
        place, speed = system.contact @ z[:n], system.contact @ z[n:]
        contact = system.contact_force(place)
        rate = speed if place > system.front_gap else system.back_stiffness * speed if place < -system.back_gap else 0.0
        force = (system.force + system.varying_force * variation) * contact
        force = force + system.force * (system.contact_dashpot * rate + system.cubic * place**3)
        return np.concatenate([z[n:], inverse @ (load - system.damping @ z[n:] - system.stiffness @ z[:n] - force)])

    return field


def scipy_motion(system: ContactSystem, omega: float, state, stop: float):
    """End state and switch times with DOP853, restarted at every switch that its events find."""
    n, field = system.degrees, field_of(system, omega)

    def front(time, z):
        return system.contact @ z[:n] - system.front_gap

    def back(time, z):
        return system.contact @ z[:n] + system.back_gap

    front.terminal = back.terminal = True
    time, z, switches = 0.0, np.array(state, dtype=float), []
    while True:
        # A short first piece leaves the border, where the event would be found again.
        away = solve_ivp(field, (time, min(time + 1e-4, stop)), z, method="DOP853", rtol=1e-12, atol=1e-13)
        piece = solve_ivp(
            field,
            (away.t[-1], stop),
            away.y[:, -1],
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            events=(front, back),
            max_step=0.2,
        )
        time, z = piece.t[-1], piece.y[:, -1]
        if piece.status != 1:
            return z, np.array(switches)
        switches.append(time)
