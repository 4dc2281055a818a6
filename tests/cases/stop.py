"""A mass and an elastic stop on one side."""

import numpy as np

from solver import ContactSystem, Event
from solver.timedomain import find_attractors
from tests.cases.case import Case, Comparison, Number
from tests.cases.curves import draw_row, folds, galerkin_row, largest

__all__ = ["CASE", "STOP"]

#: x'' + 0.03 x' + x + 10 max(x - 1, 0) = 0.1 cos.
STOP = ContactSystem([[1.0]], [[0.03]], [[1.0]], [1.0], [10.0], 1.0, load=[[0.0], [0.1]])


def _grazing() -> tuple[float, float]:
    """Where the free motion reaches the stop: (1 - Omega^2)^2 + (0.03 Omega)^2 = 0.1^2."""
    squares = np.roots([1.0, 0.03**2 - 2.0, 1.0 - 0.1**2])
    return tuple(np.sort(np.sqrt(squares)))


def _branch() -> list[float]:
    row = galerkin_row(STOP, 0.9, 1.5, 15)
    (curve,) = row.curves
    top, _ = largest(curve, row.balance.extremes(curve.points[:, :-1])[1])
    touching = np.sort(curve.points[curve.event == Event.MAX_AT_DRIVE, -1])
    return [*folds(curve)[::-1], top, *touching]


def _attractors() -> list[int]:
    row = find_attractors(STOP, "omega", [1.0, 1.2, 1.4])
    return [int(np.count_nonzero(kind)) for kind in row.kind]


CASE = Case(
    title="A mass and an elastic stop",
    source="Digits that came with the example, without its publication; grazing frequencies are exact.",
    equations=r"$$x'' + 0.03\,x' + x + 10\max(x - 1, 0) = 0.1\cos\Omega t$$",
    comparisons=(
        Comparison(
            "Digits of the example; the largest $x$ is that of the points of a curve. Grazings:"
            r" $(1 - \Omega^2)^2 + (0.03\,\Omega)^2 = 0.01$.",
            "Harmonic balance of order 15, folds and grazings located, the largest $x$ between points as well.",
            (
                Number(r"upper fold $\Omega$", 1.339895, 1e-6),
                Number(r"lower fold $\Omega$", 1.046394, 1e-6),
                Number("largest $x$", 1.78715, 5e-4),
                Number(r"grazing below resonance, $\Omega$", _grazing()[0], 1e-9),
                Number(r"grazing above resonance, $\Omega$", _grazing()[1], 1e-9),
            ),
            _branch,
        ),
        Comparison(
            "Between the folds a motion that hits the stop coexists with one that does not.",
            "Integration from rest and from random states.",
            tuple(Number(rf"attractors at $\Omega = {omega}$", n, 0) for omega, n in ((1.0, 1), (1.2, 2), (1.4, 1))),
            _attractors,
        ),
    ),
    draw=lambda axes: draw_row(axes, galerkin_row(STOP, 0.7, 1.5, 15)),
    caption="Largest $x$ at order 15; dashed where unstable.",
)
