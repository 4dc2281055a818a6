"""Stored branches of one row, cut at their folds into pieces over which the frequency is monotone."""

from dataclasses import dataclass

import numpy as np

from solver import EndReason, Event

__all__ = ["Branches", "Piece", "multivalued_intervals", "row_pieces"]

_TURNS = (Event.FOLD, Event.BRANCH_POINT)
_TOUCHING = 1e-9


@dataclass(frozen=True)
class Branches:
    """One row of a store's group `branches`: arrays over its points (P,), end reasons (branch_number, 2)."""

    omega: np.ndarray
    amplitude: np.ndarray
    arclength: np.ndarray
    stable: np.ndarray
    branch: np.ndarray
    event: np.ndarray
    end_reason: np.ndarray


@dataclass(frozen=True)
class Piece:
    """Part of a branch between two neighbouring folds or ends, both included.

    Parameters
    ----------
    omega, amplitude, arclength : (count,) arrays
        In order of arc length.
    stable : bool
        Static stability, the same all along.
    folds : tuple of bool
        Whether the first and the last point are folds.
    """

    omega: np.ndarray
    amplitude: np.ndarray
    arclength: np.ndarray
    stable: bool
    folds: tuple[bool, bool]


def row_pieces(branches: Branches) -> list[Piece]:
    """Cut every branch of a row at its folds and branch points."""
    pieces = []
    for number in np.unique(branches.branch):
        points = np.flatnonzero(branches.branch == number)
        omega, amplitude, arclength, stable, event = (
            getattr(branches, name)[points] for name in ("omega", "amplitude", "arclength", "stable", "event")
        )
        turns = np.flatnonzero(np.isin(event, _TURNS))
        if branches.end_reason[number, 1] == EndReason.CLOSED and turns.size:
            # A closed curve is opened at a fold, so that no piece is cut by where it happened to be started.
            start = turns[0]
            arclength = np.append(arclength[start:-1], arclength[: start + 1] + arclength[-1])
            omega, amplitude, stable, event = (
                np.append(values[start:-1], values[: start + 1]) for values in (omega, amplitude, stable, event)
            )
            turns = np.flatnonzero(np.isin(event, _TURNS))
        cuts = np.unique(np.concatenate([[0], turns, [omega.size - 1]]))
        for first, last in zip(cuts[:-1], cuts[1:], strict=True):
            here = slice(first, last + 1)
            # At a fold itself the stored stability is 0, whatever the piece is.
            regular = stable[here][~np.isin(event[here], _TURNS)]
            pieces.append(
                Piece(
                    omega[here], amplitude[here], arclength[here], bool(regular.size and regular[0] == 1),
                    (bool(event[first] == Event.FOLD), bool(event[last] == Event.FOLD)),
                )
            )  # fmt: skip
    return pieces


def multivalued_intervals(pieces: list[Piece]) -> tuple[tuple[float, float], ...]:
    """Frequency intervals with more than one solution, ascending; their ends are folds, or where a branch ends."""
    ends = np.array([[np.min(piece.omega), np.max(piece.omega)] for piece in pieces]).reshape(-1, 2)
    places = np.unique(ends)
    counts = np.sum((ends[:, :1] <= places[:-1]) & (ends[:, 1:] >= places[1:]), axis=0) if len(places) > 1 else []
    intervals: list[tuple[float, float]] = []
    for low, high, count in zip(places[:-1], places[1:], counts, strict=True):
        if count < 2:
            continue
        if intervals and low - intervals[-1][1] <= _TOUCHING:
            low = intervals.pop()[0]
        intervals.append((float(low), float(high)))
    return tuple(interval for interval in intervals if interval[1] - interval[0] > _TOUCHING)
