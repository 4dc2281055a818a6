"""Backbone: how the undamped pair's free vibration depends on its amplitude under the mean load."""

from dataclasses import dataclass

import numpy as np

from solver.contact.dead_zone import force_and_gain
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
    if instance_of("model", model, Model).f_pm == 0.0:
        raise ParameterError("f_pm", model.f_pm, "other than 0 for a backbone")
    amplitudes = finite_array("amplitudes", amplitudes, (None,))
    if np.any(amplitudes < 0.0):
        raise ParameterError("amplitudes", float(amplitudes.min()), "at least 0")
    force = model.f_pm / model.rotation

    # |f_0| lies between |lambda_m| - b and |lambda_m|, and carries the sign of lambda_m.
    sign = np.copysign(1.0, force)
    low, high = np.zeros(amplitudes.shape), np.full(amplitudes.shape, abs(force) + model.b)
    middle = 0.5 * (low + high)
    while np.any((low < middle) & (middle < high)):
        below = force_and_gain(middle, amplitudes, model.b)[0] < abs(force)
        low, high = np.where(below, middle, low), np.where(below, high, middle)
        middle = 0.5 * (low + high)
    mean = sign * middle
    _, gains = force_and_gain(mean, amplitudes, model.b)
    modes = model.linear_frequencies(gains)
    return Backbone(amplitudes, mean, modes[:, 0], modes[:, -1])
