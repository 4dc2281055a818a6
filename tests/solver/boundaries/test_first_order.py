"""Boundaries as curves: their equations, completeness against row sweeps, and merging."""

import numpy as np
import pytest

from solver import EndReason, Event
from solver.boundaries import SpecialPoint, boundary_curves, row_events
from solver.boundaries.first_order import FirstOrderProblem
from solver.boundaries.problem import Plane
from solver.harmonic.describing_function import evaluate
from tests.conftest import consistent, published
from tests.solver.boundary_planes import (
    GEARS,
    OMEGA,
    RANGES,
    all_planes,
    curves_of,
    distance,
    folds,
    specials,
    starts_of,
    sweep,
)

# The equations -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("axis", "low", "high"),
    [
        ("b", 0.1, 1.5),
        ("alpha", 0.0, 0.8),
        ("alpha_phase", 0.0, 3.0),
        ("f_e", 0.0, 0.5),
        ("f_pm", 0.3, 1.2),
        ("kappa", 0.3, 0.6),
        ("rotation_coupling", 0.5, 1.0),
        ("pressure_angle", 10.0, 30.0),
        ("xi_support", 0.005, 0.05),
    ],
)
def test_contact_angles_are_the_balance_and_have_its_derivatives(axis, low, high):
    """E and det dE/du against the balance on (lambda_m, lambda_c, lambda_s); all derivatives against differences."""
    model = consistent(alpha_phase=0.3, f_pv=0.1, alpha_harmonics=((0.1, 0.4),))
    plane = FirstOrderProblem(Plane(model, "omega", axis, OMEGA, (low, high)))
    rng = np.random.default_rng(5)
    seen = set()
    for _ in range(80):
        point = np.concatenate([rng.uniform(-1.8, 1.8, 3), [rng.uniform(0.3, 2.0), rng.uniform(low, high)]])
        (zones,) = plane.zones(Event.FOLD, point)
        seen.add(zones)
        problem, y = plane.problem(Event.FOLD, zones), plane.lift(Event.FOLD, zones, point)
        residual, jacobian = np.empty(6), np.empty((6, 7))
        problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
        force, square = evaluate(model.replace(**{axis: point[4]}), point[3], point[:3])
        np.testing.assert_allclose(residual, [*force, 0.0, 0.0, np.linalg.det(square)], rtol=1e-11, atol=1e-12)
        differences, other, scratch = np.empty((6, 7)), np.empty(6), np.empty((6, 7))
        for j in range(7):
            step = np.eye(7)[j] * 1e-6
            problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y + step, residual, scratch)
            problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y - step, other, scratch)
            differences[:, j] = (residual - other) / 2e-6
        np.testing.assert_allclose(jacobian, differences, rtol=0, atol=1e-7 * (1.0 + np.max(np.abs(jacobian))))
    assert len(seen) >= 5


@pytest.mark.costly
@all_planes
def test_points_solve_the_balance_and_their_own_condition(gear, axis):
    margins = {
        Event.MIN_AT_DRIVE: lambda mean, amplitude, b: mean - amplitude - b,
        Event.MIN_AT_BACK: lambda mean, amplitude, b: mean - amplitude + b,
    }
    for curve in curves_of(gear, axis):
        assert np.all(np.diff(curve.arclength) >= 0.0)
        for point, stable, special in zip(curve.points, curve.stable, curve.special, strict=True):
            model = GEARS[gear](**{axis: point[4]})
            residual, square = evaluate(model, point[3], point[:3])
            size = max(1.0, np.hypot(point[1], point[2]))
            assert np.max(np.abs(residual)) < 1e-11 * size
            if curve.kind is Event.FOLD:
                singular = np.linalg.svd(square, compute_uv=False)
                # Next to a grazing the determinant varies with the root of a margin that rounding leaves at 1e-16.
                assert singular[2] < 1e-7 * singular[0]
                assert stable == 0
            else:
                assert abs(margins[curve.kind](point[0], np.hypot(point[1], point[2]), model.b)) < 1e-12 * size
                if special != SpecialPoint.FOLD_GRAZING:
                    assert stable == (np.linalg.det(square) > 0.0)


# Completeness --------------------------------------------------------------------------------------------------------


@pytest.mark.costly
@all_planes
def test_every_event_of_every_row_lies_on_a_curve(gear, axis):
    values, starts = starts_of(gear, axis)
    crossed = {}
    for curve in curves_of(gear, axis):
        for point in curve.crossings(values)[1]:
            crossed.setdefault(point[4], []).append((curve.kind, point))
    for kind, point in starts:
        size = max(1.0, np.hypot(point[1], point[2]))
        assert distance(crossed.get(point[4], []), kind, point) < 1e-7 * size


