"""Bifurcation curves of a balance over two parameters: equations, derivatives, rows, corners, special points."""

import functools

import numpy as np
import pytest

from solver import Continuation, EndReason, Event, ParameterError
from solver.boundaries import SpecialPoint, boundary_curves
from solver.boundaries.bifurcation_curves import bifurcation_curves, bifurcation_events
from solver.boundaries.bifurcation_plane import BifurcationPlane
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.galerkin import Galerkin
from solver.stability.bifurcations import with_bifurcations
from tests.conftest import antiphase, consistent, published
from tests.solver.stability.rows import HIGH, LOW, branch

COUPLING = 0.93969262
GEARS = {
    "published": published,
    "parametric": lambda **changes: consistent(
        **{"rotation_coupling": COUPLING, "variation_translation": 0.0, **changes}
    ),
    "antiphase": lambda **changes: antiphase(**{"rotation_coupling": COUPLING, **changes}),
}
RANGE = (0.05, 0.5)
PLANES = [("published", "f_e"), ("parametric", "alpha"), ("antiphase", "f_e")]
FIRST, HIGHER = DescribingFunction(), Galerkin(3)
BIFURCATIONS = (Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER)
EVERYTHING = (Event.FOLD, Event.MIN_AT_DRIVE, Event.MIN_AT_BACK, Event.MAX_AT_DRIVE, Event.MAX_AT_BACK, *BIFURCATIONS)
OMEGA = (LOW, HIGH)
planes = pytest.mark.parametrize(("gear", "axis"), PLANES)
balances = pytest.mark.parametrize("balance", [FIRST, HIGHER], ids=["first", "higher"])


@functools.cache
def starts_of(gear, axis, balance, count=24):
    kinds = EVERYTHING if isinstance(balance, Galerkin) else BIFURCATIONS
    found = []
    for value in np.linspace(*RANGE, count):
        problem, curve = branch(GEARS[gear](**{axis: value}), balance)
        found += bifurcation_events([with_bifurcations(balance, problem, curve, Continuation())], value, kinds)
    return found


@functools.cache
def curves_of(gear, axis, balance):
    return bifurcation_curves(balance, GEARS[gear](), "omega", axis, OMEGA, RANGE, starts_of(gear, axis, balance))


def shown(balance, point):
    return point[[0, *balance.fundamental, -2, -1]]


