"""The table of docs/physics.md, section 7: where labels of the published set change, by bisection on rows."""

import numpy as np
import pytest

from solver import Event, domain_label, sweep_row
from tests.conftest import published

MESH, SHAFT = np.linspace(0.45, 0.8, 351), np.linspace(1.05, 1.5, 451)


def labels(model, window):
    """All labels of a row at the frequencies of a window; the branches are those of the whole range."""
    row = sweep_row(model, "omega", np.concatenate([[0.05], window, [2.0]]))
    return {domain_label(code) for code in row.domain[1:-1]}


def has(label, window):
    return lambda model: label in labels(model, window)


def double_sided(window):
    return lambda model: any("2" in label.split("/")[1] for label in labels(model, window))


def shaft_event(kind):
    def found(model):
        curves = sweep_row(model, "omega", [0.05, 1.0, 2.0]).curves
        return any(np.any((curve.event == kind) & (curve.points[:, 3] > 0.9)) for curve in curves)

    return found


def threshold(parameter, statement, low, high):
    """Where a statement about the model begins or ceases to hold, by bisection."""
    before = statement(published(**{parameter: low}))
    assert statement(published(**{parameter: high})) is not before
    for _ in range(11):
        middle = 0.5 * (low + high)
        if statement(published(**{parameter: middle})) is before:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@pytest.mark.parametrize(
    "parameter, statement, low, high, expected, resolution",
    [
        pytest.param("f_e", has("1/1", SHAFT), 0.05, 0.20, 0.140, 6e-4, id="f_e: shaft 1/1"),
        pytest.param("f_e", has("2/0-2", MESH), 0.10, 0.25, 0.198, 6e-4, id="f_e: mesh 2/0-2"),
        pytest.param("f_e", has("2/1-2", MESH), 0.25, 0.36, 0.321, 2e-3, id="f_e: mesh 2/1-2"),
        pytest.param("f_e", has("2/2", MESH), 0.33, 0.45, 0.370, 6e-4, id="f_e: mesh 2/2"),
        pytest.param("alpha", shaft_event(Event.FOLD), 0.20, 0.35, 0.278, 6e-4, id="alpha: shaft jumps"),
        pytest.param("alpha", shaft_event(Event.MIN_AT_DRIVE), 0.30, 0.45, 0.388, 6e-4, id="alpha: contact loss"),
        pytest.param("f_pm", shaft_event(Event.FOLD), 0.50, 0.65, 0.5855, 6e-5, id="f_pm: shaft jumps"),
        pytest.param("f_pm", shaft_event(Event.MIN_AT_DRIVE), 0.60, 0.80, 0.714, 6e-4, id="f_pm: contact loss"),
        pytest.param("b", has("2/0-2", MESH), 0.90, 1.10, 1.011, 6e-4, id="b: mesh 2/0-2"),
        pytest.param("b", double_sided(SHAFT), 0.12, 0.25, 0.18, 8e-3, id="b: shaft settles"),
        pytest.param("b", has("1/2", MESH), 0.50, 0.70, 0.62, 1e-2, id="b: mesh 1/2"),
        pytest.param("b", has("2/0-1", MESH), 0.50, 0.70, 0.62, 2e-2, id="b: mesh 2/0-1"),
    ],
)
def test_thresholds_of_the_published_set(parameter, statement, low, high, expected, resolution):
    assert threshold(parameter, statement, low, high) == pytest.approx(expected, abs=resolution)


def test_multivalued_intervals_of_the_default_row():
    row = sweep_row(published(), "omega", np.linspace(0.05, 2.0, 40))
    (curve,) = row.curves
    edges = np.sort(curve.points[curve.event == Event.FOLD, 3])
    np.testing.assert_allclose(edges, [0.55937, 0.63464, 1.22381, 1.22971], rtol=0, atol=6e-6)


def test_what_the_article_has_and_first_order_has_not():
    """Bilateral impact in the shaft-frequency resonance at default load: I stays at 1."""
    assert not double_sided(SHAFT)(published())


def test_three_stable_solutions_occur_in_narrow_strips():
    assert "3/0-2" in labels(published(b=0.62), MESH)
    assert {"3/0-2", "3/1-2", "3/0-1-2"} <= labels(published(f_e=0.325), MESH)
