"""Boundaries as curves: their equations, completeness against row sweeps, special points and merging."""

import functools

import numpy as np
import pytest
from scipy.optimize import root

from solver import Continuation, EndReason, Event, LinearSeeds, ParameterError, first_order_problem, sweep_row
from solver.boundaries import SpecialPoint, boundary_curves, missed_events, row_events
from solver.boundaries.plane import Plane
from solver.harmonic.first_order import evaluate
from tests.conftest import MODELS, consistent, published

OMEGA = (0.05, 2.0)
GRID = np.linspace(*OMEGA, 100)
RANGES = {"b": (0.02, 1.5), "alpha": (0.0, 0.8), "f_e": (0.0, 0.5), "f_pm": (0.3, 1.2)}
ROWS = 81
GEARS = {**MODELS, "isola": lambda **changes: consistent(**{"rotation_coupling": np.cos(np.radians(20.0)), **changes})}
PLANES = [(gear, axis) for gear in GEARS for axis in RANGES]
published_planes = pytest.mark.parametrize("axis", list(RANGES))
all_planes = pytest.mark.parametrize(("gear", "axis"), PLANES)


def sweep(gear, axis, value):
    return sweep_row(GEARS[gear](**{axis: value}), "omega", GRID, seeds=LinearSeeds())


@functools.cache
def starts_of(gear, axis):
    """Rows' parameters and all their events."""
    values = np.linspace(*RANGES[axis], ROWS)
    return values, [event for value in values for event in row_events(sweep(gear, axis, value), value)]


@functools.cache
def curves_of(gear, axis):
    return boundary_curves(GEARS[gear](), "omega", axis, OMEGA, RANGES[axis], starts_of(gear, axis)[1])


def specials(curves, code):
    """Points of one code on several curves, (n, 5)."""
    return np.concatenate([np.empty((0, 5)), *(curve.points[curve.special == code] for curve in curves)])


def folds(gear, axis):
    return [curve for curve in curves_of(gear, axis) if curve.kind is Event.FOLD]


def distance(events, kind, point):
    """Distance from a point to the nearest of some (kind, point) pairs of the same kind, inf without one."""
    return min((np.max(np.abs(other - point)) for k, other in events if k == kind), default=np.inf)


# The equations -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("axis", "low", "high"),
    [
        ("b", 0.1, 1.5), ("alpha", 0.0, 0.8), ("alpha_phase", 0.0, 3.0), ("f_e", 0.0, 0.5), ("f_pm", 0.3, 1.2),
        ("kappa", 0.3, 0.6), ("rotation_coupling", 0.5, 1.0), ("pressure_angle", 10.0, 30.0), ("xi_support", 0.005, 0.05),
    ],
)  # fmt: skip
def test_contact_angles_are_the_balance_and_have_its_derivatives(axis, low, high):
    """E and det dE/du against the balance on (lambda_m, lambda_c, lambda_s); all derivatives against differences."""
    model = consistent(alpha_phase=0.3, f_pv=0.1, alpha_harmonics=((0.1, 0.4),))
    plane = Plane(model, "omega", axis, OMEGA, (low, high))
    rng = np.random.default_rng(5)
    seen = set()
    for _ in range(80):
        point = np.concatenate([rng.uniform(-1.8, 1.8, 3), [rng.uniform(0.3, 2.0), rng.uniform(low, high)]])
        (zones,) = plane.zones(Event.FOLD, point)
        seen.add(zones)
        problem, y = plane.problem(Event.FOLD, zones), plane.lift(Event.FOLD, zones, point)
        residual, jacobian = np.empty(6), np.empty((6, 7))
        problem.balance(problem.theta, problem.direction, y, residual, jacobian)
        force, square = evaluate(model.replace(**{axis: point[4]}), point[3], point[:3])
        np.testing.assert_allclose(residual, [*force, 0.0, 0.0, np.linalg.det(square)], rtol=1e-11, atol=1e-12)
        differences, other, scratch = np.empty((6, 7)), np.empty(6), np.empty((6, 7))
        for j in range(7):
            step = np.eye(7)[j] * 1e-6
            problem.balance(problem.theta, problem.direction, y + step, residual, scratch)
            problem.balance(problem.theta, problem.direction, y - step, other, scratch)
            differences[:, j] = (residual - other) / 2e-6
        np.testing.assert_allclose(jacobian, differences, rtol=0, atol=1e-7 * (1.0 + np.max(np.abs(jacobian))))
    assert len(seen) >= 5


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


