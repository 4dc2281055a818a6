"""What may be asked of the figures, checked before anything is computed or drawn."""

import math
from collections.abc import Sequence

from pipeline.config.allowed import check_one, sentence_of
from pipeline.config.quantities import QUANTITIES
from pipeline.config.schema import Figures
from pipeline.errors import ConfigurationError
from pipeline.plan.kinds import kind_of
from pipeline.plan.plan import Plan

__all__ = ["check_options", "check_quantity", "check_units", "figure_options"]

#: As a share of an axis: down to here, what stored boundaries are known to is less than a pixel.
NARROWEST = 1e-5


def figure_options(
    curves: list[float] | None,
    formats: Sequence[str],
    dpi: int,
    *,
    window: list[float] | None = None,
    stability: str = "static",
    units: str = "dimensionless",
    multipliers: list[float] | None = None,
    quantity: str | None = None,
    of: str = "worst",
) -> Figures:
    """Options of figures, as the configuration has them under `figures`.

    Parameters
    ----------
    curves : list of float or None
        Parameter values whose amplitude-frequency curves are drawn; None leaves the choice to us.
    formats : sequence of str
        Of "png", "pdf" and "svg".
    dpi : int
        Pixels per inch of the PNG.
    window : list of float, optional
        A part of the plane, [x low, x high, p low, p high], drawn in addition as map-window.
    stability : str, optional
        Which motions the labels count: "static" (det J > 0, what is dynamically unstable is shaded) or "dynamic".
    units : str, optional
        Of the axes: "dimensionless", or "physical" with the dimensionless value on the opposite side; that needs a gear
        in physical units.
    multipliers : list of float, optional
        Parameter values along whose branches Floquet multipliers are drawn.
    quantity : str, optional
        One of `pipeline.config.quantities.QUANTITIES`: its map is drawn in addition, and curves of it instead of those
        of the amplitude.
    of : str, optional
        Where several motions coexist that a label counts, that map shows the "worst", the largest value, or the
        "mildest", the smallest.
    """
    further = {"window": window, "stability": stability, "units": units, "quantity": quantity, "of": of}
    return Figures(curves=curves, multipliers=multipliers, formats=list(formats), dpi=dpi, **further)


def check_options(plan: Plan, options: Figures) -> None:
    """Raise unless these figures can be drawn of this plane.

    Raises
    ------
    ConfigurationError
        One line that names the key, its value and what is allowed.
    """
    row = plan.parameter
    if plan.parameter2 is not None:
        for key in ("curves", "window", "units", "multipliers", "quantity"):
            if (value := getattr(options, key)) not in (None, "dimensionless"):
                raise ConfigurationError(
                    f"figures.{key} = {value} is not allowed for a volume: with plane.layer=VALUE, a value of "
                    f"{plan.parameter2.name}, it is drawn of the plane of that layer"
                )
    for key, values in (("curves", options.curves), ("multipliers", options.multipliers)):
        if values is not None and not values:
            raise ConfigurationError(f"figures.{key} = [] is not allowed: it must be null or hold at least one value")
        for value in values or []:
            if not (math.isfinite(value) and row.low <= value <= row.high):
                raise ConfigurationError(
                    f"figures.{key} = {value} is not allowed: it must lie within {row.name} = {row.low:g} ... "
                    f"{row.high:g}"
                )
    if not options.formats:
        names = sentence_of(Figures, "formats").removeprefix("one of ")
        raise ConfigurationError(f"figures.formats = [] is not allowed: it must be a list of {names}")
    for name in ("formats", "dpi", "stability", "units", "quantity", "of"):
        check_one(Figures, f"figures.{name}", getattr(options, name))
    check_quantity(plan, "figures.quantity", options.quantity)
    check_units(plan, options.units)
    if options.window is not None:
        _check_window(plan, options.window)


def check_quantity(plan: Plan, key: str, quantity: str | None) -> None:
    """Raise ConfigurationError, which names the key, unless motions of the gear have a quantity; None asks for none."""
    lacks = kind_of(plan).lacks
    if quantity in lacks:
        names = ", ".join(name for name in QUANTITIES if name not in lacks)
        raise ConfigurationError(f"{key} = {quantity!r} is not allowed: this gear has none; it must be one of {names}")


def check_units(plan: Plan, units: str) -> None:
    """Raise ConfigurationError unless a plane can be shown in these units."""
    if units == "physical" and plan.physical is None:
        raise ConfigurationError(
            "figures.units = 'physical' is not allowed: it must be dimensionless, as this plane's gear is"
        )


def _check_window(plan: Plan, window: list[float]) -> None:
    axes = (plan.sweep, plan.parameter)
    if len(window) != 4 or not all(math.isfinite(value) for value in window):
        names = ",".join(f"{axis.name} {end}" for axis in axes for end in ("low", "high"))
        raise ConfigurationError(
            f"figures.window = {window} is not allowed: it must be null or four finite numbers, [{names}]"
        )
    for axis, low, high in zip(axes, window[::2], window[1::2], strict=True):
        if not axis.low <= low < high <= axis.high:
            raise ConfigurationError(
                f"figures.window = {window} is not allowed: {axis.name} must ascend "
                f"within {axis.low:g} ... {axis.high:g}"
            )
        if high - low < NARROWEST * (axis.high - axis.low):
            raise ConfigurationError(
                f"figures.window = {window} is not allowed: it must span at least {NARROWEST:g} of the axis {axis.name}"
            )
