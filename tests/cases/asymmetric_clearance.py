"""A clearance slightly off the middle, with an isolated subharmonic branch."""

import numpy as np

from solver import ContactSystem
from solver.timedomain import AttractorKind, IsolatedBranch, find_attractors, isolated_branches
from tests.cases.case import Case, Comparison, Number
from tests.cases.curves import SUBHARMONIC, draw_branch, draw_row, folds, galerkin_row

__all__ = ["CASE", "off_the_middle"]


def off_the_middle(epsilon: float) -> ContactSystem:
    """x'' + 0.04 x' + 0.25 x + 0.75 f(x) = 1.2 + sin, gaps 4 + epsilon in front and 4 - epsilon at the back."""
    return ContactSystem(
        [[1.0]], [[0.04]], [[0.25]], [1.0], [0.75], 4.0 + epsilon, 4.0 - epsilon, load=[[1.2], [-1.0j]]
    )


def _isola(epsilon: float, order: int) -> IsolatedBranch:
    """The closed branch of three periods near 2.8."""
    row = galerkin_row(off_the_middle(epsilon), 2.0, 3.2, order)
    (branch,) = isolated_branches(row, np.linspace(2.6, 2.95, 8)).branches
    assert branch.period == 3 and branch.isolated
    return branch


def _ends() -> list[float]:
    return [end for epsilon in (0.0, 0.1) for end in folds(_isola(epsilon, 7).curve)]


def _by_integration() -> list[int]:
    """Motions of three periods 0.01 inside and 0.01 outside of both ends."""
    low, high = folds(_isola(0.1, 7).curve)
    places = [low - 0.01, low + 0.01, high - 0.01, high + 0.01]
    kinds = find_attractors(off_the_middle(0.1), "omega", places).kind
    return [int(np.count_nonzero(kind == AttractorKind.PERIOD_3)) for kind in kinds]


def _draw(axes) -> None:
    row = galerkin_row(off_the_middle(0.1), 0.3, 3.2, 9)
    draw_row(axes, row)
    for branch in isolated_branches(row, np.linspace(0.3, 3.2, 60)).branches:
        draw_branch(axes, row.system, branch.balance, branch.curve, SUBHARMONIC)
    axes.set_ylim(3.8, 10.0)


CASE = Case(
    title="A clearance slightly off the middle",
    source="C. Duan, R. Singh, Isolated sub-harmonic resonance branch in the frequency response of an oscillator with"
    " slight asymmetry in the clearance, Journal of Sound and Vibration 314 (2008) 12–18,"
    " [doi:10.1016/j.jsv.2007.12.040](https://doi.org/10.1016/j.jsv.2007.12.040).",
    equations=r"$$x'' + 0.04\,x' + 0.25\,x + 0.75\,f(x) = 1.2 + \sin\Omega t,$$ with gaps $4 + \varepsilon$ and"
    r" $4 - \varepsilon$.",
    comparisons=(
        Comparison(
            "The source has figures; these digits are of harmonic balance of order 21.",
            "The closed branch of three periods, from an attractor, at order 7.",
            (
                Number(r"lower end $\Omega$, $\varepsilon = 0$", 2.671885, 2e-6),
                Number(r"upper end $\Omega$, $\varepsilon = 0$", 2.904090, 2e-6),
                Number(r"lower end $\Omega$, $\varepsilon = 0.1$", 2.654053, 2e-6),
                Number(r"upper end $\Omega$, $\varepsilon = 0.1$", 2.907733, 2e-6),
            ),
            _ends,
        ),
        Comparison(
            r"Motions of three periods exist inside the branch's ends alone, $\varepsilon = 0.1$.",
            "Attractors 0.01 outside and inside of both ends, by integration from rest and from random states.",
            (
                Number("outside of the lower end", 0, 0),
                Number("inside of the lower end", 1, 0),
                Number("inside of the upper end", 1, 0),
                Number("outside of the upper end", 0, 0),
            ),
            _by_integration,
        ),
    ),
    draw=_draw,
    caption=r"Largest $x$ at order 9 below the peak, $\varepsilon = 0.1$; blue: motions of several periods; dashed:"
    " unstable.",
)
