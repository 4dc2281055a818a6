"""Amplitudes of the mesh displacement or force by order of the mesh frequency, at every step of a run along a row."""

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.diagram.following import Followed
from pipeline.analysis.diagram.options import SpectrumOptions
from pipeline.plan.numerics import point_of
from pipeline.plan.traits import contact_system
from solver.timedomain import AttractorKind, SlowRun, order_spectrum, trajectory
from solver.timedomain.integrator import with_the_rest

__all__ = ["Spectra", "spectra_of"]

#: Records of a motion that does not repeat with the record, whose powers are averaged (P. D. Welch, "The use of fast
#: Fourier transform for the estimation of power spectra", IEEE Transactions on Audio and Electroacoustics 15, 1967).
_RECORDS = 8
#: Samples of a period: so many for each order that is shown, and this many at least. What the corners of the force have
#: beyond falls back at that distance from the orders that are shown.
_SAMPLES_OF_ORDER, _FEWEST_SAMPLES = 6, 64


@dataclass(frozen=True, eq=False)
class Spectra:
    """Spectra of the X steps of a run, by ascending value of the swept parameter.

    Parameters
    ----------
    options : SpectrumOptions
    followed : Followed
    values : (X,) array
    omega : (X,) array
        Mesh frequency.
    orders : (K,) array
        Above 0.
    amplitudes : (X, K) array
        Single-sided; nan where there is no bounded motion.
    mean : (X,) array
    kind : (X,) array
        `AttractorKind`.
    jumps : (X,) array
        As of `SlowRun`.
    """

    options: SpectrumOptions
    followed: Followed
    values: np.ndarray
    omega: np.ndarray
    orders: np.ndarray
    amplitudes: np.ndarray
    mean: np.ndarray
    kind: np.ndarray
    jumps: np.ndarray


def spectra_of(followed: Followed, options: SpectrumOptions) -> Spectra:
    """Spectra along the run of one direction.

    Parameters
    ----------
    followed : Followed
    options : SpectrumOptions
    """
    run = followed.runs[options.direction]
    samples = max(_FEWEST_SAMPLES, int(np.ceil(_SAMPLES_OF_ORDER * options.orders)))
    orders = np.arange(options.periods * samples // 2 + 1) / options.periods
    shown = (orders > 0.0) & (orders <= options.orders * (1.0 + 1e-12))
    amplitudes, mean = np.full((run.values.size, shown.sum()), np.nan), np.full(run.values.size, np.nan)
    omega = np.empty(run.values.size)
    for i, value in enumerate(run.values.tolist()):
        model, omega[i] = point_of(followed.plan, followed.way.value, value)
        if not AttractorKind(int(run.kind[i])).settled and run.kind[i] != AttractorKind.UNSETTLED:
            continue
        found = _spectrum(model, float(omega[i]), run, i, options, samples)
        mean[i], amplitudes[i] = found[0], found[shown]
    ascending = slice(None) if options.direction == "up" else slice(None, None, -1)
    parts = (run.values, omega, orders[shown], amplitudes, mean, run.kind, run.jumps)
    values, omega, orders, *others = parts
    return Spectra(
        options, followed, values[ascending], omega[ascending], orders, *(array[ascending] for array in others)
    )


def _spectrum(model, omega: float, run: SlowRun, i: int, options: SpectrumOptions, samples: int) -> np.ndarray:
    """Amplitudes of one step at the orders 0, 1/periods, ...; the powers of several records are averaged."""
    kind, system = AttractorKind(int(run.kind[i])), contact_system(model)
    whole = kind.periodic and options.periods % int(kind) == 0
    records = 1 if whole else _RECORDS
    state = with_the_rest(system, run.state[i][np.isfinite(run.state[i])])
    motion = trajectory(model, omega, state, records * options.periods, samples)
    signal = getattr(motion, options.of).reshape(records, -1)
    _, amplitudes = order_spectrum(signal, options.periods, None if whole else "hann")
    found = np.sqrt(np.mean(amplitudes**2, axis=0))
    found[0] = np.mean(amplitudes[:, 0])
    return found
