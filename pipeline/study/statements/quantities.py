"""How the numbers of statements are computed: from the regions and boundary curves of stored planes, or anew."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import StoreError
from pipeline.plane.labels import TRAITS, intervals, jumping, labels_with, share_of
from pipeline.study.statements.planes import Planes, default_model
from solver import Continuation, Event, Proof, enumerate_row, label_parts, sweep_row

__all__ = [
    "AllSolutions",
    "DefaultInterval",
    "LabelThreshold",
    "RowFolds",
    "ShareOfCount",
    "StoredFolds",
    "TraitThreshold",
    "WorstImpact",
]

_COLUMNS = 400


class _Listed:
    """Numbers that read as a list, to the four digits that a comparison with the article deserves."""

    def shown(self, values: Sequence[float]) -> str:
        """For a cell of a table."""
        return ", ".join(f"{value:.4g}" for value in values) or "none"


class _Grouped:
    """Numbers that belong together in groups, one group a line."""

    size: int
    decimals: int

    def shown(self, values: Sequence[float]) -> str:
        """For a cell of a table."""
        texts = [f"{value:.{self.decimals}f}" for value in values]
        groups = (", ".join(texts[i : i + self.size]) for i in range(0, len(texts), self.size))
        return "\n".join(groups) or "none"


@dataclass(frozen=True)
class DefaultInterval:
    """Ends of the widest interval with several stable motions, at one resonance of the published gear."""

    plane: str
    resonance: str

    @property
    def how(self) -> str:
        """In words."""
        return f"fold curves met by the row of the default value, {self.resonance} resonance; the widest interval"

    def shown(self, values: Sequence[float]) -> str:
        """For a cell of a table."""
        return "–".join(f"{value:.4f}" for value in values)

    def values(self, planes: Planes) -> tuple[float, ...]:
        """Low and high end in omega."""
        found = intervals(planes.default_line(self.plane, self.resonance), jumping)
        if not found:
            raise StoreError("there is no multivalued interval")
        return max(found, key=lambda interval: interval[1] - interval[0])


@dataclass(frozen=True)
class LabelThreshold(_Listed):
    """Where labels appear ("from") or disappear ("to") at one resonance: one number for each pair of label and end.

    Of several unbroken ranges the first beginning and the last end count.
    """

    plane: str
    resonance: str
    ends: tuple[tuple[str, str], ...]

    @property
    def how(self) -> str:
        """In words."""
        words = {"from": "first appears", "to": "last disappears"}
        parts = " and ".join(f"{label} {words[end]}" for label, end in self.ends)
        return f"where {parts} in the regions of the {self.resonance} resonance"

    def values(self, planes: Planes) -> tuple[float, ...]:
        """Values of the row parameter."""
        part = planes.part(self.plane, self.resonance)
        found = []
        for label, end in self.ends:
            ranges = part.ranges((label,))
            if not ranges:
                raise StoreError(f"there is no {label}")
            found.append(_inner(part, ranges[0][0] if end == "from" else ranges[-1][1], f"{label} {end}"))
        return tuple(found)


@dataclass(frozen=True)
class TraitThreshold(_Listed):
    """Where a trait of `pipeline.plane.labels` begins ("from") or ends ("to") in the range nearest to a value."""

    plane: str
    resonance: str
    trait: str
    end: str
    near: float

    @property
    def how(self) -> str:
        """In words."""
        verb = "begins" if self.end == "from" else "ends"
        return f"where {self.trait} {verb} in the regions of the {self.resonance} resonance, nearest to the article's"

    def values(self, planes: Planes) -> tuple[float, ...]:
        """One value of the row parameter."""
        part = planes.part(self.plane, self.resonance)
        ranges = part.ranges(labels_with(part.labels, TRAITS[self.trait]))
        low, high = part.plane.p_range
        places = [found[self.end == "to"] for found in ranges]
        inside = [place for place in places if low < place < high]
        if not inside:
            raise StoreError(f"{self.trait} does not {'begin' if self.end == 'from' else 'end'} in this plane")
        return (min(inside, key=lambda place: abs(place - self.near)),)


def _inner(part, place: float, what: str) -> float:
    if not part.plane.p_range[0] < place < part.plane.p_range[1]:
        raise StoreError(f"{what} lies at the border of the plane or beyond")
    return place


@dataclass(frozen=True)
class WorstImpact(_Listed):
    """The severest impact state I of stable motions at one resonance of the published gear."""

    plane: str
    resonance: str

    @property
    def how(self) -> str:
        """In words."""
        return f"largest I of the labels that the row of the default value meets, {self.resonance} resonance"

    def values(self, planes: Planes) -> tuple[float, ...]:
        """The state's number."""
        line = planes.default_line(self.plane, self.resonance)
        return (float(max(state for label in line.labels for state in label_parts(label)[1])),)


