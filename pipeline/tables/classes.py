"""Verbal classes by rule: what the measured numbers are called, so that they can stand beside the study's words.

Every rule takes plain numbers and every threshold is a named constant; `RULES` says the same in the tables' notes.
"""

from collections.abc import Sequence

from pipeline.tables.bands import BandAtResonance
from solver import ImpactState

__all__ = [
    "ASPECTS",
    "RULES",
    "impact_class",
    "jump_class",
    "percent",
    "resonance_class",
    "stability_class",
    "worst_impact",
]

#: A jump is prominent where its widest interval is at least this share of the natural frequency.
PROMINENT_JUMP = 0.05
#: A jump grows or shrinks over the band where its widths in the first and last row differ by more than this share of
#: the widest.
JUMP_TREND = 0.1
#: An impact state counts in a row from this share of the region's cells on.
IMPACT_SHARE = 0.01
#: A peak is near linear within this share of the natural frequency.
NEAR_LINEAR = 0.02
#: A band is settled where jump width and peak vary by at most this share of the natural frequency.
SETTLED = 0.01

#: From harmless to severe; the place in this list ranks the states.
IMPACTS = ("none", "out of contact", "single-sided", "double-sided")
_RANK = {
    ImpactState.PERMANENT: 0,
    ImpactState.MIRRORED_PERMANENT: 0,
    ImpactState.FREE: 1,
    ImpactState.SINGLE_SIDED: 2,
    ImpactState.MIRRORED_SINGLE_SIDED: 2,
    ImpactState.DOUBLE_SIDED: 3,
}

def percent(share: float) -> str:
    """A share in words; what is there is never shown as nothing."""
    return "<1 %" if 0.0 < share < 0.005 else f"{100.0 * share:.0f} %"


RULES = {
    "jump": (
        f"Jump: none; narrow where the widest multivalued interval is below {percent(PROMINENT_JUMP)} of the linear "
        "natural frequency, else prominent; increasing or decreasing where its widths in the first and the last row of "
        f"the band differ by more than {percent(JUMP_TREND)} of the widest, else steady."
    ),
    "impact": (
        "Impact: the severest state (none, out of contact, single-sided, double-sided) that stable motions have in at "
        f"least {percent(IMPACT_SHARE)} of the region's cells of a row, from the first to the last row of the band, "
        "and the severest in between; in brackets the share of the band's region in which a stable motion has the "
        "severest. Rows without a region count as none where stable motions never lose contact."
    ),
    "resonance": (
        "Resonance: linear where no stable motion of the region ever parts the teeth, so that only damping, stiffness "
        f"variation and excitation move the peak; else near linear within {percent(NEAR_LINEAR)} of the linear natural "
        "frequency, softening below, hardening above; from the first to the last row with a peak."
    ),
    "stability": (
        "Stability: stable where every solution of the region is statically stable, unstable where some cells have no "
        "stable solution, else conditional: the start decides which motion is reached (in brackets the share of cells "
        f"with an unstable solution). Settled where jump width and peak vary by at most {percent(SETTLED)} of the "
        "linear natural frequency over the band, else moving."
    ),
}


def jump_class(widths: Sequence[float]) -> str:
    """Class of the jumps of a band.

    Parameters
    ----------
    widths : sequence of float
        Widest multivalued interval of every row as a share of the natural frequency, 0 without one; not empty.

    Examples
    --------
    >>> jump_class([0.02, 0.04, 0.08])
    'prominent, increasing'
    """
    widest = max(widths)
    if widest <= 0.0:
        return "none"
    size = "prominent" if widest >= PROMINENT_JUMP else "narrow"
    with_jump = sum(width > 0.0 for width in widths)
    part = "" if with_jump == len(widths) else f" in {with_jump} of {len(widths)} rows"
    if len(widths) == 1:
        return size
    change = widths[-1] - widths[0]
    trend = "steady" if abs(change) <= JUMP_TREND * widest else "increasing" if change > 0.0 else "decreasing"
    return f"{size}{part}, {trend}"


def worst_impact(states: Sequence[int], cells: int) -> int:
    """Rank in `IMPACTS` of the severest state that counts, from the cells in each `ImpactState`."""
    return max((_RANK[state] for state in ImpactState if states[state] >= IMPACT_SHARE * cells > 0.0), default=0)


def impact_class(ranks: Sequence[int], share: float) -> str:
    """Class of a band from the ranks of its rows and the share of cells with the severest of them.

    Examples
    --------
    >>> impact_class([3, 3, 2], 0.25)
    'double-sided to single-sided (double-sided in 25 %)'
    """
    if not ranks:
        return "no region"
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


def stability_class(
    cells: int, unstable: int, without_stable: int, widths: Sequence[float], shifts: Sequence[float]
) -> str:
    """Class of a band from its region's cells, those with an unstable and those without a stable solution.

    Examples
    --------
    >>> stability_class(200, 50, 0, [0.05, 0.051], [-0.02, -0.02])
    'conditional (25 %), settled'
    """
    if not cells:
        return "no region"
    share = percent(unstable / cells)
    if without_stable:
        text = f"unstable ({share})"
    elif unstable:
        text = f"conditional ({share})"
    else:
        # A jump may fit between two columns of the grid, where no cell sees its unstable solution.
        text = "conditional (within less than a cell)" if max(widths) > 0.0 else "stable"
    if len(widths) == 1:
        return text
    # A band in which the peak comes and goes is not settled, however little the rest of it moves.
    whole = len(shifts) == len(widths)
    settled = whole and max(widths) - min(widths) <= SETTLED and max(shifts) - min(shifts) <= SETTLED
    return f"{text}, {'settled' if settled else 'moving'}"


def _jump(band: BandAtResonance) -> str:
    return jump_class(band.widths)


def _impact(band: BandAtResonance) -> str:
    # Without a region there is no share, but no impact either where contact is never lost.
    ranks = [worst_impact(row.states, row.cells) for row in band.rows if row.cells or not row.contact_lost]
    most = max(ranks, default=0)
    severest = [state for state in ImpactState if _RANK[state] == most]
    # Mirrored states share a rank; adding their cells could count one twice, so the more frequent of them speaks.
    return impact_class(ranks, band.share(max(band.states[state] for state in severest)))


def _resonance(band: BandAtResonance) -> str:
    return resonance_class(band.shifts, [row.linear for row in band.peak_rows])


def _stability(band: BandAtResonance) -> str:
    return stability_class(band.cells, band.unstable, band.without_stable, band.widths, band.shifts)


#: What a column of the study's tables can be answered with.
ASPECTS = {"jump": _jump, "impact": _impact, "resonance": _resonance, "stability": _stability}