@all_planes
def test_slices_are_the_events_of_rows_that_nobody_started_from(gear, axis):
    curves = curves_of(gear, axis)
    births = specials(curves, SpecialPoint.ISOLA)[:, 4]
    rng = np.random.default_rng(11)
    for value in np.sort(rng.uniform(*RANGES[axis], 12)):
        events = row_events(sweep(gear, axis, value), value)
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
    events = [(kind, point[3]) for kind, point in row_events(row, 0.02)]
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
    ("axis", "counts"),
    [("b", (4, 4, 2)), ("alpha", (5, 4, 2)), ("f_e", (3, 3, 1)), ("f_pm", (3, 3, 1))],
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


# Special points ------------------------------------------------------------------------------------------------------


def cusp_equations(gear, axis, unknowns, **others):
    """E, det dE/du and its derivative along the null vector, all from the plain balance by central differences."""
    model, omega, u = GEARS[gear](**{axis: unknowns[4], **others}), unknowns[3], np.asarray(unknowns[:3])
    residual, square = evaluate(model, omega, u)
    v = np.linalg.svd(square)[2][-1]
    v *= np.sign(v[np.argmax(np.abs(v))])
    ahead, behind = (np.linalg.det(evaluate(model, omega, u + h * v)[1]) for h in (1e-5, -1e-5))
    return np.array([*residual, np.linalg.det(square), (ahead - behind) / 2e-5])


@all_planes
def test_cusps_solve_the_cusp_equations(gear, axis):
    corners = specials(folds(gear, axis), SpecialPoint.FOLD_GRAZING)
    for point in specials(folds(gear, axis), SpecialPoint.CUSP):
        if len(corners) and np.min(np.max(np.abs(corners - point), axis=1)) < 1e-9:
            continue
        start = point * (1.0 + 1e-4 * np.array([1.0, -1.0, 1.0, 0.1, -0.1]))
        result = root(lambda unknowns: cusp_equations(gear, axis, unknowns), start, tol=1e-12)
        np.testing.assert_allclose(result.x[3:], point[3:], rtol=0, atol=1e-7)


@pytest.mark.parametrize(("axis", "value"), [("alpha", 0.278), ("f_pm", 0.5855)])
def test_shaft_jumps_end_in_a_cusp(axis, value):
    """PHYSICS section 7: at alpha = 0.278 and f_pm = 0.5855."""
    cusps = specials(folds("published", axis), SpecialPoint.CUSP)
    shaft = cusps[(np.abs(cusps[:, 3] - 1.2444) < 1e-3)]
    assert np.min(np.abs(shaft[:, 4] - value)) < 5e-4


@pytest.mark.parametrize(("axis", "value"), [("alpha", 0.388), ("f_pm", 0.714), ("f_e", 0.140)])
def test_contact_loss_ends_at_an_extremum(axis, value):
    """PHYSICS section 7: the shaft resonance loses contact up to alpha = 0.388, f_pm = 0.714, and from f_e = 0.140."""
    curves = [curve for curve in curves_of("published", axis) if curve.kind is Event.MIN_AT_DRIVE]
    found = specials(curves, SpecialPoint.EXTREMUM)
    shaft = found[np.abs(found[:, 3] - 1.28) < 0.01]
    assert len(shaft) == 1
    assert shaft[0, 4] == pytest.approx(value, abs=5e-4)


@all_planes
def test_fold_grazings_lie_on_both_curves(gear, axis):
    """On the fold curve they are its corners, on the grazing curve the zeros of det dE/du: two independent ways."""
    curves = curves_of(gear, axis)
    corners = specials(folds(gear, axis), SpecialPoint.FOLD_GRAZING)
    grazings = specials([c for c in curves if c.kind is not Event.FOLD], SpecialPoint.FOLD_GRAZING)
    assert len(corners) == len(grazings)
    for point in corners:
        assert np.min(np.max(np.abs(grazings - point), axis=1)) < 1e-8


@published_planes
def test_corners_are_passed(axis):
    """A fold whose motion touches the back flank goes on beyond, and single- and double-sided folds are one curve."""
    bent = [curve for curve in folds("published", axis) if np.any(curve.special == SpecialPoint.FOLD_GRAZING)]
    assert bent
    for curve in bent:
        b = curve.parameter if axis == "b" else 1.0
        margin = curve.mean - curve.amplitude + b
        for i in np.flatnonzero(curve.special == SpecialPoint.FOLD_GRAZING):
            assert abs(margin[i]) < 1e-10
            np.testing.assert_allclose(curve.points[i], curve.points[i + 1], rtol=0, atol=1e-13)
            assert margin[i - 1] * margin[i + 2] < 0.0
        # In the plane the curve stays tangent: it goes straight on or, at a cusp, straight back.
        corners = np.flatnonzero(curve.special == SpecialPoint.FOLD_GRAZING)
        for before, after, code in zip(
            curve.slopes[corners, 3:], curve.slopes[corners + 1, 3:], curve.special[corners + 1], strict=True
        ):
            cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
            assert cosine == pytest.approx(-1.0 if code == SpecialPoint.CUSP else 1.0, abs=1e-6)


