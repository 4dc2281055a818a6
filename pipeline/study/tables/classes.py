"""Verbal classes by rule: what the measured numbers are called, so that they can stand beside the study's words.

Every rule takes plain numbers and every threshold is a named constant; `RULES` says the same in the tables' notes.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.plane.labels import RANKS, share_of
from pipeline.study.numerals import percent
from pipeline.study.tables.bands import BandAtResonance
from solver import label_parts

__all__ = [
    "ASPECTS",
    "RULES",
    "impact_class",
    "jump_class",
    "jump_trend",
    "ranks",
    "resonance_class",
    "settled",
    "severest",
]

#: A jump is prominent where its widest interval is at least this share of the natural frequency.
PROMINENT_JUMP = 0.05
#: A jump grows or shrinks over the band where its widths at the first and last value differ by more than this share of
#: the widest.
JUMP_TREND = 0.1
#: An impact state counts from this share of the resonance's part of the axis on.
IMPACT_SHARE = 0.001
#: A peak is near linear within this share of the natural frequency.
NEAR_LINEAR = 0.02
#: A jump, or a peak, is settled where jump width and peak vary by at most this share of the natural frequency.
SETTLED = 0.01

#: From harmless to severe; the place in this list ranks the states.
IMPACTS = ("no impact", "out of contact", "single-sided", "double-sided")


RULES = {
    "jump": (
        f"Jump: narrow where the widest multivalued interval is below {percent(PROMINENT_JUMP)} of the linear "
        "natural frequency, else prominent; increasing or decreasing where its widths at the first and the last value "
        f"of the band differ by more than {percent(JUMP_TREND)} of the widest, else steady."
    ),
    "impact": (
        "Impact: the severest state (no impact, out of contact, single-sided, double-sided) that stable motions have "
        f"in {percent(IMPACT_SHARE)} of the resonance's part of the Ω axis or more, from the first to the last value "
        "of the band, and the severest in between; in brackets the share of the region with the severest."
    ),
    "resonance": (
        "Resonance: linear where no stable motion in the resonance's part of the Ω axis ever parts the teeth, so that "
        "only damping, stiffness variation and excitation move the peak; else near linear within "
        f"{percent(NEAR_LINEAR)} of the linear natural frequency, softening below, hardening above; from the first to "
        "the last row with a peak."
    ),
    "stability": (
        "Stability: the share of the region without a stable motion of one mesh period, by integration where the store "
        "has attractors of all its cells, else by the multipliers of the first-order motions (from the boundary curves "
        "where they are stored, else counted in cells); and the share in which several motions are statically stable, "
        "so that the start decides which one is reached."
    ),
}


def jump_class(widths: Sequence[float], height: float) -> str:
    """Class of the jumps of a band.

    Parameters
    ----------
    widths : sequence of float
        Widest multivalued interval of every line as a share of the natural frequency, 0 without one; not empty.
    height : float
        Share of the band's height with a jump.

    Examples
    --------
    >>> jump_class([0.02, 0.04, 0.08], 1.0)
    'prominent, increasing'
    """
    widest = max(widths)
    if height <= 0.0:
        return "no jump"
    size = "prominent" if widest >= PROMINENT_JUMP else "narrow"
    if len(widths) == 1:
        return size
    part = "" if height >= 1.0 - 1e-9 else f" in {percent(height)} of the band"
    return f"{size}{part}, {jump_trend(widths)}"


def jump_trend(widths: Sequence[float]) -> str:
    """Whether the jump's width grows or shrinks from the first to the last line."""
    change = widths[-1] - widths[0]
    return "steady" if abs(change) <= JUMP_TREND * max(widths) else "increasing" if change > 0.0 else "decreasing"


def severest(shares: Mapping[str, float]) -> int:
    """Rank in `IMPACTS` of the severest state that counts, from the labels' shares of a line or a region."""
    parts = {state: share_of(shares, lambda label, state=state: state in label_parts(label)[1]) for state in RANKS}
    return max((RANKS[state] for state, share in parts.items() if share >= IMPACT_SHARE), default=0)


def impact_class(ranks: Sequence[int], share: float) -> str:
    """Class of a band from the ranks of its lines and the region's share with the severest of them.

    Examples
    --------
    >>> impact_class([3, 3, 2], 0.25)
    'double-sided to single-sided (double-sided in 25 %)'
    """
    first, last, most = ranks[0], ranks[-1], max(ranks)
    text = IMPACTS[first] if first == last else f"{IMPACTS[first]} to {IMPACTS[last]}"
    if most not in (first, last):
        text += f", up to {IMPACTS[most]}"
    if most == 0:
        return text
    return f"{text} ({percent(share)})" if text == IMPACTS[most] else f"{text} ({IMPACTS[most]} in {percent(share)})"


def resonance_class(shifts: Sequence[float], linear: Sequence[bool]) -> str:
    """Class of a band from the shift of the peak of each row that has one, and whether the row's region is linear.

    Examples
    --------
    >>> resonance_class([-0.05, -0.01, 0.01], [False, False, True])
    'softening to linear, near linear between'
    """
    if not shifts:
        return "no peak"
    words = [_shift_word(*row) for row in zip(shifts, linear, strict=True)]
    text = words[0] if words[0] == words[-1] else f"{words[0]} to {words[-1]}"
    between = [word for word in dict.fromkeys(words) if word not in (words[0], words[-1])]
    return f"{text}, {' and '.join(between)} between" if between else text


def _shift_word(shift: float, linear: bool) -> str:
    if linear:
        return "linear"
    if abs(shift) <= NEAR_LINEAR:
        return "near linear"
    return "softening" if shift < 0.0 else "hardening"


def settled(widths: Sequence[float], shifts: Sequence[float]) -> bool:
    """Whether jump width and peak stay as they are; where the peak comes and goes they do not."""
    # Comparisons with nan are false.
    return bool(np.ptp(widths) <= SETTLED and np.ptp(shifts or [np.nan]) <= SETTLED)


def ranks(band: BandAtResonance) -> list[int]:
    """Rank of the severest state of every line of a band."""
    found = []
    for line in band.lines:
        length = line.ends[-1] - line.ends[0]
        found.append(severest({label: size / length for label, size in line.lengths.items()}))
    return found


def _jump(band: BandAtResonance) -> str:
    return jump_class(band.widths, band.jump_height)


def _impact(band: BandAtResonance) -> str:
    found = ranks(band)
    most = max(found)
    return impact_class(found, share_of(band.region.shares, lambda label: most in _ranks_of(label)))


def _ranks_of(label: str) -> set[int]:
    return {RANKS[state] for state in label_parts(label)[1]}


def _resonance(band: BandAtResonance) -> str:
    return resonance_class([row.shift for row in band.with_peak], band.linear)


def _stability(band: BandAtResonance) -> str:
    several = f", several in {percent(band.several)}" if band.several else ""
    return f"{band.lacking.text} by {band.lacking.source}{several}"


#: What a column of the study's tables can be answered with.
ASPECTS = {"jump": _jump, "impact": _impact, "resonance": _resonance, "stability": _stability}
