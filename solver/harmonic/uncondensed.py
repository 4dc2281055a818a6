"""First-order balance of all seven degrees of freedom: 21 unknowns, for those who want the system as it stands.

It is assembled from M, C, K and the mesh vectors alone and shares nothing with the condensed kernels but the describing
functions, so that each checks the other. Harmonics are complex amplitudes Y_1 = Y_c - i Y_s.
"""

import cmath

import numpy as np

from solver.contact.dead_zone import describing_functions
from solver.model.checks import finite_array, frequency, instance_of
from solver.model.gear_model import Model

__all__ = ["translations", "uncondensed_balance"]


def _force_harmonics(model: Model, variation: float, unknowns) -> tuple[np.ndarray, np.ndarray]:
    """Mean and fundamental of (1 + variation s) f with f truncated to its own first two harmonics.

    Returns
    -------
    force : (2,) complex array
        R_0 and R_1.
    slopes : (2, 3) complex array
        Derivatives by (lambda_m, lambda_c, lambda_s).
    """
    mean, cosine, sine = (float(u) for u in unknowns)
    fundamental = complex(cosine, -sine)
    amplitude = abs(fundamental)
    unit = fundamental / amplitude if amplitude > 0.0 else 0j
    f_0, gain, f_0_m, f_0_a, _, gain_m, gain_a, _ = describing_functions(mean, amplitude, model.b)
    f = np.array([f_0, gain * fundamental])
    d_f = np.array(
        [
            [f_0_m, f_0_a * unit.real, -f_0_a * unit.imag],
            [gain_m * unit, gain + gain_a * unit.real * unit, -1j * gain - gain_a * unit.imag * unit],
        ]
    )
    harmonics = [a * cmath.exp(1j * phase) for a, phase in model.stiffness_harmonics()] + [0j]
    first, second = variation * harmonics[0], variation * harmonics[1]

    def product(mean_part, first_part):
        return np.array(
            [
                mean_part + 0.5 * (first * np.conj(first_part)).real,
                first_part + first * mean_part + 0.5 * second * np.conj(first_part),
            ]
        )

    return product(f[0], f[1]), product(d_f[0], d_f[1])


def uncondensed_balance(model: Model, omega: float, unknowns) -> tuple[np.ndarray, np.ndarray]:
    """Residual and Jacobian of the 21-unknown balance.

    Parameters
    ----------
    model : Model
    omega : float
        Frequency, > 0.
    unknowns : (21,) array_like
        Means, cosine and sine amplitudes of (x1, y1, z1, x2, y2, z2, lambda), seven each.

    Returns
    -------
    residual : (21,) array
        Mean, cosine and sine rows of M y'' + C y' + K y + (h_t k_t + h_r k_r) f(lambda) - e_7 load.
    jacobian : (21, 21) array

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    instance_of("model", model, Model)
    omega = frequency(omega)
    mean, cosine, sine = finite_array("unknowns", unknowns, (21,)).reshape(3, 7)
    mass, damping, stiffness = model.matrices()
    translation, rotation = model.mesh_vectors()
    load = model.load_harmonics(omega)
    dynamic = stiffness - omega**2 * mass + 1j * omega * damping
    mesh = mean[6], cosine[6], sine[6]
    force_t, slopes_t = _force_harmonics(model, model.variation_translation, mesh)
    force_r, slopes_r = _force_harmonics(model, model.variation_rotation, mesh)

    row_mean = stiffness @ mean + translation * force_t[0].real + rotation * force_r[0].real
    row_first = dynamic @ (cosine - 1j * sine) + translation * force_t[1] + rotation * force_r[1]
    row_mean[6] -= load[0].real
    row_first[6] -= load[1]

    jacobian = np.zeros((3, 7, 3, 7))
    jacobian[0, :, 0] = stiffness
    jacobian[1, :, 1], jacobian[1, :, 2] = dynamic.real, dynamic.imag
    jacobian[2, :, 1], jacobian[2, :, 2] = -dynamic.imag, dynamic.real
    slopes = translation[:, None, None] * slopes_t + rotation[:, None, None] * slopes_r
    jacobian[0, :, :, 6] += slopes[:, 0].real
    jacobian[1, :, :, 6] += slopes[:, 1].real
    jacobian[2, :, :, 6] -= slopes[:, 1].imag
    return np.concatenate([row_mean, row_first.real, -row_first.imag]), jacobian.reshape(21, 21)


def translations(model: Model, omega: float, unknowns) -> np.ndarray:
    """Harmonics of the six translations that belong to a condensed solution.

    Parameters
    ----------
    model : Model
    omega : float
        Frequency, > 0.
    unknowns : (3,) array_like
        lambda_m, lambda_c, lambda_s.

    Returns
    -------
    (3, 6) array
        Means, cosine and sine amplitudes of x1, y1, z1, x2, y2, z2:
        X_k = -d_j (kappa_g R^t_k + 2i k Omega xi_hg Lambda_k)/Z_j(k Omega) (docs/physics.md, section 3).

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    """
    instance_of("model", model, Model)
    omega, unknowns = frequency(omega), finite_array("unknowns", unknowns, (3,))
    force, _ = _force_harmonics(model, model.variation_translation, unknowns)
    fundamental = complex(unknowns[1], -unknowns[2])
    direction, stiffness = model.direction, np.array(model.k_support)
    kappa, xi = np.repeat(model.kappa, 3), np.repeat(model.xi_translation, 3)
    impedance = stiffness - omega**2 + 2j * omega * np.array(model.xi_support)
    mean = -direction * kappa * force[0].real / stiffness
    first = -direction * (kappa * force[1] + 2j * omega * xi * fundamental) / impedance
    return np.array([mean, first.real, -first.imag])
