"""Gears and systems as the vectors that kernels read: every slot is named in `solver.model.parameters`."""

import numpy as np

from solver.model.checks import ParameterError, finite_number, frequency, instance_of, one_of
from solver.model.contact_system import SYSTEM_AXES, ContactSystem, reduced
from solver.model.gear_model import GEOMETRIC, SCALAR_PARAMETERS, Model
from solver.model.parameters import (
    ALPHA,
    ALPHA_2,
    ALPHA_2_PHASE,
    ALPHA_PHASE,
    BACK_GAP,
    BACK_STIFFNESS,
    CONE,
    CUBIC,
    DASHPOT,
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

__all__ = [
    "AXES",
    "GAP_AXES",
    "SYSTEM_AXES",
    "axis_vectors",
    "bounded_change",
    "check_axis",
    "check_values",
    "dead_zone_ends",
    "gear_vectors",
    "packed",
    "parameter_vector",
]

#: Everything that may be an axis of a plane or of a continuation.
AXES = ("omega", *SCALAR_PARAMETERS)

#: Those of a gear and of a system that move the ends of the dead zone.
GAP_AXES = ("b", "gap", "gap_scale")

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
    finite_number("high", high, above=finite_number("low", low))
    check_values(system, axis, np.array([low, high]), omega)


def check_values(system: Model | ContactSystem, axis: str, values: np.ndarray, omega: float | None) -> None:
    """Refuse values of an axis that a system cannot have.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        One of `AXES`, or of `SYSTEM_AXES` for a ContactSystem.
    values : (k,) array
        Finite.
    omega : float or None
        The mesh frequency, > 0; needed unless it is the axis.

    Raises
    ------
    ParameterError
        If the axis is unknown, a value of it is not allowed, or the frequency is missing.
    """
    instance_of("system", system, Model, ContactSystem)
    one_of("axis", axis, AXES if isinstance(system, Model) else SYSTEM_AXES)
    if axis != "omega" or omega is not None:
        frequency(omega)
    for value in (float(values.min()), float(values.max())) if values.size else ():
        _check_value(system, axis, value)


def _check_value(system: Model | ContactSystem, axis: str, value: float) -> None:
    """Refuse one value of a known axis."""
    if axis == "omega":
        frequency(value)
    elif isinstance(system, Model):
        system.replace(**{axis: value})
    else:
        system.at(axis, value)


def dead_zone_ends(system: Model | ContactSystem, axis: str, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the dead zone of lambda, low and high, at values of an axis; low is -inf where there is no back flank.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        Its own value of the axis is not used.
    values : array
        Of any shape.
    """
    if isinstance(system, Model):
        high = values if axis == "b" else np.full(np.shape(values), system.b)
        return -high, high
    if axis not in GAP_AXES:
        values = np.ones(np.shape(values))
    front, back = (1.0, 1.0) if axis == "gap" else (system.front_gap, system.back_gap)
    return -back * values if system.two_sided else np.full(np.shape(values), -np.inf), front * values


def bounded_change(parameters: np.ndarray) -> bool:
    """`ContactSystem.bounded_change` of what `packed` gives."""
    return bool(np.isfinite(parameters[BACK_GAP]) and parameters[BACK_STIFFNESS] == 1.0 and parameters[CUBIC] == 0.0)


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
        counts = GEAR, order * period, period, 1 + len(stiffness), 1 + len(errors), 1.0, 1.0
        head[[KIND, HARMONICS, PERIOD, STIFFNESSES, LOADS, SIGN, BACK_STIFFNESS]] = np.multiply(constant, counts)
        head[[MESH_FREQUENCY, FRONT_GAP, BACK_GAP]] = vector[[OMEGA, B, B]]
        further, rest = (constant * np.array(pairs, dtype=float).ravel() for pairs in (stiffness, errors))
        vectors.append([head, vector[[ALPHA, ALPHA_PHASE]], further, vector, vector[[F_E, F_E_PHASE]], rest])
    return np.concatenate(vectors[0]), np.concatenate(vectors[1])


def _system(system: ContactSystem, axis: str, omega: float | None, order: int, period: int):
    one_of("axis", axis, SYSTEM_AXES)
    system = reduced(system)
    closed = system.stiffness + np.outer(system.force, system.contact)
    sign = np.sign(np.linalg.det(closed))
    if sign == 0.0:
        raise ParameterError(
            "stiffness", system.stiffness, "such that closing the contact makes the system statically stable"
        )
    # A contact that is stiffer than what carries it makes the equations small; a power of 2 changes nothing else.
    stiffer = abs(system.contact @ np.linalg.pinv(system.stiffness) @ system.force)
    sign *= 2.0 ** max(0.0, np.round(np.log2(max(stiffer, 1.0))))
    size, count = max(len(system.load), len(system.inertial_load)), max(len(system.stiffness_harmonics), 1)
    sizes = order * period, period, count, size - 1, system.degrees, sign
    if axis == "contact_damping":
        # What it adds to C is no difference of two floats.
        parameters = _system_vector(system, sizes, omega or 0.0)
        still = system.at("damping", 0.0)
        start, end = (_system_vector(one, sizes, 0.0) for one in (still, still.at(axis, 1.0)))
    else:
        at_zero, at_one = (0.0 if axis == "omega" else omega, 1.0 if axis == "omega" else omega)
        parameters = start = _system_vector(system.at(axis, 0.0), sizes, at_zero or 0.0)
        end = _system_vector(system.at(axis, 1.0), sizes, at_one or 0.0)
    # An infinite gap stays what it is.
    with np.errstate(invalid="ignore"):
        slope = end - start
    slope[BACK_GAP] = slope[BACK_GAP] if system.two_sided else 0.0
    return parameters, slope


def _system_vector(system: ContactSystem, sizes: tuple, omega: float) -> np.ndarray:
    """Numbers of a system at one frequency; sizes are H, nu, N, L, n and the sign of its static balance."""
    head = np.zeros(PAIRS)
    head[[KIND, HARMONICS, PERIOD, STIFFNESSES, LOADS, DEGREES, SIGN]] = SYSTEM, *sizes
    head[[MESH_FREQUENCY, FRONT_GAP, BACK_GAP]] = omega, system.front_gap, system.back_gap
    head[[BACK_STIFFNESS, DASHPOT, CUBIC]] = system.back_stiffness, system.contact_dashpot, system.cubic
    pairs = np.array(system.stiffness_harmonics or ((0.0, 0.0),), dtype=float)
    loads = [np.zeros((sizes[3] + 1, system.degrees), dtype=complex) for _ in range(2)]
    for target, source in zip(loads, (system.load, system.inertial_load), strict=True):
        target[: len(source)] = source
    matrices = system.mass, system.damping, system.stiffness, system.contact, system.force, system.varying_force
    return np.concatenate([head, pairs.ravel(), *(part.view(float).ravel() for part in (*matrices, *loads))])
