"""The head of a figure: which gear, which balance, which grid, and what is held fixed."""

import functools
import re

from matplotlib.figure import Figure
from matplotlib.textpath import TextPath

from pipeline.figures.layout import RIGHT
from pipeline.figures.naming import fixed_parameters, gear_text, symbol
from pipeline.plan.plan import Plan
from pipeline.plan.unfelt import unfelt_harmonics
from pipeline.plane.stored import StoredPlane

__all__ = ["HEAD", "balance_text", "write_heading"]

#: Inches.
HEAD = 0.3
_LEFT, _TOP, _LINE, _BETWEEN = 0.08, 0.05, 0.145, 0.4
#: Points of its letters, where there is room.
_SIZE = 8.0
#: Of formulas: commands, which are a letter each, and what is not seen.
_MARKUP = re.compile(r"(\\[a-z]+ ?)|[${}_^]", re.IGNORECASE)


def write_heading(figure: Figure, plane: StoredPlane) -> None:
    """Write two lines at the top: the store, its balance and grid, what is fixed; the gear."""
    width, height = figure.get_size_inches()
    plan = plane.plan
    sizes = " \u00d7 ".join(f"{axis.num} {symbol(axis.name)}" for axis in plan.axes)
    about = f"{plane.path.stem}:  {balance_text(plan)},  {sizes}"
    fixed = fixed_parameters(plan, plane.scales)
    for line, (left, right) in enumerate(((about, fixed), (gear_text(plan), _unfelt(plan)))):
        y, size = 1.0 - (_TOP + line * _LINE) / height, _fitting(left, right, width)
        figure.text(_LEFT / width, y, left, ha="left", va="top", fontsize=size)
        figure.text(1.0 - RIGHT / width, y, right, ha="right", va="top", fontsize=size)


def _fitting(left: str, right: str, width: float) -> float:
    """The size of letters at which both ends of a line have room, at most the usual one."""
    texts, room = [text for text in (left, right) if text], width - _LEFT - RIGHT - _BETWEEN
    # Formulas take long to set. Without their markup, with letters as wide as any, they are no narrower than they are.
    if _inches("".join(_MARKUP.sub(_wide, text) for text in texts)) <= room:
        return _SIZE
    return min(_SIZE, _SIZE * room / sum(map(_inches, texts)))


def _wide(found: re.Match) -> str:
    return "m" if found[1] else ""


@functools.lru_cache(maxsize=64)
def _inches(text: str) -> float:
    """The width of a text in letters of the usual size; the figures of a plane have the same ones."""
    if not text:
        return 0.0
    # Letters reach furthest at points of their outlines; to look between these takes three times as long.
    return float(TextPath((0.0, 0.0), text, size=_SIZE).vertices[:, 0].max()) / 72.0


def balance_text(plan: Plan) -> str:
    """The harmonic balance in a few words."""
    order, period = plan.solver["order"], plan.solver["period"]
    if plan.solver["balance"] == "describing_function":
        return "order 1 (describing function)"
    return f"order {order} (harmonic balance)" + (f" of {period} periods" if period > 1 else "")


def _unfelt(plan: Plan) -> str:
    """What the balance does not feel of the excitation; empty where it feels everything."""
    found = unfelt_harmonics(plan)
    if found is None:
        return ""
    # Of what they are is for the run to say: the gear needs the room.
    numbers = sorted({*found.stiffness, *found.error})
    return f"not felt: harmonic{'s' * (len(numbers) > 1)} {', '.join(map(str, numbers))} of the excitation"
