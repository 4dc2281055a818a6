"""The bilinear oscillator: a spring that is stiffer one way."""

import numpy as np

from solver import ContactSystem, free_vibration
from solver.timedomain import isolated_branches
from tests.cases.case import Case, Comparison, Number
from tests.cases.curves import SUBHARMONIC, draw_branch, draw_row, galerkin_row

__all__ = ["CASE"]


def _oscillator(stiffness: float, damping: float = 0.0) -> ContactSystem:
    """Stiffness 1 for x < 0, another one for x > 0."""
    return ContactSystem([[1.0]], [[damping]], [[1.0]], [1.0], [stiffness - 1.0], 0.0, load=[[0.0], [1.0]])


def _natural() -> list[float]:
    return [
        free_vibration(_oscillator(stiffness), [highest], order=63).omega[0]
        for stiffness, highest in ((4.0, 1.0), (4.0, 7.0), (9.0, 1.0), (25.0, 1.0), (100.0, 1.0))
    ]


def _branches():
    row = galerkin_row(_oscillator(4.0, 0.04), 0.8, 4.6, 9, 9)
    return row, isolated_branches(row, np.linspace(0.8, 4.6, 39)).branches


def _subharmonics() -> list[int]:
    """Whether a branch of two, and one of three periods passes twice and three times the natural frequency."""
    _, branches = _branches()
    ranges = {b.period: (b.curve.points[:, -1].min(), b.curve.points[:, -1].max()) for b in branches}
    return [int(ranges[period][0] < period * 4.0 / 3.0 < ranges[period][1]) for period in (2, 3)]


def _draw(axes) -> None:
    row, branches = _branches()
    draw_row(axes, row)
    for branch in branches:
        draw_branch(axes, row.system, branch.balance, branch.curve, SUBHARMONIC)
    axes.set_ylim(0.0, 4.0)


CASE = Case(
    title="The bilinear oscillator",
    source="S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, Journal of Sound and Vibration"
    " 90 (1983) 129–155; J. M. T. Thompson, A. R. Bokaian, R. Ghaffari, Subharmonic resonances and chaotic motions of a"
    " bilinear oscillator, IMA Journal of Applied Mathematics 31 (1983) 207–234.",
    equations=r"$$x'' + 2\zeta x' + k(x)\,x = \cos\Omega t,$$ $k = 1$ for $x \lt 0$ and $k_2$ for $x \gt 0$.",
    comparisons=(
        Comparison(
            r"The natural frequency is exactly $2\,\omega_1\omega_2/(\omega_1 + \omega_2)$, whatever the amplitude;"
            r" that of the impact oscillator, $k_2 \to \infty$, is 2.",
            "Free vibration by harmonic balance of order 63.",
            tuple(
                Number(rf"$k_2 = {stiffness:g}$, largest $x$ {highest:g}", 2.0 * w / (1.0 + w), 1e-6)
                for stiffness, highest in ((4.0, 1.0), (4.0, 7.0), (9.0, 1.0), (25.0, 1.0), (100.0, 1.0))
                for w in (np.sqrt(stiffness),)
            ),
            _natural,
        ),
        Comparison(
            r"Subharmonic resonances lie near $n$ times the natural frequency, here with $k_2 = 4$ and $\zeta = 0.02$.",
            "Branches of $n$ periods from attractors, order 9: 1 where one passes there.",
            (Number("two periods at 8/3", 1, 0), Number("three periods at 4", 1, 0)),
            _subharmonics,
        ),
    ),
    draw=_draw,
    caption=r"Largest $x$ at order 9, $k_2 = 4$, $\zeta = 0.02$; blue: motions of several periods; dashed: unstable.",
)
