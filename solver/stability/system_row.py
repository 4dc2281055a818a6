"""The linear systems along a row of a plane as stacked arrays: what both stability methods and their kernels read.

With lambda = w . y, contact or not chi(tau) in {0, 1}, a perturbation of a motion obeys

    y'' + M^-1 C y' + M^-1 K y + chi(tau) [M^-1 h + M^-1 h_v s(tau)] lambda = 0,
    s(tau) = Re sum_l S_l exp(i l Omega tau)

The load does not enter, so that a row over frequency or load has one such system; over backlash only the gaps change.
"""

import math
from dataclasses import dataclass

import numpy as np

from solver.harmonic.layout import SYSTEM_AXES
from solver.model.checks import ParameterError
from solver.model.condensation import AXES
from solver.model.contact_system import ContactSystem, gear_system
from solver.model.gear_model import Model

__all__ = ["SystemRow", "system_row"]

_LOADS = ("f_e", "f_e_phase", "f_pm", "f_pv", "excitation")


@dataclass(frozen=True, eq=False)
class SystemRow:
    """m systems of n degrees of freedom, and for each of k motions which of them it belongs to.

    Parameters
    ----------
    damping, stiffness : (m, n, n) arrays
        M^-1 C, M^-1 K.
    force, varying, contact : (m, n) arrays
        M^-1 h, M^-1 h_v, w.
    phasors : (m, L) complex array
        S_l = alpha_l exp(i Phi_kl).
    which : (k,) int array
    omega : (k,) array
        Frequency of the forcing.
    gaps : (k, 2) array
        Front and back gap.
    """

    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray
    varying: np.ndarray
    contact: np.ndarray
    phasors: np.ndarray
    which: np.ndarray
    omega: np.ndarray
    gaps: np.ndarray

    @property
    def states(self) -> int:
        """2 n, the number of multipliers of a motion."""
        return 2 * self.force.shape[1]

    @property
    def systems(self) -> tuple[np.ndarray, ...]:
        """The stacked systems in the order in which kernels take them."""
        return self.damping, self.stiffness, self.force, self.varying, self.contact, self.phasors

    @property
    def decay(self) -> np.ndarray:
        """trace(M^-1 C) of every motion, (k,): by Liouville the sum of all exponents is its negative."""
        return np.trace(self.damping, axis1=1, axis2=2)[self.which]

    def take(self, motions) -> "SystemRow":
        """The row of some of the motions, chosen as NumPy indexes them."""
        return SystemRow(*self.systems, self.which[motions], self.omega[motions], self.gaps[motions])

    def tokens(self) -> list[bytes]:
        """Every system as bytes: equal where the linear systems are."""
        return [b"".join(part[i].tobytes() for part in self.systems) for i in range(len(self.force))]


def system_row(system: Model | ContactSystem, axis: str, values, omega: float | None = None) -> SystemRow:
    """The systems of motions at k values of one axis.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        "omega" or a scalar parameter of the gear; for a ContactSystem one of `solver.harmonic.layout.SYSTEM_AXES`.
    values : (k,) array_like
    omega : float, optional
        The frequency, > 0; needed unless it is the axis.

    Raises
    ------
    ParameterError
        If the axis, a value of it or the frequency is not allowed.
    """
    values = np.array(values, dtype=float)
    if values.ndim != 1 or not np.all(np.isfinite(values)):
        raise ParameterError("values", f"array of shape {values.shape}", "a vector of finite numbers")
    axes = AXES if isinstance(system, Model) else SYSTEM_AXES
    if axis not in axes:
        raise ParameterError("axis", axis, f"one of {', '.join(axes)}")
    frequencies = values if axis == "omega" else np.full(values.size, math.nan if omega is None else omega)
    if not np.all((frequencies > 0.0) & (frequencies < np.inf)):
        raise ParameterError("omega", omega, "a finite number above 0")
    which = np.zeros(values.size, dtype=np.int64)
    fixed = gear_system(system) if isinstance(system, Model) else system
    chosen, gaps = [fixed], np.tile([fixed.front_gap, fixed.back_gap], (values.size, 1))
    if axis in ("b", "gap"):
        gaps[:] = values[:, None]
        if not fixed.two_sided:
            gaps[:, 1] = np.inf
    elif axis == "alpha" and not isinstance(system, Model):
        unique, which = np.unique(values, return_inverse=True)
        (_, phase), *higher = system.stiffness_harmonics or ((0.0, 0.0),)
        stiffness_harmonics = [((value, phase), *higher) for value in unique]
        return _stack([fixed] * unique.size, stiffness_harmonics, which, frequencies, gaps)
    elif axis != "omega" and axis not in _LOADS:
        unique, which = np.unique(values, return_inverse=True)
        chosen = [gear_system(system.replace(**{axis: float(value)})) for value in unique]
    return _stack(chosen, [one.stiffness_harmonics for one in chosen], which, frequencies, gaps)


def _stack(systems, stiffness_harmonics, which, omega, gaps) -> SystemRow:
    n, parts = systems[0].degrees, []
    for one in systems:
        columns = np.column_stack([one.damping, one.stiffness, one.force, one.varying_force])
        parts.append(np.linalg.solve(one.mass, columns))
    parts = np.array(parts)
    # A pair without variation stands for none, so that kernels always have one.
    pairs = np.array([harmonics or ((0.0, 0.0),) for harmonics in stiffness_harmonics], dtype=float)
    arrays = (parts[..., :n], parts[..., n : 2 * n], parts[..., 2 * n], parts[..., 2 * n + 1])
    contact = np.array([one.contact for one in systems])
    return SystemRow(
        *(np.ascontiguousarray(array) for array in arrays),
        contact,
        pairs[..., 0] * np.exp(1j * pairs[..., 1]),
        np.ascontiguousarray(which, dtype=np.int64),
        np.ascontiguousarray(omega),
        np.ascontiguousarray(gaps),
    )
