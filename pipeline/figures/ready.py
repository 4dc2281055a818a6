"""Whoever imports this is ready to draw: fonts are found, formulas can be set, and both backends are loaded.

A process hands all of that on when it forks (`pipeline.run.helpers`).
"""

import io

import scipy.optimize  # noqa: F401  (`solver.regions.slabs` takes it where it is needed)

import pipeline.figures.backbone
import pipeline.figures.curves
import pipeline.figures.map
import pipeline.figures.output  # noqa: F401
from pipeline.figures.drawing import Drawing, own_style

__all__ = []


def _draw_something() -> None:
    with own_style():
        figure = Drawing((1.0, 1.0))
        figure.add_axes((0.2, 0.2, 0.7, 0.7), xlabel=r"$\lambda_a$ and more")
        for kind in ("png", "pdf"):
            figure.savefig(io.BytesIO(), format=kind)


_draw_something()
