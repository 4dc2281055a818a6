"""Harmonics of a quantity known at places of one mesh cycle, by least squares."""

import math
from dataclasses import dataclass

import numpy as np

from solver.model.checks import ParameterError, finite_array, whole_number
from solver.model.gear_model import Harmonics

__all__ = ["CycleFit", "fit_cycle"]


@dataclass(frozen=True)
class CycleFit:
    """mean + sum_l A_l cos(l theta + Phi_l), and what it leaves over.

    Parameters
    ----------
    mean : float
    harmonics : tuple of (amplitude, phase)
        A_l >= 0 and Phi_l (rad), l = 1, 2, ...
    rms, largest : float
        Root mean square and largest size of the residuals at the points.
    """

    mean: float
    harmonics: Harmonics
    rms: float
    largest: float


def fit_cycle(angle, value, count: int) -> CycleFit:
    """Fit `count` harmonics of the mesh cycle, by linear least squares.

    Parameters
    ----------
    angle : (n,) array
        Mesh phase theta (rad) within [0, 2 pi), in any order and spacing, each once; no gap as wide as half a period of
        the highest harmonic, the one across the end of the cycle included.
    value : (n,) array
        In any unit.
    count : int
        Number of harmonics, from 1; 2 `count` + 1 points are needed.

    Returns
    -------
    CycleFit

    Raises
    ------
    ParameterError
        Naming angle, value or count.
    """
    angle, count = finite_array("angle", angle, (None,)), whole_number("count", count, 1, 100)
    value = finite_array("value", value, angle.shape)
    outside = angle[(angle < 0.0) | (angle >= 2.0 * math.pi)]
    if outside.size:
        raise ParameterError("angle", float(outside[0]), "within one mesh cycle, at least 0 and below 2 pi")
    if angle.size < 2 * count + 1:
        raise ParameterError("count", count, f"at most {(angle.size - 1) // 2} for {angle.size} points")
    ascending = np.sort(angle)
    steps = np.diff(ascending, append=ascending[0] + 2.0 * math.pi)
    if np.any(steps <= 1e-9):
        raise ParameterError("angle", float(ascending[np.argmin(steps)]), "given once")
    widest = int(np.argmax(steps))
    if steps[widest] >= math.pi / count:
        raise ParameterError(
            "angle",
            float(ascending[widest]),
            f"followed by another after less than half a period of harmonic {count}, not after {steps[widest]:.4g} rad",
        )
    turns = np.outer(angle, np.arange(1, count + 1))
    matrix = np.column_stack([np.ones(angle.size), np.cos(turns), np.sin(turns)])
    (mean, *parts), *_ = np.linalg.lstsq(matrix, value, rcond=None)
    cosines, sines = np.array(parts[:count]), np.array(parts[count:])
    residual = value - matrix @ [mean, *parts]
    # A cos(l theta + Phi) = A cos Phi cos(l theta) - A sin Phi sin(l theta).
    amplitudes, phases = np.hypot(cosines, sines), np.arctan2(-sines, cosines)
    return CycleFit(
        float(mean),
        tuple(zip(amplitudes.tolist(), phases.tolist(), strict=True)),
        float(np.sqrt(np.mean(residual**2))),
        float(np.max(np.abs(residual))),
    )
