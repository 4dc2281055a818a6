"""What the study's wordings claim, as data, and the rules that compare a claim with what was measured."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.study.agreement import AGREES, DIFFERS, NOT_COMPARED, THRESHOLD_AGREES
from pipeline.study.numerals import percent, signed
from pipeline.study.tables.bands import BandAtResonance
from pipeline.study.tables.classes import IMPACTS, NEAR_LINEAR, PROMINENT_JUMP, jump_trend, ranks, settled
from pipeline.study.tables.edges import nearest_edge
from solver import ImpactState

__all__ = ["READINGS", "Claim", "Entry", "Verdict", "judge"]

#: Rule -> what the wording is taken to say.
READINGS = {
    "jump prominent": f"the widest jump of the band reaches {percent(PROMINENT_JUMP)} of the natural frequency",
    "jump not prominent": f"no jump of the band reaches {percent(PROMINENT_JUMP)} of the natural frequency",
    "jump grows": "the jump is wider at the band's last value than at its first, by the rule for increasing",
    "jump settled": "the jump's width varies over the band no more than the rule for settled allows",
    "jump smaller": "the widest jump is narrower than in the band before",
    "jump ends": "with a growing parameter the jump ends at the study's value",
    "double-sided": "the severest impact of the band is double-sided",
    "double- to single-sided": "the severest impact is double-sided at the first value, single-sided at the last",
    "double-sided less": "double-sided motions have a smaller share of the region than in the band before",
    "single-sided to none": "double-sided impact nowhere in the band and no impact at its last value",
    "double-sided impact ends": "with a growing parameter double-sided impact ends at the study's value",
    "contact loss ends": "with a growing parameter loss of contact ends at the study's value",
    "softening": f"the peak lies below the linear natural frequency, in every row by more than {percent(NEAR_LINEAR)}",
    "below natural": "the peak lies below the linear natural frequency in every row",
    "softening to hardening": "softening in the first row with a peak, hardening in the last, by that rule",
    "peak settled": "the peak varies over the band no more than the rule for settled allows",
    "somewhere none stable": "some places of the region have no stable motion",
    "everywhere one stable": "every place of the region has a stable motion",
}


@dataclass(frozen=True)
class Claim:
    """What one wording claims.

    Parameters
    ----------
    rule : str
        Of `READINGS`.
    resonances : tuple of str
        Where; the claim holds if it holds at one of them.
    value : float, optional
        The study's threshold, where the rule has one.
    """

    rule: str
    resonances: tuple[str, ...] = ("mesh", "shaft")
    value: float | None = None


@dataclass(frozen=True)
class Entry:
    """One entry of a table of the study.

    Parameters
    ----------
    wording : str
    claims : tuple of Claim
        All of which must hold; none where the wording cannot be given a meaning.
    unclear : str
        Why it cannot, or what the wording leaves open.
    """

    wording: str
    claims: tuple[Claim, ...] = ()
    unclear: str = ""


@dataclass(frozen=True)
class Verdict:
    """Whether an entry agrees with what was measured, and the numbers behind that."""

    kind: str
    reason: str

    @property
    def text(self) -> str:
        """For a cell."""
        return f"{self.kind}: {self.reason}"


Rule = Callable[[Claim, BandAtResonance, BandAtResonance | None], tuple[bool, str]]


def judge(entry: Entry, here: Mapping[str, BandAtResonance], before: Mapping[str, BandAtResonance]) -> Verdict:
    """Compare an entry of the study with a band.

    Parameters
    ----------
    entry : Entry
    here, before : mapping
        Resonance -> the band and the one before it in the table; what is not measured is missing.
    """
    if not entry.claims:
        return Verdict(NOT_COMPARED, entry.unclear)
    found = []
    for claim in entry.claims:
        missing = [name for name in claim.resonances if name not in here]
        relative = claim.rule in ("jump smaller", "double-sided less")
        if missing or (relative and any(name not in before for name in claim.resonances)):
            return Verdict(NOT_COMPARED, f"{' and '.join(missing) or 'the band before'} not measured")
        found.append(_judged(claim, here, before))
    holds = all(held for held, _ in found)
    return Verdict(AGREES if holds else DIFFERS, "; ".join(dict.fromkeys(text for _, text in found)))


def _judged(claim: Claim, here, before) -> tuple[bool, str]:
    rule = _RULES[claim.rule]
    each = {name: rule(claim, here[name], before.get(name)) for name in claim.resonances}
    holding = {name: text for name, (held, text) in each.items() if held}
    shown = holding or {name: text for name, (_, text) in each.items()}
    return bool(holding), ", ".join(f"{name} {text}" for name, text in shown.items())


def _widest(band: BandAtResonance) -> str:
    return f"widest jump {percent(max(band.widths))}" if band.jump_height else "without jump"


def _width_change(band: BandAtResonance) -> str:
    return f"jump {percent(band.widths[0])} to {percent(band.widths[-1])}"


def _severest(band: BandAtResonance) -> str:
    share = percent(band.state_share(ImpactState.DOUBLE_SIDED))
    most = IMPACTS[max(ranks(band))]
    return f"double-sided in {share}" if most == "double-sided" else f"{most}, double-sided in {share}"


def _course(band: BandAtResonance) -> str:
    found = ranks(band)
    first, last, most = (IMPACTS[rank] for rank in (found[0], found[-1], max(found)))
    return f"{first} to {last}" + ("" if most in (first, last) else f", up to {most}")


def _shift(band: BandAtResonance) -> str:
    shifts = [row.shift for row in band.with_peak]
    if not shifts:
        return "without peak"
    first, last = (signed(100.0 * shift) for shift in (shifts[0], shifts[-1]))
    return f"peak {first} %" if first == last else f"peak {first} to {last} %"


def _every_shift(band: BandAtResonance, below: float) -> bool:
    return bool(band.with_peak) and all(row.shift < below for row in band.with_peak)


def _jump_smaller(claim, band, before):
    return max(band.widths) < max(before.widths), f"{_widest(band)}, {_widest(before)} in the band before"


def _double_less(claim, band, before):
    now, then = (one.state_share(ImpactState.DOUBLE_SIDED) for one in (band, before))
    return now < then, f"double-sided in {percent(now)}, {percent(then)} in the band before"


def _course_is(first: str, last: str) -> Rule:
    def rule(claim, band, before):
        found = ranks(band)
        return (IMPACTS[found[0]], IMPACTS[found[-1]]) == (first, last), _course(band)

    return rule


def _to_none(claim, band, before):
    found = ranks(band)
    return max(found) < IMPACTS.index("double-sided") and found[-1] == 0, _course(band)


def _hardens(claim, band, before):
    rows = list(zip(band.with_peak, band.linear, strict=True))
    if not rows:
        return False, _shift(band)
    (first, first_linear), (last, last_linear) = rows[0], rows[-1]
    held = not (first_linear or last_linear) and first.shift < -NEAR_LINEAR and last.shift > NEAR_LINEAR
    return held, _shift(band)


def _ends(what: str) -> Rule:
    def rule(claim, band, before):
        edge = nearest_edge(band.edges[what], False, claim.value, claim.value)
        if edge is None:
            return False, f"{what} does not end in this plane, article {claim.value:g}"
        change = edge.value / claim.value - 1.0
        text = f"{what} ends at {edge.value:.4g}, article {claim.value:g}, {signed(100.0 * change, 0)} %"
        return abs(change) <= THRESHOLD_AGREES, text

    return rule


_RULES: dict[str, Rule] = {
    "jump prominent": lambda claim, band, _: (max(band.widths) >= PROMINENT_JUMP, _widest(band)),
    "jump not prominent": lambda claim, band, _: (max(band.widths) < PROMINENT_JUMP, _widest(band)),
    "jump grows": lambda claim, band, _: (jump_trend(band.widths) == "increasing", _width_change(band)),
    "jump settled": lambda claim, band, _: (settled(band.widths, [0.0]), _width_change(band)),
    "jump smaller": _jump_smaller,
    "double-sided": lambda claim, band, _: (IMPACTS[max(ranks(band))] == "double-sided", _severest(band)),
    "double- to single-sided": _course_is("double-sided", "single-sided"),
    "double-sided less": _double_less,
    "single-sided to none": _to_none,
    "softening": lambda claim, band, _: (_every_shift(band, -NEAR_LINEAR), _shift(band)),
    "below natural": lambda claim, band, _: (_every_shift(band, 0.0), _shift(band)),
    "softening to hardening": _hardens,
    "peak settled": lambda claim, band, _: (
        settled([0.0], [row.shift if row.peak else np.nan for row in band.peaks]),
        _shift(band),
    ),
    "somewhere none stable": lambda claim, band, _: (
        band.without_stable > 0.0,
        f"no stable motion in {percent(band.without_stable)}, several in {percent(band.several)} of the region",
    ),
    "everywhere one stable": lambda claim, band, _: (
        band.without_stable == 0.0,
        f"no stable motion in {percent(band.without_stable)}, several in {percent(band.several)} of the region",
    ),
    **{f"{what} ends": _ends(what) for what in ("jump", "contact loss", "double-sided impact")},
}
