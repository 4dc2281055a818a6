"""Which labels occur over an operating range and a tolerance of the row parameter, and which of them is the worst."""

import itertools
from dataclasses import dataclass

import numpy as np

from pipeline.analysis.margins.curves import boundaries_of, crossed, part_of, traced
from pipeline.analysis.margins.lines import codes_along, divided, swept
from pipeline.analysis.margins.options import Design, nominal_value, replaced
from pipeline.plan.numerics import frame_of
from pipeline.plan.plan import Plan
from pipeline.plane.labels import RANKS
from pipeline.plane.regions import stored_curves
from pipeline.plane.stored import StoredPlane
from solver import ImpactState, domain_label, label_parts
from solver.boundaries import BoundaryCurve
from solver.regions import RegionError, Regions, regions

__all__ = ["Corner", "corners", "labels_of_rows", "labels_within", "severity"]

#: Rows and columns from which boundaries are started, more where those leave something unexplained.
_ROWS = (5, 17, 65)
#: Rows of a rectangle that are looked at where there are no regions, besides those between the stored boundaries' ends.
_LOOKED_AT = 9


@dataclass(frozen=True)
class Corner:
    """Labels that occur with further parameters at the ends of their tolerances.

    Parameters
    ----------
    values : dict of str to float
        The further parameters; empty for the nominal gear.
    labels : tuple of str
        The worst first.
    """

    values: dict[str, float]
    labels: tuple[str, ...]


def severity(label: str) -> tuple[int, int]:
    """What ranks a label: its severest impact, no stable motion at all above all, then how many stable motions.

    Examples
    --------
    >>> sorted(["1/2", "2/0-1", "0/-", "1/0", "2/0-2"], key=severity)
    ['1/0', '2/0-1', '1/2', '2/0-2', '0/-']
    """
    n, states = label_parts(label)
    return (max(RANKS[state] for state in states), n) if n else (len(ImpactState), 0)


def corners(plan: Plan, design: Design, plane: StoredPlane) -> list[Corner]:
    """Labels of the nominal gear and of all combinations of the further tolerances' ends.

    Parameters
    ----------
    plan : Plan
    design : Design
    plane : StoredPlane
        With its boundaries.

    Raises
    ------
    ArithmeticError
        If boundaries cannot be followed or do not divide the plane.
    """
    if plan.is_first_order:
        labels, own = labels_within, stored_curves(plane)
    else:
        labels, own = labels_of_rows, boundaries_of(plane.boundaries.curves).marked[0]
    found = [Corner({}, labels(plan, design, own))]
    spread = {name: size for name, size in design.further.items() if size > 0.0}
    nominal = {name: nominal_value(plan, design.x, design.p, name) for name in spread}
    ends = [(nominal[name] - size, nominal[name] + size) for name, size in spread.items()]
    for combination in itertools.product(*ends) if spread else ():
        values = dict(zip(spread, combination, strict=True))
        found.append(Corner(values, labels(replaced(plan, values, design.x, design.p), design, None)))
    return found


def labels_within(plan: Plan, design: Design, curves: tuple[BoundaryCurve, ...] | None) -> tuple[str, ...]:
    """All labels over the operating range and the tolerance of the row parameter, the worst first.

    Parameters
    ----------
    plan : Plan
    design : Design
    curves : tuple of BoundaryCurve or None
        All of the plane; traced on the spot within that part of it if not given.
    """
    x, p = (design.low, design.high), (design.p - design.tolerance, design.p + design.tolerance)
    if x[0] < x[1] and p[0] < p[1]:
        found = set(_regions(plan, x, p, curves).labels)
    elif x[0] < x[1] or p[0] < p[1]:
        name, ends = (plan.sweep.name, x) if x[0] < x[1] else (plan.parameter.name, p)
        places, kinds = crossed(plan, name, ends, design.x, design.p)
        line = divided(places, kinds, ends, codes_along(plan, name, ends, design.x, design.p))
        found = {domain_label(stretch.code) for stretch in line.stretches}
    else:
        codes = codes_along(plan, plan.sweep.name, (plan.sweep.low, plan.sweep.high), design.x, design.p)
        found = {domain_label(code) for code in codes([design.x]).tolist()}
    return _worst_first(found)


def _worst_first(labels: set[str]) -> tuple[str, ...]:
    return tuple(sorted(labels - {""}, key=lambda label: (severity(label), label), reverse=True))


def labels_of_rows(plan: Plan, design: Design, between: np.ndarray | None) -> tuple[str, ...]:
    """`labels_within` of a higher order: of some rows, each of them divided where its own branches fold and graze.

    Parameters
    ----------
    plan : Plan
    design : Design
    between : (k, 2) array or None
        Where stored boundaries end and turn round: labels come and go at these and where boundaries cross, so that rows
        halfway between two of them are looked at as well.
    """
    low, high = design.p - design.tolerance, design.p + design.tolerance
    rows = np.linspace(low, high, _LOOKED_AT if low < high else 1)
    if between is not None and low < high:
        inside = (between[:, 0] >= design.low) & (between[:, 0] <= design.high)
        ends = np.unique(np.clip(np.append(between[inside, 1], [low, high]), low, high))
        rows = np.append(rows, (0.5 * (ends[:-1] + ends[1:]))[np.argsort(np.diff(ends))[-_LOOKED_AT:]])
    x, found, axis = (design.low, design.high), set(), plan.sweep
    for row in map(float, rows):
        whole = axis.low, axis.high
        codes = codes_along(plan, axis.name, whole, design.x, row)
        if x[0] == x[1]:
            found |= {domain_label(code) for code in codes([x[0]]).tolist()}
            continue
        points, kinds = swept(plan, axis.name, whole, design.x, row)
        line = divided(points[:, -1], kinds, x, codes)
        found |= {domain_label(stretch.code) for stretch in line.stretches}
    return _worst_first(found)


def _regions(plan: Plan, x, p, curves: tuple[BoundaryCurve, ...] | None) -> Regions:
    """The regions of a part of a plane."""
    ceiling = float(plan.solver["amplitude_max"])
    if curves is not None:
        return regions(*frame_of(part_of(plan, x, p)), curves, omega=plan.omega, amplitude_max=ceiling)
    for rows in _ROWS:
        window, curves = traced(plan, x, p, rows)
        try:
            return regions(*frame_of(window), curves, omega=plan.omega, amplitude_max=ceiling)
        except RegionError:
            # A boundary that lies between the rows and columns is missing.
            if rows == _ROWS[-1]:
                raise
    raise AssertionError
