"""Amplitudes of a sampled motion by order of the mesh frequency."""

import numpy as np

from solver.model.checks import ParameterError, finite_array, finite_number, one_of

__all__ = ["order_spectrum"]


def order_spectrum(samples, periods: float, window: str | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Single-sided amplitudes of evenly sampled signals by order of the forcing frequency.

    Parameters
    ----------
    samples : (..., N) array_like
        Values at N even places of the record, beginning with its start; its end, which is the next start, is left out.
    periods : float
        Forcing periods P that the record covers, > 0.
    window : None or "hann"
        None where the record is a whole number of the signal's own periods: then amplitudes are those of its Fourier
        series, as exact as the samples are many. Otherwise "hann", which keeps what does not repeat in its place.

    Returns
    -------
    orders : (N // 2 + 1,) array
        0, 1/P, 2/P, ...: half orders where P is even.
    amplitudes : (..., N // 2 + 1) array
        Of the cosines whose sum the signal is; the mean, with its sign, at order 0. A cosine in the middle of a bin has
        its own amplitude under both windows. Without a window mean^2 + sum of amplitude^2 / 2 is the mean square, where
        the last amplitude of an even N counts twice (Parseval).

    Raises
    ------
    ParameterError
        If there are fewer than two samples, one is not finite, or another argument is not allowed.

    Notes
    -----
    F. J. Harris, "On the use of windows for harmonic analysis with the discrete Fourier transform", Proceedings of the
    IEEE 66 (1978) 51-83: the periodic Hann window, and amplitudes over its mean. The mean under the window is taken
    out first; it would spread into the next bin.
    """
    values = finite_array("samples", samples, None)
    if values.ndim == 0 or values.shape[-1] < 2:
        raise ParameterError("samples", samples, "at least two finite numbers along the last axis")
    periods = finite_number("periods", periods, above=0.0)
    if window is not None:
        one_of("window", window, ("hann",))
    count = values.shape[-1]
    weights = np.ones(count) if window is None else 1.0 - np.cos(2.0 * np.pi * np.arange(count) / count)
    mean = (values * weights).sum(axis=-1, keepdims=True) / weights.sum()
    amplitudes = np.abs(np.fft.rfft((values - mean) * weights, axis=-1)) * (2.0 / weights.sum())
    amplitudes[..., 0] = mean[..., 0]
    if count % 2 == 0:
        # Of what alternates from sample to sample there is one line, not two.
        amplitudes[..., -1] *= 0.5
    return np.arange(count // 2 + 1) / periods, amplitudes
