"""What attractors are called, and what random starts cannot tell, said once for all texts and figures."""

import numpy as np

from solver import ImpactState
from solver.timedomain import AttractorKind

__all__ = ["attractor_name", "bound", "cell_label", "label_meaning", "likely_missed", "percents"]


def attractor_name(kind: int, impact: int) -> str:
    """Kind and impact state: "1T/0", "chaotic/2"; without a state where it has none.

    Examples
    --------
    >>> attractor_name(2, 1), attractor_name(12, -1)
    ('2T/1', 'unbounded')
    """
    name = AttractorKind(kind).label.replace("_", "-")
    return f"{name}/{ImpactState(impact).symbol}" if impact >= 0 else name


def cell_label(kinds, impacts) -> str:
    """Everything that was found in a cell, in the order of kinds and states: "1T/0 + 1T/1 + 4T/1".

    Parameters
    ----------
    kinds, impacts : sequence of int
        Of its attractors; `AttractorKind.NONE` is left out.
    """
    found = sorted((int(kind), int(impact)) for kind, impact in zip(kinds, impacts, strict=True) if kind)
    return " + ".join(attractor_name(*one) for one in found)


def label_meaning(label: str) -> str:
    """A label of a cell in the alphabet of CF flag meanings.

    Examples
    --------
    >>> label_meaning("1T/0 + quasi-periodic/1"), label_meaning("")
    ('1T_I0+quasi_periodic_I1', 'not_known')
    """
    return label.replace(" + ", "+").replace("/", "_I").replace("-", "_") or "not_known"


def likely_missed(starts: int) -> float:
    """The largest share of the box that an attractor's basin may have and still be missed with a chance of 5 %."""
    return 1.0 if starts == 0 else float(1.0 - np.float64(0.05) ** (1.0 / starts))


def bound(starts: int) -> str:
    """What random starts cannot tell.

    Examples
    --------
    >>> bound(4)
    'With 4 random starts, an attractor with basin share p was missed with probability (1 - p)^4: 5 % at p = 53 %.'
    """
    if starts == 0:
        return "Without random starts, nothing is known of attractors that no other start led to."
    many = "start" if starts == 1 else "starts"
    share = 100.0 * likely_missed(starts)
    said = f"{share:.0f}" if share >= 9.5 else f"{share:.2g}"
    return (
        f"With {starts} random {many}, an attractor with basin share p was missed with probability (1 - p)^{starts}: "
        f"5 % at p = {said} %."
    )


def percents(counts: list[int]) -> list[str]:
    """Shares in percent with one decimal that add up to 100 % exactly (largest remainders).

    What is not 0 does not look so, which the largest one pays for.

    Examples
    --------
    >>> percents([1, 1, 1]), percents([9999, 1, 0]), percents([0, 0])
    (['33.4 %', '33.3 %', '33.3 %'], ['99.9 %', '0.1 %', '0.0 %'], ['–', '–'])
    """
    counts, total = np.asarray(counts, dtype=np.int64), int(np.sum(counts))
    if total == 0:
        return ["–"] * len(counts)
    tenths, rest = np.divmod(counts * 1000, total)
    tenths[np.argsort(-rest, kind="stable")[: 1000 - int(tenths.sum())]] += 1
    hidden = (counts > 0) & (tenths == 0)
    tenths[hidden] = 1
    tenths[np.argmax(tenths)] -= int(np.sum(hidden))
    return [f"{number / 10:.1f} %" for number in tenths.tolist()]
