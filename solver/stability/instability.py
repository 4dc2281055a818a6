"""What the multipliers of a motion say about it, and what two methods say together."""

import enum
from dataclasses import dataclass

import numpy as np

__all__ = ["Instability", "Stability", "classify", "combine"]

# A multiplier this close to the real axis, as a share of its size, is real.
_REAL = 1e-8


class Instability(enum.IntEnum):
    """How a periodic motion is unstable."""

    NONE = 0
    FOLD = 1
    PERIOD_DOUBLING = 2
    NEIMARK_SACKER = 3
    DISPUTED = 4

    @property
    def sentence(self) -> str:
        """What it means, for the reader of a log."""
        return _SENTENCES[self]


_SENTENCES = {
    Instability.NONE: "Every small perturbation decays.",
    Instability.FOLD: "A perturbation grows without changing sign: the motion runs away to another one.",
    Instability.PERIOD_DOUBLING: "A perturbation grows and changes sign every period: motions of twice the period.",
    Instability.NEIMARK_SACKER: "A perturbation grows at a frequency of its own: quasi-periodic motions.",
    Instability.DISPUTED: "The methods disagree, or a multiplier is on the unit circle: a higher order settles it.",
}


@dataclass(frozen=True)
class Stability:
    """Stability of k motions, every field an array (k,).

    Parameters
    ----------
    kind : int8 array
        `Instability`: what both methods agree on, else DISPUTED.
    modulus : array
        Largest modulus of Floquet's multipliers; below 1 for a stable motion.
    hill_kind, floquet_kind : int8 arrays
        What each method says; DISPUTED where its largest modulus is 1 within the tolerance.
    hill_modulus, floquet_modulus : arrays
        Largest modulus of each method's multipliers.
    margin : array
        1 - modulus: what a perturbation loses over a period, negative where it grows.
    """

    kind: np.ndarray
    modulus: np.ndarray
    hill_kind: np.ndarray
    floquet_kind: np.ndarray
    hill_modulus: np.ndarray
    floquet_modulus: np.ndarray
    margin: np.ndarray


def classify(multipliers, tolerance: float = 1e-6) -> tuple[np.ndarray, np.ndarray]:
    """Kind and size of the largest multiplier.

    Parameters
    ----------
    multipliers : (..., m) complex array_like
    tolerance : float
        Half width of the band about modulus 1 in which nothing is decided.

    Returns
    -------
    kind : (...) int8 array of `Instability`
        NONE below the band, DISPUTED inside it. Above it FOLD if the multiplier is real and positive, PERIOD_DOUBLING
        if real and negative, else NEIMARK_SACKER.
    modulus : (...) array

    Examples
    --------
    >>> classify([[0.5, -1.1], [0.9, 0.8], [1.0, 0.3], [0.6 + 0.9j, 0.6 - 0.9j]])[0]
    array([2, 0, 4, 3], dtype=int8)
    """
    multipliers = np.asarray(multipliers, dtype=complex)
    sizes = np.abs(multipliers)
    largest = np.argmax(sizes, axis=-1)[..., None]
    modulus = np.take_along_axis(sizes, largest, axis=-1)[..., 0]
    leading = np.take_along_axis(multipliers, largest, axis=-1)[..., 0]
    conditions = [
        ~(np.abs(modulus - 1.0) > tolerance),
        modulus < 1.0,
        ~(np.abs(leading.imag) <= _REAL * modulus),
        leading.real > 0.0,
    ]
    kinds = [Instability.DISPUTED, Instability.NONE, Instability.NEIMARK_SACKER, Instability.FOLD]
    codes = np.select(conditions, [int(kind) for kind in kinds], default=int(Instability.PERIOD_DOUBLING))
    return codes.astype(np.int8), modulus


def combine(hill, floquet, static=None, tolerance: float = 1e-6) -> Stability:
    """What both methods say together.

    Parameters
    ----------
    hill, floquet : (k, m) complex array_like
        Multipliers.
    static : (k,) array_like, optional
        Static stability, positive where det J > 0. A motion that both methods call stable is disputed
        where this is not.
    tolerance : float
        As for `classify`.

    Returns
    -------
    Stability
    """
    hill_kind, hill_modulus = classify(hill, tolerance)
    floquet_kind, floquet_modulus = classify(floquet, tolerance)
    agreed = hill_kind == floquet_kind
    if static is not None:
        agreed &= (np.asarray(static) > 0) | (hill_kind != Instability.NONE)
    kind = np.where(agreed, hill_kind, np.int8(Instability.DISPUTED)).astype(np.int8)
    return Stability(
        kind, floquet_modulus, hill_kind, floquet_kind, hill_modulus, floquet_modulus, 1.0 - floquet_modulus
    )