@dataclass(frozen=True)
class ShareOfCount:
    """Share of a plane's area in which at least so many motions are stable."""

    plane: str
    count: int

    @property
    def how(self) -> str:
        """In words."""
        return f"area of the regions with n >= {self.count}, as a share of the plane"

    def shown(self, values: Sequence[float]) -> str:
        """For a cell of a table."""
        return ", ".join(f"{100.0 * value:.2g} % of the plane" for value in values)

    def values(self, planes: Planes) -> tuple[float, ...]:
        """One share."""
        return (share_of(planes.whole(self.plane).shares, lambda label: label_parts(label)[0] >= self.count),)


@dataclass(frozen=True)
class StoredFolds(_Grouped):
    """Omega, lambda_m and lambda_a of the folds of the published gear, by ascending omega."""

    plane: str

    size, decimals = 3, 6

    @property
    def how(self) -> str:
        """In words."""
        return "fold curves of the stored plane met by the row of the default value: Ω, λ_m, λ_a"

    def values(self, planes: Planes) -> tuple[float, ...]:
        """Three numbers a fold."""
        value = planes.default(self.plane)
        curves = planes.whole(self.plane).curves
        points = [curve.crossings([value])[1] for curve in curves if curve.kind is Event.FOLD]
        return _flat(np.concatenate([np.empty((0, 5)), *points])[:, [3, 0, 1, 2]])


@dataclass(frozen=True)
class RowFolds(_Grouped):
    """Omega, lambda_m and lambda_a of the folds of a gear of `conf/gear`, by ascending omega."""

    gear: str
    low: float = 0.05
    high: float = 2.0

    size, decimals = 3, 6

    @property
    def how(self) -> str:
        """In words."""
        return f"one row of gear={self.gear} continued anew over Ω = {self.low:g}–{self.high:g}: Ω, λ_m, λ_a"

    def values(self, planes: Planes) -> tuple[float, ...]:
        """Three numbers a fold."""
        grid = np.linspace(self.low, self.high, _COLUMNS)
        row = sweep_row(default_model(self.gear), "omega", grid, continuation=Continuation())
        points = [curve.points[curve.event == Event.FOLD] for curve in row.curves]
        return _flat(np.concatenate([np.empty((0, 4)), *points])[:, [3, 0, 1, 2]])


def _flat(points: np.ndarray) -> tuple[float, ...]:
    """Rows omega, lambda_m, lambda_c, lambda_s as a flat tuple of omega, lambda_m, lambda_a by ascending omega."""
    omega, mean, cos, sin = points[np.argsort(points[:, 0])].T
    return tuple(map(float, np.column_stack([omega, mean, np.hypot(cos, sin)]).ravel()))


@dataclass(frozen=True)
class AllSolutions(_Grouped):
    """lambda_m and lambda_a of every solution of a gear of `conf/gear` at one frequency, by ascending amplitude."""

    gear: str
    omega: float

    size, decimals = 2, 8

    @property
    def how(self) -> str:
        """In words."""
        return f"every solution of gear={self.gear} at Ω = {self.omega:g} enumerated with proof: λ_m, λ_a"

    def values(self, planes: Planes) -> tuple[float, ...]:
        """Two numbers a solution."""
        found = enumerate_row(default_model(self.gear), "omega", [self.omega])
        if found.proof[0] != Proof.PROVEN:
            raise StoreError("the solutions are not proven to be all")
        pairs = np.column_stack([found.mean[0], found.amplitude[0]])
        pairs = pairs[np.isfinite(pairs[:, 0])]
        return tuple(map(float, pairs[np.argsort(pairs[:, 1])].ravel()))
