"""What integration says about one solution of the map."""

import enum
from dataclasses import dataclass

import numpy as np

from solver.timedomain import Attractor, AttractorKind

__all__ = ["Seen", "Verdict", "seen_of", "settling_of"]


class Verdict(enum.IntEnum):
    """Whether a motion that starts on a solution of the map settles on it."""

    CONFIRMED = 0
    OTHER_MOTION = 1
    WRONG_IMPACT = 2
    NOT_PERIOD_1 = 3
    UNBOUNDED = 4
    UNSETTLED = 5
    FAILED = 6

    @property
    def sentence(self) -> str:
        """What the verdict means."""
        return _SENTENCES[self]


_SENTENCES = {
    Verdict.CONFIRMED: "It settles on a motion with the map's mean, amplitude and impact state.",
    Verdict.OTHER_MOTION: "It settles on another motion: the map's does not exist, is unstable, or lies far off.",
    Verdict.WRONG_IMPACT: "It settles on a motion with the map's mean and amplitude, but in another impact state.",
    Verdict.NOT_PERIOD_1: "It settles on a motion that does not repeat after the map's period: 2T, torus, chaos.",
    Verdict.UNBOUNDED: "It grows above the ceiling.",
    Verdict.UNSETTLED: "It converges so slowly that the allowed periods do not tell where to.",
    Verdict.FAILED: "It could not be integrated; the message says why.",
}


@dataclass(frozen=True)
class Seen:
    """What became of one start; plain numbers, nan where they do not apply.

    Parameters
    ----------
    verdict : Verdict
    kind, period, impact, periods_used : int
    mean, amplitude, lyapunov, largest_multiplier : float
        As in `solver.timedomain.Attractor`.
    message : str
        Why it failed, else empty.
    """

    verdict: Verdict
    kind: int = int(AttractorKind.FAILED)
    period: int = 0
    impact: int = -1
    periods_used: int = 0
    mean: float = np.nan
    amplitude: float = np.nan
    lyapunov: float = np.nan
    largest_multiplier: float = np.nan
    message: str = ""


def seen_of(attractor: Attractor, mean: float, amplitude: float, impact: int, room: float, period: int) -> Seen:
    """Compare where a motion settled with the solution of the map that it started on.

    Parameters
    ----------
    attractor : Attractor
    mean, amplitude : float
        Of the map's solution.
    impact : int
        Its `ImpactState`.
    room : float
        How far mean and amplitude may be off.
    period : int
        Forcing periods after which motions of the map repeat; a motion that repeats sooner is one of them.
    """
    failed = attractor.kind is AttractorKind.FAILED
    return Seen(
        _verdict(attractor, mean, amplitude, impact, room, period),
        int(attractor.kind),
        attractor.period,
        int(attractor.impact),
        attractor.periods_used,
        attractor.mean,
        attractor.amplitude,
        attractor.lyapunov,
        attractor.largest_multiplier,
        attractor.status.sentence if failed else "",
    )


_ENDINGS = {
    AttractorKind.FAILED: Verdict.FAILED,
    AttractorKind.UNBOUNDED: Verdict.UNBOUNDED,
    AttractorKind.UNSETTLED: Verdict.UNSETTLED,
}


def _verdict(attractor: Attractor, mean, amplitude, impact, room, period) -> Verdict:
    if attractor.kind in _ENDINGS:
        return _ENDINGS[attractor.kind]
    if not attractor.kind.periodic or period % attractor.period != 0:
        return Verdict.NOT_PERIOD_1
    if not (abs(attractor.mean - mean) <= room and abs(attractor.amplitude - amplitude) <= room):
        return Verdict.OTHER_MOTION
    return Verdict.CONFIRMED if attractor.impact == impact else Verdict.WRONG_IMPACT


def settling_of(max_periods: int):
    """The `Settling` that never integrates a motion for more than `max_periods` forcing periods, the watch over the
    Lyapunov exponent included.

    Examples
    --------
    >>> settling = settling_of(3000)
    >>> settling.max_periods, settling.lyapunov_periods
    (740, 2000)
    """
    from solver.timedomain import Settling

    block = Settling().block
    window = min(Settling().lyapunov_periods, max_periods // 2 // 20 * 20)
    return Settling(max_periods=max_periods - window - window // 10 - block, lyapunov_periods=window)
