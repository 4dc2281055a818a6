"""A mass between two stops, held by a spring of its own."""

import numpy as np

from solver import ContactSystem
from tests.cases.case import Case, Comparison, Number
from tests.cases.curves import draw_row, folds, galerkin_row, largest

__all__ = ["CASE", "TWO_STOPS"]

#: x'' + 0.06 x' + 0.3 x + 0.5 f(x) = 0.03 cos, gap 0.2.
TWO_STOPS = ContactSystem([[1.0]], [[0.06]], [[0.3]], [1.0], [0.5], 0.2, 0.2, load=[[0.0], [0.03]])


def _branch() -> list[float]:
    row = galerkin_row(TWO_STOPS, 0.5, 1.0, 9)
    (curve,) = row.curves
    return [*folds(curve)[::-1], *largest(curve, np.hypot(curve.points[:, 1], curve.points[:, 2]))]


CASE = Case(
    title="A mass between two stops",
    source="Uncertainty quantification of nonlinear vibration response of the oscillator with double-sided unilateral"
    " spring, [doi:10.1063/5.0175313](https://doi.org/10.1063/5.0175313).",
    equations=r"$$x'' + 0.06\,x' + 0.3\,x + 0.5\,f(x) = 0.03\cos\Omega t,$$ with gaps of 0.2 on both sides.",
    comparisons=(
        Comparison(
            "Digits of a harmonic balance of this example; the peak is the largest of the points of a curve.",
            "Harmonic balance of order 9, the peak between points as well.",
            (
                Number(r"upper fold $\Omega$", 0.781234, 1e-6),
                Number(r"lower fold $\Omega$", 0.665708, 1e-6),
                Number("peak of the first harmonic", 0.64221, 1e-4),
                Number(r"its $\Omega$", 0.7772, 5e-4),
            ),
            _branch,
        ),
    ),
    draw=lambda axes: draw_row(axes, galerkin_row(TWO_STOPS, 0.3, 1.0, 9)),
    caption="Largest $x$ at order 9; dashed where unstable.",
)