def row_curve(gear, axis, point):
    """The branch of one row through a fold: it leaves along the null vector of dE/du."""
    model = GEARS[gear](**{axis: point[4]})
    problem = first_order_problem(model, "omega", *OMEGA)
    null = np.linalg.svd(evaluate(model, point[3], point[:3])[1])[2][-1]
    return Continuation().trace_both_ways(problem, point[:4], *OMEGA, heading=np.append(null, 0.0))


@pytest.mark.parametrize("gear", ["published", "isola", "consistent"])
def test_isolas_shrink_to_points(gear):
    """Next to an ISOLA the branch through the fold is closed, and its size falls with the root of the distance."""
    found = 0
    for curve in folds(gear, "alpha"):
        for i in np.flatnonzero(curve.special == SpecialPoint.ISOLA):
            inside = np.sign(curve.parameter[i + 1] - curve.parameter[i])
            sizes = []
            for gap in (1e-7, 4e-7):
                level = curve.parameter[i] + inside * gap
                points = curve.crossings([level])[1]
                nearest = points[np.argmin(np.abs(points[:, 3] - curve.x[i]))]
                branch = row_curve(gear, "alpha", nearest)
                assert branch.closed
                sizes.append(np.ptp(branch.points[:, 3]))
            assert sizes[0] < 0.02
            assert sizes[1] / sizes[0] == pytest.approx(2.0, abs=0.3)
            found += 1
    assert found >= 1


@pytest.mark.parametrize("gear", ["published", "isola", "consistent"])
def test_mergers_reconnect_branches(gear):
    """On one side of a MERGER some branch is closed that on the other side is not."""
    points = specials(folds(gear, "alpha"), SpecialPoint.MERGER)
    assert len(points)
    for point in points:
        kinds = []
        for level in (point[4] - 2e-4, point[4] + 2e-4):
            near = [
                other
                for curve in folds(gear, "alpha")
                for other in curve.crossings([level])[1]
                if np.max(np.abs(other[:4] - point[:4])) < 0.5
            ]
            kinds.append({row_curve(gear, "alpha", other).closed for other in near})
        assert True in kinds[0] and True not in kinds[1]


def test_isola_of_the_consistent_gear():
    """PHYSICS section 7, c = cos 20 deg: born between alpha 0.40 and 0.41, joined between 0.45 and 0.46; its folds."""
    curves = folds("isola", "alpha")

    def mesh(points):
        return points[points[:, 3] < 0.7]

    (birth,) = mesh(specials(curves, SpecialPoint.ISOLA))
    (merger,) = mesh(specials(curves, SpecialPoint.MERGER))
    assert 0.40 < birth[4] < 0.41 and 0.45 < merger[4] < 0.46
    at = mesh(np.concatenate([curve.crossings([0.44])[1] for curve in curves]))
    found = sorted((point[3], point[0], np.hypot(point[1], point[2])) for point in at)
    # PHYSICS prints 2.122699 for the first amplitude. Solving E = 0, det dE/du = 0 with f_0 and f_1 by quadrature and the
    # receptances written out (nothing of this package) gives 2.122987 from either start, and the other three as printed.
    expected = [
        (0.511643, 1.084987, 2.122987), (0.513399, 0.826381, 1.879884),
        (0.521717, 0.921135, 2.289807), (0.580161, 1.548228, 0.955863),
    ]  # fmt: skip
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)


def test_a_merger_and_a_cusp_close_together_are_both_found():
    """Where the isola joins, the fold curve turns at a MERGER and again at a CUSP 3e-6 of omega away."""
    (curve,) = [c for c in folds("isola", "alpha") if np.any(np.abs(c.x[c.special > 0] - 0.592) < 1e-3)]
    codes = curve.special[(curve.special > 0) & (np.abs(curve.x - 0.592) < 1e-3)]
    assert sorted(codes) == [SpecialPoint.CUSP, SpecialPoint.MERGER]


