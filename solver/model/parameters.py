"""Every slot of the vectors of parameters that kernels read, and views of their parts.

Kernels read `parameters`, with the swept axis at 0, and what the axis adds to them: at axis value p every number is
parameters + p * slope. There are three layouts, made in `solver.model.packing` and `solver.boundaries.problem`:

- a gear: the GEAR_SIZE numbers of its model and the frequency. The describing function reads them alone;
- a system and its balance: header | N pairs (alpha_l, Phi_kl) | what belongs to the kind. Of a gear that is its own
  numbers, then L pairs (f_el, Phi_l); of a `ContactSystem` M, C, K, then w, h, h_v, then F_l and F^i_l for l = 0 ... L
  with real and imaginary part of every coordinate in turn. H harmonics of the base frequency Omega/nu are balanced; N
  harmonics of the stiffness and L of the load are of Omega itself;
- a plane: its header | a system | what its x axis adds | how a path bends p (PATH slots, then edges, slots and
  coefficients; one 0 where nothing bends).

The lengths N, L and n stand in the header, as do those of a path in its first slots: kernels are told one vector.
"""

from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel

__all__ = ["error_slot", "gear_numbers", "kind_start", "number_at", "stiffness_slot", "system_loads", "system_matrices"]

# A gear.
OMEGA, B, ALPHA, ALPHA_PHASE, ALPHA_2, ALPHA_2_PHASE, F_E, F_E_PHASE, F_PM, F_PV, XI_MESH = range(11)
KAPPA, XI_TRANSLATION, XI_SUPPORT, K_SUPPORT = 11, 13, 15, 21
CONE, PRESSURE, SIGMA, ROTATION, ROTATION_GEOMETRIC, VARIATION_T, VARIATION_R, GEAR_SIZE = range(27, 35)

# Header of a system: its kind, H, nu, N, L, n, the sign of its static balance, Omega, both gaps, and of the contact law
# the stiffness of the back flank over that of the front one, the dashpot of touching teeth and the cubic spring; then N
# pairs.
KIND, HARMONICS, PERIOD, STIFFNESSES, LOADS, DEGREES, SIGN, MESH_FREQUENCY, FRONT_GAP, BACK_GAP = range(10)
BACK_STIFFNESS, DASHPOT, CUBIC, PAIRS = range(10, 14)
GEAR, SYSTEM = 0.0, 1.0

# Header of a plane: contact of either flank; with contact angles the grazed flank's slot of y, its level and the size
# of lambda; without them the event, and the steps of differences along x and p.
FRONT_CONTACT, BACK_CONTACT, FLANK, LEVEL, LENGTH_SCALE, EVENT, X_STEP, P_STEP, PLANE_HEADER = range(9)

# A path: stretches, numbers that move, degree of the polynomials; then edges of the stretches.
STRETCHES, MOVING, DEGREE, EDGES = range(4)

_I = types.int64


@kernel(types.UniTuple(types.float64, 2)(ARRAY, ARRAY, types.float64, _I), inline=True)
def number_at(parameters, parameter_slope, p, slot):
    """One number at axis value p, and its derivative.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    slot : int
    """
    return parameters[slot] + p * parameter_slope[slot], parameter_slope[slot]


@kernel(_I(_I), inline=True)
def stiffness_slot(l):
    """Where alpha_l stands in a system, before Phi_kl; l >= 1."""
    return PAIRS + 2 * (l - 1)


@kernel(_I(ARRAY), inline=True)
def kind_start(parameters):
    """Where what belongs to the kind begins in a system."""
    return PAIRS + 2 * int(parameters[STIFFNESSES])


@kernel(ARRAY(ARRAY, ARRAY), inline=True)
def gear_numbers(parameters, vector):
    """The gear's own numbers in `vector`: the parameters of a system themselves, or what an axis adds to them."""
    start = kind_start(parameters)
    return vector[start : start + GEAR_SIZE]


@kernel(_I(ARRAY, _I), inline=True)
def error_slot(parameters, l):
    """Where f_el stands in a gear's system, before its phase; l >= 1."""
    return kind_start(parameters) + GEAR_SIZE + 2 * (l - 1)


@kernel(types.Tuple((types.UniTuple(MATRIX, 3), types.UniTuple(ARRAY, 3)))(ARRAY, ARRAY), inline=True)
def system_matrices(parameters, vector):
    """M, C, K (n, n) and w, h, h_v (n,) of a `ContactSystem` in `vector`: its parameters, or what an axis adds."""
    start, n = kind_start(parameters), int(parameters[DEGREES])
    middle = start + 3 * n * n
    square, row = vector[start:middle].reshape(3, n, n), vector[middle : middle + 3 * n].reshape(3, n)
    return (square[0], square[1], square[2]), (row[0], row[1], row[2])


@kernel(types.UniTuple(types.float64[:, :, ::1], 2)(ARRAY, ARRAY), inline=True)
def system_loads(parameters, vector):
    """F and F^i (L + 1, n, 2) of a `ContactSystem` in `vector`, real and imaginary parts last."""
    n, rows = int(parameters[DEGREES]), int(parameters[LOADS]) + 1
    start = kind_start(parameters) + 3 * n * n + 3 * n
    both = vector[start : start + 4 * n * rows].reshape(2, rows, n, 2)
    return both[0], both[1]
