"""Dynamic stability of many motions: monodromy matrices, multipliers, and what they say.

Deviations from a motion that never switches contact depend on the linear system and the frequency alone, unless there
is a cubic spring: what several motions of one call share so is computed once.
"""

from dataclasses import dataclass

import numpy as np

from solver.continuation.problem import Balance
from solver.flow.switched_system import CUBIC, FREQUENCY, SWITCHED_SYSTEM, strength_of
from solver.kernels import types
from solver.kernels.compile import ARRAY, FLAGS, MATRIX, kernel
from solver.model.checks import ParameterError, finite_array, finite_number, has_methods, number_array, whole_number
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import check_values, packed
from solver.model.parameters import PERIOD
from solver.stability.instability import named
from solver.stability.monodromy import carry_through, fill_monodromies, find_switches, fitted_room, new_room
from solver.stability.multipliers import LARGEST, TESTS, eigenvalues, spectral_tests, where_multipliers_lie

__all__ = ["TOLERANCE", "Stability", "assess", "classify", "monodromies", "motion_multipliers", "multipliers"]

_I, _F = types.int64, types.float64
_CUBE = types.float64[:, :, ::1]

#: Moduli this close to 1 are undecided.
TOLERANCE = 1e-6


@dataclass(frozen=True)
class Stability:
    """Stability of k motions.

    Parameters
    ----------
    kind : (k,) int8 array
        `Instability`.
    modulus : (k,) array
        Largest modulus of the multipliers, whatever the kind; nan where they cannot be computed.
    tests : (k, TESTS) array
        `solver.stability.multipliers.spectral_tests` of every motion.
    """

    kind: np.ndarray
    modulus: np.ndarray
    tests: np.ndarray

    @property
    def margin(self) -> np.ndarray:
        """1 - modulus, (k,): what a perturbation loses over a period, negative where it grows."""
        return 1.0 - self.modulus


@kernel(ARRAY(SWITCHED_SYSTEM, _I), inner=True)
def _linear_system(system, zone):
    """All that deviations depend on from a motion that never leaves a zone of contact, as one array."""
    parts = (system.matrices, system.vectors, system.variation)
    size = 2
    for part in parts:
        size += part.size
    numbers = np.empty(size)
    numbers[0], numbers[1], at = system.numbers[FREQUENCY], strength_of(system, zone), 2
    for part in parts:
        for i in range(part.shape[0]):
            for j in range(part.shape[1]):
                numbers[at] = part[i, j]
                at += 1
    return numbers


@kernel(types.boolean(ARRAY, ARRAY), inline=True)
def _equal(left, right):
    if left.shape[0] != right.shape[0]:
        return False
    for i in range(left.shape[0]):  # noqa: SIM110 (kernels have no generators)
        if left[i] != right[i]:
            return False
    return True


@kernel(types.void(ARRAY, ARRAY, ARRAY, MATRIX, _F, FLAGS, MATRIX))
def _assess(parameters, parameter_slope, values, motions, tolerance, bits, tests):
    """Fill bits (k,) and tests (k, TESTS) of motions (k, 2 H + 1) at axis values (k,)."""
    if values.shape[0] == 0:
        return
    room = new_room(parameters, parameter_slope, values[0], motions.shape[1])
    # Of the last motions that stayed free, and in contact: the linear system, bits and tests.
    free, closed = np.zeros(0), np.zeros(0)
    known_bits, known_tests = np.zeros(2, np.int8), np.empty((2, TESTS))
    for k in range(values.shape[0]):
        room = fitted_room(parameters, parameter_slope, values[k], room)
        count = find_switches(motions[k], room)
        zone = 1 if room.zones[0] != 0 else 0
        alike = count == 0 and room.system.numbers[CUBIC] == 0.0
        if alike:
            linear = _linear_system(room.system, room.zones[0])
            if _equal(linear, closed if zone == 1 else free):
                bits[k] = known_bits[zone]
                for i in range(TESTS):
                    tests[k, i] = known_tests[zone, i]
                continue
            if zone == 1:
                closed = linear
            else:
                free = linear
        carry_through(count, parameters[PERIOD], room)
        real, imaginary = room.multipliers[0], room.multipliers[1]
        eigenvalues(room.matrix, real, imaginary)
        bits[k] = where_multipliers_lie(real, imaginary, tolerance)
        spectral_tests(real, imaginary, tests[k])
        if alike:
            known_bits[zone] = bits[k]
            for i in range(TESTS):
                known_tests[zone, i] = tests[k, i]


