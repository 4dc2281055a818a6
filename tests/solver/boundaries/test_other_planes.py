"""Boundaries in planes of other axes, of other lengths and without load, and what `boundary_curves` refuses."""

import numpy as np
import pytest

from solver import Continuation, EndReason, Event, ParameterError, sweep_row
from solver.boundaries import SpecialPoint, boundary_curves, row_events, tracer
from tests.conftest import published
from tests.solver.boundary_planes import GRID, OMEGA, RANGES, curves_of, cusp_equations, distance, specials, starts_of


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
        for event in row_events(sweep_row(published(alpha=value), "b", grid, omega=0.65).curves, value)
    ]
    curves = boundary_curves(published(), "b", "alpha", (0.02, 1.5), (0.05, 0.6), starts, omega=0.65)
    assert [curve.kind for curve in curves] == [Event.FOLD, Event.MIN_AT_BACK]
    assert list(curves[0].special[curves[0].special > 0]) == [
        SpecialPoint.BORDER,
        SpecialPoint.CUSP,
        SpecialPoint.BORDER,
    ]
    for value in (0.2222, 0.3333, 0.5555):
        events = row_events(sweep_row(published(alpha=value), "b", grid, omega=0.65).curves, value)
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
    starts = [event for v in values for event in row_events(sweep_row(model.replace(f_pm=v), "omega", GRID).curves, v)]
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
    assert not curve.closed and len(curve.crossings([0.4])[0]) == 0


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


def test_where_no_tangent_can_be_told_a_start_is_a_curve_of_one_point(monkeypatch):
    def lost(problem, y):
        return np.full(y.size, np.nan)

    row = sweep_row(published(), "omega", np.linspace(0.5, 0.8, 9))
    starts = row_events(row.curves, published().f_e)
    monkeypatch.setattr(tracer, "curve_tangent", lost)
    curves = boundary_curves(published(), "omega", "f_e", (0.5, 0.8), (0.1, 0.3), starts)
    assert len(curves) == len(starts) > 1
    assert all(len(curve.points) == 1 and curve.ends == (EndReason.STEP_TOO_SMALL,) * 2 for curve in curves)
