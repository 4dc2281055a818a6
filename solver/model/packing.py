"""Gears and systems as the vectors that kernels read: every slot is named in `solver.model.parameters`."""

import numpy as np

from solver.model.checks import ParameterError, finite_number, frequency, instance_of, one_of
from solver.model.contact_system import ContactSystem, reduced
from solver.model.gear_model import GEOMETRIC, SCALAR_PARAMETERS, Model
from solver.model.parameters import (
    ALPHA,
    ALPHA_2,
    ALPHA_2_PHASE,
    ALPHA_PHASE,
    BACK_GAP,
    CONE,
    DEGREES,
    F_E,
    F_E_PHASE,
    F_PM,
    F_PV,
    FRONT_GAP,
    GEAR,
    GEAR_SIZE,
    HARMONICS,
    K_SUPPORT,
    KAPPA,
    KIND,
    LOADS,
    MESH_FREQUENCY,
    OMEGA,
    PAIRS,
    PERIOD,
    PRESSURE,
    ROTATION,
    ROTATION_GEOMETRIC,
    SIGMA,
    SIGN,
    STIFFNESSES,
    SYSTEM,
    VARIATION_R,
    VARIATION_T,
    XI_MESH,
    XI_SUPPORT,
    XI_TRANSLATION,
    B,
)

__all__ = ["AXES", "SYSTEM_AXES", "axis_vectors", "check_axis", "gear_vectors", "packed", "parameter_vector"]

#: Everything that may be an axis of a plane or of a continuation.
AXES = ("omega", *SCALAR_PARAMETERS)

#: What may be varied of a `ContactSystem`: the frequency, both gaps, the first harmonic of the stiffness, and a factor
#: on the oscillating part of the load.
SYSTEM_AXES = ("omega", "gap", "alpha", "excitation")

# Where each scalar parameter begins in the vector of a gear, and how many numbers it takes.
_SLOTS = {
    name: slice(first, first + count)
    for name, first, count in (
        ("omega", OMEGA, 1),
        ("b", B, 1),
        ("alpha", ALPHA, 1),
        ("alpha_phase", ALPHA_PHASE, 1),
        ("f_e", F_E, 1),
        ("f_e_phase", F_E_PHASE, 1),
        ("f_pm", F_PM, 1),
        ("f_pv", F_PV, 1),
        ("xi_mesh", XI_MESH, 1),
        ("kappa", KAPPA, 2),
        ("xi_translation", XI_TRANSLATION, 2),
        ("xi_support", XI_SUPPORT, 6),
        ("k_support", K_SUPPORT, 6),
        ("pitch_cone_angle", CONE, 1),
        ("pressure_angle", PRESSURE, 1),
        ("translation_coupling", SIGMA, 1),
        ("rotation_coupling", ROTATION, 1),
        ("variation_translation", VARIATION_T, 1),
        ("variation_rotation", VARIATION_R, 1),
    )
}


def parameter_vector(model: Model, omega: float) -> np.ndarray:
    """The model at one frequency as the flat vector that kernels read, of shape (34,); angles in degrees."""
    parameters = np.zeros(GEAR_SIZE)
    parameters[OMEGA] = omega
    for name in SCALAR_PARAMETERS:
        value = getattr(model, name)
        parameters[_SLOTS[name]] = 0.0 if value == GEOMETRIC else value
    parameters[SIGMA] = model.sigma
    parameters[ROTATION_GEOMETRIC] = float(model.rotation_coupling == GEOMETRIC)
    if model.alpha_harmonics:
        parameters[ALPHA_2], parameters[ALPHA_2_PHASE] = model.alpha_harmonics[0]
    return parameters


