"""On either side of a period-doubling or Neimark-Sacker curve motions are what the curve says, in all planes."""

import functools

import numpy as np
import pytest

from solver import Continuation, LinearSeeds, sweep_row
from solver.boundaries import BIFURCATIONS, SpecialPoint, boundary_curves, row_events
from solver.continuation.continuation import Event
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.galerkin import Galerkin
from solver.stability import Instability, assess, motion_multipliers
from solver.stability.bifurcations import with_bifurcations
from tests.conftest import antiphase, consistent, published
from tests.solver.stability.rows import branch

OMEGA = (0.3, 2.0)
FIRST, HIGHER = DescribingFunction(), Galerkin(3)
RANGES = {"f_e": (0.05, 0.5), "alpha": (0.05, 0.5), "f_pm": (0.3, 1.0), "b": (0.1, 1.2)}
GEARS = {"published": published, "consistent": consistent, "antiphase": antiphase}
PLANES = [
    ("published", "f_e", FIRST),
    ("published", "b", FIRST),
    ("published", "alpha", FIRST),
    ("antiphase", "f_e", FIRST),
    ("antiphase", "f_pm", FIRST),
    ("consistent", "alpha", FIRST),
    ("published", "f_e", HIGHER),
    ("antiphase", "f_e", HIGHER),
    ("consistent", "alpha", HIGHER),
]
planes = pytest.mark.parametrize(("gear", "axis", "balance"), PLANES, ids=lambda value: str(value))
# How far to step to either side, in units of lambda and of the plane's ranges.
_ASIDE = 1e-5


@functools.cache
def curves_of(gear, axis, balance, rows=16):
    starts = []
    for value in np.linspace(*RANGES[axis], rows):
        model = GEARS[gear](**{axis: value})
        if balance.truncated:
            curves = sweep_row(model, "omega", np.linspace(*OMEGA, 60), seeds=LinearSeeds()).curves
        else:
            problem, curve = branch(model, balance)
            curves = [with_bifurcations(balance, problem, curve, Continuation())]
        starts += row_events(curves, value, BIFURCATIONS)
    return boundary_curves(GEARS[gear](), "omega", axis, OMEGA, RANGES[axis], starts, balance=balance)


def equations(gear, axis, balance, y):
    """Balance (n,) at y = (u, x, p), and its derivatives (n, n + 2)."""
    n, step = balance.unknowns, 1e-6

    def at(p):
        problem = balance.problem(GEARS[gear](**{axis: p}), "omega", *OMEGA)
        residual, jacobian = np.empty(n), np.empty((n, n + 1))
        problem.residual_and_jacobian(
            problem.parameters, problem.parameter_slope, np.ascontiguousarray(y[:-1]), residual, jacobian
        )
        return residual, jacobian

    residual, jacobian = at(y[-1])
    along_p = (at(y[-1] + step)[0] - at(y[-1] - step)[0]) / (2.0 * step)
    return residual, np.column_stack([jacobian, along_p])


def beside(gear, axis, balance, y, along):
    """Two motions (u, x, p) next to y on the surface of motions, to either side of a curve with the direction `along`;
    with the sign of det dE/du of each."""
    scale = np.array([*[1.0] * balance.unknowns, np.ptp(OMEGA), np.ptp(RANGES[axis])])
    _, jacobian = equations(gear, axis, balance, y)
    surface = np.linalg.svd(jacobian * scale)[2][-2:]
    along = surface @ (along / scale)
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along) @ surface
    for sign in (1.0, -1.0):
        found = y + sign * _ASIDE * across * scale
        for _ in range(4):
            residual, jacobian = equations(gear, axis, balance, found)
            found = found - scale * np.linalg.lstsq(jacobian * scale, residual, rcond=None)[0]
        square = equations(gear, axis, balance, found)[1][:, : balance.unknowns]
        yield found, np.linalg.det(square) > 0.0


