"""Harmonic balance of order H on the contact coordinate, with exact Fourier coefficients of the contact force.

With theta = Omega tau/nu, lambda = Lambda_0 + Re sum_{k=1}^{H} Lambda_k exp(i k theta), Lambda_k = c_k - i s_k, the
unknowns are (Lambda_0, c_1, s_1, ..., c_H, s_H). The force of a motion with the contact spectra chi, chi+ (front) and
chi- (back) is

    f_k = sum_m chi_(k-m) L_m - front chi+_k + back chi-_k,    L_0 = Lambda_0, L_m = Lambda_m/2, L_-m = conj L_m

for every k (docs/physics.md, section 4; chi = chi+ + chi-, chi- times the stiffness of the back flank), and q = s f
follows from f_0 ... f_(H + N nu): a full Galerkin balance. Rows are E_0, then Re E_k and -Im E_k with E_k = D_k
Lambda_k + 2 (A_k f_k + B_k q_k) - G_k, for which a statically stable solution has a positive Jacobian determinant. f
vanishes where contact switches, so that the derivatives of f are those at fixed contact.
"""

from dataclasses import dataclass

import numpy as np

from solver.contact.spectrum import extremes
from solver.continuation.problem import Problem
from solver.harmonic.contact_extrema import contacts
from solver.harmonic.galerkin_rows import residual_and_jacobian, test_functions
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import eliminate
from solver.model.checks import ParameterError, finite_array, finite_number, instance_of, number_array, whole_number
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import bounded_change, check_axis, packed
from solver.model.parameters import BACK_GAP, FRONT_GAP

__all__ = ["Galerkin", "linear_solution"]

_F = types.float64


@kernel(_F(ARRAY, ARRAY, _F, ARRAY))
def linear_solution(parameters, parameter_slope, p, unknowns):
    """Solution of the balance without backlash (f = lambda), and the sign of its Jacobian's determinant.

    As the dead zone of a two-sided gap differs from lambda by at most the gap, the sign is the topological degree of
    the balance for every gap: the signs of det J over all solutions add up to it.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    p : float
        Axis value.
    unknowns : (n,) array
        Filled.
    """
    base, along = parameters.copy(), parameter_slope.copy()
    n = unknowns.shape[0]
    for slot in (FRONT_GAP, BACK_GAP):
        base[slot], along[slot] = 0.0, 0.0
    y, residual, jacobian = np.zeros(n + 1), np.empty(n), np.empty((n, n + 1))
    y[0], y[n] = 1.0, p
    residual_and_jacobian(base, along, y, residual, jacobian)
    square = jacobian[:, :n].copy()
    right = residual.copy()
    determinant = eliminate(square, right)
    for i in range(n):
        unknowns[i] = -right[i]
    unknowns[0] += 1.0
    return np.sign(determinant)


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, ARRAY))
def _linear_degree(parameters, parameter_slope, grid, unknowns, signs):
    """Fill `signs` with the degree at every axis value of `grid`; `unknowns` (n,) is overwritten."""
    for i in range(grid.shape[0]):
        signs[i] = linear_solution(parameters, parameter_slope, grid[i], unknowns)


@kernel(types.void(MATRIX, MATRIX))
def _extremes(motions, result):
    """Lowest and highest lambda of every motion: fill found (k, 2)."""
    for i in range(motions.shape[0]):
        result[i, 0], _, result[i, 1], _ = extremes(motions[i])


