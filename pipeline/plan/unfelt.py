"""Harmonics of the excitation above those that a plan balances: the motions that they drive are not in its labels."""

from dataclasses import dataclass
from itertools import product

from pipeline.plan.kinds import kind_of
from pipeline.plan.numerics import model_at
from pipeline.plan.plan import Plan
from pipeline.plan.traits import excitation_harmonics, stiffness_harmonics

__all__ = ["UnfeltHarmonics", "unfelt_harmonics"]

#: Of the largest harmonic.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class UnfeltHarmonics:
    """Harmonics of the mesh frequency, ascending, that a balance of some order does not feel.

    Parameters
    ----------
    order : int
        Of the balance.
    stiffness, error : tuple of int
        Of the mesh stiffness, and of the transmission error or of what else drives the motion.
    drives : str
        What that is called.
    """

    order: int
    stiffness: tuple[int, ...]
    error: tuple[int, ...]
    drives: str = "transmission error"

    @property
    def words(self) -> str:
        """Which they are.

        Examples
        --------
        >>> UnfeltHarmonics(1, (2, 3), (2,)).words
        'stiffness harmonics 2, 3 and transmission error harmonic 2'
        """
        named = (("stiffness", self.stiffness), (self.drives, self.error))
        parts = [
            f"{name} harmonic{'s' * (len(numbers) > 1)} {', '.join(map(str, numbers))}"
            for name, numbers in named
            if numbers
        ]
        return " and ".join(parts)

    @property
    def sentence(self) -> str:
        """One line for people, with what feels them."""
        enough = max(self.stiffness + self.error)
        return (
            f"order {self.order} does not feel the motion that {self.words} drive, so that its labels are not "
            f"verified: solver=hb solver.order={enough} or more and stages=[attractors] feel it"
        )


def unfelt_harmonics(plan: Plan) -> UnfeltHarmonics | None:
    """What a plan's balance does not feel of its excitation; None where it feels all of it.

    A balance of order H has no row for the harmonics above H. Those of the transmission error do not enter at all;
    those of the stiffness, times the harmonics of the contact force, enter the rows up to H only in part.

    Parameters
    ----------
    plan : Plan
        Of a plane, a volume or a layer.
    """
    order = int(plan.solver["order"])
    stiffness, error = set(), set()
    planes = [plan] if plan.parameter2 is None else [plan.layer(0), plan.layer(-1)]
    for plane in planes:
        for row, column in product((plan.parameter.low, plan.parameter.high), (plan.sweep.low, plan.sweep.high)):
            model = model_at(plane, row, column)
            stiffness |= _above(order, stiffness_harmonics(model))
            error |= _above(order, excitation_harmonics(model))
    found = tuple(sorted(stiffness)), tuple(sorted(error))
    return UnfeltHarmonics(order, *found, kind_of(plan).drives) if stiffness | error else None


def _above(order: int, harmonics) -> set[int]:
    """The numbers of the harmonics above an order that are there; those that a fit leaves by rounding are not."""
    largest = max((abs(amplitude) for amplitude, _ in harmonics), default=0.0)
    there = (number for number, (size, _) in enumerate(harmonics, start=1) if abs(size) > _ROUNDING * largest)
    return {number for number in there if number > order}
