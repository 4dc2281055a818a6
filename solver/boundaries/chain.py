"""Pieces of one curve that follow each other, and the joining of those that meet where continuation stops."""

from dataclasses import dataclass

import numpy as np

from solver.boundaries.curve import Piece
from solver.continuation.continuation import Curve, EndReason

__all__ = ["MEET", "Chain", "joined", "reversed_piece"]

_SAME = 1e-6
#: Continuation creeps up to a corner to about its smallest step times the steepness there.
MEET = 1e-4


def reversed_piece(piece: Piece) -> Piece:
    """The same piece, the other way."""
    curve = piece.curve
    back = Curve(
        curve.points[::-1].copy(),
        -curve.tangents[::-1],
        curve.arclength[-1] - curve.arclength[::-1],
        curve.stable[::-1].copy(),
        curve.event[::-1].copy(),
        curve.ends[::-1],
        curve.refused,
    )
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
        return Chain(tuple(reversed_piece(piece) for piece in self.pieces[::-1]), self.closed)

    def directed(self) -> "Chain":
        """From the end with the smaller p, then x."""
        first, last = (tuple(y[[-1, -2]]) for y in self.tips)
        return self.reversed() if not self.closed and first > last else self

    def parts(self) -> list["Chain"]:
        """The chain cut at its corners."""
        corners = [i for i, piece in enumerate(self.pieces) if piece.curve.ends[1] is EndReason.STEP_TOO_SMALL]
        if not corners:
            return [self]
        cuts = [0, *(i + 1 for i in corners if i + 1 < len(self.pieces)), len(self.pieces)]
        return [Chain(self.pieces[first:last]) for first, last in zip(cuts[:-1], cuts[1:], strict=True)]

    def followed_by(self, piece: Piece) -> "Chain":
        """With one more piece, or closed if that one is the first again."""
        first = self.pieces[0]
        same = np.array_equal(first.problem.theta, piece.problem.theta)
        ends = ((piece.curve.points[i], first.curve.points[i]) for i in (0, -1))
        if same and all(np.max(np.abs(ours - theirs) / first.problem.scale) < _SAME for ours, theirs in ends):
            return Chain(self.pieces, True)
        return Chain((*self.pieces, piece))


def _gap(left: Chain, right: Chain) -> float:
    """Scaled distance from the end of one chain to the start of another, if continuation stopped at both."""
    if left.ends[1] is not EndReason.STEP_TOO_SMALL or right.ends[0] is not EndReason.STEP_TOO_SMALL:
        return np.inf
    return float(np.max(np.abs(left.tips[1] - right.tips[0]) / right.pieces[0].problem.scale))


def joined(chains: list[Chain]) -> list[Chain]:
    """The chains, those of them joined that stop at the same corner, each from the end with the smaller p (then x)."""
    chains = list(chains)
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
        if best[0] > MEET:
            return [chain.directed() for chain in chains]
        _, i, j, whole = best
        if i == j:
            chains[i] = Chain(whole.pieces, True)
        else:
            chains[i] = whole
            del chains[j]
