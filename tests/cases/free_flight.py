"""Free vibration of a mass that flies between two springs."""

import numpy as np

from solver import ContactSystem, free_vibration
from tests.cases.case import Case, Comparison, Number

__all__ = ["CASE", "FLYING"]

#: x'' + f(x) = 0 with gaps 1.
FLYING = ContactSystem([[1.0]], [[0.0]], [[0.0]], [1.0], [1.0], 1.0, 1.0)
_HIGHEST = (1.5, 3.0, 10.0)


def _draw(axes) -> None:
    highest = np.geomspace(1.02, 20.0, 60)
    axes.plot(free_vibration(FLYING, highest, order=31).omega, highest, color="#1a1a1a", linewidth=1.3)
    axes.set(xlabel="Ω", ylabel="largest displacement", xlim=(0.0, 1.0), ylim=(0.0, 20.0))


CASE = Case(
    title="Backbone of a clearance",
    source="Closed form: half a period on the springs, and two flights of length 2 at the speed $A - 1$.",
    equations=r"$$x'' + f(x) = 0, \qquad 1/\Omega = 1 + \frac{2}{\pi\,(A - 1)},$$ gap 1, largest displacement $A$.",
    comparisons=(
        Comparison(
            "The closed form.",
            "Free vibration by harmonic balance of order 63.",
            tuple(
                Number(rf"$\Omega$ at $A = {highest:g}$", value, 5e-8)
                for highest, value in zip(_HIGHEST, (0.43990085, 0.75854699, 0.93393744), strict=True)
            ),
            lambda: free_vibration(FLYING, _HIGHEST, order=63).omega,
        ),
    ),
    draw=_draw,
    caption="The backbone.",
)