def places(curve, balance):
    """Places (u, x, p) of a curve away from its corners, and its directions there."""
    n, gap = balance.unknowns, int(curve.kind is Event.NEIMARK_SACKER)
    for stretch in curve.stretches:
        where = [0, 1, 2, 5 + gap, 6 + gap] if balance.truncated else [*range(n), n + gap, n + gap + 1]
        arclength = stretch.curve.arclength
        for fraction in np.linspace(0.08, 0.92, 7):
            i = np.argmin(np.abs(arclength - fraction * arclength[-1]))
            if min(arclength[i], arclength[-1] - arclength[i]) > 1e-2:
                yield stretch.curve.points[i, where], (stretch.curve.tangents[i] * stretch.problem.scale)[where]


@pytest.mark.costly
@planes
def test_exactly_one_side_has_the_critical_multipliers_outside(gear, axis, balance):
    looked = dict.fromkeys(BIFURCATIONS, 0)
    for curve in curves_of(gear, axis, balance):
        for y, along in places(curve, balance):
            outside, kinds = [], []
            for found, static in beside(gear, axis, balance, y, along):
                model, motion, omega = GEARS[gear](**{axis: found[-1]}), found[:-2], found[-2]
                multipliers = motion_multipliers(model, omega, motion)
                if curve.kind is Event.PERIOD_DOUBLING:
                    outside.append(np.sum((multipliers.imag == 0.0) & (multipliers.real < -1.0)))
                else:
                    outside.append(np.sum((multipliers.imag > 0.0) & (np.abs(multipliers) > 1.0)))
                stability = assess(model, "omega", [omega], motion[None], balance=balance, static=[static])
                kinds.append(Instability(stability.kind[0]))
            assert abs(outside[0] - outside[1]) == 1, (curve.kind.name, y)
            calm, critical = kinds if outside[0] < outside[1] else kinds[::-1]
            if calm is Instability.NONE:
                assert critical is Instability[curve.kind.name]
            looked[curve.kind] += 1
    assert sum(looked.values()) > 10


@planes
@pytest.mark.parametrize("share", [0.37, 0.7778])
def test_motions_of_a_row_change_only_where_it_crosses_a_curve(gear, axis, balance, share):
    """By multipliers alone, along the main branch of a row that gave no start; for antiphase that of f_e = 0.4."""
    low, high = RANGES[axis]
    value = low + share * (high - low)
    curves = curves_of(gear, axis, balance)
    crossed = [(curve.kind, point) for curve in curves for point in curve.crossings([value])[1]]
    model, fine = GEARS[gear](**{axis: value}), Continuation(largest_step=0.02, largest_angle=0.05)
    problem, coarse = branch(model, balance)
    curve = fine.trace_both_ways(problem, coarse.points[0], *OMEGA)
    shown, total = [0, *balance.fundamental, -1], 0
    multipliers = motion_multipliers(model, curve.points[:, -1], curve.points[:, :-1])
    minus, plus = (np.sign(np.prod(multipliers - at, axis=1).real) for at in (-1.0, 1.0))
    outside = np.sum(np.abs(multipliers) > 1.0, axis=1)
    for i in range(len(curve.points) - 1):
        here, there = curve.points[i : i + 2, shown]
        inside = dict.fromkeys(BIFURCATIONS, 0)
        for kind, point in crossed:
            step = there - here
            part = (point[:4] - here) @ step / (step @ step)
            if 0.0 <= part < 1.0 and np.linalg.norm(point[:4] - here - part * step) < 0.05 * np.linalg.norm(step):
                inside[kind] += 1
        total += sum(inside.values())
        assert (inside[Event.PERIOD_DOUBLING] % 2 == 1) == (minus[i] != minus[i + 1])
        if plus[i] == plus[i + 1] and not inside[Event.PERIOD_DOUBLING]:
            assert abs(outside[i + 1] - outside[i]) == 2 * (inside[Event.NEIMARK_SACKER] % 2)
    assert total > 0 or not crossed


@planes
def test_curves_end_for_a_reason(gear, axis, balance):
    for curve in curves_of(gear, axis, balance):
        for end, place in zip(curve.ends, (0, -1), strict=True):
            assert end.sentence
            if end.name == "RANGE_LEFT":
                assert curve.special[place] in (
                    SpecialPoint.BORDER,
                    SpecialPoint.RESONANCE_1_1,
                    SpecialPoint.RESONANCE_1_2,
                )
