"""What public functions are called with: small gears, rows, planes and motions, computed once."""

import functools

import numpy as np

import solver
from solver import ContactSystem, Continuation, GearPair, GearTeeth, Model, Newton, ToothMesh, sweep_row
from solver.boundaries import boundary_curves, row_events
from solver.regions import regions
from tests.public import OBJECT, POSITIVE, optional

WRONG_OMEGA = optional(POSITIVE)

GRID = np.linspace(0.5, 0.8, 7)

GEAR = dict(b=1.0, alpha=0.2, f_e=0.2, f_pm=0.5, kappa=0.5, xi_mesh=0.05, xi_translation=0.0125, xi_support=0.01)
GEAR |= dict(k_support=1.0, pitch_cone_angle=45.0, pressure_angle=20.0, translation_coupling=0.3173)
GEAR |= dict(rotation_coupling=0.7719, variation_translation=1.0, variation_rotation=0.0)
GEAR |= dict(alpha_phase=0.0, alpha_harmonics=(), f_e_phase=0.0, f_e_harmonics=(), f_pv=0.0)

PAIR = dict(teeth=(20, 30), module=4e-3, shaft_angle=90.0, pressure_angle=20.0, face_width=0.02, mass=(0.8, 1.7))
PAIR |= dict(inertia=(5e-4, 2e-3), support_stiffness=1e8, support_damping=100.0, mesh_stiffness=2e8)
ROTOR = dict.fromkeys(
    ("inertia", "base_radius", "mass", "support_stiffness", "far_inertia", "shaft_stiffness"), (1.0, 2.0)
)
ROTOR |= dict(support_damping=(0.1, 0.1), shaft_damping=(0.1, 0.1))
ROTOR |= dict(mesh_stiffness=1.0, mesh_damping=0.1, half_backlash=1.0, torque=0.1)
PAIR |= dict(mesh_damping_ratio=0.05, half_backlash=5e-5, torque=100.0, mesh_stiffness_harmonics=((2e7, 0.0),))
PAIR |= dict(error_harmonics=((5e-6, 0.0),), load_torque=None, torque_fluctuation=0.0, reference_length=None)

TEETH = dict(teeth=20, module=4e-3, bore=0.03, pressure_angle=20.0, addendum=1.0, dedendum=1.25, profile_shift=0.1)
TEETH |= dict(edge_radius=None, youngs_modulus=206e9, poisson=0.3)

CORRECTOR, STEPS = Newton(), Continuation(max_points=400)


@functools.cache
def model() -> Model:
    return Model(**GEAR)


@functools.cache
def pair() -> GearPair:
    return GearPair(**PAIR)


@functools.cache
def teeth() -> GearTeeth:
    return GearTeeth(**TEETH)


@functools.cache
def tooth_mesh() -> ToothMesh:
    return ToothMesh(teeth(), teeth(), 0.02)


@functools.cache
def stop() -> ContactSystem:
    """A mass against two stops."""
    one = np.eye(1)
    return ContactSystem(one, 0.1 * one, 0.5 * one, [1.0], [1.0], 0.5, 0.5, load=[[0.1], [0.3]])


@functools.cache
def row(f_e: float = 0.2) -> solver.Row:
    return sweep_row(model().replace(f_e=f_e), "omega", GRID)


@functools.cache
def problem(balance=None):
    balance = solver.DescribingFunction() if balance is None else balance
    return balance.problem(model(), "omega", 0.5, 0.8)


@functools.cache
def starts():
    return row_events(row().curves, 0.2)


@functools.cache
def plane():
    found = [event for f_e in (0.1, 0.15, 0.2) for event in row_events(row(f_e).curves, f_e)]
    return boundary_curves(model(), "omega", "f_e", (0.5, 0.8), (0.1, 0.2), found)


@functools.cache
def divided():
    return regions(model(), "omega", "f_e", (0.5, 0.8), (0.1, 0.2), plane())


def wrong_settings() -> tuple:
    return optional((*OBJECT, Newton(), Continuation))


MOTION = np.array([0.6, 0.1, 0.2, 0.0, 0.0])