def axis_vectors(model: Model, axis: str, omega: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """`parameters` with the axis set to 0, and `parameter_slope`, what the axis adds to them.

    Parameters
    ----------
    model : Model
    axis : str
        One of `AXES`.
    omega : float, optional
        The frequency; needed unless it is the axis.

    Returns
    -------
    parameters, parameter_slope : (34,) arrays

    Raises
    ------
    ParameterError
        If the axis is unknown.
    """
    if axis not in AXES:
        raise ParameterError("axis", axis, f"one of {', '.join(AXES)}")
    parameters = parameter_vector(model, 0.0 if axis == "omega" else omega)
    parameter_slope = np.zeros(GEAR_SIZE)
    parameters[_SLOTS[axis]] = 0.0
    parameter_slope[_SLOTS[axis]] = 1.0
    if axis == "rotation_coupling":
        parameters[ROTATION_GEOMETRIC] = 0.0
    return parameters, parameter_slope


def check_axis(system: Model | ContactSystem, axis: str, low: float, high: float, omega: float | None) -> None:
    """Refuse what no balance over an axis can be made of.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        One of `AXES`, or of `SYSTEM_AXES` for a ContactSystem.
    low, high : float
        Range of the axis.
    omega : float or None
        The mesh frequency, > 0; needed unless it is the axis.

    Raises
    ------
    ParameterError
        If the axis is unknown, its ends do not ascend, an end is not allowed, or the frequency is missing.
    """
    instance_of("system", system, Model, ContactSystem)
    gear = isinstance(system, Model)
    one_of("axis", axis, AXES if gear else SYSTEM_AXES)
    finite_number("high", high, above=finite_number("low", low))
    if axis == "omega":
        frequency(low)
    if axis != "omega" or omega is not None:
        frequency(omega)
    if axis == "omega":
        return
    if gear:
        for value in (low, high):
            system.replace(**{axis: value})
    elif axis == "gap" and system.two_sided:
        finite_number("gap", low, at_least=0.0)


def packed(system: Model | ContactSystem, axis: str, omega: float | None, order: int, period: int):
    """`parameters` with the axis at 0, and what it adds to them, for a balance of order H/nu on nu periods 2 pi/Omega.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        One of `AXES`, or of `SYSTEM_AXES` for a ContactSystem.
    omega : float or None
        The mesh frequency; needed unless it is the axis.
    order, period : int
        Harmonics of the mesh frequency, and nu.

    Returns
    -------
    parameters, parameter_slope : arrays of one length

    Raises
    ------
    ParameterError
        If the axis is unknown.
    """
    if not isinstance(system, Model):
        return _system(system, axis, omega, order, period)
    vectors = axis_vectors(system, axis, omega)
    # The first pairs are parameters that may be axes; the others are fixed.
    return gear_vectors(*vectors, system.stiffness_harmonics()[1:], system.error_harmonics()[1:], order, period)


def gear_vectors(
    parameters, parameter_slope, stiffness, errors, order: int, period: int
) -> tuple[np.ndarray, np.ndarray]:
    """Vectors of `packed` from those of a gear.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        `axis_vectors` of the gear.
    stiffness, errors : sequence of (amplitude, phase)
        Harmonics 2, 3, ... of the mesh stiffness and of the transmission error.
    order, period : int
        Harmonics of the mesh frequency, and nu.
    """
    vectors = []
    for vector, constant in ((parameters, 1.0), (parameter_slope, 0.0)):
        head = np.zeros(PAIRS)
        counts = GEAR, order * period, period, 1 + len(stiffness), 1 + len(errors), 1.0
        head[[KIND, HARMONICS, PERIOD, STIFFNESSES, LOADS, SIGN]] = np.multiply(constant, counts)
        head[[MESH_FREQUENCY, FRONT_GAP, BACK_GAP]] = vector[[OMEGA, B, B]]
        further, rest = (constant * np.array(pairs, dtype=float).ravel() for pairs in (stiffness, errors))
        vectors.append([head, vector[[ALPHA, ALPHA_PHASE]], further, vector, vector[[F_E, F_E_PHASE]], rest])
    return np.concatenate(vectors[0]), np.concatenate(vectors[1])


def _system(system: ContactSystem, axis: str, omega: float | None, order: int, period: int):
    if axis not in SYSTEM_AXES:
        raise ParameterError("axis", axis, f"one of {', '.join(SYSTEM_AXES)}")
    system = reduced(system)
    pairs = np.array(system.stiffness_harmonics or ((0.0, 0.0),), dtype=float)
    size = max(len(system.load), len(system.inertial_load))
    loads = [np.zeros((size, system.degrees), dtype=complex) for _ in range(2)]
    for target, source in zip(loads, (system.load, system.inertial_load), strict=True):
        target[: len(source)] = source
    closed = system.stiffness + np.outer(system.force, system.contact)
    sign = np.sign(np.linalg.det(closed))
    if sign == 0.0:
        raise ParameterError(
            "stiffness", system.stiffness, "such that closing the contact makes the system statically stable"
        )
    # A contact that is stiffer than what carries it makes the equations small; a power of 2 changes nothing else.
    stiffer = abs(system.contact @ np.linalg.pinv(system.stiffness) @ system.force)
    sign *= 2.0 ** max(0.0, np.round(np.log2(max(stiffer, 1.0))))
    head = np.zeros(PAIRS)
    head[[KIND, HARMONICS, PERIOD]] = SYSTEM, order * period, period
    head[[STIFFNESSES, LOADS, DEGREES, SIGN]] = len(pairs), size - 1, system.degrees, sign
    head[MESH_FREQUENCY], head[FRONT_GAP], head[BACK_GAP] = omega or 0.0, system.front_gap, system.back_gap
    head_along, pairs_along = np.zeros(PAIRS), np.zeros_like(pairs)
    if axis == "omega":
        head[MESH_FREQUENCY], head_along[MESH_FREQUENCY] = 0.0, 1.0
    elif axis == "gap":
        head_along[FRONT_GAP], head[FRONT_GAP] = 1.0, 0.0
        if system.two_sided:
            head_along[BACK_GAP], head[BACK_GAP] = 1.0, 0.0
    elif axis == "alpha":
        pairs[0, 0], pairs_along[0, 0] = 0.0, 1.0
    constant = [system.mass, system.damping, system.stiffness, system.contact, system.force, system.varying_force]
    along = [np.zeros_like(part) for part in constant] + [np.zeros_like(load) for load in loads]
    if axis == "excitation":
        for load, load_along in zip(loads, along[-2:], strict=True):
            load_along[1:], load[1:] = load[1:], 0.0
    ahead, behind = ([part.view(float).ravel() for part in parts] for parts in ([*constant, *loads], along))
    return np.concatenate([head, pairs.ravel(), *ahead]), np.concatenate([head_along, pairs_along.ravel(), *behind])
