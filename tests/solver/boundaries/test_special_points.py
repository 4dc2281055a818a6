"""Special points of boundaries: cusps, grazed folds, births of isolas and mergers, each found in a second way."""

import numpy as np
import pytest
from scipy.optimize import root

from solver import EndReason, Event
from solver.boundaries import SpecialPoint
from tests.solver.boundary_planes import (
    all_planes,
    curves_of,
    cusp_equations,
    folds,
    published_planes,
    row_curve,
    specials,
)


@pytest.mark.costly
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
    """docs/physics.md, section 7: at alpha = 0.278 and f_pm = 0.5855."""
    cusps = specials(folds("published", axis), SpecialPoint.CUSP)
    shaft = cusps[(np.abs(cusps[:, 3] - 1.2444) < 1e-3)]
    assert np.min(np.abs(shaft[:, 4] - value)) < 5e-4


@pytest.mark.parametrize(("axis", "value"), [("alpha", 0.388), ("f_pm", 0.714), ("f_e", 0.140)])
def test_contact_loss_ends_at_an_extremum(axis, value):
    """docs/physics.md, section 7: contact loss up to alpha = 0.388, f_pm = 0.714, and from f_e = 0.140."""
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
    """docs/physics.md, section 7: born between alpha 0.40 and 0.41, joined between 0.45 and 0.46; its folds."""
    curves = folds("isola", "alpha")

    def mesh(points):
        return points[points[:, 3] < 0.7]

    (birth,) = mesh(specials(curves, SpecialPoint.ISOLA))
    (merger,) = mesh(specials(curves, SpecialPoint.MERGER))
    assert 0.40 < birth[4] < 0.41 and 0.45 < merger[4] < 0.46
    at = mesh(np.concatenate([curve.crossings([0.44])[1] for curve in curves]))
    found = sorted((point[3], point[0], np.hypot(point[1], point[2])) for point in at)
    # docs/physics.md, section 7: also solved there with plain arithmetic, nothing of this package.
    expected = [
        (0.511643, 1.084987, 2.122987),
        (0.513399, 0.826381, 1.879884),
        (0.521717, 0.921135, 2.289807),
        (0.580161, 1.548228, 0.955863),
    ]
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
