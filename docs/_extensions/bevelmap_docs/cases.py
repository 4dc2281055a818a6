"""Published cases as a page: source, equations, numbers, ours and a figure, from the objects that the tests compare."""

import io
import math
import re
from collections.abc import Sequence

import matplotlib
from matplotlib.figure import Figure

from tests.cases.case import Case, Number
from tests.cases.gallery import CASES

__all__ = ["figure", "published", "section"]

_STYLE = {"font.family": "sans-serif", "font.size": 9.5, "axes.linewidth": 0.7, "svg.fonttype": "none"}


def published() -> str:
    """All cases; ours are computed, and figures drawn, as the page is built."""
    return "\n".join(
        section(case, [comparison.ours() for comparison in case.comparisons], figure(case)) for case in CASES
    )


def section(case: Case, ours: Sequence[Sequence[float]], picture: str) -> str:
    """One case in Markdown.

    Parameters
    ----------
    case : Case
    ours : sequence of sequences
        Our numbers of each of its comparisons.
    picture : str
        Its figure as SVG, or nothing.
    """
    _, formula, rest = case.equations.split("$$")
    lines = [f"## {case.title}", "", f"*Source.* {case.source}", "", "$$", formula, "$$", ""]
    if rest.strip():
        lines += [rest.strip()[0].upper() + rest.strip()[1:], ""]
    if case.remark:
        lines += [case.remark, ""]
    for comparison, found in zip(case.comparisons, ours, strict=True):
        lines += [f"*Numbers.* {comparison.reference} *Ours.* {comparison.how}", ""]
        lines += ["| | given | accuracy | ours |", "| --- | --- | --- | --- |"]
        for number, value in zip(comparison.numbers, found, strict=True):
            lines.append(
                f"| {number.what} | {_digits(number.value, number)} | {_accuracy(number)} | {_digits(value, number)} |"
            )
        lines.append("")
    if picture:
        lines += [picture, "", case.caption, ""]
    return "\n".join(lines)


def _digits(value: float, number: Number) -> str:
    """A value with the digits that the accuracy tells of, and one more."""
    if number.accuracy == 0:
        return f"{value:.0f}"
    return f"{value:.{max(0, math.ceil(-math.log10(number.accuracy)) + 1)}f}"


def _accuracy(number: Number) -> str:
    return f"{number.accuracy:g}".replace("e-0", "e-") if number.accuracy else "exact"


def figure(case: Case) -> str:
    """The figure of a case as SVG on one line, a block of HTML in Markdown; nothing where it has none."""
    if case.draw is None:
        return ""
    # Names within one page must differ.
    style = {**_STYLE, "svg.hashsalt": case.title}
    with matplotlib.rc_context(style):
        drawn = Figure(figsize=(6.4, 3.6), facecolor="white", layout="constrained")
        case.draw(drawn.subplots())
        text = io.StringIO()
        drawn.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    picture = text.getvalue()
    picture = picture[picture.index("<svg") :]
    label = re.sub(r'[<>"&$\\]', "", case.caption)
    return re.sub(r"\s*\n\s*", " ", picture).replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1)
