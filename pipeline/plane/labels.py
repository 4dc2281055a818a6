"""What n/I labels have in common: jumps, loss of contact, double-sided impact."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from solver import ImpactState, label_parts
from solver.regions.bands import Line

__all__ = ["RANKS", "TRAITS", "contact_lost", "double_sided", "intervals", "jumping", "labels_with", "share_of"]

_TOGETHER = {ImpactState.PERMANENT, ImpactState.MIRRORED_PERMANENT}

#: Severity of the impact states, from harmless to severe.
RANKS = {
    ImpactState.PERMANENT: 0,
    ImpactState.MIRRORED_PERMANENT: 0,
    ImpactState.FREE: 1,
    ImpactState.SINGLE_SIDED: 2,
    ImpactState.MIRRORED_SINGLE_SIDED: 2,
    ImpactState.DOUBLE_SIDED: 3,
}


def jumping(label: str) -> bool:
    """Whether several stable motions coexist; the solutions between them are unstable.

    Every fold makes one stable and one unstable solution, so that several solutions are several stable ones, unless
    some lie above the amplitude ceiling.
    """
    return label_parts(label)[0] > 1


def contact_lost(label: str) -> bool:
    """Whether a stable motion parts the teeth."""
    return bool(label_parts(label)[1] - _TOGETHER)


def double_sided(label: str) -> bool:
    """Whether a stable motion strikes both flanks."""
    return ImpactState.DOUBLE_SIDED in label_parts(label)[1]


#: By the names used in tables.
TRAITS: dict[str, Callable[[str], bool]] = {
    "jump": jumping,
    "contact loss": contact_lost,
    "double-sided impact": double_sided,
}


def labels_with(labels: Iterable[str], trait: Callable[[str], bool]) -> tuple[str, ...]:
    """The labels that have a trait."""
    return tuple(label for label in labels if trait(label))


def share_of(shares: Mapping[str, float], trait: Callable[[str], bool]) -> float:
    """What the labels that have a trait add up to."""
    return sum((share for label, share in shares.items() if trait(label)), 0.0)


def intervals(line: Line, trait: Callable[[str], bool]) -> tuple[tuple[float, float], ...]:
    """Unbroken parts of a row with a trait, ascending."""
    flags = np.array([trait(label) for label in line.labels], dtype=int)
    starts, stops = (np.flatnonzero(np.diff(flags, prepend=0, append=0) == step) for step in (1, -1))
    return tuple((float(line.ends[a]), float(line.ends[b])) for a, b in zip(starts, stops, strict=True))
