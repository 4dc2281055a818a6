"""What the study's tables 1 to 3 say: rows, columns, wording with its meaning, and the plane each is read from."""

from dataclasses import dataclass

import numpy as np

from pipeline.plan.axes import Axis
from pipeline.study.tables.claims import Claim, Entry

__all__ = ["ARTICLE_TABLES", "ArticleTable", "Band", "Column", "band_range", "band_rows"]

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
    entries : tuple of Entry
        The study's, one per column.
    """

    text: str
    low: float
    high: float
    entries: tuple[Entry, ...]
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


_MESH, _SHAFT = ("mesh",), ("shaft",)
_BILATERAL_SHAFT = Entry("Bilateral impact in shaft frequency", (Claim("double-sided", _SHAFT),))


def _to_no_impact(value: float) -> Entry:
    return Entry(
        "Unilateral to no impact",
        (Claim("single-sided to none", _SHAFT), Claim("contact loss ends", _SHAFT, value)),
        "read of the shaft resonance, of which the row before speaks",
    )


ARTICLE_TABLES = (
    ArticleTable(
        1,
        "omega_b",
        "b",
        "b",
        "half backlash",
        (
            Column("Amplitude Jump Region", ("jump", "resonance")),
            Column("Tooth Surface Impact", ("impact",)),
            Column("Stability", ("stability",)),
        ),
        (
            Band(
                "0.1",
                0.1,
                0.1,
                (
                    Entry(
                        "Near linear, softening",
                        (
                            Claim("jump not prominent", _MESH),
                            Claim("jump not prominent", _SHAFT),
                            Claim("below natural", _MESH),
                            Claim("below natural", _SHAFT),
                        ),
                        "both at once only if near linear is said of the jump and softening of the peak",
                    ),
                    Entry("Severe bilateral impact", (Claim("double-sided"),), "how much is severe stays open"),
                    Entry("Unstable", (Claim("somewhere none stable"),)),
                ),
            ),
            Band(
                "0.2–0.6",
                0.2,
                0.6,
                (
                    Entry("Increasing jump region", (Claim("jump grows"),)),
                    Entry("Transition to unilateral impact", (Claim("double- to single-sided"),)),
                    Entry("Moderate", unclear="a grade between unstable and stable without a measure"),
                ),
            ),
            Band(
                "> 0.98",
                0.98,
                np.inf,
                (
                    Entry("Stabilized jumps", (Claim("jump settled", _MESH), Claim("jump settled", _SHAFT))),
                    Entry(
                        "Reduced impact",
                        (Claim("double-sided less", _MESH), Claim("double-sided impact ends", _MESH, 0.98)),
                        "read of double-sided impact at the mesh resonance, which the study's text ends at 0.98",
                    ),
                    Entry("Stable", (Claim("everywhere one stable", _MESH), Claim("everywhere one stable", _SHAFT))),
                ),
                above=True,
            ),
        ),
    ),
    ArticleTable(
        2,
        "omega_alpha",
        "alpha",
        "α",
        "mesh stiffness variation",
        (
            Column("Amplitude Jump", ("jump",)),
            Column("Tooth Surface Impact", ("impact",)),
            Column("Resonance Shift", ("resonance",)),
        ),
        (
            Band(
                "0–0.25",
                0.0,
                0.25,
                (
                    Entry("Prominent in mesh frequency", (Claim("jump prominent", _MESH),)),
                    _BILATERAL_SHAFT,
                    Entry("Softening to hardening", (Claim("softening to hardening"),)),
                ),
            ),
            Band(
                "> 0.4",
                0.4,
                np.inf,
                (
                    Entry(
                        "Reduced in shaft frequency", (Claim("jump smaller", _SHAFT), Claim("jump ends", _SHAFT, 0.25))
                    ),
                    _to_no_impact(0.4),
                    Entry(
                        "Stable in mesh frequency",
                        (Claim("peak settled", _MESH),),
                        "read of the peak's place, of which the column speaks",
                    ),
                ),
                above=True,
            ),
        ),
    ),
    ArticleTable(
        3,
        "omega_fpm",
        "f_pm",
        "f_pm",
        "mean load",
        (
            Column("Amplitude Jump", ("jump",)),
            Column("Tooth Surface Impact", ("impact",)),
            Column("Resonance Behavior", ("resonance",)),
        ),
        (
            Band(
                "0.5–0.57",
                0.5,
                0.57,
                (
                    Entry("Prominent jumps", (Claim("jump prominent"),)),
                    _BILATERAL_SHAFT,
                    Entry("Softening", (Claim("softening"),)),
                ),
            ),
            Band(
                "0.75–1.0",
                0.75,
                1.0,
                (
                    Entry(
                        "Reduced jumps",
                        (Claim("jump smaller", _MESH), Claim("jump smaller", _SHAFT), Claim("jump ends", _SHAFT, 0.57)),
                    ),
                    _to_no_impact(0.75),
                    Entry("Weak linearity", unclear="it may mean hardly linear as well as weakly nonlinear"),
                ),
            ),
        ),
    ),
)


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


def band_range(band: Band, axis: Axis) -> tuple[float, float] | None:
    """The part of a band that a plane covers; None where that is nothing, or one value of a band of many."""
    low, high = max(band.low, axis.low), min(band.high, axis.high)
    return (low, high) if low < high or (band.single and low == high) else None
