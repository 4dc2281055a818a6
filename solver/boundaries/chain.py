"""Pieces of one curve that follow each other, and the joining of those that meet where continuation stops."""

from dataclasses import dataclass

import numpy as np

from solver.boundaries.bifurcation_plane import WINDOW
from solver.boundaries.curve import Piece
from solver.continuation import Curve, EndReason

__all__ = ["Chain", "joined"]

_SAME = 1e-6
# Continuation creeps up to a corner to about its smallest step times the steepness there.
_MEET = 1e-4


def _reversed(piece: Piece) -> Piece:
    curve = piece.curve
    back = Curve(
        curve.points[::-1].copy(), -curve.tangents[::-1], curve.arclength[-1] - curve.arclength[::-1],
        curve.stable[::-1].copy(), curve.event[::-1].copy(), curve.ends[::-1], curve.refused,
    )  # fmt: skip
    return Piece(piece.problem, back)


@dataclass(frozen=True)
class Chain:
    """Pieces in order; `closed` if the last one leads back to the first."""

    pieces: tuple[Piece, ...]
    closed: bool = False

    @property
    def ends(self) -> tuple[EndReason, EndReason]:
        """Why it ends at its first and at its last point."""
        if self.closed:
            return EndReason.CLOSED, EndReason.CLOSED
        return self.pieces[0].curve.ends[0], self.pieces[-1].curve.ends[1]

    @property
    def tips(self) -> tuple[np.ndarray, np.ndarray]:
        """Its first and its last y."""
        return self.pieces[0].curve.points[0], self.pieces[-1].curve.points[-1]

    def reversed(self) -> "Chain":
        """The same curve, the other way."""
        return Chain(tuple(_reversed(piece) for piece in self.pieces[::-1]), self.closed)

    def directed(self) -> "Chain":
        """From the end with the smaller p, then x."""
        first, last = (tuple(y[[-1, -2]]) for y in self.tips)
        return self.reversed() if not self.closed and first > last else self

    def closed_up(self) -> "Chain":
        """The same pieces as a closed curve."""
        return Chain(self.pieces, True)

    def starts_at(self, window: int, y: np.ndarray) -> bool:
        """Whether its first piece begins at a y of a window."""
        first = self.pieces[0]
        gap = np.abs(y - first.curve.points[0]) / first.problem.scale
        return int(first.problem.theta[WINDOW]) == window and bool(np.max(gap) < _SAME)


def _gap(left: Chain, right: Chain) -> float:
    """Distance in scaled unknowns from the end of one chain to the start of another, if continuation stopped at both."""
    if left.ends[1] is not EndReason.STEP_TOO_SMALL or right.ends[0] is not EndReason.STEP_TOO_SMALL:
        return np.inf
    return float(np.max(np.abs(left.tips[1] - right.tips[0]) / right.pieces[0].problem.scale))


def joined(chains: list[Chain]) -> list[Chain]:
    """The chains, those of them joined that stop at the same corner, each from the end with the smaller p (then x)."""
    chains = [Chain(chain.pieces, chain.closed or chain.pieces[0].curve.closed) for chain in chains]
    while True:
        gaps = []
        for i, left in enumerate(chains):
            if left.closed:
                continue
            if len(left.pieces[0].curve.points) > 1:
                gaps.append((_gap(left, left), i, i, left))
            for j, right in enumerate(chains[:i]):
                if not right.closed:
                    for one in (left, left.reversed()):
                        for other in (right, right.reversed()):
                            gaps.append((_gap(one, other), i, j, Chain((*one.pieces, *other.pieces))))
        best = min(gaps, key=lambda gap: gap[0], default=(np.inf,))
        if best[0] > _MEET:
            return [chain.directed() for chain in chains]
        _, i, j, whole = best
        if i == j:
            chains[i] = whole.closed_up()
        else:
            chains[i] = whole
            del chains[j]
