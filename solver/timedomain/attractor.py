"""Kinds of attractors."""

from solver.explained import Explained

__all__ = ["AttractorKind"]


class AttractorKind(Explained):
    """What a motion ends on."""

    NONE = 0, "Nothing is known."
    PERIOD_1 = 1, "The motion repeats after every forcing period."
    PERIOD_2 = 2, "The motion repeats after two forcing periods."
    PERIOD_3 = 3, "The motion repeats after three forcing periods."
    PERIOD_4 = 4, "The motion repeats after four forcing periods."
    PERIOD_5 = 5, "The motion repeats after five forcing periods."
    PERIOD_6 = 6, "The motion repeats after six forcing periods."
    PERIOD_7 = 7, "The motion repeats after seven forcing periods."
    PERIOD_8 = 8, "The motion repeats after eight forcing periods."
    PERIOD_LONGER = 9, "The motion repeats after more than eight forcing periods."
    QUASI_PERIODIC = 10, "The motion never repeats, and neighbouring motions neither part nor meet: a torus."
    CHAOTIC = 11, "Neighbouring motions part exponentially: the largest Lyapunov exponent is above 0."
    UNBOUNDED = 12, "The contact coordinate grew above the ceiling."
    UNSETTLED = 13, "The motion had not settled after the allowed periods."

    @property
    def periodic(self) -> bool:
        """Whether the motion repeats after a known number of periods, up to eight."""
        return AttractorKind.PERIOD_1 <= self <= AttractorKind.PERIOD_8

    @property
    def settled(self) -> bool:
        """Whether it is a bounded attractor: periodic, a torus or chaos."""
        return AttractorKind.PERIOD_1 <= self <= AttractorKind.CHAOTIC

    @property
    def label(self) -> str:
        """ "1T" ... "8T", "nT" for more, or the name in small letters; empty for none."""
        if self is AttractorKind.NONE:
            return ""
        if self is AttractorKind.PERIOD_LONGER:
            return "nT"
        return f"{int(self)}T" if self.periodic else self.name.lower()
