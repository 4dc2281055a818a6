"""What may be asked of the figures, checked before anything is computed or drawn."""

import math

from pipeline.config.allowed import check_one, sentence_of
from pipeline.config.quantities import QUANTITIES
from pipeline.config.schema import Figures
from pipeline.errors import ConfigurationError
from pipeline.plan.kinds import kind_of
from pipeline.plan.plan import Plan

__all__ = ["check_options", "check_quantity", "check_units"]

#: As a share of an axis: down to here, what stored boundaries are known to is less than a pixel.
NARROWEST = 1e-5


def check_options(
    plan: Plan,
    curves: list[float] | None,
    formats: list[str],
    dpi: int,
    window: list[float] | None = None,
    stability: str = "static",
    units: str = "dimensionless",
    multipliers: list[float] | None = None,
    quantity: str | None = None,
    of: str = "worst",
) -> None:
    """Raise unless these figures can be drawn of this plane.

    Parameters
    ----------
    plan : Plan
    curves : list of float or None
        Parameter values whose amplitude-frequency curves are drawn; None leaves the choice to us.
    formats : list of str
        Of "png", "pdf" and "svg".
    dpi : int
        Pixels per inch of the PNG.
    window : list of float or None
        A part of the plane, [x low, x high, p low, p high]; None draws none.
    stability : str
        "static" or "dynamic".
    units : str
        "dimensionless" or "physical"; the latter needs a gear in physical units.
    multipliers : list of float or None
        Parameter values along whose branches Floquet multipliers are drawn.
    quantity : str or None
        One of `pipeline.config.quantities.QUANTITIES`, drawn over the plane and along the curves.
    of : str
        "worst" or "mildest".

    Raises
    ------
    ConfigurationError
        One line that names the key, its value and what is allowed.
    """
    row = plan.parameter
    if plan.parameter2 is not None:
        asked = {"curves": curves, "window": window, "units": units, "multipliers": multipliers, "quantity": quantity}
        for key, value in asked.items():
            if value not in (None, "dimensionless"):
                raise ConfigurationError(
                    f"figures.{key} = {value} is not allowed for a volume: with plane.layer=VALUE, a value of "
                    f"{plan.parameter2.name}, it is drawn of the plane of that layer"
                )
    for key, values in (("curves", curves), ("multipliers", multipliers)):
        if values is not None and not values:
            raise ConfigurationError(f"figures.{key} = [] is not allowed: it must be null or hold at least one value")
        for value in values or []:
            if not (math.isfinite(value) and row.low <= value <= row.high):
                raise ConfigurationError(
                    f"figures.{key} = {value} is not allowed: it must lie within {row.name} = {row.low:g} ... "
                    f"{row.high:g}"
                )
    if not formats:
        names = sentence_of(Figures, "formats").removeprefix("one of ")
        raise ConfigurationError(f"figures.formats = [] is not allowed: it must be a list of {names}")
    words = {"stability": stability, "units": units, "quantity": quantity, "of": of}
    for name, value in {"formats": formats, "dpi": dpi, **words}.items():
        check_one(Figures, f"figures.{name}", value)
    check_quantity(plan, "figures.quantity", quantity)
    check_units(plan, units)
    if window is not None:
        _check_window(plan, window)


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
