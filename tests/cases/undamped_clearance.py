"""Forced vibration of a mass with clearance, without damping: the exact solution of two pieces."""

import math

import numpy as np
from scipy.optimize import brentq

from solver import ContactSystem, Galerkin, LiftedSeeds, solve, sweep_row
from tests.cases.case import Case, Comparison, Number
from tests.cases.curves import INK

__all__ = ["CASE"]

_FORCE = 0.1
_OMEGAS = (0.45, 0.6, 0.8, 0.9)
_LOOSE = ContactSystem([[1.0]], [[0.0]], [[0.0]], [1.0], [1.0], 1.0, 1.0, load=[[0.0], [_FORCE]])


def _exact(omega: float) -> float:
    """The largest displacement of the symmetric motion in phase with the force.

    Against the spring x = 1 + C cos t + P cos(Omega t)/(1 - Omega^2) until t_1; from there x = V (t - T/4) -
    P cos(Omega t)/Omega^2 across the gap, to the opposite point half a period later. x = 1 and x' continuous at t_1.
    """
    quarter, square = 0.5 * math.pi / omega, omega**2

    def pieces(leave: float) -> tuple[float, float]:
        force = _FORCE * math.cos(omega * leave)
        return -force / ((1.0 - square) * math.cos(leave)), (1.0 + force / square) / (leave - quarter)

    def jump(leave: float) -> float:
        """Of the speed, times cos t_1, which removes its pole."""
        spring, speed = pieces(leave)
        sine = _FORCE * math.sin(omega * leave)
        before = -spring * math.sin(leave) - omega * sine / (1.0 - square)
        return (before - speed - sine / omega) * math.cos(leave)

    leave = brentq(jump, 0.5 * math.pi + 1e-9, quarter - 1e-6, xtol=1e-15)
    return 1.0 + pieces(leave)[0] + _FORCE / (1.0 - square)


def _ours() -> list[float]:
    balance = Galerkin(63)
    found = [solve(_LOOSE, [0.0, _exact(omega), 0.0], omega, balance=balance).motion for omega in _OMEGAS]
    return [balance.extremes(motion)[1] for motion in found]


def _draw(axes) -> None:
    row = sweep_row(
        _LOOSE.at("damping", 1.0), "omega", np.linspace(0.36, 0.94, 40), balance=Galerkin(9), seeds=LiftedSeeds(9)
    )
    for curve in row.curves:
        axes.plot(curve.points[:, -1], row.balance.extremes(curve.points[:, :-1])[1], color=INK, linewidth=1.3)
    omega = np.linspace(0.42, 0.92, 26)
    axes.plot(omega, [_exact(place) for place in omega], "o", color="#1f4e8c", markersize=3.5, label="exact")
    axes.legend(frameon=False)
    axes.set(xlabel="Ω", ylabel="largest displacement", xlim=(0.36, 0.94), ylim=(0.0, 10.0))


CASE = Case(
    title="A clearance without damping, exactly",
    source="J. P. Den Hartog, S. J. Mikina, Forced vibrations with non-linear spring constants, Transactions of the"
    " ASME (1932): exact solutions of the pieces, joined.",
    equations=r"$$x'' + f(x) = 0.1\cos\Omega t,$$ gap 1.",
    comparisons=(
        Comparison(
            "The joined pieces: symmetric motion in phase with the force.",
            "Harmonic balance of order 63.",
            tuple(Number(rf"largest $x$ at $\Omega = {omega}$", _exact(omega), 2e-6) for omega in _OMEGAS),
            _ours,
        ),
    ),
    draw=_draw,
    caption="Largest $x$ at order 9, and the exact solution.",
)