# The equations -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", EVERYTHING)
@pytest.mark.parametrize(
    ("x_axis", "p_axis"),
    [
        ("omega", "b"),
        ("alpha", "alpha_phase"),
        ("kappa", "xi_support"),
        ("rotation_coupling", "omega"),
        ("pressure_angle", "variation_rotation"),
        ("f_e", "omega"),
        ("k_support", "translation_coupling"),
    ],
)
@pytest.mark.parametrize("balance", [FIRST, HIGHER, Galerkin(2, 2)], ids=["first", "higher", "doubled"])
def test_derivatives_are_those_of_differences(balance, x_axis, p_axis, kind):
    if kind not in BIFURCATIONS and not isinstance(balance, Galerkin):
        return
    model = consistent(alpha_phase=0.3, f_pv=0.1, alpha_harmonics=((0.1, 0.4),), pressure_angle=21.0)
    places = {
        "omega": 1.1,
        "rotation_coupling": 0.9,
        "translation_coupling": 0.8,
        "kappa": 0.4,
        "xi_support": 0.03,
        "k_support": 0.9,
    }
    where = [places.get(axis) or getattr(model, axis) for axis in (x_axis, p_axis)]
    plane = BifurcationPlane(balance, model, x_axis, p_axis, *((w - 0.3, w + 0.4) for w in where), omega=1.1)
    rng = np.random.default_rng(5)
    for share in (0.1, 0.4) if kind is Event.NEIMARK_SACKER else (0.0,):
        (window,) = plane.windows(kind, share)
        problem = plane.problem(kind, window)
        for _ in range(8):
            u = rng.normal(size=balance.unknowns) / (1.0 + np.arange(balance.unknowns) // 2)
            extra = [share] if kind is Event.NEIMARK_SACKER else []
            y = np.concatenate([u, extra, where])
            n = problem.unknowns
            residual, other, jacobian, scratch = np.empty(n), np.empty(n), np.empty((n, n + 1)), np.empty((n, n + 1))
            problem.balance(problem.theta, problem.direction, y, residual, jacobian)
            differences = np.empty((n, n + 1))
            for j in range(n + 1):
                step = np.eye(n + 1)[j] * 1e-6
                problem.balance(problem.theta, problem.direction, y + step, residual, scratch)
                problem.balance(problem.theta, problem.direction, y - step, other, scratch)
                differences[:, j] = (residual - other) / 2e-6
            size = 1.0 + np.max(np.abs(jacobian), axis=1, keepdims=True)
            # Next to a grazing differences are worse than what they are compared with.
            assert np.quantile(np.abs(jacobian - differences) / size, 0.98) < 1e-6
            assert np.max(np.abs(jacobian - differences) / size) < 1e-3


@balances
@planes
def test_points_solve_the_balance_and_their_own_condition(gear, axis, balance):
    for curve in curves_of(gear, axis, balance):
        assert np.all(np.diff(curve.arclength) >= 0.0)
        for piece in curve.pieces:
            problem, n = piece.problem, piece.problem.unknowns
            residual, jacobian = np.empty(n), np.empty((n, n + 1))
            for y in piece.curve.points[::7]:
                problem.balance(problem.theta, problem.direction, y, residual, jacobian)
                # Next to a grazing a determinant varies with the root of a margin that rounding leaves at 1e-16.
                steepness = np.linalg.norm(jacobian * problem.scale, axis=1)
                assert np.max(np.abs(residual) / (1.0 + steepness)) < 1e-7 * max(1.0, np.max(np.abs(y)))


# Rows ----------------------------------------------------------------------------------------------------------------


@balances
@planes
def test_every_start_lies_on_exactly_one_curve(gear, axis, balance):
    curves = curves_of(gear, axis, balance)
    for kind, point in starts_of(gear, axis, balance):
        near = [c.distances(shown(balance, point)[None])[0] < 1e-6 for c in curves if c.kind is kind]
        assert sum(near) == 1, (kind, point[-2:])


@balances
@planes
def test_rows_that_nobody_started_from_meet_the_curves(gear, axis, balance):
    kinds = EVERYTHING if isinstance(balance, Galerkin) else BIFURCATIONS
    curves = curves_of(gear, axis, balance)
    values = [0.17, 0.3141, 0.4567]
    crossings = {value: [(c.kind, p) for c in curves for p in c.crossings([value])[1]] for value in values}
    total = 0
    for value in values:
        problem, curve = branch(GEARS[gear](**{axis: value}), balance)
        row = with_bifurcations(balance, problem, curve, Continuation())
        for kind, point in bifurcation_events([row], value, kinds):
            total += 1
            gaps = [np.max(np.abs(p - shown(balance, point))) for k, p in crossings[value] if k is kind]
            assert min(gaps, default=np.inf) < 1e-7, (kind, point[-2:])
    assert total > 0


def test_order_of_the_starts_does_not_matter():
    starts = starts_of("published", "f_e", HIGHER)
    shuffled = [starts[i] for i in np.random.default_rng(3).permutation(len(starts))]
    again = bifurcation_curves(HIGHER, published(), "omega", "f_e", OMEGA, RANGE, shuffled)
    for first, second in zip(curves_of("published", "f_e", HIGHER), again, strict=True):
        assert first.kind is second.kind and first.ends == second.ends
        np.testing.assert_array_equal(first.points, second.points)


def test_the_neimark_sacker_of_antiphase_lies_where_physics_puts_it():
    """docs/physics.md, section 8: at Omega = 1.904 for f_e = 0.2."""
    curves = [c for c in curves_of("antiphase", "f_e", HIGHER) if c.kind is Event.NEIMARK_SACKER]
    places = np.concatenate([c.crossings([0.2])[1][:, 3] for c in curves])
    assert np.min(np.abs(places - 1.904)) < 2e-3


def test_the_period_doublings_of_parametric_resonance_form_one_tongue():
    curves = [c for c in curves_of("parametric", "alpha", HIGHER) if c.kind is Event.PERIOD_DOUBLING]
    (tongue,) = [c for c in curves if np.all(c.x > 1.0)]
    assert set(tongue.ends) == {EndReason.RANGE_LEFT}
    assert np.sum(tongue.special == SpecialPoint.EXTREMUM) == 1
    np.testing.assert_allclose(np.sort(tongue.crossings([0.2])[1][:, 3]), [1.17547, 1.246548], atol=1e-5)


def test_fold_curves_cross_a_row_where_it_folds():
    balance = Galerkin(1)
    starts = starts_of("published", "f_e", balance)
    folds = [s for s in starts if s[0] is Event.FOLD]
    curves = bifurcation_curves(balance, published(), "omega", "f_e", OMEGA, RANGE, folds)
    ours = np.sort(np.concatenate([c.crossings([0.2])[1][:, 3] for c in curves]))
    problem, curve = branch(published(f_e=0.2), balance)
    theirs = np.sort(curve.points[curve.event == Event.FOLD][:, -1])
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-8)


# Corners and special points ------------------------------------------------------------------------------------------


