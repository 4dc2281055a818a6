"""The spur pair of one degree of freedom: both gears on rigid supports, their relative motion along the line of action.

    x'' + 2 zeta x' + [1 + sum_l alpha_l cos(l Omega tau + Phi_kl)] f(x)
        = F_m + sum_l [F_l cos(l Omega tau + Theta_l) + (l Omega)^2 e_l cos(l Omega tau + Phi_l)]

x is the dynamic transmission error, the displacement between the teeth, in units of any reference length b_c; time is
in units of 1/omega_n, omega_n^2 = k_m/m_e with the mean mesh stiffness and the equivalent mass of both gears;
F_m = T/(R k_m b_c) (Kahraman and Singh 1991, J. Sound Vib. 146(1), 135-156; docs/physics.md, section 9).
"""

import numpy as np

from solver.model.checks import finite_number
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Harmonics, harmonic_pairs

__all__ = ["harmonic_rows", "spur_pair"]


def spur_pair(
    damping_ratio: float,
    gap: float,
    mean_load: float,
    *,
    stiffness_harmonics: Harmonics = (),
    error_harmonics: Harmonics = (),
    load_harmonics: Harmonics = (),
    **law: float,
) -> ContactSystem:
    """The spur pair as a system of one coordinate.

    Parameters
    ----------
    damping_ratio : float
        zeta, >= 0.
    gap : float
        Half backlash over the reference length, >= 0.
    mean_load : float
        F_m.
    stiffness_harmonics, error_harmonics, load_harmonics : sequence of (amplitude, phase)
        (alpha_l, Phi_kl), (e_l, Phi_l) and (F_l, Theta_l) for l = 1, 2, ...; phases in rad.
    **law : float
        What else the contact does: `back_stiffness`, `contact_dashpot` of `ContactSystem`.

    Raises
    ------
    ParameterError
        Naming the parameter, its value and what is allowed.

    Examples
    --------
    The pair of Kahraman and Singh at the frequency of half its natural one, without its higher harmonics:

    >>> import numpy as np, solver
    >>> pair = solver.spur_pair(0.05, 1.0, 0.1, stiffness_harmonics=[(0.2, np.pi)], error_harmonics=[(0.01, 0.0)])
    >>> [round(mean, 6) for mean in solver.all_solutions(pair, 0.5).mean.tolist()]
    [1.103068]
    """
    damping_ratio = finite_number("damping_ratio", damping_ratio, at_least=0.0)
    gap, mean_load = finite_number("gap", gap, at_least=0.0), finite_number("mean_load", mean_load)
    load = harmonic_rows("load_harmonics", load_harmonics, 1)
    load[0] = mean_load
    return ContactSystem(
        [[1.0]],
        [[2.0 * damping_ratio]],
        [[0.0]],
        [1.0],
        [1.0],
        gap,
        gap,
        [1.0],
        harmonic_pairs("stiffness_harmonics", stiffness_harmonics),
        load,
        harmonic_rows("error_harmonics", error_harmonics, 1),
        **law,
    )


def harmonic_rows(name: str, harmonics: Harmonics, n: int) -> np.ndarray:
    """One-sided harmonics of a load that is the same on all coordinates, without a mean.

    Parameters
    ----------
    name : str
        What errors name.
    harmonics : sequence of (amplitude, phase)
        Of l = 1 ... L; phases in rad.
    n : int
        Number of coordinates.

    Returns
    -------
    (L + 1, n) array, complex
        amplitude exp(i phase), from l = 0 on, where it is 0.

    Raises
    ------
    ParameterError
        If they are no such pairs.
    """
    rows = [amplitude * np.exp(1j * phase) for amplitude, phase in harmonic_pairs(name, harmonics)]
    return np.repeat(np.array([0.0, *rows], dtype=complex)[:, None], n, axis=1)
