"""Two masses, one of them on a foundation that only pushes."""

import numpy as np

from solver import ContactSystem, Galerkin, solve
from solver.stability import assess
from solver.timedomain import settle, shoot, trajectory
from tests.cases.case import Case, Comparison, Number

__all__ = ["CASE", "PUSHED"]

#: M = I, C = 0.1 I, K = [[1, -1], [-1, 2]], 5 max(q_1, 0), 0.375 cos 1.44 t on mass 2.
PUSHED = ContactSystem(
    np.eye(2), 0.1 * np.eye(2), [[1.0, -1.0], [-1.0, 2.0]], [1.0, 0.0], [5.0, 0.0], 0.0, load=[[0, 0], [0, 0.375]]
)
_OMEGA = 1.44
_NUMBERS = tuple(
    Number(what, value, 1e-6 if what == "largest multiplier" else 1e-7)
    for what, value in (
        ("mean of $q_1$", -0.2575375),
        ("first harmonic of $q_1$", 0.3779385),
        ("second harmonic", 0.0281892),
        ("third harmonic", 0.0081739),
        ("largest multiplier", 0.803992),
    )
)


def _orbit():
    found, slots = settle(PUSHED, _OMEGA, np.zeros((1, 4)))
    return shoot(PUSHED, _OMEGA, found.state[0, slots[0]], order=3)


def _by_shooting() -> list[float]:
    orbit = _orbit()
    return [orbit.harmonics[0].real, *np.abs(orbit.harmonics[1:]), orbit.largest_multiplier]


def _by_balance() -> list[float]:
    balance = Galerkin(45)
    motion = solve(PUSHED, [-0.25, 0.3, 0.2], _OMEGA, balance=balance).motion
    multiplier = assess(PUSHED, "omega", [_OMEGA], motion[None], balance=balance).modulus[0]
    return [motion[0], *np.hypot(motion[1:7:2], motion[2:7:2]), multiplier]


def _draw(axes) -> None:
    samples = trajectory(PUSHED, _OMEGA, _orbit().state, 1, 400)
    axes.plot(samples.displacement, samples.speed, color="#1a1a1a", linewidth=1.3)
    axes.axvline(0.0, color="#8a8a8a", linewidth=0.8)
    axes.set(xlabel="q₁", ylabel="velocity of mass 1")


CASE = Case(
    title="A motion by event-driven harmonic balance",
    source="Event-driven Gauss quadrature and stability analysis for fast alternating frequency–time harmonic balance"
    " of non-smooth systems, Communications in Nonlinear Science and Numerical Simulation (2023) 107189,"
    " [doi:10.1016/j.cnsns.2023.107189](https://doi.org/10.1016/j.cnsns.2023.107189).",
    equations=r"$$\begin{aligned} q_1'' + 0.1\,q_1' + q_1 - q_2 + 5\max(q_1, 0) &= 0 \\"
    r" q_2'' + 0.1\,q_2' + 2\,q_2 - q_1 &= 0.375\cos 1.44\,t \end{aligned}$$",
    comparisons=(
        Comparison(
            "Digits that came with the example.",
            "Integration from rest, then shooting; multipliers of the exact monodromy matrix.",
            _NUMBERS,
            _by_shooting,
        ),
        Comparison(
            "The same digits.",
            "Harmonic balance of order 45 from a rough guess, and its multipliers.",
            _NUMBERS,
            _by_balance,
        ),
    ),
    draw=_draw,
    caption="The motion of mass 1; the foundation pushes on the right of the line.",
)
