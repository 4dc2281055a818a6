"""What the multipliers of a motion, and its static stability, say about it."""

import numpy as np

from solver.explained import Explained

__all__ = [
    "BEYOND_MINUS_ONE",
    "BEYOND_ONE",
    "LEFT_TO_FOLDS",
    "NEAR_CIRCLE",
    "NOT_FINITE",
    "PAIR_OUTSIDE",
    "Instability",
    "named",
]

#: Where multipliers lie, as bits: a real one beyond -1, an odd number of them beyond +1, a pair outside the unit circle
#: (complex, or real beyond +1), any one on it within the tolerance, one that is not finite.
BEYOND_MINUS_ONE, BEYOND_ONE, PAIR_OUTSIDE, NEAR_CIRCLE, NOT_FINITE = 1, 2, 4, 8, 16


class Instability(Explained):
    """How a periodic motion is unstable.

    Static stability, det J > 0, is exact for the balance; its multipliers are those of the motion that the balance
    gives, which is not a true one. A real multiplier beyond -1 or a complex pair outside the unit circle is an
    instability by itself; one beyond +1 is not, since folds belong to det J (docs/physics.md, section 6). Several may
    hold at once. The first of these that does is the kind:

    1. UNDECIDED where a multiplier is not finite;
    2. PERIOD_DOUBLING with a real multiplier beyond -1, whatever else holds;
    3. NEIMARK_SACKER with a complex pair outside;
    4. UNDECIDED with a multiplier on the unit circle, within the tolerance;
    5. with a real multiplier beyond +1: FOLD where det J <= 0, else CONTRADICTORY;
    6. without one: NONE where det J > 0, else CONTRADICTORY.

    A pair that meets on the real axis beyond +1 stays a pair until one of the two comes back through +1. So along a
    branch the kinds 2 and 3 begin and end where multipliers pass the unit circle, never where others do. (Two
    multipliers may meet outside the circle, on the negative real axis, and turn 3 into 2.)
    """

    NONE = 0, "Every small perturbation decays."
    FOLD = 1, "A perturbation grows without changing sign: the motion runs away to another one."
    PERIOD_DOUBLING = 2, "A perturbation grows and changes sign every period: motions of twice the period."
    NEIMARK_SACKER = 3, "A perturbation grows at a frequency of its own: quasi-periodic motions."
    CONTRADICTORY = 4, "Static and dynamic stability contradict each other: the order of the balance is too low here."
    UNDECIDED = 5, "A multiplier is on the unit circle, or cannot be computed: nothing is known."


#: Kinds of which dynamic stability alone tells no instability: a statically stable motion of these counts as stable.
LEFT_TO_FOLDS = (Instability.NONE, Instability.CONTRADICTORY)


def named(bits, static=None) -> np.ndarray:
    """`Instability` of motions, int8 (k,).

    Parameters
    ----------
    bits : (k,) int array
        `solver.stability.multipliers.where_multipliers_lie`.
    static : (k,) array_like, optional
        Positive where det J > 0. Without it nothing contradicts: a real multiplier beyond +1 is a FOLD.
    """
    bits = np.asarray(bits)
    beyond = (bits & BEYOND_ONE) != 0
    stable = ~beyond if static is None else np.asarray(static) > 0
    conditions = [
        (bits & NOT_FINITE) != 0,
        (bits & BEYOND_MINUS_ONE) != 0,
        (bits & PAIR_OUTSIDE) != 0,
        (bits & NEAR_CIRCLE) != 0,
        beyond == stable,
        beyond,
    ]
    kinds = [
        Instability.UNDECIDED,
        Instability.PERIOD_DOUBLING,
        Instability.NEIMARK_SACKER,
        Instability.UNDECIDED,
        Instability.CONTRADICTORY,
        Instability.FOLD,
    ]
    return np.select(conditions, [int(kind) for kind in kinds], default=int(Instability.NONE)).astype(np.int8)
