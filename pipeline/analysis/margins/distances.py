"""How far a design point, and its operating range, are from the nearest change of label in each parameter."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from pipeline.analysis.boundaries.tracing import to_store
from pipeline.analysis.margins.curves import Boundaries, P, X, boundaries_of, traced
from pipeline.analysis.margins.lines import Line, codes_along, divided, swept
from pipeline.analysis.margins.options import Design, nominal_value
from pipeline.plan.axes import Axis
from pipeline.plan.numerics import gear_at
from pipeline.plan.plan import Plan
from solver import Event

__all__ = [
    "Margin",
    "across",
    "further_axis",
    "losses_of_axis",
    "margins_of_axis",
    "margins_of_further",
    "nearest_over_range",
]

#: How far from a boundary, relative to the axis, the label beyond is asked for: further where too close to be told.
_STEPS = 10.0 ** np.arange(-7.0, -3.5)
#: Rows and columns of a plane that is traced on the spot.
_ROWS = 9
#: Values that cannot be 0: the balance would be singular or leave the mean open.
_ABOVE_ZERO = ("omega", "f_pm", "kappa", "k_support", "rotation_coupling", "xi_mesh", "xi_support")
_HALF_TURN = {"alpha_phase": np.pi, "f_e_phase": np.pi}
_BELOW = {"pitch_cone_angle": 180.0, "pressure_angle": 90.0}


@dataclass(frozen=True)
class Margin:
    """Distance to the nearest boundary in one parameter and direction.

    Parameters
    ----------
    name : str
        The parameter.
    upward : bool
    of_range : bool
        Whether it is the smallest over the operating range, or that of the design point.
    value : float
        Where it is counted from.
    limit : float
        Up to where there is none, if there is none: the end of the axis.
    place : float or None
        The parameter's value on the boundary; None without one.
    at : float
        Where on the swept axis.
    kind : Event
    beyond : int
        Code of the label on the other side; 0 where it cannot be had.
    """

    name: str
    upward: bool
    of_range: bool
    value: float
    limit: float
    place: float | None
    at: float
    kind: Event = Event.NONE
    beyond: int = 0

    @property
    def distance(self) -> float | None:
        """In the parameter's own unit, at least 0; None without a boundary."""
        return None if self.place is None else abs(self.place - self.value)


def further_axis(plan: Plan, design: Design, name: str) -> Axis:
    """Where a parameter that is no axis is looked at: from 0, or 1/reach of its value where it cannot be 0 (and half a
    turn either way for phases), to reach times its value, or 1 where that is 0."""
    value, tolerance = nominal_value(plan, design.x, design.p, name), design.further.get(name, 0.0)
    if name in _HALF_TURN:
        low, high = value - _HALF_TURN[name], value + _HALF_TURN[name]
    else:
        low, high = sorted((0.0, design.reach * value or 1.0))
        if name in _ABOVE_ZERO and value != 0.0:
            low, high = sorted((value / design.reach, design.reach * value))
    low, high = min(low, value - tolerance), max(high, value + tolerance)
    if name in _BELOW:
        high = min(high, np.nextafter(_BELOW[name], 0.0))
    return Axis(name, float(low), float(high), _ROWS)


def _of_line(line: Line, axis: Axis, value: float, at: float | None) -> list[Margin]:
    found = []
    for upward, limit in ((False, axis.low), (True, axis.high)):
        place, kind, beyond = line.beyond(value, upward) or (None, Event.NONE, 0)
        here = at if at is not None else value if place is None else place
        found.append(Margin(axis.name, upward, False, value, limit, place, here, kind, beyond))
    return found


def margins_of_axis(row: Line, column: Line, plan: Plan, design: Design) -> list[Margin]:
    """Those of the point in the plane's own axes, from the lines through it, and of the range in the swept one."""
    found = [*_of_line(row, plan.sweep, design.x, None), *_of_line(column, plan.parameter, design.p, design.x)]
    if design.low == design.high:
        return found
    for upward, end, far, limit in (
        (False, design.low, design.high, plan.sweep.low),
        (True, design.high, design.low, plan.sweep.high),
    ):
        # From the far end of the range: a boundary inside of it leaves no distance.
        place, kind, beyond = row.beyond(far, upward) or (None, Event.NONE, 0)
        start = end if place is None or (place > end) == upward and place != end else place
        at = start if place is None else place
        found.append(Margin(plan.sweep.name, upward, True, start, limit, place, at, kind, beyond))
    return found


def losses_of_axis(bifurcations: Boundaries, plan: Plan, design: Design) -> list[Margin]:
    """To the nearest bifurcations in the plane's own axes; where there is none in a direction, nothing."""
    row, column = (
        divided(*bifurcations.along(held, value), (axis.low, axis.high), None)
        for held, value, axis in ((P, design.p, plan.sweep), (X, design.x, plan.parameter))
    )
    found = [*_of_line(row, plan.sweep, design.x, None), *_of_line(column, plan.parameter, design.p, design.x)]
    return [margin for margin in found if margin.place is not None]