@kernel(types.void(_CUBE, MATRIX, MATRIX))
def _eigenvalues(matrices, real, imaginary):
    for k in range(matrices.shape[0]):
        eigenvalues(matrices[k], real[k], imaginary[k])


@kernel(types.void(MATRIX, MATRIX, _F, FLAGS))
def _where(real, imaginary, tolerance, bits):
    for k in range(real.shape[0]):
        bits[k] = where_multipliers_lie(real[k], imaginary[k], tolerance)


def classify(multipliers, static=None, tolerance: float = TOLERANCE) -> np.ndarray:
    """`Instability` of motions from their multipliers.

    Parameters
    ----------
    multipliers : (k, m) complex array_like
    static : (k,) array_like, optional
        As for `solver.stability.instability.named`.
    tolerance : float
        Half width of the band about modulus 1 in which nothing is decided.

    Returns
    -------
    (k,) int8 array

    Raises
    ------
    ParameterError
        If an argument is not allowed.

    Examples
    --------
    >>> from solver.stability.instability import Instability
    >>> [Instability(kind).name for kind in classify([[0.5, -1.1], [1.0, 0.3], [0.6 + 0.9j, 0.6 - 0.9j]])]
    ['PERIOD_DOUBLING', 'UNDECIDED', 'NEIMARK_SACKER']
    >>> [Instability(kind).name for kind in classify([[1.2, 0.8]] * 2, static=[0, 1])]
    ['FOLD', 'CONTRADICTORY']
    """
    multipliers = number_array("multipliers", multipliers, kind=complex).astype(complex)
    if multipliers.ndim != 2:
        raise ParameterError("multipliers", f"array of shape {multipliers.shape}", "of shape (k, m)")
    static, tolerance = _checked_static(static, len(multipliers)), finite_number("tolerance", tolerance, at_least=0.0)
    bits = np.empty(len(multipliers), np.int8)
    _where(np.ascontiguousarray(multipliers.real), np.ascontiguousarray(multipliers.imag), tolerance, bits)
    return named(bits, static)


def _checked(system, axis: str, values, motions, omega, order: int, period: int):
    """Packed parameters, axis values (k,) and motions (k, 2 H + 1) as kernels take them."""
    values, period = finite_array("values", values, (None,)), whole_number("period", period, 1, 10_000)
    check_values(system, axis, values, omega)
    motions = np.ascontiguousarray(finite_array("motions", motions, (values.size, None)))
    if motions.shape[1] % 2 == 0:
        raise ParameterError("motions", f"array of shape {motions.shape}", f"({values.size}, an odd number)")
    return *packed(system, axis, omega, order, period), values, motions


def _checked_static(static, count: int):
    if static is not None and number_array("static", static, kind=bool).shape != (count,):
        raise ParameterError("static", f"array of shape {np.shape(static)}", f"of shape ({count},)")
    return static


def monodromies(
    system: Model | ContactSystem, axis: str, values, motions, *, omega: float | None = None, period: int = 1
) -> np.ndarray:
    """Monodromy matrices of k motions over the period nu 2 pi/Omega from tau = 0, on the states (y, y').

    Parameters
    ----------
    system : Model or ContactSystem
        A gear pair is taken with equal supports merged and without what the contact does not reach
        (`solver.model.contact_system.gear_system`): the multipliers left out are those of the supports' motion across
        the contact direction, exp[(-xi_j +- sqrt(xi_j^2 - k_j)) nu 2 pi/Omega].
    axis : str
        "omega" or a scalar parameter of the gear; for a ContactSystem one of `solver.model.packing.SYSTEM_AXES`.
    values : (k,) array_like
    motions : (k, 2 H + 1) array_like
        (Lambda_0, c_1, s_1, ...) of harmonics of Omega/nu.
    omega : float, optional
        The frequency, > 0; needed unless it is the axis.
    period : int
        nu.

    Returns
    -------
    (k, 2 n, 2 n) array
        nan where it cannot be computed.

    Raises
    ------
    ParameterError
        If the axis, a value of it, the frequency or the motions are not allowed, or n is not the same for all values.

    Notes
    -----
    The contact force is continuous, so that the matrices of the smooth pieces between contact switches multiply,
    without jumps (docs/physics.md, section 6.2).
    """
    parameters, parameter_slope, values, motions = _checked(system, axis, values, motions, omega, 1, period)
    if values.size == 0:
        return np.empty((0, 0, 0))
    one = np.empty((1, 0, 0))
    states = 2 * (fill_monodromies(parameters, parameter_slope, values[:1], motions[:1], one))
    matrices = np.empty((values.size, states, states))
    if fill_monodromies(parameters, parameter_slope, values, motions, matrices):
        raise ParameterError("values", values.tolist(), "such that all have the same number of coordinates")
    return matrices


