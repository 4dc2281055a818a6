"""What the study's wordings claim, as data, and the rules that compare a claim with what was measured."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.study.agreement import AGREES, DIFFERS, NOT_COMPARED, THRESHOLD_AGREES
from pipeline.study.numerals import percent, signed
from pipeline.study.tables.bands import BandAtResonance
from pipeline.study.tables.classes import IMPACTS, NEAR_LINEAR, PROMINENT_JUMP, SETTLED, jump_trend, ranks, settled
from pipeline.study.tables.edges import nearest_edge
from solver import ImpactState

__all__ = ["READINGS", "Claim", "Entry", "Verdict", "judge"]

#: Rule -> what the wording is taken to say.
READINGS = {
    "jump prominent": f"the widest jump of the band reaches {percent(PROMINENT_JUMP)} of the natural frequency",
    "jump not prominent": f"no jump of the band reaches {percent(PROMINENT_JUMP)} of the natural frequency",
    "jump grows": "the jump is wider at the band's last value than at its first, by the rule for increasing",
    "jump settled": f"the jump's width varies over the band by at most {percent(SETTLED)} of the natural frequency",
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
    "peak settled": f"the peak varies over the band by at most {percent(SETTLED)} of the natural frequency",
    "somewhere none stable": "some places of the region have no stable motion of one mesh period",
    "everywhere one stable": "every place of the region has a stable motion of one mesh period",
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


#: What a text says before its first number.
_WORDS = re.compile(r"[^0-9−+<]*")

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
        if "stable" in claim.rule and any(np.isnan(here[name].lacking.share) for name in claim.resonances):
            return Verdict(NOT_COMPARED, "no row of the plane in the band")
        found.append(_judged(claim, here, before))
    failing = [shown for held, shown in found if not held]
    return Verdict(DIFFERS if failing else AGREES, _joined(failing or [shown for _, shown in found]))


def _judged(claim: Claim, here, before) -> tuple[bool, dict[str, str]]:
    """Whether a claim holds, and what shows that: resonance -> text."""
    rule = _RULES[claim.rule]
    each = {name: rule(claim, here[name], before.get(name)) for name in claim.resonances}
    holding = {name: text for name, (held, text) in each.items() if held}
    return bool(holding), holding or {name: text for name, (_, text) in each.items()}


def _joined(shown: Sequence[Mapping[str, str]]) -> str:
    """Texts with their resonances, those that differ by a number alone behind the same words.

    Examples
    --------
    >>> _joined([{"mesh": "widest jump 0.4 %", "shaft": "widest jump 0.3 %"}, {"mesh": "no peak"}])
    'widest jump 0.4 % (mesh), 0.3 % (shaft); no peak (mesh)'
    """
    places: dict[str, dict[str, list[str]]] = {}
    for name, text in (item for one in shown for item in one.items()):
        words = _WORDS.match(text)[0]
        places.setdefault(words, {}).setdefault(text.removeprefix(words), []).append(name)
    parts = []
    for words, rests in places.items():
        parts.append(
            words + ", ".join(f"{rest} ({' and '.join(dict.fromkeys(names))})" for rest, names in rests.items())
        )
    return "; ".join(parts).replace("  (", " (")


def _widest(band: BandAtResonance) -> str:
    return f"widest jump {percent(max(band.widths))}" if band.jump_height else "no jump"


def _width_change(band: BandAtResonance) -> str:
    first, last = percent(band.widths[0]), percent(band.widths[-1])
    return f"jump {first} throughout" if first == last else f"jump {first} to {last}"


def _severest(band: BandAtResonance) -> str:
    most = IMPACTS[max(ranks(band))]
    if most == "double-sided":
        return f"double-sided in {percent(band.state_share(ImpactState.DOUBLE_SIDED))}"
    start = nearest_edge(band.edges["double-sided impact"], True, band.region.low, band.region.high)
    beyond = f", double-sided from {start.value:.3g}" if start and start.value > band.region.high else ""
    return f"{most}{' at most' if most != IMPACTS[0] else ''}{beyond}"


def _course(band: BandAtResonance) -> str:
    found = ranks(band)
    first, last, most = (IMPACTS[rank] for rank in (found[0], found[-1], max(found)))
    course = f"{first} throughout" if first == last == most else f"{first} to {last}"
    return course + ("" if most in (first, last) else f", up to {most}")


def _shift(band: BandAtResonance) -> str:
    shifts = [row.shift for row in band.with_peak]
    if not shifts:
        return "without peak"
    first, last = (signed(100.0 * shift) for shift in (shifts[0], shifts[-1]))
    return f"peak {first} %" if first == last else f"peak {first} to {last} %"


def _every_shift(band: BandAtResonance, below: float) -> bool:
    return bool(band.with_peak) and all(row.shift < below for row in band.with_peak)


def _jump_smaller(claim, band, before):
    held = max(band.widths) < max(before.widths)
    if not held and band.born:
        return held, f"{band.born}, which sweeps miss"
    return held, f"{_widest(band)}, before {percent(max(before.widths))}"


def _double_less(claim, band, before):
    now, then = (one.state_share(ImpactState.DOUBLE_SIDED) for one in (band, before))
    return now < then, f"double-sided in {percent(now)}, before {percent(then)}"


def _course_is(first: str, last: str) -> Rule:
    def rule(claim, band, before):
        found = ranks(band)
        return (IMPACTS[found[0]], IMPACTS[found[-1]]) == (first, last), _course(band)

    return rule


def _to_none(claim, band, before):
    found = ranks(band)
    held = max(found) < IMPACTS.index("double-sided") and found[-1] == 0
    return held, f"{_course(band)}: {band.born}, which sweeps miss" if not held and band.born else _course(band)


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
            return False, f"{what} does not end in this plane"
        change = edge.value / claim.value - 1.0
        text = f"{what} ends at {edge.value:.3g}, article {claim.value:g} ({signed(100.0 * change, 0)} %)"
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
    "somewhere none stable": lambda claim, band, _: (band.lacking.share > 0.0, band.lacking.text),
    "everywhere one stable": lambda claim, band, _: (band.lacking.share == 0.0, band.lacking.text),
    **{f"{what} ends": _ends(what) for what in ("jump", "contact loss", "double-sided impact")},
}