@dataclass(frozen=True)
class Galerkin:
    """Full Galerkin balance of any order, on the forcing period or a multiple of it.

    Parameters
    ----------
    order : int
        H, the harmonics of the mesh frequency, 1 to 64. Order 1 differs from `DescribingFunction`, which
        truncates the force before it is multiplied by the stiffness.
    period : int
        nu: motions may repeat after that many forcing periods only; 1 to 4. There are then nu * order harmonics of
        Omega/nu.

    Raises
    ------
    ParameterError
        If either is not a whole number within these bounds.

    Notes
    -----
    Force and products of force and stiffness have their exact harmonics (docs/physics.md, sections 4.1 and 4.4).
    """

    order: int = 5
    period: int = 1

    def __post_init__(self):
        for name, top in (("order", 64), ("period", 4)):
            object.__setattr__(self, name, whole_number(name, getattr(self, name), 1, top))

    @property
    def harmonics(self) -> int:
        """Harmonics of the base frequency Omega/nu."""
        return self.order * self.period

    @property
    def unknowns(self) -> int:
        """Number n of unknowns (Lambda_0, c_1, s_1, ...)."""
        return 2 * self.harmonics + 1

    @property
    def truncated(self) -> bool:
        """No: the product of force and stiffness is complete before it is projected."""
        return False

    @property
    def fundamental(self) -> tuple[int, int]:
        """Slots of the cosine and sine amplitude of the mesh frequency among the unknowns."""
        return 2 * self.period - 1, 2 * self.period

    def problem(
        self, system: Model | ContactSystem, axis: str, low: float, high: float, omega: float | None = None
    ) -> Problem:
        """The balance as a curve over one axis.

        Parameters
        ----------
        system : Model or ContactSystem
        axis : str
            "omega" or a scalar parameter of the gear; for a ContactSystem one of `solver.model.packing.SYSTEM_AXES`.
        low, high : float
            Range of the axis, for scaling.
        omega : float, optional
            The mesh frequency; needed unless it is the axis.

        Raises
        ------
        ParameterError
            If the axis is unknown, its ends do not ascend or are not allowed, or the frequency is missing.
        """
        check_axis(system, axis, low, high, omega)
        parameters, parameter_slope = packed(system, axis, omega, self.order, self.period)
        scale = np.full(self.unknowns + 1, system.motion_size)
        scale[-1] = 0.1 * (high - low)
        return self.balance_problem(parameters, parameter_slope, scale)

    @staticmethod
    def balance_problem(parameters: np.ndarray, parameter_slope: np.ndarray, scale: np.ndarray) -> Problem:
        """The balance as a curve for vectors of `solver.model.packing.packed`.

        Parameters
        ----------
        parameters, parameter_slope : arrays
            Parameters at p = 0 and what p adds to them.
        scale : (n + 1,) array
            Typical size of each unknown and of p.

        Raises
        ------
        ParameterError
            If one is no vector of numbers, or a scale is not above 0.
        """
        return Problem(
            residual_and_jacobian, test_functions, parameters, parameter_slope, scale, test_count=5, contacts=contacts
        )

    def lifted(self, motions: np.ndarray) -> np.ndarray:
        """First-order motions (..., 3) as starting values (..., n) of this balance.

        Raises
        ------
        ParameterError
            If they are no numbers of that shape.
        """
        motions = number_array("motions", motions, last=3)
        starts = np.zeros((*motions.shape[:-1], self.unknowns))
        starts[..., [0, *self.fundamental]] = motions
        return starts

    def extremes(self, motions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest lambda over the period of motions (..., n): two (...) arrays; nan where motions are.

        Raises
        ------
        ParameterError
            If they are no numbers of that shape.
        """
        motions = number_array("motions", motions, last=self.unknowns).astype(float)
        result = np.full((*motions.shape[:-1], 2), np.nan)
        known = ~np.isnan(motions[..., 0])
        values = np.empty((int(np.sum(known)), 2))
        _extremes(np.ascontiguousarray(motions[known]), values)
        result[known] = values
        return result[..., 0], result[..., 1]

    def linear_solution(self, problem: Problem, p: float) -> tuple[float, np.ndarray]:
        """Degree of the balance and solution (n,) without backlash at one axis value.

        Raises
        ------
        ParameterError
            If it is no problem of this balance, or a value is not finite.
        """
        p, unknowns = finite_number("p", p), np.empty(self.unknowns)
        self._check(problem)
        return linear_solution(problem.parameters, problem.parameter_slope, p, unknowns), unknowns

    def degree(self, problem: Problem, grid: np.ndarray) -> np.ndarray:
        """Degree of the balance at every axis value (X,): what the signs of det J add up to over all solutions.

        nan where the force is no bounded change of a linear one, as of a contact with one flank: none is known.

        Raises
        ------
        ParameterError
            If it is no problem of this balance, or a value is not finite.
        """
        self._check(problem)
        grid = finite_array("grid", grid, (None,))
        if not bounded_change(problem.parameters):
            return np.full(grid.size, np.nan)
        signs = np.empty(grid.size)
        _linear_degree(problem.parameters, problem.parameter_slope, grid, np.empty(self.unknowns), signs)
        return signs

    def displacement(self, motion: np.ndarray, angle) -> np.ndarray:
        """lambda of one motion (n,) at base angles Omega tau/nu of any shape.

        Raises
        ------
        ParameterError
            If they are no finite numbers of that shape.
        """
        motion, angle = finite_array("motion", motion, (self.unknowns,)), finite_array("angle", angle, None)
        k = np.arange(1, self.harmonics + 1)
        turns = angle[..., None] * k
        return motion[0] + np.cos(turns) @ motion[1::2] + np.sin(turns) @ motion[2::2]

    def _check(self, problem: Problem) -> None:
        """Refuse what is no problem of this balance."""
        if (
            instance_of("problem", problem, Problem).residual_and_jacobian is not residual_and_jacobian
            or problem.unknowns != self.unknowns
        ):
            raise ParameterError("problem", problem, f"one of {self}.problem(...)")
