"""Bifurcation curves of a balance over two parameters: equations, derivatives, rows, corners, special points."""

import functools

import numpy as np
import pytest

from solver import Continuation, EndReason, Event, ParameterError
from solver.boundaries import BIFURCATIONS, FOLDS_AND_GRAZINGS, SpecialPoint, boundary_curves, row_events
from solver.boundaries.problem import Plane
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
EVERYTHING = (*FOLDS_AND_GRAZINGS, *BIFURCATIONS)
OMEGA = (LOW, HIGH)
planes = pytest.mark.parametrize(("gear", "axis"), PLANES)
balances = pytest.mark.parametrize("balance", [FIRST, HIGHER], ids=["first", "higher"])


@functools.cache
def starts_of(gear, axis, balance, count=24):
    kinds = EVERYTHING if isinstance(balance, Galerkin) else BIFURCATIONS
    values = np.linspace(*RANGE, count)
    return [event for value in values for event in row_events([row_of(gear, axis, balance, value)], value, kinds)]


def row_of(gear, axis, balance, value):
    """The main branch of a row with its bifurcations."""
    model = GEARS[gear](**{axis: value})
    problem, curve = branch(model, balance)
    return with_bifurcations(balance, problem, curve, Continuation())


@functools.cache
def curves_of(gear, axis, balance):
    return boundary_curves(GEARS[gear](), "omega", axis, OMEGA, RANGE, starts_of(gear, axis, balance), balance=balance)


def shown(balance, point):
    return point[[0, *balance.fundamental, -2, -1]]


# The equations -------------------------------------------------------------------------------------------------------


@pytest.mark.costly
@balances
@planes
def test_points_solve_the_balance_and_their_own_condition(gear, axis, balance):
    for curve in curves_of(gear, axis, balance):
        assert np.all(np.diff(curve.arclength) >= 0.0)
        for stretch in curve.stretches:
            problem, n = stretch.problem, stretch.problem.unknowns
            residual, jacobian = np.empty(n), np.empty((n, n + 1))
            for y in stretch.curve.points[::7]:
                problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
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
        for kind, point in row_events([row_of(gear, axis, balance, value)], value, kinds):
            total += 1
            gaps = [np.max(np.abs(p - shown(balance, point))) for k, p in crossings[value] if k is kind]
            assert min(gaps, default=np.inf) < 1e-7, (kind, point[-2:])
    assert total > 0


def test_order_of_the_starts_does_not_matter():
    starts = starts_of("published", "f_e", HIGHER)
    shuffled = [starts[i] for i in np.random.default_rng(3).permutation(len(starts))]
    again = boundary_curves(published(), "omega", "f_e", OMEGA, RANGE, shuffled, balance=HIGHER)
    for first, second in zip(curves_of("published", "f_e", HIGHER), again, strict=True):
        assert first.kind is second.kind and first.ends == second.ends
        np.testing.assert_array_equal(first.points, second.points)


def test_the_neimark_sacker_of_antiphase_lies_where_physics_puts_it():
    """docs/physics.md, section 8: at Omega = 1.904 for f_e = 0.2."""
    curves = [c for c in curves_of("antiphase", "f_e", HIGHER) if c.kind is Event.NEIMARK_SACKER]
    places = np.concatenate([c.crossings([0.2])[1][:, 3] for c in curves])
    assert np.min(np.abs(places - 1.904)) < 3e-3


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
    curves = boundary_curves(published(), "omega", "f_e", OMEGA, RANGE, folds, balance=balance)
    ours = np.sort(np.concatenate([c.crossings([0.2])[1][:, 3] for c in curves]))
    problem, curve = branch(published(f_e=0.2), balance)
    theirs = np.sort(curve.points[curve.event == Event.FOLD][:, -1])
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-8)


# Corners and special points ------------------------------------------------------------------------------------------


def test_corners_join_what_stops_there():
    curves = curves_of("published", "f_e", HIGHER)
    assert any(len(curve.stretches) > 1 for curve in curves)
    for curve in curves:
        for before, after in zip(curve.stretches[:-1], curve.stretches[1:], strict=True):
            gap = np.abs(before.curve.points[-1] - after.curve.points[0]) / after.problem.scale
            assert np.max(gap) < 1e-4
        for end, place in zip(curve.ends, (0, -1), strict=True):
            if end is EndReason.RANGE_LEFT:
                assert curve.special[place] in (
                    SpecialPoint.BORDER,
                    SpecialPoint.RESONANCE_1_1,
                    SpecialPoint.RESONANCE_1_2,
                )


def test_grazings_of_motions_that_fold_are_marked():
    for curve in curves_of("published", "f_e", HIGHER):
        marked = np.flatnonzero(curve.special == SpecialPoint.FOLD_GRAZING)
        if curve.kind in (Event.MIN_AT_DRIVE, Event.MIN_AT_BACK):
            changes = np.flatnonzero(np.diff(curve.stable) != 0)
            assert all(np.min(np.abs(marked - i)) <= 1 for i in changes)


def test_wrong_input_is_refused():
    start = starts_of("published", "f_e", HIGHER)[0]
    with pytest.raises(ParameterError, match="of the kinds"):
        boundary_curves(published(), "omega", "f_e", OMEGA, RANGE, [(Event.BRANCH_POINT, np.zeros(5))])
    with pytest.raises(ParameterError, match=r"starts = .* 9\)"):
        boundary_curves(published(), "omega", "f_e", OMEGA, RANGE, [(start[0], start[1][:5])], balance=HIGHER)
    with pytest.raises(ParameterError, match="inside the plane"):
        boundary_curves(published(), "omega", "f_e", OMEGA, (0.0, 0.01), [start], balance=HIGHER)
    with pytest.raises(ParameterError, match="another parameter"):
        Plane(published(), "b", "b", (0.1, 0.2), (0.1, 0.2), omega=1.0)
    with pytest.raises(ParameterError, match="omega = None"):
        Plane(published(), "b", "alpha", (0.1, 0.2), (0.1, 0.2))


def test_a_start_that_leads_nowhere_is_a_curve_of_one_point():
    lost = np.array([1.0, *np.full(6, 0.3), 1.0, 0.2])
    starts = [(Event.PERIOD_DOUBLING, lost)]
    (curve,) = boundary_curves(published(), "omega", "f_e", OMEGA, RANGE, starts, balance=HIGHER)
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
        problem.residual_and_jacobian(
            problem.parameters, problem.parameter_slope, np.append(u, 1.1), residual, jacobian
        )
        above = residual.copy()
        u[0] += 1e-7
        problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, np.append(u, 1.1), above, jacobian)
        np.testing.assert_allclose(residual, above, rtol=0, atol=1e-5)


# What it shares with the first order ---------------------------------------------------------------------------------


def test_first_order_boundaries_are_not_changed_by_what_both_share():
    model = published()
    problem, curve = branch(model, FIRST)
    folds = [(Event.FOLD, np.append(y, 0.2)) for y in curve.points[curve.event == Event.FOLD]]
    for boundary in boundary_curves(model, "omega", "f_e", OMEGA, RANGE, folds):
        assert boundary.shown == (0, 1, 2, 5, 6)
        assert np.max(boundary.distances(boundary.points[::5])) < 1e-9
