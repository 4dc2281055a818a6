"""Impact state of a motion and the n/I label of a set of motions (docs/physics.md, section 5)."""

from collections.abc import Iterable

import numpy as np

from solver.explained import Explained

__all__ = ["ImpactState", "domain_code", "domain_label", "domain_labels", "domain_parts", "impact_state", "label_parts"]


class ImpactState(Explained):
    """What the teeth do over one period, from the extremes of lambda."""

    PERMANENT = 0, "lambda_min > b: the drive flanks never part."
    SINGLE_SIDED = 1, "-b <= lambda_min <= b < lambda_max: the teeth part and strike the drive flank again."
    DOUBLE_SIDED = 2, "lambda_min < -b and lambda_max > b: the teeth strike both flanks."
    FREE = 3, "-b <= lambda_min and lambda_max <= b: the teeth never touch."
    MIRRORED_SINGLE_SIDED = 4, "lambda_min < -b <= lambda_max <= b: the teeth strike the back flank only."
    MIRRORED_PERMANENT = 5, "lambda_max < -b: the back flanks never part."

    @property
    def symbol(self) -> str:
        """How the state is written in an n/I label."""
        return "012f"[self] if self <= ImpactState.FREE else ("1m" if self == 4 else "0m")


def impact_state(lowest, highest, b) -> np.ndarray:
    """Impact state of motions whose displacement ranges from `lowest` to `highest`.

    Parameters
    ----------
    lowest, highest : array_like
        Extremes of lambda over a period, lambda_m -+ lambda_a at first order.
    b : array_like
        Half backlash, broadcast against them.

    Returns
    -------
    int8 array of `ImpactState`; -1 where an extreme is nan.

    Examples
    --------
    >>> impact_state([1.2, 0.3, -1.5, -0.5], [2.0, 2.0, 2.5, 0.5], 1.0)
    array([0, 1, 2, 3], dtype=int8)
    """
    lowest, highest, b = np.broadcast_arrays(lowest, highest, b)
    conditions = [
        np.isnan(lowest) | np.isnan(highest),
        lowest > b,
        (lowest >= -b) & (highest > b),
        highest > b,
        lowest >= -b,
        highest >= -b,
    ]
    codes = [
        -1,
        ImpactState.PERMANENT,
        ImpactState.SINGLE_SIDED,
        ImpactState.DOUBLE_SIDED,
        ImpactState.FREE,
        ImpactState.MIRRORED_SINGLE_SIDED,
    ]
    return np.select(conditions, [int(c) for c in codes], default=int(ImpactState.MIRRORED_PERMANENT)).astype(np.int8)


_STATES = len(ImpactState)


def domain_code(n, states):
    """Code of an n/I label: 1 + 64 n + the sum of 2^I over the distinct states I; 0 is kept for "not computed".

    Parameters
    ----------
    n : array_like of int
        Number of stable solutions.
    states : array_like of int
        Bit mask of their states, bit I for state I.

    Returns
    -------
    uint16 array
    """
    return (1 + (np.asarray(n, dtype=np.uint16) << _STATES) + np.asarray(states, dtype=np.uint16)).astype(np.uint16)


def domain_parts(code) -> tuple[np.ndarray, np.ndarray]:
    """n and the bit mask of the states of codes of any shape, two int64 arrays; n is -1 where nothing was computed.

    Examples
    --------
    >>> n, mask = domain_parts([domain_code(2, 0b011), 0])
    >>> n.tolist(), mask.tolist()
    ([2, -1], [3, 0])
    """
    inside = np.asarray(code, dtype=np.int64) - 1
    return inside >> _STATES, np.where(inside < 0, 0, inside & (1 << _STATES) - 1)


def _states(mask: int) -> list[ImpactState]:
    return [state for state in ImpactState if mask >> state & 1]


def domain_label(code: int) -> str:
    """The label "n/I" of a code, for example "2/0-1"; "0/-" where no solution is stable, "" for "not computed".

    Examples
    --------
    >>> domain_label(domain_code(2, 0b011))
    '2/0-1'
    """
    if code == 0:
        return ""
    n, mask = divmod(int(code) - 1, 1 << _STATES)
    return f"{n}/{'-'.join(state.symbol for state in _states(mask)) or '-'}"


def domain_labels(most: int) -> dict[int, str]:
    """All codes that up to `most` stable solutions can have, ascending, with their labels."""
    codes: Iterable[int] = (
        int(domain_code(n, mask))
        for n in range(most + 1)
        for mask in range(1 << _STATES)
        if (mask == 0) == (n == 0) and mask.bit_count() <= n
    )
    return {code: domain_label(code) for code in codes}


def label_parts(label: str) -> tuple[int, frozenset[ImpactState]]:
    """Number of stable solutions and their states of a label "n/I"; the inverse of `domain_label`.

    Examples
    --------
    >>> n, states = label_parts("2/0-1")
    >>> n, sorted(states) == [ImpactState.PERMANENT, ImpactState.SINGLE_SIDED], label_parts("0/-")
    (2, True, (0, frozenset()))
    """
    n, symbols = label.split("/")
    return int(n), frozenset(state for state in ImpactState if state.symbol in symbols.split("-"))