def multipliers(
    system: Model | ContactSystem, axis: str, values, motions, *, omega: float | None = None, period: int = 1
) -> np.ndarray:
    """Floquet multipliers, the eigenvalues of `monodromies`.

    Parameters
    ----------
    system, axis, values, motions, omega, period
        As for `monodromies`.

    Returns
    -------
    (k, 2 n) complex array
        Conjugates side by side.

    Raises
    ------
    ParameterError
        As `monodromies`.

    Notes
    -----
    G. Floquet's theory, as in R. Seydel, Practical Bifurcation and Stability Analysis (3rd ed., 2010), chapter 7.
    """
    matrices = monodromies(system, axis, values, motions, omega=omega, period=period)
    real, imaginary = np.empty(matrices.shape[:2]), np.empty(matrices.shape[:2])
    _eigenvalues(matrices, real, imaginary)
    return real + 1j * imaginary


def motion_multipliers(system: Model | ContactSystem, omega, motions, period: int = 1) -> np.ndarray:
    """Floquet multipliers of motions of one system.

    Parameters
    ----------
    system : Model or ContactSystem
    omega : float or (k,) array
        Frequency of the forcing.
    motions : (2 H + 1,) or (k, 2 H + 1) array
    period : int
        nu.

    Returns
    -------
    (2 n,) or (k, 2 n) complex array
        As from `multipliers`.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    many, frequencies = np.atleast_2d(number_array("motions", motions)), number_array("omega", omega)
    if np.ndim(motions) not in (1, 2):
        raise ParameterError("motions", f"array of shape {many.shape}", "of shape (2 H + 1,) or (k, 2 H + 1)")
    if frequencies.shape not in ((), (1,), (len(many),)) or not np.all((frequencies > 0.0) & (frequencies < np.inf)):
        raise ParameterError("omega", omega, f"one or {len(many)} finite numbers above 0")
    frequencies = np.broadcast_to(frequencies, len(many))
    found = multipliers(system, "omega", frequencies, many, period=period)
    return found[0] if np.ndim(motions) == 1 else found


def assess(
    system: Model | ContactSystem,
    axis: str,
    values,
    motions,
    *,
    omega: float | None = None,
    balance: Balance | None = None,
    static=None,
    tolerance: float = TOLERANCE,
) -> Stability:
    """Stability of k motions at values of one axis.

    Parameters
    ----------
    system : Model or ContactSystem
        As for `monodromies`.
    axis : str
        "omega" or a scalar parameter of the gear; for a ContactSystem one of `solver.model.packing.SYSTEM_AXES`.
    values : (k,) array_like
    motions : (k, n) array_like
        Solutions of the balance: (lambda_m, lambda_c, lambda_s) at first order, else (Lambda_0, c_1, s_1, ...).
    omega : float, optional
        The frequency, > 0; needed unless it is the axis.
    balance : Balance, optional
        Whose solutions the motions are; the describing function of first order unless given.
    static : (k,) array_like, optional
        Static stability of the motions, positive where det J > 0.
    tolerance : float
        Moduli this close to 1 are undecided.

    Returns
    -------
    Stability
        Where several motions at one place never switch contact, or the axis is one that deviations from these do not
        feel (load, backlash), their multipliers are computed once.

    Raises
    ------
    ParameterError
        If the axis, a value of it, the frequency or the shape of the motions is not allowed.
    """
    if balance is not None:
        has_methods("balance", balance, "problem", "extremes")
    order, period, unknowns = (1, 1, 3) if balance is None else (balance.order, balance.period, balance.unknowns)
    parameters, parameter_slope, values, motions = _checked(system, axis, values, motions, omega, order, period)
    if motions.shape[1] != unknowns:
        raise ParameterError("motions", f"array of shape {motions.shape}", f"of shape ({values.size}, {unknowns})")
    static, tolerance = _checked_static(static, values.size), finite_number("tolerance", tolerance, at_least=0.0)
    bits, tests = np.empty(values.size, np.int8), np.empty((values.size, TESTS))
    _assess(parameters, parameter_slope, values, motions, tolerance, bits, tests)
    return Stability(named(bits, static), tests[:, LARGEST].copy(), tests)
