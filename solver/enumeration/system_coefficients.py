"""The condensed balance of a `ContactSystem` as intervals, from its matrices.

With Z_0 = K - Omega^2 M + i Omega C the first harmonic is Lambda + A f + B q = G with A = w.Z_0^-1 h, B = w.Z_0^-1 h_v
and G = w.Z_0^-1 F: the balance of `solver.harmonic.condensed` divided by its D, which changes neither its solutions nor
the sign of its Jacobian determinant; a damper of touching teeth makes A (1 + i Omega c_c) of A. Where Z_0 cannot be
proven to be regular, the contact is closed first, Z = Z_0 + h w^T and D = 1 - A. The mean is the same with Z_0 = K.
Where K lets the system move freely the contact carries the mean load, D_0 = 0 and c = 1; so it is taken to be where the
static stiffness of the rest is below 1e-12 of the contact's. The solutions of the linear systems are enclosed
(`solver.enumeration.verified_solve`), the numbers parameters + p * parameter_slope taken as the exact floats they are.
"""

import math

import numpy as np

from solver.enumeration.enclosed import (
    FACTORED,
    HALF_GAP,
    LAW_ROW,
    MEAN_GAIN,
    MEAN_LOAD,
    MIRRORED,
    SHIFT,
    put,
    put_complex,
)
from solver.enumeration.interval import (
    COMPLEX,
    INTERVAL,
    above,
    add,
    complex_multiply,
    complex_scale,
    complex_subtract,
    divide,
    exact,
    multiply,
    phasor,
    square,
    subtract,
)
from solver.enumeration.verified_solve import INTERVALS, product, solve_enclosed
from solver.harmonic.condensed import gaps
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.parameters import (
    DASHPOT,
    DEGREES,
    LOADS,
    MESH_FREQUENCY,
    STIFFNESSES,
    stiffness_slot,
    system_loads,
    system_matrices,
)

__all__ = ["FREE_MEAN", "HELD_AND_MODULATED", "PULLED", "enclose_system"]

#: Of what nothing can be proven: springs hold lambda and the stiffness varies; a steady force moves lambda against it;
#: nothing but a contact with one flank holds the mean, and the load does not press it together.
HELD_AND_MODULATED, PULLED, FREE_MEAN = 1, 2, 3

_F, _I, _B = types.float64, types.int64, types.boolean
_THREE = types.Tuple((types.UniTuple(COMPLEX, 3), _B))
# Static stiffness of the rest over that of the contact below which the system counts as free.
_FREE = 1e-12
# Width of an enclosure of c = 1 that still tells that nothing but the contact holds lambda.
_NARROW = 1e-3


@kernel(_THREE(ARRAY, _F, _I, _B), inner=True)
def _receptances(numbers, omega, l, closed):
    """w.Z^-1 h, w.Z^-1 h_v and w.Z^-1 F of harmonic l, with the contact closed or open; whether they are proven."""
    n = int(numbers[DEGREES])
    (mass, damping, stiffness), (contact, force, varying) = system_matrices(numbers, numbers)
    steady, growing = system_loads(numbers, numbers)
    frequency = multiply(exact(float(l)), exact(omega))
    squared = square(frequency)
    matrix, rights = np.empty((n, n, 4)), np.zeros((3, n, 4))
    for i in range(n):
        for j in range(n):
            real, imaginary = exact(stiffness[i, j]), (0.0, 0.0)
            if l > 0 and mass[i, j] != 0.0:
                real = subtract(real, multiply(squared, exact(mass[i, j])))
            if l > 0 and damping[i, j] != 0.0:
                imaginary = multiply(frequency, exact(damping[i, j]))
            if closed and force[i] * contact[j] != 0.0:
                real = add(real, multiply(exact(force[i]), exact(contact[j])))
            matrix[i, j, 0], matrix[i, j, 1] = real
            matrix[i, j, 2], matrix[i, j, 3] = imaginary
        rights[0, i, 0], rights[0, i, 1] = force[i], force[i]
        rights[1, i, 0], rights[1, i, 1] = varying[i], varying[i]
        if l <= int(numbers[LOADS]):
            for part in range(2):
                load = exact(steady[l, i, part])
                if l > 0 and growing[l, i, part] != 0.0:
                    load = add(load, multiply(squared, exact(growing[l, i, part])))
                rights[2, i, 2 * part], rights[2, i, 2 * part + 1] = load
    proven = solve_enclosed(matrix, rights)
    return (product(contact, rights[0]), product(contact, rights[1]), product(contact, rights[2])), proven


@kernel(COMPLEX(ARRAY, _I), inline=True)
def _stiffness_phasor(numbers, l):
    return phasor(exact(numbers[stiffness_slot(l)]), numbers[stiffness_slot(l) + 1])


@kernel(types.Tuple((INTERVAL, INTERVAL, INTERVAL, INTERVAL, _B, _B))(ARRAY), inner=True)
def _static(numbers):
    """c, B_0, the mean load and kappa; whether springs hold lambda, and whether all is proven."""
    (A, B, G), proven = _receptances(numbers, 0.0, 0, False)
    if proven:
        kappa = divide(exact(1.0), A[0])
        if not (A[0][0] > 0.0 and kappa[1] <= _FREE):
            return A[0], B[0], G[0], kappa, True, True
    (A, B, G), proven = _receptances(numbers, 0.0, 0, True)
    # Elsewhere K is too close to a singular matrix to tell.
    free = A[0][0] <= 1.0 <= A[0][1] and A[0][1] - A[0][0] < _NARROW
    return (1.0, 1.0), B[0], G[0], (0.0, 0.0), False, proven and free


