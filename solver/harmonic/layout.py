"""A system and its harmonic balance as the flat vectors that kernels read: `theta`, and what an axis adds to it.

    theta = (kind | H, nu, N, L, n | sign | Omega, front gap, back gap | N pairs (alpha_l, Phi_kl) | load of the kind)

H harmonics of the base frequency Omega/nu are balanced; N harmonics of the stiffness and L of the load are of Omega
itself. Gear pair: the 34 numbers of `solver.model.condensation`, then L pairs (f_el, Phi_l). Other systems: M, C, K, w,
h, h_v, then F_l and F^i_l for l = 0 ... L with real and imaginary part of every coordinate in turn.
"""

import numpy as np

from solver.model.checks import ParameterError, finite_number, frequency, instance_of, one_of
from solver.model.condensation import ALPHA, ALPHA_PHASE, AXES, F_E, F_E_PHASE, B, axis_vectors
from solver.model.condensation import OMEGA as MODEL_OMEGA
from solver.model.contact_system import ContactSystem, reduced
from solver.model.gear_model import Model

__all__ = [
    "BACK",
    "FRONT",
    "GEAR",
    "HARMONICS",
    "KIND",
    "LOADS",
    "OMEGA",
    "PAIRS",
    "PERIOD",
    "SIGN",
    "STIFFNESSES",
    "SYSTEM_AXES",
    "check_axis",
    "packed",
]

KIND, HARMONICS, PERIOD, STIFFNESSES, LOADS, DEGREES, SIGN, OMEGA, FRONT, BACK, PAIRS = range(11)
GEAR, SYSTEM = 0.0, 1.0

#: What may be varied of a `ContactSystem`: the frequency, both gaps, the first harmonic of the stiffness, and a factor
#: on the oscillating part of the load.
SYSTEM_AXES = ("omega", "gap", "alpha", "excitation")


def check_axis(system: Model | ContactSystem, axis: str, low: float, high: float, omega: float | None) -> None:
    """Refuse what no balance over an axis can be made of.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        One of `solver.model.condensation.AXES`, or of `SYSTEM_AXES` for a ContactSystem.
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
    """`theta` with the axis at 0, and the direction of the axis, for a balance of order H/nu on nu periods 2 pi/Omega.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        One of `solver.model.condensation.AXES`, or of `SYSTEM_AXES` for a ContactSystem.
    omega : float or None
        The mesh frequency; needed unless it is the axis.
    order, period : int
        Harmonics of the mesh frequency, and nu.

    Returns
    -------
    theta, direction : arrays of one length

    Raises
    ------
    ParameterError
        If the axis is unknown.
    """
    pack = _gear if isinstance(system, Model) else _system
    head, rest, head_along, rest_along = pack(system, axis, omega)
    head[HARMONICS], head[PERIOD] = order * period, period
    return np.concatenate([head, rest]), np.concatenate([head_along, rest_along])


def _gear(model: Model, axis: str, omega: float | None):
    model_theta, along = axis_vectors(model, axis, omega)
    pairs, errors = model.stiffness_harmonics(), model.error_harmonics()
    heads, rests = [], []
    for vector, constant in ((model_theta, 1.0), (along, 0.0)):
        head = np.zeros(PAIRS)
        head[OMEGA], head[FRONT], head[BACK] = vector[MODEL_OMEGA], vector[B], vector[B]
        # The first pairs are parameters that may be axes; the others are fixed.
        stiffness = [vector[[ALPHA, ALPHA_PHASE]], *(constant * np.array(pair) for pair in pairs[1:])]
        load = [vector[[F_E, F_E_PHASE]], *(constant * np.array(pair) for pair in errors[1:])]
        heads.append(np.concatenate([head, *stiffness]))
        rests.append(np.concatenate([vector, *load]))
    heads[0][[KIND, STIFFNESSES, LOADS, SIGN]] = GEAR, len(pairs), len(errors), 1.0
    return heads[0], rests[0], heads[1], rests[1]


def _system(system: ContactSystem, axis: str, omega: float | None):
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
    head[[KIND, STIFFNESSES, LOADS, DEGREES, SIGN]] = SYSTEM, len(pairs), size - 1, system.degrees, sign
    head[OMEGA], head[FRONT], head[BACK] = omega or 0.0, system.front_gap, system.back_gap
    head_along, pairs_along = np.zeros(PAIRS), np.zeros_like(pairs)
    if axis == "omega":
        head[OMEGA], head_along[OMEGA] = 0.0, 1.0
    elif axis == "gap":
        head_along[FRONT], head[FRONT] = 1.0, 0.0
        if system.two_sided:
            head_along[BACK], head[BACK] = 1.0, 0.0
    elif axis == "alpha":
        pairs[0, 0], pairs_along[0, 0] = 0.0, 1.0
    constant = [system.mass, system.damping, system.stiffness, system.contact, system.force, system.varying_force]
    along = [np.zeros_like(part) for part in constant] + [np.zeros_like(load) for load in loads]
    if axis == "excitation":
        for load, load_along in zip(loads, along[-2:], strict=True):
            load_along[1:], load[1:] = load[1:], 0.0
    rests = [np.concatenate([part.view(float).ravel() for part in parts]) for parts in ([*constant, *loads], along)]
    return np.concatenate([head, pairs.ravel()]), rests[0], np.concatenate([head_along, pairs_along.ravel()]), rests[1]
