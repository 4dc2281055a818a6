"""What a published case is: source, equations, numbers with their accuracy, how ours are computed, and a figure.

Tests compare the numbers (`tests.cases.test_cases`); the page "Published cases" of the site is made of the same objects
(`bevelmap_docs.cases`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes

__all__ = ["Case", "Comparison", "Number"]


@dataclass(frozen=True)
class Number:
    """What a source gives.

    Parameters
    ----------
    what : str
        In Markdown.
    value : float
    accuracy : float
        How far ours may be from it; 0 for counts.
    """

    what: str
    value: float
    accuracy: float


@dataclass(frozen=True)
class Comparison:
    """Numbers that one computation gives.

    Parameters
    ----------
    reference : str
        Where the numbers come from, in a sentence.
    how : str
        How ours are computed, in a sentence.
    numbers : tuple of Number
    ours : callable
        Our numbers, in the same order.
    slow : bool
        Whether it takes long, so that it is run on request only.
    """

    reference: str
    how: str
    numbers: tuple[Number, ...]
    ours: Callable[[], Sequence[float]]
    slow: bool = False


@dataclass(frozen=True)
class Case:
    """A published example.

    Parameters
    ----------
    title : str
    source : str
        Authors, title, place, in Markdown.
    equations : str
        In Markdown: one formula between $$ and $$, and after it what it needs.
    comparisons : tuple of Comparison
    draw : callable
        Draws the figure in axes.
    caption : str
        What the figure shows, in Markdown.
    remark : str
        What there is to say besides.
    """

    title: str
    source: str
    equations: str
    comparisons: tuple[Comparison, ...]
    draw: Callable[[Axes], None] | None = None
    caption: str = ""
    remark: str = ""
