"""Axes in physical units with the dimensionless value on the opposite side."""

from matplotlib.axes import Axes

from pipeline.figures.naming import symbol
from pipeline.plane.stored import StoredPlane
from solver import Scale

__all__ = ["LIFT", "lift", "show_bar_units", "show_units", "spare", "titled"]

#: Inches that an axis above a panel takes, and points.
LIFT = 0.36
_LIFT_POINTS = 72.0 * LIFT
#: Inches that an axis at the right of a panel takes.
_ASIDE = 0.42


def lift(plane: StoredPlane) -> float:
    """Inches for an axis above the panels of a map."""
    return LIFT if plane.scales is not None and plane.plan.sweep.name in plane.scales else 0.0


def spare(plane: StoredPlane) -> float:
    """Inches for an axis at the right of the panels of a map."""
    return _ASIDE if plane.scales is not None and plane.plan.parameter.name in plane.scales else 0.0


def titled(axes: Axes, plane: StoredPlane, text: str, below_axis: bool = False) -> None:
    """Set the title of a panel, above the upper axis where there is one."""
    lifted = plane.scales is not None and not below_axis
    axes.set_title(text, **({"pad": 4.0 + _LIFT_POINTS} if lifted else {}))


def show_units(axes: Axes, plane: StoredPlane, x: str | None = None, y: str | None = None, sides: str = "blrt") -> None:
    """Turn finished axes of dimensionless values into physical ones; nothing happens to a plane without scales.

    Parameters
    ----------
    axes : Axes
        Its limits set.
    plane : StoredPlane
    x, y : str or None
        Parameters along the axes, or "length", "velocity" and "force" for quantities of motions; one without a unit
        keeps its axis as it is.
    sides : str
        Of b, l (physical) and t, r (dimensionless): which sides have tick labels and names.
    """
    for name, axis, low, high, secondary in (
        (x, axes.xaxis, "b", "t", axes.secondary_xaxis),
        (y, axes.yaxis, "l", "r", axes.secondary_yaxis),
    ):
        if plane.scales is None or name is None or name not in plane.scales:
            continue
        places = {"b": "bottom", "t": "top", "l": "left", "r": "right"}
        scale, label = plane.scales[name], axis.get_label_text()
        dimensionless = symbol(name) if name in plane.attributes else label
        axis.set_ticks_position(places[high])
        axis.set_label_position(places[high])
        axis.set_label_text(dimensionless if high in sides else "")
        axis.set_tick_params(**{f"label{places[high]}": high in sides, f"label{places[low]}": False})
        other = secondary(places[low], functions=_functions(scale.shown))
        if low in sides:
            other_axis = other.xaxis if low == "b" else other.yaxis
            what = scale.name if name in plane.attributes else label.partition(" $")[0]
            other_axis.set_label_text(f"{what} ({scale.unit})" if what else "")
        other.tick_params(**{f"label{places[low]}": low in sides})


def show_bar_units(bar: Axes, scale: Scale) -> Axes:
    """Of a colour bar of dimensionless values, which go to its left: physical ones at the right, on an axis of their
    own."""
    bar.yaxis.tick_left()
    bar.set_ylabel("")
    return bar.secondary_yaxis("right", functions=_functions(scale.shown))


def _functions(size: float):
    return (lambda value: value * size), (lambda value: value / size)
