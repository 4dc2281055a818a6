"""Two masses coupled by a spring that is stiffer one way."""

import numpy as np

from solver import ContactSystem
from tests.cases.case import Case, Comparison, Number
from tests.cases.curves import draw_row, folds, galerkin_row

__all__ = ["BILINEAR", "CASE"]

_COUPLING = np.array([[1.0, -1.0], [-1.0, 1.0]])
#: K = I + 0.1 [[1, -1], [-1, 1]], 0.9 more for x_1 > x_2.
BILINEAR = ContactSystem(
    np.eye(2),
    0.03 * np.eye(2),
    np.eye(2) + 0.1 * _COUPLING,
    [1.0, -1.0],
    [0.9, -0.9],
    0.0,
    load=[[0.0, 0.0], [0.0, 0.15]],
)

CASE = Case(
    title="Bilinear coupling",
    source="A. Kogani, B. Yousefzadeh, Unilateral vibration transmission in mechanical systems with bilinear coupling,"
    " International Journal of Non-Linear Mechanics (2025) 105272, [arXiv:2502.08726](https://arxiv.org/abs/2502.08726),"
    " whose coupling is smoothed; here it is not.",
    equations=r"$$\begin{aligned} x_1'' + 0.03\,x_1' + x_1 + g &= 0 \\ x_2'' + 0.03\,x_2' + x_2 - g &="
    r" 0.15\cos\Omega t \end{aligned}$$ with $g = 0.1\,\lambda + 0.9\max(\lambda, 0)$ and $\lambda = x_1 - x_2$.",
    comparisons=(
        Comparison(
            "Digits of a harmonic balance of this example.",
            "Harmonic balance of order 45.",
            (Number(r"lower fold $\Omega$", 0.447641, 1e-6), Number(r"upper fold $\Omega$", 0.457760, 1e-6)),
            lambda: folds(*galerkin_row(BILINEAR, 0.4, 0.5, 45, 9).curves),
        ),
    ),
    draw=lambda axes: draw_row(axes, galerkin_row(BILINEAR, 0.4, 1.6, 15, 9)),
    caption=r"Largest $\lambda$ at order 15; dashed where unstable.",
)