def test_closed_fold_curve_between_two_cusps():
    (curve,) = [curve for curve in folds("published", "b") if curve.closed]
    assert curve.ends == (EndReason.CLOSED, EndReason.CLOSED)
    np.testing.assert_array_equal(curve.points[0], curve.points[-1])
    assert sorted(curve.special[curve.special > 0]) == [SpecialPoint.CUSP, SpecialPoint.CUSP]


def test_names_have_sentences():
    assert all(point.sentence for point in SpecialPoint)


# What others ask of the curves ---------------------------------------------------------------------------------------


def test_refined_points_are_exact_and_dense():
    window = (0.55, 0.57, 0.15, 0.25)
    for curve in curves_of("published", "alpha"):
        points = curve.refined(1e-3, 1e-3, window)
        inside = (points[:, 3] > 0.55) & (points[:, 3] < 0.57) & (points[:, 4] > 0.15) & (points[:, 4] < 0.25)
        both = inside[1:] & inside[:-1]
        assert np.all(np.max(np.abs(np.diff(points[:, 3:], axis=0)), axis=1)[both] < 1.2e-3)
        for point in points[inside][::7]:
            residual, square = evaluate(published(alpha=point[4]), point[3], point[:3])
            assert np.max(np.abs(residual)) < 1e-11
            if curve.kind is Event.FOLD:
                singular = np.linalg.svd(square, compute_uv=False)
                assert singular[2] < 1e-7 * singular[0]
            else:
                touch = 1.0 if curve.kind is Event.MIN_AT_DRIVE else -1.0
                assert abs(point[0] - np.hypot(point[1], point[2]) - touch) < 1e-12


def test_missed_events_lead_to_isolas():
    """Rows that no sweep starts an isola in are told where it is; every one of them starts a closed branch."""
    values, starts = starts_of("consistent", "alpha")
    missed = missed_events(curves_of("consistent", "alpha"), starts, values)
    birth, merger = (
        specials(folds("consistent", "alpha"), code)[:, 4] for code in (SpecialPoint.ISOLA, SpecialPoint.MERGER)
    )
    rows = sorted({point[4] for _, point in missed if point[4] < 0.6})
    mesh = values[(values > np.min(birth)) & (values < np.max(merger))]
    np.testing.assert_array_equal(rows, mesh)
    for kind, point in missed:
        if kind is Event.FOLD and point[4] < 0.6:
            assert row_curve("consistent", "alpha", point).closed
    assert missed_events(curves_of("published", "f_e"), *starts_of("published", "f_e")[::-1]) == []


def test_lengths_scale_with_the_backlash():
    """The balance is homogeneous in (b, f_pm, f_pv, f_e), so that the curves in (omega, alpha) are the same ones."""
    _, starts = starts_of("published", "alpha")
    factor = 37.0
    scaled = [(kind, point * [factor, factor, factor, 1.0, 1.0]) for kind, point in starts]
    model = published(b=factor, f_pm=0.5 * factor, f_e=0.2 * factor)
    again = boundary_curves(
        model, "omega", "alpha", OMEGA, RANGES["alpha"], scaled, continuation=Continuation(amplitude_max=100.0 * factor)
    )
    for first, second in zip(curves_of("published", "alpha"), again, strict=True):
        np.testing.assert_array_equal(first.special[first.special > 0], second.special[second.special > 0])
        np.testing.assert_allclose(
            first.points[first.special > 0, 3:], second.points[second.special > 0, 3:], rtol=0, atol=1e-9
        )


def test_any_two_parameters_span_a_plane():
    """Backlash over stiffness variation at a fixed frequency: neither axis is the frequency."""
    values, grid = np.linspace(0.05, 0.6, 12), np.linspace(0.02, 1.5, 60)
    starts = [
        event
        for value in values
        for event in row_events(sweep_row(published(alpha=value), "b", grid, omega=0.65), value)
    ]
    curves = boundary_curves(published(), "b", "alpha", (0.02, 1.5), (0.05, 0.6), starts, omega=0.65)
    assert [curve.kind for curve in curves] == [Event.FOLD, Event.MIN_AT_BACK]
    assert list(curves[0].special[curves[0].special > 0]) == [
        SpecialPoint.BORDER, SpecialPoint.CUSP, SpecialPoint.BORDER
    ]  # fmt: skip
    for value in (0.2222, 0.3333, 0.5555):
        events = row_events(sweep_row(published(alpha=value), "b", grid, omega=0.65), value)
        crossings = [(curve.kind, point) for curve in curves for point in curve.crossings([value])[1]]
        assert len(crossings) == len(events)
        assert all(distance(crossings, kind, point) < 1e-8 for kind, point in events)
    # The cusp lies in the plane of omega and b at its alpha, too.
    cusp = curves[0].points[curves[0].special == SpecialPoint.CUSP][0]
    assert np.max(np.abs(cusp_equations("published", "alpha", [*cusp[:3], 0.65, cusp[4]], b=cusp[3]))) < 1e-6


