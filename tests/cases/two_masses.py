"""Two masses, one of them against a stiff stop."""

import dataclasses

import numpy as np
from scipy.optimize import brentq

from solver import ContactSystem, Continuation, Curve, Galerkin, sweep_row
from solver.stability.bifurcations import with_bifurcations
from tests.cases.case import Case, Comparison, Number
from tests.cases.curves import draw_branch, folds, largest

__all__ = ["CASE", "CHAIN", "TWO_MASSES", "second_mass", "traced"]

CHAIN = np.array([[1.0, -1.0], [-1.0, 2.0]])
TWO_MASSES = ContactSystem(
    mass=np.eye(2),
    damping=0.03 * CHAIN,
    stiffness=CHAIN,
    contact=[1.0, 0.0],
    force=[100.0, 0.0],
    front_gap=1.0,
    load=[[0.0, 0.0], [0.0, 0.1]],
)


def second_mass(points: np.ndarray) -> np.ndarray:
    """Fundamental of mass 2 at points (k, n + 1) of a branch, from its own equation of motion."""
    omega, first = points[:, -1], points[:, 1] - 1j * points[:, 2]
    return np.abs((0.1 + (1.0 + 0.03j * omega) * first) / (2.0 - omega**2 + 0.06j * omega))


def traced(order: int) -> tuple[Galerkin, Curve]:
    """The branch from 0.8 down to 0.5, from the motion that misses the stop."""
    balance, continuation = Galerkin(order), Continuation(largest_step=0.05)
    problem = balance.problem(TWO_MASSES, "omega", 0.5, 0.8)
    start = np.zeros(balance.unknowns + 1)
    free = np.linalg.solve(TWO_MASSES.dynamic_stiffness(0.8), TWO_MASSES.load[1])[0]
    start[[1, 2, -1]] = free.real, -free.imag, 0.8
    curve = continuation.trace(problem, start, 0.5, 0.8, heading=-1)
    return balance, with_bifurcations(balance, problem, curve, continuation)


def _resonance() -> list[float]:
    _, curve = traced(21)
    top, place = largest(curve, second_mass(curve.points))
    return [*folds(curve), top, place, largest(curve, np.hypot(curve.points[:, 1], curve.points[:, 2]))[1]]


def _grazing(damping: float) -> float:
    """Where the motion without the stop reaches it, below the resonance near 0.618."""
    system = dataclasses.replace(TWO_MASSES, damping=damping * CHAIN)

    def beyond(omega: float) -> float:
        return abs(np.linalg.solve(system.dynamic_stiffness(omega), system.load[1])[0]) - 1.0

    return brentq(beyond, 0.62, 0.8, xtol=1e-14)


def _lower_folds(damping: float) -> list[float]:
    """Of rows with proof at first order: the fold at which the motion without the stop ends."""
    found = []
    for stiffness in (10.0, 100.0, 1e3, 1e4):
        system = dataclasses.replace(TWO_MASSES, damping=damping * CHAIN, force=[stiffness, 0.0])
        row = sweep_row(system, "omega", np.linspace(0.3, 2.0, 200))
        assert np.all(row.certified == 1)
        found.append(folds(*row.curves)[0])
    return found


def _draw(axes) -> None:
    balance, curve = traced(21)
    draw_branch(axes, TWO_MASSES, balance, curve)
    axes.set(xlabel="Ω", ylabel="largest displacement of mass 1", xlim=(0.5, 0.8))


CASE = Case(
    title="Two masses and a stiff stop",
    source="M. Krack, J. Gross, Harmonic Balance for Nonlinear Vibration Problems, Springer 2019, and the example of"
    " its program NLvib; L. Woiwode, M. Krack, Are Chebyshev-based stability analysis and Urabe's error bound useful"
    " features for harmonic balance?, [arXiv:2303.16802](https://arxiv.org/abs/2303.16802).",
    equations=r"$$\begin{aligned} x_1'' + d\,(x_1' - x_2') + x_1 - x_2 + k\max(x_1 - 1, 0) &= 0 \\"
    r" x_2'' + d\,(2\,x_2' - x_1') + 2\,x_2 - x_1 &= 0.1\cos\Omega t \end{aligned}$$ with $d = 0.03$, $k = 100$.",
    comparisons=(
        Comparison(
            "Digits of harmonic balance of order 41 and of shooting; the source prints curves.",
            "Harmonic balance of order 21.",
            (
                Number(r"lower fold $\Omega$", 0.653442, 2e-5),
                Number(r"upper fold $\Omega$", 0.755632, 2e-5),
                Number("peak of mass 2, first harmonic", 0.9372, 2e-4),
                Number(r"its $\Omega$", 0.751, 1e-3),
                Number(r"$\Omega$ of the peak of mass 1", 0.754, 1e-3),
            ),
            _resonance,
        ),
        *(
            Comparison(
                f"Where the motion without the stop reaches it, $d = {damping}$: the solution of one equation.",
                "Fold of the row at first order, its solutions proven to be all, for stops of four stiffnesses.",
                tuple(
                    Number(rf"lower fold $\Omega$, $k = 10^{power}$", _grazing(damping), 1e-5) for power in (1, 2, 3, 4)
                ),
                lambda damping=damping: _lower_folds(damping),
            )
            for damping in (0.03, 0.06)
        ),
    ),
    draw=_draw,
    caption="Largest displacement of the mass at the stop, order 21; dashed where unstable.",
    remark="Between the folds the motion that hits the stop loses stability at period doublings around the peak and at"
    " Neimark–Sacker points below; that is tested as well.",
)
