"""Codes of attractors by kind and impact state, as the stages that follow attractors store and label them."""

import numpy as np

from solver import ImpactState
from solver.timedomain import Attractor, AttractorKind

__all__ = ["attractor_code", "attractor_flags", "attractor_label"]

_STATES = len(ImpactState) + 1
_WORDS = {
    AttractorKind.FAILED: "failed",
    AttractorKind.PERIOD_1: "1T",
    AttractorKind.PERIOD_2: "2T",
    AttractorKind.PERIOD_3: "3T",
    AttractorKind.PERIOD_4: "4T",
    AttractorKind.PERIOD_HIGHER: "nT",
    AttractorKind.QUASI_PERIODIC: "quasi-periodic",
    AttractorKind.CHAOTIC: "chaotic",
    AttractorKind.UNBOUNDED: "unbounded",
    AttractorKind.UNSETTLED: "unsettled",
}


def attractor_code(attractor: Attractor) -> int:
    """Code of an attractor: 1 + 7 times its kind + (1 + its impact state); 0 is kept for "not computed"."""
    return 1 + _STATES * int(attractor.kind) + 1 + int(attractor.impact)


def attractor_label(code: int) -> str:
    """The label of a code, kind and impact state: "1T/0", "2T/1", "nT/1" (period above 4), "chaotic/2"; "" for 0.

    Examples
    --------
    >>> attractor_label(1 + 7 * int(AttractorKind.PERIOD_2) + 1 + int(ImpactState.SINGLE_SIDED))
    '2T/1'
    """
    if code == 0:
        return ""
    kind, state = divmod(int(code) - 1, _STATES)
    return _WORDS[AttractorKind(kind)] + (f"/{ImpactState(state - 1).symbol}" if state else "")


def attractor_flags() -> dict:
    """CF attributes of the codes."""
    codes = np.arange(1, 1 + _STATES * len(AttractorKind))
    labels = [attractor_label(code) for code in codes]
    # CF wants meanings that start with a letter and hold no slash.
    meanings = [f"T{label[0]}{label[2:]}" if label[1:2] == "T" and label[0] != "n" else label for label in labels]
    meanings = [meaning.replace("/", "_I").replace("-", "_") for meaning in meanings]
    return {
        "flag_values": [0, *codes.tolist()],
        "flag_meanings": " ".join(["not_computed", *meanings]),
        "labels": ["", *labels],
    }