def test_both_flanks_touch_without_load():
    """At f_pm = 0 the motion touches both flanks, loses contact and the mean is open: the grazings end there."""
    model = published(f_pv=0.1)
    values = np.linspace(-0.41, 0.6, 24)
    starts = [event for v in values for event in row_events(sweep_row(model.replace(f_pm=v), "omega", GRID), v)]
    curves = boundary_curves(model, "omega", "f_pm", OMEGA, (-0.41, 0.6), starts)
    assert {curve.kind for curve in curves} >= {Event.MIN_AT_DRIVE, Event.MIN_AT_BACK, Event.MAX_AT_DRIVE}
    ended = specials(curves, SpecialPoint.DOUBLE_GRAZING)
    assert len(ended) > 0
    np.testing.assert_allclose(ended[:, 4], 0.0, atol=1e-9)
    np.testing.assert_allclose(ended[:, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.hypot(ended[:, 1], ended[:, 2]), 1.0, atol=1e-9)


def test_a_start_off_every_boundary_is_kept_as_a_point():
    start = np.array([1.5, 0.5, 0.2, 0.9, 0.4])
    (curve,) = boundary_curves(published(), "omega", "alpha", OMEGA, RANGES["alpha"], [(Event.FOLD, start)])
    assert curve.ends == (EndReason.STEP_TOO_SMALL, EndReason.STEP_TOO_SMALL)
    np.testing.assert_array_equal(curve.points, start[None])
    assert not curve.closed and len(curve.crossings([0.4])[0]) == 0 and len(curve.refined(0.1, 0.1)) == 1


def test_no_starts_no_boundaries():
    assert boundary_curves(published(), "omega", "alpha", OMEGA, RANGES["alpha"], []) == ()


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"p_axis": "omega"}, "p_axis"),
        ({"p_axis": "mass"}, "p_axis"),
        ({"x_range": (1.0, 1.0)}, "x_range"),
        ({"p_range": (0.0, np.inf)}, "p_range"),
        ({"x_axis": "b"}, "omega"),
        ({"starts": [(Event.FOLD, np.array([1.0, 0.0, 0.0, 3.0, 0.4]))]}, "starts"),
        ({"starts": [(Event.FOLD, np.array([np.nan, 0.0, 0.0, 1.0, 0.4]))]}, "starts"),
        ({"starts": [(Event.FOLD, np.zeros(4))]}, "starts"),
        ({"starts": [(Event.BRANCH_POINT, np.array([1.0, 0.0, 0.0, 1.0, 0.4]))]}, "starts"),
    ],
)
def test_what_is_not_allowed_is_named(changes, name):
    values = dict(x_axis="omega", p_axis="alpha", x_range=OMEGA, p_range=RANGES["alpha"], starts=[])
    with pytest.raises(ParameterError) as caught:
        boundary_curves(published(), **{**values, **changes})
    assert caught.value.name == name


# The generalised kernel ----------------------------------------------------------------------------------------------


def test_a_curve_ends_where_any_component_leaves_its_box():
    model = published()
    problem = first_order_problem(model, "omega", *OMEGA)
    start = sweep("published", "alpha", 0.2).curves[0].points[0]
    low, high = np.array([-np.inf, -np.inf, -np.inf, 0.05]), np.array([np.inf, np.inf, np.inf, 2.0])
    free = Continuation().trace(problem, start, 0.05, 2.0)
    level = 0.5 * np.max(free.points[:, 1])
    high[1] = level
    curve = Continuation().trace(problem, start, low, high)
    assert curve.ends[1] is EndReason.RANGE_LEFT
    assert curve.points[-1, 1] == level and np.all(curve.points[:-1, 1] < level)
    # From that border it heads out at once, or back in.
    outwards = Continuation().trace(problem, curve.points[-1], low, high, heading=curve.tangents[-1])
    assert len(outwards.points) == 1 and outwards.ends[1] is EndReason.RANGE_LEFT
    back = Continuation().trace(problem, curve.points[-1], low, high, heading=-curve.tangents[-1])
    np.testing.assert_allclose(back.points[-1], start, rtol=0, atol=1e-8)
