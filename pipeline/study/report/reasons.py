"""Why a published statement does not come out, where more can be said than that the model is not fully printed."""

from pipeline.study.agreement import NOT_COMPARED
from pipeline.study.statements import Evaluated

__all__ = ["reason_of"]

_SEVERAL = (
    "Sweeping the frequency up and down shows at most two motions at a place; the enumeration of all solutions finds "
    "the third, in narrow strips."
)
_REASONS = {
    "interval_shaft": "The interval is narrow because its folds meet in a cusp at a little more stiffness variation or "
    "load, and near a cusp the width moves much faster than anything else.",
    "b_shaft_settles": "The limit is read where double-sided impact ends; the article says settled without saying of "
    "what.",
    "fe_shaft_1_1": "Up to the first loss of contact the motion is linear, and the threshold is where the linear peak "
    "equals the static deflection. This one and the end of contact loss in f_pm contradict each other (a).",
    "alpha_shaft_jumps": "The folds end in a cusp. A raster loses the interval before that, where it is narrower than "
    "a step of the frequency, and so sees it end at a smaller value.",
    "bilateral_shaft": "At the default load the motion at the shaft resonance does not reach the back flank (c). The "
    "printed condition of single-sided impact holds for double-sided impact as well, so that the two can be taken for "
    "each other.",
    "n3_b": _SEVERAL,
    "n3_fe": _SEVERAL,
}
_GENERAL = "Nothing more specific is known than that the model is not fully printed."


def reason_of(found: Evaluated) -> str:
    """A sentence or two; what kept it from being computed, if that is it."""
    if found.verdict == NOT_COMPARED:
        return f"Not computed: {found.reason}."
    return _REASONS.get(found.statement.key, _GENERAL)
