"""The planes that ship: each composes, and where two of them meet in a point they hold the same motions."""

import numpy as np
import pytest

from pipeline.analysis import boundaries
from pipeline.analysis.margins.curves import P, boundaries_of
from pipeline.config.compose import compose, conf_folder
from pipeline.errors import ConfigurationError
from pipeline.plan.numerics import balance_of, continuation_of, model_at, point_of, row_of, seeds_of
from pipeline.plan.planning import plan, warnings
from pipeline.plane.boundaries import read_boundaries
from solver import all_solutions
from solver.boundaries import FOLDS_AND_GRAZINGS
from tests.conftest import MODELS
from tests.pipeline.planes import small_plan, small_store

PLANES = sorted(path.stem for path in (conf_folder() / "plane").glob("*.yaml"))


def row_at(planned, value):
    return row_of(planned, value, balance_of(planned.solver), continuation_of(planned.solver), seeds_of(planned.solver))


def test_the_planes_are_these():
    assert set(PLANES) >= {
        "b_fe",
        "omega_alpha",
        "omega_b",
        "omega_fe",
        "omega_fpm",
        "omega_phase",
        "omega_xi",
        "omega_xi_support",
    }


@pytest.mark.parametrize("name", ["omega_xi", "omega_xi_support", "omega_phase"])
def test_new_planes_hold_the_default_row(name):
    """At the published value of their parameter, rows of every plane over frequency are the same row."""
    size = "plane.sweep.num=61"
    planned, usual = plan(compose([f"plane={name}", size])), plan(compose(["plane=omega_fe", size]))
    value = {"omega_xi": 0.05, "omega_xi_support": 0.01, "omega_phase": 0.0}[name]
    assert planned.parameter.low <= value <= planned.parameter.high
    row, expected = row_at(planned, value), row_at(usual, 0.2)
    np.testing.assert_array_equal(row.domain, expected.domain)
    np.testing.assert_array_equal(row.amplitude, expected.amplitude)


def test_b_fe_meets_omega_b():
    """A plane without the frequency on an axis: its cells agree with enumeration, and with the plane omega x b."""
    planned = plan(compose(["plane=b_fe", "plane.sweep.num=26"]))
    over_frequency = plan(compose(["plane=omega_b", "plane.sweep.min=0.6", "plane.sweep.max=0.7", "plane.sweep.num=2"]))
    assert planned.omega == 0.6
    for b in (0.1, 0.7, 1.0):
        row = row_at(planned, b)
        for column in (0, 10, 25):
            model, omega = point_of(planned, b, planned.sweep.values[column])
            found = all_solutions(model, omega)
            assert row.n_solutions[column] == len(found.amplitude)
            amplitude = row.amplitude[column, : len(found.amplitude)]
            np.testing.assert_allclose(amplitude, np.sort(found.amplitude), rtol=1e-7)
        first = row_at(over_frequency, b)
        np.testing.assert_allclose(
            row.amplitude[10, : row.n_solutions[10]], first.amplitude[0, : first.n_solutions[0]], rtol=1e-7
        )


@pytest.mark.parametrize("gear", [*MODELS, "miter", "differential"])
def test_mesh_damping_keeps_the_ratio(gear):
    """xi_hg/xi_h of every row is the gear's own, and the gear at its own value is itself."""
    planned = plan(compose(["plane=omega_xi", f"gear={gear}"]))
    own = model_at(plan(compose([f"gear={gear}"])), 0.2, 1.0)
    assert model_at(planned, own.xi_mesh, 1.0).replace(f_e=0.2) == own
    for value in (0.005, 0.11, 0.2):
        model = model_at(planned, value, 1.0)
        assert model.xi_mesh == value
        for xi, its in zip(model.xi_translation, own.xi_translation, strict=True):
            assert xi / value == pytest.approx(its / own.xi_mesh, rel=1e-14)
    physical = gear in ("miter", "differential")
    damping = [text for text in warnings(planned) if "does not feel" not in text]
    assert (damping == []) == physical
    alone = warnings(plan(compose(["plane=omega_xi", f"gear={gear}", "plane.parameter.name=xi_mesh"])))
    assert any("xi_mesh = 0.005 differs from gear.kappa" in line and "mesh_damping" in line for line in alone)


@pytest.mark.costly
def test_boundaries_over_mesh_damping(tmp_path):
    """Folds and grazings where rows of other damping meet them: plain axes of the solver know nothing of the path."""
    window = ["plane.sweep.min=0.5", "plane.sweep.max=0.7", "plane.parameter.min=0.03", "plane.parameter.max=0.08"]
    planned = small_plan("plane=omega_xi", *window, columns=21, rows=4)
    path = small_store(tmp_path / "plane.zarr", planned)
    assert boundaries.trace(path, planned).cut_short == ()
    shown, met = boundaries_of(read_boundaries(path, planned).curves), 0
    for value in (0.041, 0.062):
        gear = (f"gear.xi_mesh={value}", f"gear.xi_translation={0.25 * value}")
        row = row_at(small_plan("plane=omega_b", *gear, *window[:2], rows=2), 1.0)
        events = np.concatenate([curve.points[np.isin(curve.event, FOLDS_AND_GRAZINGS), -1] for curve in row.curves])
        crossed, _ = shown.along(P, value)
        met += crossed.size
        for x in crossed:
            assert np.min(np.abs(events - x)) < 1e-7
    assert met >= 4


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["gear.xi_mesh=0"], "gear.xi_mesh = 0.0 is not allowed: it must be above 0 where mesh_damping is an axis"),
        (
            ["plane.parameter.min=-0.1"],
            "plane.parameter.min = -0.1 is not allowed: it must be a finite number at least 0",
        ),
        (
            ["plane.sweep.name=xi_translation", "plane.omega=1"],
            "plane.sweep.name = 'xi_translation' .* over mesh_damping",
        ),
        (["plane.sweep.name=mesh_damping", "plane.parameter.name=b"], "mesh_damping changes several numbers at once"),
        (
            ["gear=miter", "gear.physical.mesh_damping_ratio=0.1"],
            "mesh_damping_ratio is not allowed here: mesh_damping",
        ),
    ],
)
def test_what_mesh_damping_cannot_be(words, said):
    with pytest.raises(ConfigurationError, match=said):
        plan(compose(["plane=omega_xi", *words]))
