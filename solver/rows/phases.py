"""Motions of several forcing periods that are one motion: the same one begun a number of forcing periods later."""

import numpy as np

from solver.continuation.solution_curve import Curve, EndReason
from solver.rows.span import RowSpan

__all__ = ["distance_to_curve", "equal_motions", "one_phase", "shifted"]

_SAME = 1e-6
#: In units of lambda's size: subharmonics of a motion of the forcing period, and those of a branch at which
#: continuation may give up because they vanish.
_NO_SUBHARMONIC, _VANISHING = 1e-6, 2e-2


def shifted(motions: np.ndarray, periods: int, period: int) -> np.ndarray:
    """The same motions, some forcing periods later.

    Parameters
    ----------
    motions : (..., n) array
        Unknowns (Lambda_0, c_1, s_1, ...).
    periods : int
        How many forcing periods later.
    period : int
        nu, forcing periods of the balance.

    Returns
    -------
    (..., n) array
    """
    k = np.arange(1, motions.shape[-1] // 2 + 1)
    moved = (motions[..., 1::2] - 1j * motions[..., 2::2]) * np.exp(2j * np.pi * k * periods / period)
    result = motions.copy()
    result[..., 1::2], result[..., 2::2] = moved.real, -moved.imag
    return result


def equal_motions(left: np.ndarray, right: np.ndarray, scale, period: int) -> np.ndarray:
    """Whether solutions are one motion, perhaps some forcing periods later.

    Parameters
    ----------
    left, right : (..., n) arrays
    scale : float or (n,) array
        Size of the unknowns.
    period : int
        nu, forcing periods of the balance.

    Returns
    -------
    (...) bool array
    """
    return np.logical_or.reduce(
        [
            np.max(np.abs((shifted(left, shift, period) if shift else left) - right) / scale, axis=-1) <= _SAME
            for shift in range(period)
        ]
    )


def distance_to_curve(y: np.ndarray, curve: Curve, scale: np.ndarray, period: int) -> float:
    """Distance of y = (u, p), in scaled unknowns, from the polygon through a curve's points, at its nearest phase.

    Parameters
    ----------
    y : (n + 1,) array
    curve : Curve
    scale : (n + 1,) array
    period : int
        nu, forcing periods of the balance.
    """
    steps = np.diff(curve.points, axis=0) / scale
    squares, nearest = np.maximum(np.sum(steps**2, axis=1), 1e-300), np.inf
    for shift in range(period):
        ahead = (np.append(shifted(y[:-1], shift, period), y[-1]) - curve.points[:-1]) / scale
        along = np.clip(np.sum(ahead * steps, axis=1) / squares, 0.0, 1.0)
        nearest = min(nearest, np.min(np.linalg.norm(ahead - along[:, None] * steps, axis=1)))
    return float(nearest)


def one_phase(span: RowSpan, curve: Curve) -> Curve:
    """A subharmonic curve cut where its subharmonics vanish: beyond, it is the same motions one period later.

    There it is singular, so that continuation gives up close by or steps across. A curve of four periods is cut where
    it has the subharmonics of two left; where it has no others, it is a curve of two.
    """
    period, k = span.balance.period, np.repeat(np.arange(1, span.balance.harmonics + 1), 2)
    if period == 1 or not len(curve.points):
        return curve
    for divisor in (2, 4) if period == 4 else (period,):
        motions = curve.points[:, 1:-1][:, k % divisor != 0]
        size = np.linalg.norm(motions, axis=1) / span.problem.scale[0]
        if np.max(size) >= _NO_SUBHARMONIC:
            break
    else:
        return curve
    largest = int(np.argmax(size))
    # Across the singular point the subharmonics change sign from one point to the next; or there are none any more, and
    # the curve goes on along the motions of the shorter period.
    none = size < _NO_SUBHARMONIC
    turned = np.flatnonzero((np.sum(motions[1:] * motions[:-1], axis=1) < 0.0) | none[1:] | none[:-1])
    first = max((int(i) + 1 for i in turned if i < largest), default=0)
    last = min((int(i) for i in turned if i >= largest), default=len(size) - 1)
    ends = tuple(
        EndReason.JOINED if cut != whole or (end is EndReason.STEP_TOO_SMALL and size[cut] < _VANISHING) else end
        for cut, whole, end in zip((first, last), (0, len(size) - 1), curve.ends, strict=True)
    )
    return curve.between(first, last, ends)