@kernel(INTERVAL(INTERVAL), inline=True)
def _negative(x):
    """-x, exactly."""
    return -x[1], -x[0]


@kernel(_I(ARRAY, MATRIX), inner=True)
def _enclose(numbers, here):
    """Fill one point; 0, or why nothing can be proven."""
    n, omega = int(numbers[DEGREES]), numbers[MESH_FREQUENCY]
    (_, damping, _), (_, _, varying) = system_matrices(numbers, numbers)
    damped, varies = numbers[DASHPOT] != 0.0, False
    for i in range(n):
        varies = varies or varying[i] != 0.0
        for j in range(n):
            damped = damped or damping[i, j] != 0.0
    first = varies and numbers[stiffness_slot(1)] != 0.0
    second = varies and numbers[STIFFNESSES] > 1.0 and numbers[stiffness_slot(2)] != 0.0
    c, B_0, load, kappa, held, proven = _static(numbers)
    front, back, _, _, far = gaps(numbers, numbers, 0.0)
    if held and first:
        return HELD_AND_MODULATED
    if held and proven and not c[0] > 0.0:
        return PULLED
    half, shift = exact(front), (0.0, 0.0)
    if far == 0.0:
        half, shift = (0.0, 0.0), exact(front)
    elif front != back:
        half = multiply(exact(0.5), add(exact(front), exact(back)))
        half, shift = (max(half[0], 0.0), half[1]), multiply(exact(0.5), subtract(exact(front), exact(back)))
    if held and (shift[0] != 0.0 or shift[1] != 0.0):
        load = subtract(load, shift)
    if not held and far == 0.0 and not load[0] > 0.0:
        return FREE_MEAN

    (A, B, G), regular = _receptances(numbers, omega, 1, False)
    D = exact(1.0), (0.0, 0.0)
    if not regular:
        (A, B, G), regular = _receptances(numbers, omega, 1, True)
        D = complex_subtract(D, A)
    if numbers[DASHPOT] != 0.0:
        A = complex_multiply(A, (exact(1.0), multiply(exact(numbers[DASHPOT]), exact(omega))))
    if far > 1.0:
        # Of -lambda the stiffer flank is in front, and the contact's stiffness is that of the back one.
        stiffer = exact(far)
        A, B, B_0 = complex_scale(stiffer, A), complex_scale(stiffer, B), multiply(stiffer, B_0)
        c, kappa, load, shift = multiply(stiffer, c), divide(kappa, stiffer), _negative(load), _negative(shift)
        G = _negative(G[0]), _negative(G[1])
    factored = not damped and not first and not second
    if factored:
        D, A = (D[0], (0.0, 0.0)), (A[0], (0.0, 0.0))
    zero = (0.0, 0.0), (0.0, 0.0)
    P_1, P_2, e = zero, zero, zero
    if first:
        S = _stiffness_phasor(numbers, 1)
        P_1, e = complex_multiply(B, S), complex_scale(multiply(exact(0.5), B_0), S)
    if second:
        P_2 = complex_scale(exact(0.5), complex_multiply(B, _stiffness_phasor(numbers, 2)))
    put(here, MIRRORED, exact(1.0 if far > 1.0 else 0.0))
    put_complex(here, 0, D)
    put_complex(here, 2, A)
    put_complex(here, 4, P_1)
    put_complex(here, 6, P_2)
    put_complex(here, 8, G)
    put_complex(here, 10, e)
    put(here, MEAN_GAIN, c if proven and regular else (math.nan, math.nan))
    put(here, MEAN_LOAD, load)
    put(here, HALF_GAP, half)
    put(here, SHIFT, shift)
    put(here, FACTORED, exact(1.0 if factored else 0.0))
    middle = 0.5 * (kappa[0] + kappa[1])
    put(here, LAW_ROW, (middle, above(max(kappa[1] - middle, middle - kappa[0])) if held else 0.0))
    put(here, LAW_ROW + 1, exact(1.0 / far if far > 1.0 else far))
    return 0


@kernel(_I(ARRAY, ARRAY, ARRAY, INTERVALS))
def enclose_system(parameters, parameter_slope, grid, enclosed):
    """Fill `enclosed` (X, SLOTS, 2), of `solver.enumeration.enclosed`, at many axis values of a `ContactSystem`.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed` for one harmonic and one period.
    grid : (X,) array
        Axis values.
    enclosed : (X, SLOTS, 2) array
        Filled.

    Returns
    -------
    int
        0, or why nothing can be proven: `HELD_AND_MODULATED`, `PULLED` or `FREE_MEAN`.
    """
    numbers = np.empty(parameters.shape[0])
    for i in range(grid.shape[0]):
        for k in range(numbers.shape[0]):
            # An infinite gap does not move.
            numbers[k] = parameters[k] if parameter_slope[k] == 0.0 else parameters[k] + grid[i] * parameter_slope[k]
        refused = _enclose(numbers, enclosed[i])
        if refused != 0:
            return refused
    return 0
