"""The impact pair at first order, whose harmonic balance has a closed form."""

import math

import numpy as np
from scipy.optimize import brentq

from solver import ContactSystem, enumerate_row, sweep_row
from tests.cases.case import Case, Comparison, Number
from tests.cases.curves import INK

__all__ = ["CASE"]

_DAMPING, _MEAN, _FORCE = 0.05, 0.25, 0.25
_PAIR = ContactSystem([[1.0]], [[2.0 * _DAMPING]], [[0.0]], [1.0], [1.0], 1.0, 1.0, load=[[_MEAN], [_FORCE]])
_AMPLITUDES = (0.6, 1.2, 2.4)


def _mean_part(mu: float) -> float:
    """Mean of |cos theta + mu|."""
    return abs(mu) if abs(mu) >= 1.0 else 2.0 / math.pi * (mu * math.asin(mu) + math.sqrt(1.0 - mu**2))


def _first_part(mu: float) -> float:
    """First harmonic of |cos theta + mu|."""
    return math.copysign(1.0, mu) if abs(mu) >= 1.0 else 2.0 / math.pi * (math.asin(mu) + mu * math.sqrt(1.0 - mu**2))


def _frequencies(amplitude: float) -> list[float]:
    """Where the balance has a motion of that amplitude: f(x) = x + (|x - 1| - |x + 1|)/2 of x = m + a cos theta."""

    def ends(mean: float) -> tuple[float, float]:
        return (mean - 1.0) / amplitude, (mean + 1.0) / amplitude

    def load(mean: float) -> float:
        low, high = ends(mean)
        return mean + 0.5 * amplitude * (_mean_part(low) - _mean_part(high)) - _MEAN

    low, high = ends(brentq(load, 0.0, 2.0, xtol=1e-15))
    gain = 1.0 + 0.5 * (_first_part(low) - _first_part(high))
    squares = np.roots([1.0, 4.0 * _DAMPING**2 - 2.0 * gain, gain**2 - (_FORCE / amplitude) ** 2])
    return sorted(math.sqrt(square.real) for square in squares if abs(square.imag) < 1e-12 and square.real > 0.0)


_PLACES = tuple((amplitude, omega) for amplitude in _AMPLITUDES for omega in _frequencies(amplitude))


def _ours() -> list[float]:
    """The nearest amplitude of the proven solutions at each place."""
    found = []
    for amplitude, omega in _PLACES:
        amplitudes = enumerate_row(_PAIR, "omega", [omega]).amplitude[0]
        found.append(amplitudes[np.nanargmin(np.abs(amplitudes - amplitude))])
    return found


def _draw(axes) -> None:
    row = sweep_row(_PAIR, "omega", np.linspace(0.1, 1.6, 120))
    for curve in row.curves:
        axes.plot(curve.points[:, -1], curve.amplitude, color=INK, linewidth=1.3)
    for amplitude in np.linspace(0.3, 4.0, 30):
        places = _frequencies(amplitude)
        axes.plot(places, np.full(len(places), amplitude), "o", color="#1f4e8c", markersize=3.0)
    axes.set(xlabel="Ω", ylabel="amplitude", xlim=(0.1, 1.6), ylim=(0.0, 4.2))


CASE = Case(
    title="The impact pair at first order",
    source="R. J. Comparin, R. Singh, Non-linear frequency response characteristics of an impact pair, Journal of Sound"
    " and Vibration 134 (1989) 259–290: describing functions in closed form.",
    equations=r"$$x'' + 0.1\,x' + f(x) = 0.25 + 0.25\cos\Omega t,$$ gap 1; $x = m + a\cos(\Omega t + \varphi)$.",
    comparisons=(
        Comparison(
            r"The closed form: $m$ carries the load, and $(N - \Omega^2)^2 + (0.1\,\Omega)^2 = (0.25/a)^2$.",
            "The enumerated solutions, proven to be all: the one nearest in amplitude.",
            tuple(Number(rf"$a$ at $\Omega = {omega:.9f}$", amplitude, 1e-8) for amplitude, omega in _PLACES),
            _ours,
        ),
    ),
    draw=_draw,
    caption="Amplitude of all solutions at first order, and the closed form.",
)
