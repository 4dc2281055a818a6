"""What may be asked of the stages `diagram` and `spectrum`, checked before anything is computed."""

from dataclasses import dataclass

import numpy as np

from pipeline.config.physical import value_of
from pipeline.config.schema import Diagram, Spectrum
from pipeline.errors import refused
from pipeline.plan.plan import Plan
from pipeline.plan.scales import scales_of

__all__ = ["FEWEST_COLUMNS", "SpectrumOptions", "Way", "spectrum_of", "way_of"]

#: A run has at least so many steps, unless it is told how many.
FEWEST_COLUMNS = 400


@dataclass(frozen=True)
class Way:
    """The row that is followed, and in which steps.

    Parameters
    ----------
    value : float
        Of the row parameter.
    columns : (X,) tuple of float
        Values of the swept parameter, ascending.
    max_periods : int
        Forcing periods of a motion at each of them.
    """

    value: float
    columns: tuple[float, ...]
    max_periods: int


@dataclass(frozen=True)
class SpectrumOptions:
    """Spectra along a row.

    Parameters
    ----------
    way : Way
    direction : str
        "up" or "down".
    of : str
        "displacement" or "force".
    axis : str
        What is drawn upwards: "frequency" or "order".
    orders : float
        The highest order of the mesh frequency.
    periods : int
        Forcing periods of a record: orders are multiples of one over it.
    """

    way: Way
    direction: str
    of: str
    axis: str
    orders: float
    periods: int


def way_of(key: str, options: Diagram | Spectrum, plan: Plan) -> Way:
    """The row that the settings under `key` describe.

    Raises
    ------
    ConfigurationError
        One line that names the key, its value and what is allowed.
    """
    row, sweep = plan.parameter, plan.sweep
    allowed = f"a value of {row.name} within {row.low:g} ... {row.high:g}"
    value = value_of(f"{key}.value", row.name, options.value, scales_of(plan), allowed)
    if not row.low <= value <= row.high:
        raise refused(f"{key}.value", options.value, allowed)
    if options.columns is None and sweep.num >= FEWEST_COLUMNS:
        columns = sweep.values
    else:
        columns = np.linspace(sweep.low, sweep.high, options.columns or FEWEST_COLUMNS)
    return Way(value, tuple(columns.tolist()), options.max_periods)


def spectrum_of(options: Spectrum, plan: Plan) -> SpectrumOptions:
    """The spectra that the settings describe; raises ConfigurationError as `way_of`."""
    way = way_of("spectrum", options, plan)
    return SpectrumOptions(way, options.direction, options.of, options.axis, float(options.orders), options.periods)