def margins_of_further(plan: Plan, design: Design, name: str) -> list[Margin]:
    """Those of the point and of the operating range in a parameter that is no axis.

    Raises
    ------
    ArithmeticError
        If its boundaries cannot be followed.
    """
    axis = further_axis(plan, design, name)
    value, ends = nominal_value(plan, design.x, design.p, name), (axis.low, axis.high)
    points, kinds = swept(plan, name, ends, design.x, design.p)
    codes = codes_along(plan, name, ends, design.x, design.p)
    found = _of_line(divided(points[:, -1], kinds, ends, codes), axis, value, design.x)
    if design.low < design.high:
        crossing = across(plan, design, axis)
        _, curves = traced(crossing, (design.low, design.high), ends, _ROWS)
        boundaries = boundaries_of([to_store(curve) for curve in curves])
        found += nearest_over_range(boundaries, crossing, design, value)
    return found


def across(plan: Plan, design: Design, axis: Axis) -> Plan:
    """The plane of the swept axis and of a parameter that is no axis, the row parameter being that of the point."""
    numbers = gear_at(plan, design.p, design.x)
    gear = {key: value for key, value in numbers.items() if key not in (axis.name, plan.sweep.name)}
    omega = None if axis.name == "omega" else plan.frequency(design.p)
    return dataclasses.replace(plan, gear=gear, parameter=axis, omega=omega, thermal=None)


def nearest_over_range(boundaries: Boundaries, plan: Plan, design: Design, value: float) -> list[Margin]:
    """Distance in the row parameter from a value to the nearest boundary anywhere in the operating range.

    It is 0 where a boundary crosses the range itself.
    """
    low, high, axis = design.low, design.high, plan.parameter
    places, kinds = boundaries.marked
    inside = (places[:, 0] >= low) & (places[:, 0] <= high)
    candidates = [np.column_stack([places[inside], kinds[inside]])]
    for x in (low, high):
        crossed, kind = boundaries.along(X, x)
        candidates.append(np.column_stack([np.full(crossed.size, x), crossed, kind]))
    crossed, kind = boundaries.along(P, value)
    here = (crossed >= low) & (crossed <= high)
    candidates.append(np.column_stack([crossed[here], np.full(here.sum(), value), kind[here]]))
    candidates = np.concatenate(candidates)
    found = []
    for upward, limit in ((False, axis.low), (True, axis.high)):
        sign = 1.0 if upward else -1.0
        beyond = candidates[(sign * (candidates[:, 1] - value) >= 0.0) & (sign * (limit - candidates[:, 1]) > 0.0)]
        order = np.lexsort((beyond[:, 0], sign * beyond[:, 1]))
        margin = Margin(axis.name, upward, True, value, limit, None, low)
        for x, p, kind in beyond[order]:
            code = _changed(boundaries, plan, design, float(x), float(p), sign, p == value)
            if code is not None:
                margin = Margin(axis.name, upward, True, value, limit, float(p), float(x), Event(int(kind)), code)
                break
        found.append(margin)
    return found


def _changed(boundaries, plan, design, x, p, sign, crosses) -> int | None:
    """The label beyond a boundary at (x, p), seen in the direction of `sign`; None if it is the one before.

    At a boundary that crosses the range itself, that on the far side in x.
    """
    height = plan.parameter.high - plan.parameter.low
    for step in _STEPS:
        before = _codes_near(boundaries, plan, design, x, p if crosses else p - sign * step * height)
        after = before if crosses else _codes_near(boundaries, plan, design, x, p + sign * step * height)
        known = [code for code in after if code and before[0] and code != before[0]]
        if known:
            return known[0]
    return None


def _codes_near(boundaries, plan, design, x, p) -> list[int]:
    """Labels of a row within the operating range between two crossings each, the nearest to x first."""
    p = min(max(p, plan.parameter.low), plan.parameter.high)
    crossed, _ = boundaries.along(P, p)
    inside = crossed[(crossed > design.low) & (crossed < design.high)]
    cuts = np.unique(np.concatenate([[design.low, design.high], inside]))
    if cuts.size == 1:
        middles = cuts
    else:
        away = np.maximum(np.maximum(cuts[:-1] - x, x - cuts[1:]), 0.0)
        nearest = np.argsort(away, kind="stable")[:3]
        middles = 0.5 * (cuts[:-1] + cuts[1:])[nearest]
    codes = codes_along(plan, plan.sweep.name, (plan.sweep.low, plan.sweep.high), x, p)
    return codes(middles).tolist()
