"""One measured number with its repeats and its ratios, and the sizes of a run."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field

__all__ = ["FULL", "QUICK", "TINY", "Baselines", "Measurement", "Sizes", "timed"]


@dataclass(frozen=True)
class Sizes:
    """How much is measured.

    Parameters
    ----------
    columns : int
        Of the row that kernel, row, enumeration and baselines are measured on.
    planes : dict
        Name of a plane's measurement -> columns, rows and repeats of the command.
    repeats : int
        Of everything in this process; baselines are measured once.
    starts : int
        Repeats of the smallest command.
    cold : bool
        Whether the kernels are compiled once from an empty cache.
    """

    columns: int
    planes: dict[str, tuple[int, int, int]]
    repeats: int
    starts: int
    cold: bool


FULL = Sizes(400, {"plane_draft": (160, 60, 3), "plane_paper": (400, 200, 3)}, 15, 3, True)
QUICK = Sizes(200, {"plane_draft": (160, 60, 1)}, 5, 1, False)
#: For tests.
TINY = Sizes(20, {"plane_draft": (20, 4, 1)}, 2, 1, False)


@dataclass(frozen=True)
class Baselines:
    """Seconds that the two programs of `benchmarks.baselines` take per frequency of one direction."""

    fsolve: float
    runge_kutta: float

    def of(self, columns: int, rows: int = 1) -> dict[str, float]:
        """Seconds for so many columns, up and down, in so many rows on one core: those of one row, multiplied."""
        points = 2 * columns * rows
        return {"fsolve": self.fsolve * points, "runge_kutta": self.runge_kutta * points}


@dataclass(frozen=True)
class Measurement:
    """Median of several values.

    Parameters
    ----------
    name, what, unit : str
    values : tuple of float
        In `unit`, one per repeat.
    baselines : dict
        Baseline -> its value for the same job in the same unit.
    """

    name: str
    what: str
    unit: str
    values: tuple[float, ...]
    baselines: dict[str, float] = field(default_factory=dict)

    @property
    def median(self) -> float:
        """Of the repeats."""
        return statistics.median(self.values)

    @property
    def plain(self) -> dict:
        """For JSON."""
        ratios = {name: {"value": value, "ratio": value / self.median} for name, value in self.baselines.items()}
        return {
            "name": self.name,
            "what": self.what,
            "unit": self.unit,
            "median": self.median,
            "lowest": min(self.values),
            "highest": max(self.values),
            "repeats": len(self.values),
            "baselines": ratios,
        }


def timed(
    action: Callable[[], object], repeats: int, scale: float = 1.0, clock: Callable[[], float] = time.perf_counter
) -> tuple[float, ...]:
    """Seconds by a clock, times `scale`, of every call after a first one that is not counted."""
    action()
    found = []
    for _ in range(repeats):
        begin = clock()
        action()
        found.append(scale * (clock() - begin))
    return tuple(found)
