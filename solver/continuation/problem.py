"""What a solution curve is, as compiled kernels see it, and what a harmonic balance is, as rows and seeds see it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.continuation.correctors import Broyden, Newton, correct_all, workspace_rows
from solver.continuation.setup import Setup, no_contacts
from solver.model.checks import ParameterError, finite_array, instance_of, number_array, whole_number

__all__ = ["Balance", "Problem"]


@dataclass(frozen=True)
class Problem:
    """A curve E(u, p) = 0 as compiled kernels see it.

    Parameters
    ----------
    residual_and_jacobian, test_functions : compiled kernels
        With the signatures `RESIDUAL_AND_JACOBIAN` and `TEST_FUNCTIONS` of `solver.kernels.compile`. The first test
        function is the amplitude; each of the others has a grazing where it vanishes.
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    scale : (n + 1,) array
        Typical size of each unknown and of p.
    test_count : int
        Number of test functions, >= 1.
    contacts : compiled kernel
        With the signature `solver.continuation.setup.CONTACTS`: where a stiff contact may begin or end, so that the
        curve has a corner there. None unless given.

    Raises
    ------
    ParameterError
        If a kernel cannot be called, or an array or a number is not allowed.
    """

    residual_and_jacobian: object
    test_functions: object
    parameters: np.ndarray
    parameter_slope: np.ndarray
    scale: np.ndarray
    test_count: int
    contacts: object = no_contacts

    def __post_init__(self):
        for name in ("residual_and_jacobian", "test_functions", "contacts"):
            if not callable(getattr(self, name)):
                raise ParameterError(name, getattr(self, name), "a compiled kernel")
        for name in ("parameters", "parameter_slope"):
            if number_array(name, getattr(self, name)).ndim != 1:
                raise ParameterError(name, getattr(self, name), "a vector of numbers")
        scale = finite_array("scale", self.scale, (None,))
        if scale.size < 2 or not scale.min() > 0.0:
            raise ParameterError("scale", self.scale, "at least two numbers above 0")
        whole_number("test_count", self.test_count, 1, 10_000)

    @property
    def unknowns(self) -> int:
        """Number n of unknowns u."""
        return self.scale.size - 1

    def setup(self, corrector: Newton | Broyden) -> Setup:
        """What kernels are told about this problem and the corrector that is to solve it.

        Raises
        ------
        ParameterError
            If it is no corrector.
        """
        instance_of("corrector", corrector, Newton, Broyden)
        n, m = self.unknowns, self.test_count
        return Setup(
            corrector.kernel,
            corrector.tolerance,
            corrector.max_iterations,
            self.residual_and_jacobian,
            self.test_functions,
            self.contacts,
            self.parameters,
            self.parameter_slope,
            self.scale,
            n,
            m,
            np.empty((workspace_rows(n), n + 1)),
            np.empty((m, n + 1)),
        )

    def evaluated(self, y) -> tuple[np.ndarray, np.ndarray]:
        """Residual (n,) and Jacobian (n, n + 1) at y = (u, p); nan where y is.

        Raises
        ------
        ParameterError
            If y is no vector of n + 1 numbers.
        """
        n, y = self.unknowns, self._checked(y)
        residual, jacobian = np.empty(n), np.empty((n, n + 1))
        self.residual_and_jacobian(self.parameters, self.parameter_slope, y, residual, jacobian)
        return residual, jacobian

    def observed(self, y, count: int) -> np.ndarray:
        """The first test functions (count,) at y = (u, p); nan where y is, and where there is no such one.

        Raises
        ------
        ParameterError
            If y is no vector of n + 1 numbers, or the count is no whole number from 1 to 10000.
        """
        return self.observed_all(self._checked(y)[None], count)[0]

    def observed_all(self, points, count: int) -> np.ndarray:
        """The first test functions (k, count) at points (k, n + 1); see `observed`.

        Raises
        ------
        ParameterError
            If the points are no rows of n + 1 numbers, or the count is no whole number from 1 to 10000.
        """
        count, points = whole_number("count", count, 1, 10_000), number_array("points", points).astype(float)
        if points.ndim != 2 or points.shape[1] != self.unknowns + 1:
            raise ParameterError("points", f"array of shape {points.shape}", f"of shape (k, {self.unknowns + 1})")
        # The kernel fills all of its values, however few are wanted.
        size, observe = max(count, self.test_count), self.test_functions
        values, gradient = np.full((len(points), size), np.nan), np.empty((size, self.unknowns + 1))
        for place, found in zip(points, values, strict=True):
            observe(self.parameters, self.parameter_slope, place, found, gradient)
        return values[:, :count]

    def _checked(self, y) -> np.ndarray:
        """A copy of y = (u, p); raises ParameterError if it is no vector of n + 1 numbers."""
        y = number_array("y", y).astype(float)
        if y.shape != (self.unknowns + 1,):
            raise ParameterError("y", f"array of shape {y.shape}", f"of shape ({self.unknowns + 1},)")
        return y

    def corrected_all(
        self, guesses, corrector: Newton | Broyden, normal=None, max_iterations: int | None = None
    ) -> np.ndarray:
        """The solutions that a corrector reaches from many guesses, each on a hyperplane through it.

        Parameters
        ----------
        guesses : (k, n + 1) array_like
            The guesses (u, p).
        corrector : Newton or Broyden
        normal : (n + 1,) array_like, optional
            Across the hyperplanes, in scaled unknowns; that of constant p unless given.
        max_iterations : int, optional
            The corrector's own number unless given.

        Returns
        -------
        (k, n + 1) array
            nan where the corrector does not converge. Without `normal` p is that of the guess to the bit.

        Raises
        ------
        ParameterError
            If an argument has another size or is not finite, or is no corrector.
        """
        n = self.unknowns
        solutions = finite_array("guesses", guesses, (None, n + 1))
        instance_of("corrector", corrector, Newton, Broyden)
        if max_iterations is not None:
            whole_number("max_iterations", max_iterations, 1, 10_000)
        p = solutions[:, n].copy()
        correct_all(
            corrector.kernel,
            self.residual_and_jacobian,
            self.parameters,
            self.parameter_slope,
            self.scale,
            solutions,
            np.eye(n + 1)[n] if normal is None else finite_array("normal", normal, (n + 1,)),
            corrector.tolerance,
            max_iterations or corrector.max_iterations,
            np.empty((workspace_rows(n), n + 1)),
        )
        if normal is None:
            solutions[:, n] = p
        solutions[~np.all(np.isfinite(solutions), axis=1)] = np.nan
        return solutions

    def corrected(
        self, y, corrector: Newton | Broyden, normal=None, max_iterations: int | None = None
    ) -> np.ndarray | None:
        """The solution that a corrector reaches from one guess; None if it does not converge.

        Parameters
        ----------
        y : (n + 1,) array_like
            The guess (u, p).
        corrector, normal, max_iterations
            As for `corrected_all`.

        Raises
        ------
        ParameterError
            If an argument has another size or is not finite, or is no corrector.
        """
        guess = finite_array("y", y, (self.unknowns + 1,))
        (solution,) = self.corrected_all(guess[None], corrector, normal, max_iterations)
        return None if np.isnan(solution[0]) else solution


class Balance(Protocol):
    """A harmonic balance: which harmonics of lambda are unknown, and how their equations are made.

    `solver.harmonic.describing_function.DescribingFunction` and `solver.harmonic.galerkin.Galerkin` are the two there
    are.
    """

    order: int
    """Harmonics of the mesh frequency."""
    period: int
    """Forcing periods after which a motion repeats, nu."""
    harmonics: int
    """Harmonics of the base frequency Omega/nu."""
    unknowns: int
    """Number n = 2 harmonics + 1 of unknowns (Lambda_0, c_1, s_1, ...)."""
    truncated: bool
    """Whether the force is truncated to these harmonics before the stiffness multiplies it."""
    fundamental: tuple[int, int]
    """Slots of the cosine and sine amplitude of the mesh frequency."""

    def problem(self, model, axis: str, low: float, high: float, omega: float | None = None) -> Problem:
        """The balance as a curve over one axis.

        Parameters
        ----------
        model : Model
            Or what else the balance is of.
        axis : str
        low, high : float
            Range of the axis, for scaling.
        omega : float, optional
            The mesh frequency; needed unless it is the axis.

        Raises
        ------
        ParameterError
            If the axis is unknown, its ends do not ascend or are not allowed, or the frequency is missing.
        """

    def extremes(self, motions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest lambda of motions (..., n)."""

    def linear_solution(self, problem: Problem, p: float) -> tuple[float, np.ndarray]:
        """Degree of the balance and solution (n,) without backlash at one axis value."""

    def degree(self, problem: Problem, grid: np.ndarray) -> np.ndarray:
        """Degree of the balance at every axis value (X,)."""
