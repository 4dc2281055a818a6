"""What the study's tables 1 to 3 say: their rows, columns and wording, and the plane each of them is read from."""

from dataclasses import dataclass

import numpy as np

from pipeline.plan import Axis

__all__ = ["ARTICLE_TABLES", "ArticleTable", "Band", "Column", "band_rows"]

_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Band:
    """One row of a table of the study.

    Parameters
    ----------
    text : str
        The row's heading, with the signs of this project.
    low, high : float
        Parameter range; equal for a single value, `high` infinite for "above".
    above : bool
        Whether `low` itself is left out.
    wording : tuple of str
        The study's entries, one per column.
    """

    text: str
    low: float
    high: float
    wording: tuple[str, ...]
    above: bool = False

    @property
    def single(self) -> bool:
        """Whether the row stands for one value."""
        return self.low == self.high


@dataclass(frozen=True)
class Column:
    """One column of a table of the study, and which of our classes answer it (names in `classes.ASPECTS`)."""

    heading: str
    aspects: tuple[str, ...]


@dataclass(frozen=True)
class ArticleTable:
    """One table of the study: its number, plane, parameter (name, sign and words), columns and rows."""

    number: int
    plane: str
    parameter: str
    sign: str
    words: str
    columns: tuple[Column, ...]
    bands: tuple[Band, ...]


ARTICLE_TABLES = (
    ArticleTable(
        1, "omega_b", "b", "b", "half backlash",
        (
            Column("Amplitude Jump Region", ("jump", "resonance")),
            Column("Tooth Surface Impact", ("impact",)),
            Column("Stability", ("stability",)),
        ),
        (
            Band("0.1", 0.1, 0.1, ("Near linear, softening", "Severe bilateral impact", "Unstable")),
            Band("0.2–0.6", 0.2, 0.6, ("Increasing jump region", "Transition to unilateral impact", "Moderate")),
            Band("> 0.98", 0.98, np.inf, ("Stabilized jumps", "Reduced impact", "Stable"), above=True),
        ),
    ),
    ArticleTable(
        2, "omega_alpha", "alpha", "α", "mesh stiffness variation",
        (
            Column("Amplitude Jump", ("jump",)),
            Column("Tooth Surface Impact", ("impact",)),
            Column("Resonance Shift", ("resonance",)),
        ),
        (
            Band("0–0.25", 0.0, 0.25, (
                "Prominent in mesh frequency", "Bilateral impact in shaft frequency", "Softening to hardening")),
            Band("> 0.4", 0.4, np.inf, (
                "Reduced in shaft frequency", "Unilateral to no impact", "Stable in mesh frequency"), above=True),
        ),
    ),
    ArticleTable(
        3, "omega_fpm", "f_pm", "f_pm", "mean load",
        (
            Column("Amplitude Jump", ("jump",)),
            Column("Tooth Surface Impact", ("impact",)),
            Column("Resonance Behavior", ("resonance",)),
        ),
        (
            Band("0.5–0.57", 0.5, 0.57, ("Prominent jumps", "Bilateral impact in shaft frequency", "Softening")),
            Band("0.75–1.0", 0.75, 1.0, ("Reduced jumps", "Unilateral to no impact", "Weak linearity")),
        ),
    ),
)  # fmt: skip


def band_rows(band: Band, axis: Axis) -> np.ndarray:
    """Rows of a plane that belong to a band, ascending; none where the plane does not cover it.

    A single value takes the nearest row, provided that the axis reaches the value.
    """
    values, slack = axis.values, _TOLERANCE * max(1.0, abs(band.low))
    if band.single:
        covered = axis.low - slack <= band.low <= axis.high + slack
        return np.array([np.argmin(np.abs(values - band.low))] if covered else [], dtype=np.int64)
    above = values > band.low + slack if band.above else values >= band.low - slack
    return np.flatnonzero(above & (values <= band.high + slack))
