"""Impact state of a motion and the n/I label of a set of motions (docs/physics.md, section 5)."""

import numpy as np

from solver.explained import Explained
from solver.model.checks import ParameterError, number_array, whole_number

__all__ = [
    "ImpactState",
    "domain_code",
    "domain_label",
    "domain_labels",
    "domain_parts",
    "impact_of_range",
    "impact_state",
    "label_parts",
]


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

    Raises
    ------
    ParameterError
        If an argument is no array of numbers, the shapes do not fit or b is negative.

    Examples
    --------
    >>> impact_state([1.2, 0.3, -1.5, -0.5], [2.0, 2.0, 2.5, 0.5], 1.0)
    array([0, 1, 2, 3], dtype=int8)
    """
    lowest, highest, b = number_array("lowest", lowest), number_array("highest", highest), number_array("b", b)
    if not (b >= 0.0).all():
        raise ParameterError("b", b, "at least 0")
    try:
        lowest, highest, b = np.broadcast_arrays(lowest, highest, b)
    except ValueError:
        raise ParameterError(
            "b", f"array of shape {b.shape}", f"broadcast to {lowest.shape}, {highest.shape}"
        ) from None
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


def impact_of_range(lowest: np.ndarray, highest: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Impact states (int8) of ranges of lambda between the ends of the dead zone; -1 where a range is nan.

    Parameters
    ----------
    lowest, highest : arrays
        Extremes of lambda.
    low, high : arrays
        Ends of the dead zone; low is -inf of a one-sided contact.
    """
    one_sided = np.where(lowest > high, ImpactState.PERMANENT, ImpactState.SINGLE_SIDED)
    one_sided = np.where(highest > high, one_sided, ImpactState.FREE)
    # Seen from the middle of the dead zone both gaps are alike.
    finite = np.where(np.isfinite(low), low, -high)
    middle, half = 0.5 * (high + finite), np.maximum(0.5 * (high - finite), 0.0)
    two_sided = impact_state(lowest - middle, highest - middle, half)
    states = np.where(np.isfinite(low), two_sided, one_sided)
    return np.where(np.isnan(lowest) | np.isnan(highest), -1, states).astype(np.int8)


_STATES = len(ImpactState)
_MOST = ((2**16 - 1) >> _STATES) - 1


def domain_code(n, states):
    """Code of an n/I label: 1 + 64 n + the sum of 2^I over the distinct states I; 0 is kept for "not computed".

    Parameters
    ----------
    n : array_like of int
        Number of stable solutions, up to 1022.
    states : array_like of int
        Bit mask of their states, bit I for state I.

    Returns
    -------
    uint16 array

    Raises
    ------
    ParameterError
        If an argument is no array of whole numbers within these bounds.
    """
    n, states = _whole("n", n, _MOST), _whole("states", states, (1 << _STATES) - 1)
    return (1 + (np.asarray(n, dtype=np.uint16) << _STATES) + np.asarray(states, dtype=np.uint16)).astype(np.uint16)


def _whole(name: str, values, high: int) -> np.ndarray:
    """Whole numbers from 0 to `high`; raises ParameterError otherwise."""
    array = number_array(name, values, kind=int)
    if array.size and (array.min() < 0 or array.max() > high):
        raise ParameterError(name, values, f"whole numbers from 0 to {high}")
    return array


def domain_parts(code) -> tuple[np.ndarray, np.ndarray]:
    """n and the bit mask of the states of codes of any shape, two int64 arrays; n is -1 where nothing was computed.

    Raises
    ------
    ParameterError
        If an entry is no code.

    Examples
    --------
    >>> n, mask = domain_parts([domain_code(2, 0b011), 0])
    >>> n.tolist(), mask.tolist()
    ([2, -1], [3, 0])
    """
    inside = _whole("code", code, 2**16 - 1).astype(np.int64) - 1
    return inside >> _STATES, np.where(inside < 0, 0, inside & (1 << _STATES) - 1)


def _states(mask: int) -> list[ImpactState]:
    return [state for state in ImpactState if mask >> state & 1]


def domain_label(code: int) -> str:
    """The label "n/I" of a code, for example "2/0-1"; "0/-" where no solution is stable, "" for "not computed".

    Raises
    ------
    ParameterError
        If it is no code of `domain_code`.

    Examples
    --------
    >>> domain_label(domain_code(2, 0b011))
    '2/0-1'
    """
    code = whole_number("code", code, 0, 2**16 - 1)
    if code == 0:
        return ""
    n, mask = divmod(code - 1, 1 << _STATES)
    if mask.bit_count() > n or (mask == 0) != (n == 0):
        raise ParameterError("code", code, "a code of domain_code, with 1 to n states of n solutions")
    return f"{n}/{'-'.join(state.symbol for state in _states(mask)) or '-'}"


def domain_labels(most: int) -> dict[int, str]:
    """All codes that up to `most` stable solutions can have, ascending, with their labels.

    Raises
    ------
    ParameterError
        If `most` is not a whole number from 0 to 1022.
    """
    most = whole_number("most", most, 0, _MOST)
    n, mask = np.divmod(np.arange((most + 1) << _STATES), 1 << _STATES)
    possible = ((mask == 0) == (n == 0)) & (np.bitwise_count(mask) <= n)
    return {code: domain_label(code) for code in domain_code(n[possible], mask[possible]).tolist()}


def label_parts(label: str) -> tuple[int, frozenset[ImpactState]]:
    """Number of stable solutions and their states of a label "n/I"; the inverse of `domain_label`.

    Raises
    ------
    ParameterError
        If it is no such label.

    Examples
    --------
    >>> n, states = label_parts("2/0-1")
    >>> n, sorted(states) == [ImpactState.PERMANENT, ImpactState.SINGLE_SIDED], label_parts("0/-")
    (2, True, (0, frozenset()))
    """
    n, _, symbols = label.partition("/") if isinstance(label, str) else ("", "", "")
    states = frozenset(state for state in ImpactState if state.symbol in symbols.split("-"))
    count = int(n) if n.isascii() and n.isdecimal() and len(n) < 5 else 0
    try:
        if domain_label(domain_code(count, sum(1 << state for state in states))) == label:
            return count, states
    except ParameterError:
        pass
    raise ParameterError("label", label, "a label n/I such as 2/0-1")