@pytest.mark.costly
@all_planes
def test_slices_are_the_events_of_rows_that_nobody_started_from(gear, axis):
    curves = curves_of(gear, axis)
    births = specials(curves, SpecialPoint.ISOLA)[:, 4]
    rng = np.random.default_rng(11)
    for value in np.sort(rng.uniform(*RANGES[axis], 12)):
        events = row_events(sweep(gear, axis, value).curves, value)
        crossings = [(curve, point) for curve in curves for point in curve.crossings([value])[1]]
        for kind, point in events:
            assert distance([(curve.kind, other) for curve, other in crossings], kind, point) < 1e-8
        for curve, point in crossings:
            if distance(events, curve.kind, point) >= 1e-8:
                # Only what a row cannot reach: an isola, or a branch that comes down from the amplitude ceiling.
                assert EndReason.AMPLITUDE_CEILING in curve.ends or value > np.min(births, initial=np.inf)


def test_rows_see_two_folds_around_a_grazing():
    """At b = 0.02 the branch folds twice within 3e-7 of omega, with the grazing of the back flank in between."""
    row = sweep("published", "b", 0.02)
    events = [(kind, point[3]) for kind, point in row_events(row.curves, 0.02)]
    near = sorted(omega for kind, omega in events if kind is Event.FOLD and abs(omega - 1.2297) < 1e-3)
    assert len(near) == 2 and near[1] - near[0] < 1e-6
    found = [
        point[3]
        for curve in folds("published", "b")
        for point in curve.crossings([0.02])[1]
        if abs(point[3] - 1.2297) < 1e-3
    ]
    np.testing.assert_allclose(sorted(found), near, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("axis", "counts"), [("b", (4, 4, 2)), ("alpha", (5, 4, 2)), ("f_e", (3, 3, 1)), ("f_pm", (3, 3, 1))]
)
def test_one_boundary_is_one_curve(axis, counts):
    """Numbers of folds, lambda_min = b and lambda_min = -b of the published planes, none of them on another."""
    curves = curves_of("published", axis)
    kinds = [curve.kind for curve in curves]
    assert tuple(kinds.count(kind) for kind in (Event.FOLD, Event.MIN_AT_DRIVE, Event.MIN_AT_BACK)) == counts
    assert kinds == sorted(kinds)
    for curve in curves:
        assert set(curve.ends) <= {EndReason.RANGE_LEFT, EndReason.CLOSED}
        middle = curve.points[[len(curve.points) // 2]]
        for other in curves:
            if other is not curve and other.kind is curve.kind:
                assert other.distances(middle)[0] > 1e-5


def test_which_points_are_met_is_what_their_distances_say():
    """Along a curve the true distance; places off it by so much, to all sides, and those of the other curves."""
    rng, curves = np.random.default_rng(2), curves_of("published", "f_e")
    for curve in curves[::2]:
        places = curve.points[rng.integers(0, len(curve.points), 60)]
        sizes = np.repeat([0.0, 1e-10, 1e-7, 1e-5, 1e-3, 0.1], 10)
        aside = rng.normal(size=(60, 5)) * (sizes[:, None] * curve.scale)
        points = np.concatenate([places + aside, *(other.points[::40] for other in curves)])
        far = curve.distances(points)
        clear = (far < 0.5e-6) | (far > 2e-6)
        np.testing.assert_array_equal(curve.meets(points)[clear], far[clear] < 1e-6)
        assert np.all(curve.meets(places)) and np.count_nonzero(far[clear] > 1e-6) > 20


def test_order_of_the_starts_does_not_matter():
    _, starts = starts_of("isola", "alpha")
    shuffled = [starts[i] for i in np.random.default_rng(3).permutation(len(starts))]
    again = boundary_curves(GEARS["isola"](), "omega", "alpha", OMEGA, RANGES["alpha"], shuffled)
    for first, second in zip(curves_of("isola", "alpha"), again, strict=True):
        assert first.kind is second.kind and first.ends == second.ends
        for name in ("points", "slopes", "arclength", "stable", "special"):
            np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_few_starts_give_the_same_boundaries():
    """One start per boundary, from its far end, leads to the same special points."""
    curves = curves_of("published", "alpha")
    starts = [(curve.kind, curve.points[-2]) for curve in curves]
    again = boundary_curves(published(), "omega", "alpha", OMEGA, RANGES["alpha"], starts)
    assert len(again) == len(curves)
    for first, second in zip(curves, again, strict=True):
        marked, others = first.special > 0, second.special > 0
        np.testing.assert_array_equal(first.special[marked], second.special[others])
        np.testing.assert_allclose(first.points[marked, 3:], second.points[others, 3:], rtol=0, atol=1e-9)
