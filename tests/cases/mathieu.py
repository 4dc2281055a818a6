"""A mesh that never parts: Mathieu's equation."""

import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import mathieu_a, mathieu_b

from solver import ContactSystem, Galerkin
from solver.stability import assess
from solver.timedomain import monodromy
from tests.cases.case import Case, Comparison, Number

__all__ = ["CASE"]

_LOAD = 10.0


def _mesh(zeta: float, epsilon: float) -> ContactSystem:
    """x'' + 2 zeta x' + (1 + epsilon cos) f(x) = load, without backlash."""
    return ContactSystem([[1.0]], [[2.0 * zeta]], [[0.0]], [1.0], [1.0], 0.0, 0.0, [1.0], ((epsilon, 0.0),), [[_LOAD]])


def _tongue(characteristic) -> float:
    """Omega of a border of the first tongue without damping: a = 4/Omega^2 and q = 2 epsilon/Omega^2, epsilon = 0.1."""
    return brentq(lambda omega: characteristic(1, 0.2 / omega**2) - 4.0 / omega**2, 1.8, 2.2, xtol=1e-13)


def _multipliers() -> list[float]:
    system, start = _mesh(0.01, 0.1), [_LOAD, 0.0]
    values = np.linalg.eigvals(monodromy(system, 2.0, start)[1])
    modulus = assess(system, "omega", [2.0], [[_LOAD, 0.0, 0.0]], balance=Galerkin(1)).modulus[0]
    return [np.max(np.abs(values)), modulus, np.prod(values)]


def _borders() -> list[float]:
    """Where a multiplier of the undamped mesh is -1, so that both are: the trace is -2."""

    def trace(omega: float) -> float:
        return np.trace(monodromy(_mesh(0.0, 0.1), omega, [_LOAD, 0.0])[1]) + 2.0

    return [brentq(trace, 1.9, 2.0), brentq(trace, 2.0, 2.1)]


def _draw(axes) -> None:
    omega = np.linspace(1.7, 2.3, 241)
    for epsilon, style in ((0.1, "-"), (0.2, "--")):
        found = assess(
            _mesh(0.01, epsilon), "omega", omega, np.tile([_LOAD, 0.0, 0.0], (omega.size, 1)), balance=Galerkin(1)
        )
        axes.plot(omega, found.modulus, style, color="#1a1a1a", linewidth=1.3, label=f"ε = {epsilon}")
    axes.axhline(1.0, color="#8a8a8a", linewidth=0.8)
    axes.legend(frameon=False)
    axes.set(xlabel="Ω", ylabel="largest multiplier", xlim=(1.7, 2.3))


CASE = Case(
    title="Mathieu's equation: a mesh in permanent contact",
    source="F. Bayer, R. I. Leine, Explicit error bounds and guaranteed convergence of the Koopman–Hill projection"
    " stability method, [arXiv:2503.21318](https://arxiv.org/abs/2503.21318), for the example; characteristic values:"
    " NIST Digital Library of Mathematical Functions, section 28.2, as SciPy computes them.",
    equations=r"$$x'' + 2\zeta x' + (1 + \varepsilon\cos\Omega t)\,x = F_m$$",
    comparisons=(
        Comparison(
            r"$(\zeta, \varepsilon, \Omega) = (0.01, 0.1, 2)$; the multipliers' product is $e^{-4\pi\zeta/\Omega}$.",
            "Monodromy matrix of direct integration, and of the stability analysis of a motion.",
            (
                Number(r"largest $\lvert\mu\rvert$, integration", 1.04823068639, 1e-8),
                Number(r"largest $\lvert\mu\rvert$, stability analysis", 1.04823068639, 1e-8),
                Number("product of the multipliers", math.exp(-0.02 * math.pi), 1e-9),
            ),
            _multipliers,
        ),
        Comparison(
            r"Characteristic values $a_1(q)$ and $b_1(q)$ with $a = 4/\Omega^2$, $q = 2\varepsilon/\Omega^2$;"
            r" $\zeta = 0$, $\varepsilon = 0.1$.",
            r"Where a multiplier of the monodromy matrix is $-1$.",
            (
                Number(r"lower border of the first tongue, $\Omega$", _tongue(mathieu_a), 1e-8),
                Number(r"upper border of the first tongue, $\Omega$", _tongue(mathieu_b), 1e-8),
            ),
            _borders,
        ),
    ),
    draw=_draw,
    caption=r"Largest multiplier with $\zeta = 0.01$: above 1 the motion of the forcing period is unstable.",
)