def test_corners_join_what_stops_there():
    curves = curves_of("published", "f_e", HIGHER)
    assert any(len(curve.pieces) > 1 for curve in curves)
    for curve in curves:
        for before, after in zip(curve.pieces[:-1], curve.pieces[1:], strict=True):
            gap = np.abs(before.curve.points[-1] - after.curve.points[0]) / after.problem.scale
            assert np.max(gap) < 1e-4
        for end, place in zip(curve.ends, (0, -1), strict=True):
            if end is EndReason.RANGE_LEFT:
                assert curve.special[place] in (SpecialPoint.BORDER, SpecialPoint.RESONANCE)


def test_grazings_of_motions_that_fold_are_marked():
    for curve in curves_of("published", "f_e", HIGHER):
        marked = np.flatnonzero(curve.special == SpecialPoint.FOLD_GRAZING)
        if curve.kind in (Event.MIN_AT_DRIVE, Event.MIN_AT_BACK):
            changes = np.flatnonzero(np.diff(curve.stable) != 0)
            assert all(np.min(np.abs(marked - i)) <= 1 for i in changes)


def test_refinement_is_solved_not_interpolated():
    doublings = [c for c in curves_of("parametric", "alpha", HIGHER) if c.kind is Event.PERIOD_DOUBLING]
    curve = next(c for c in doublings if c.x[0] > 1.0)
    fine = curve.refined(0.002, 0.002)
    assert len(fine) > 2 * len(curve.points)
    assert np.max(curve.distances(fine[::20])) < 1e-9


def test_wrong_input_is_refused():
    start = starts_of("published", "f_e", HIGHER)[0]
    with pytest.raises(ParameterError, match="of the kinds"):
        bifurcation_curves(FIRST, published(), "omega", "f_e", OMEGA, RANGE, [(Event.FOLD, np.zeros(5))])
    with pytest.raises(ParameterError, match="9 numbers"):
        bifurcation_curves(HIGHER, published(), "omega", "f_e", OMEGA, RANGE, [(start[0], start[1][:5])])
    with pytest.raises(ParameterError, match="inside the plane"):
        bifurcation_curves(HIGHER, published(), "omega", "f_e", OMEGA, (0.0, 0.01), [start])
    with pytest.raises(ParameterError, match="another parameter"):
        BifurcationPlane(HIGHER, published(), "b", "b", (0.1, 0.2), (0.1, 0.2), omega=1.0)
    with pytest.raises(ParameterError, match="as no axis is the frequency"):
        BifurcationPlane(HIGHER, published(), "b", "alpha", (0.1, 0.2), (0.1, 0.2))


def test_a_start_that_leads_nowhere_is_a_curve_of_one_point():
    lost = np.array([1.0, *np.full(6, 0.3), 1.0, 0.2])
    (curve,) = bifurcation_curves(HIGHER, published(), "omega", "f_e", OMEGA, RANGE, [(Event.PERIOD_DOUBLING, lost)])
    assert len(curve.points) == 1 and curve.ends == (EndReason.STEP_TOO_SMALL,) * 2


@pytest.mark.parametrize("order", [1, 2, 5])
def test_a_motion_that_just_touches_a_flank_keeps_its_contact(order):
    """Rounding may see lambda at the flank on one side of the touching angle only; the contact is not lost for that."""
    rng = np.random.default_rng(order)
    balance = Galerkin(order)
    problem = balance.problem(published(b=1.0), "omega", LOW, HIGH)
    for _ in range(200):
        u = rng.normal(size=balance.unknowns) / (1.0 + np.arange(balance.unknowns) // 2)
        for _ in range(3):
            low, _ = balance.extremes(u[None])
            u[0] += 1.0 - low[0]
        residual, jacobian = np.empty(u.size), np.empty((u.size, u.size + 1))
        problem.balance(problem.theta, problem.direction, np.append(u, 1.1), residual, jacobian)
        above = residual.copy()
        u[0] += 1e-7
        problem.balance(problem.theta, problem.direction, np.append(u, 1.1), above, jacobian)
        np.testing.assert_allclose(residual, above, rtol=0, atol=1e-5)


# What it shares with the first order ---------------------------------------------------------------------------------


def test_first_order_boundaries_are_not_changed_by_what_both_share():
    model = published()
    problem, curve = branch(model, FIRST)
    folds = [(Event.FOLD, np.append(y, 0.2)) for y in curve.points[curve.event == Event.FOLD]]
    for boundary in boundary_curves(model, "omega", "f_e", OMEGA, RANGE, folds):
        assert boundary.seen == (0, 1, 2, 5, 6)
        assert np.max(boundary.distances(boundary.points[::5])) < 1e-9
