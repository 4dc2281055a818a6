"""Backbone: how the undamped pair's free vibration depends on its amplitude under the mean load."""

from dataclasses import dataclass

import numpy as np

from solver.contact.dead_zone import describing_functions
from solver.model.checks import ParameterError, finite_array, instance_of
from solver.model.gear_model import Model

__all__ = ["Backbone", "backbone"]


@dataclass(frozen=True)
class Backbone:
    """Free vibration over amplitude.

    Parameters
    ----------
    amplitude, mean : (k,) arrays
        lambda_a and the lambda_m that carries the mean load.
    lower, upper : (k,) arrays
        Frequencies of the two modes that involve the mesh.
    """

    amplitude: np.ndarray
    mean: np.ndarray
    lower: np.ndarray
    upper: np.ndarray


def backbone(model: Model, amplitudes) -> Backbone:
    """First-order free vibration of the pair without damping, stiffness variation and excitation.

    For every amplitude the mean follows from c f_0(lambda_m, lambda_a) = f_pm, which has one solution as f_0 grows with
    lambda_m, and the mesh acts as a spring of the stiffness N_a(lambda_m, lambda_a).

    Parameters
    ----------
    model : Model
        With f_pm != 0: without load the mean is not determined inside the gap.
    amplitudes : (k,) array_like
        lambda_a >= 0.

    Returns
    -------
    Backbone

    Raises
    ------
    ParameterError
        If there is no model or its f_pm is 0, or an amplitude is below 0.
    """
    # scipy.optimize takes 0.3 s to import, which every worker would pay.
    from scipy.optimize import brentq

    if instance_of("model", model, Model).f_pm == 0.0:
        raise ParameterError("f_pm", model.f_pm, "other than 0 for a backbone")
    amplitudes = finite_array("amplitudes", amplitudes, (None,))
    if np.any(amplitudes < 0.0):
        raise ParameterError("amplitudes", float(amplitudes.min()), "at least 0")
    force = model.f_pm / model.rotation

    def mean_at(amplitude):
        # |f_0| lies between |lambda_m| - b and |lambda_m|, and carries the sign of lambda_m.
        reach = np.copysign((abs(force) + model.b) * (1.0 + 1e-12), force)
        bracket = sorted([0.0, reach])
        return brentq(lambda m: describing_functions(m, amplitude, model.b)[0] - force, *bracket, xtol=1e-14)

    mean = np.array([mean_at(a) for a in amplitudes])
    gains = [describing_functions(m, a, model.b)[1] for m, a in zip(mean, amplitudes, strict=True)]
    modes = np.array([model.mesh_modes(gain) for gain in gains]).reshape(-1, 2)
    return Backbone(amplitudes, mean, modes[:, 0], modes[:, 1])
