"""Stretches of one boundary that follow each other, and the joining of those that meet where continuation stops."""

from dataclasses import dataclass

import numpy as np

from solver.boundaries.problem import SAME, Stretch
from solver.continuation.continuation import EndReason

__all__ = ["MEET", "Chain", "joined"]

#: Continuation creeps up to a corner to about its smallest step times the steepness there.
MEET = 1e-4


@dataclass(frozen=True)
class Chain:
    """Stretches in order; `closed` if the last one leads back to the first."""

    stretches: tuple[Stretch, ...]
    closed: bool = False

    @property
    def ends(self) -> tuple[EndReason, EndReason]:
        """Why it ends at its first and at its last point."""
        if self.closed:
            return EndReason.CLOSED, EndReason.CLOSED
        return self.stretches[0].curve.ends[0], self.stretches[-1].curve.ends[1]

    @property
    def tips(self) -> tuple[np.ndarray, np.ndarray]:
        """Its first and its last y."""
        return self.stretches[0].curve.points[0], self.stretches[-1].curve.points[-1]

    def reversed(self) -> "Chain":
        """The same curve, the other way."""
        return Chain(tuple(stretch.reversed() for stretch in self.stretches[::-1]), self.closed)

    def directed(self) -> "Chain":
        """From the end with the smaller p, then x."""
        first, last = (tuple(y[[-1, -2]]) for y in self.tips)
        return self.reversed() if not self.closed and first > last else self

    def parts(self) -> list["Chain"]:
        """The chain cut at its corners."""
        corners = [i for i, stretch in enumerate(self.stretches) if stretch.curve.ends[1] is EndReason.STEP_TOO_SMALL]
        if not corners:
            return [self]
        cuts = [0, *(i + 1 for i in corners if i + 1 < len(self.stretches)), len(self.stretches)]
        return [Chain(self.stretches[first:last]) for first, last in zip(cuts[:-1], cuts[1:], strict=True)]

    def followed_by(self, stretch: Stretch) -> "Chain":
        """With one more stretch, or closed if that one is the first again."""
        first = self.stretches[0]
        ends = ((stretch.curve.points[i], first.curve.points[i]) for i in (0, -1))
        same = first.contact == stretch.contact
        if same and all(np.max(np.abs(ours - theirs) / first.problem.scale) < SAME for ours, theirs in ends):
            return Chain(self.stretches, True)
        return Chain((*self.stretches, stretch))


def _gap(left: Chain, right: Chain) -> float:
    """Scaled distance from the end of one chain to the start of another, if continuation stopped at both."""
    if left.ends[1] is not EndReason.STEP_TOO_SMALL or right.ends[0] is not EndReason.STEP_TOO_SMALL:
        return np.inf
    return float(np.max(np.abs(left.tips[1] - right.tips[0]) / right.stretches[0].problem.scale))


def joined(chains: list[Chain]) -> list[Chain]:
    """The chains, those of them joined that stop at the same corner, each from the end with the smaller p (then x)."""
    chains = list(chains)
    while True:
        gaps = []
        for i, left in enumerate(chains):
            if left.closed:
                continue
            if len(left.stretches[0].curve.points) > 1:
                gaps.append((_gap(left, left), i, i, left))
            for j, right in enumerate(chains[:i]):
                if not right.closed:
                    for one in (left, left.reversed()):
                        for other in (right, right.reversed()):
                            gaps.append((_gap(one, other), i, j, Chain((*one.stretches, *other.stretches))))
        best = min(gaps, key=lambda gap: gap[0], default=(np.inf,))
        if best[0] > MEET:
            return [chain.directed() for chain in chains]
        _, i, j, whole = best
        if i == j:
            chains[i] = Chain(whole.stretches, True)
        else:
            chains[i] = whole
            del chains[j]
