"""From Python alone to a plane and its figures."""

import subprocess
import sys
import textwrap

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.__main__ import main
from pipeline.errors import ComputationError, ConfigurationError
from pipeline.run import rows

SMALL = ["plane.sweep.num=40", "plane.parameter.num=5", "cluster=none"]


def places(tmp_path):
    return [f"store.root={tmp_path / 'store'}", f"output.root={tmp_path / 'out'}"]


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    folder = tmp_path_factory.mktemp("computed")
    return pipeline.compute("omega_fe", [*SMALL, *places(folder), "gear.b=0.5"])


def test_a_plane_is_computed_and_opened(plane, capsys):
    assert capsys.readouterr() == ("", "")
    assert plane.path.is_dir() and {"boundaries", "branches"} <= set(plane.tree.children)
    assert np.all(plane.tree["status"].values == 1)
    assert plane.plan.omega is None or plane.plan.sweep.num == 40


def test_it_is_what_the_command_line_computes(plane, tmp_path):
    command = ["plane=omega_fe", *SMALL, *places(tmp_path), "gear.b=0.5", "stages=[sweep]", "store.name=same"]
    assert main(command) == 0
    same = pipeline.open_plane("same", root=tmp_path / "store")
    xr.testing.assert_identical(same.tree["amplitude"].drop_attrs(), plane.tree["amplitude"].drop_attrs())


def test_again_it_only_opens_it(plane, monkeypatch):
    monkeypatch.setattr(rows, "sweep_block", None)
    root = plane.path.parent
    again = pipeline.compute(
        "omega_fe", [*SMALL, f"store.root={root}", f"output.root={root.parent / 'out'}", "gear.b=0.5"]
    )
    assert again.path == plane.path


def test_what_is_not_allowed_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match="gear.b"):
        pipeline.compute("omega_fe", [*SMALL, *places(tmp_path), "gear.b=-1"])
    assert not (tmp_path / "store").exists()


def test_rows_that_fail_are_an_error_and_stored(tmp_path, monkeypatch):
    def fails(plan, row, *others):
        raise ArithmeticError(f"row {row} has it")

    monkeypatch.setattr(rows, "stored_row", fails)
    with pytest.raises(ComputationError):
        pipeline.compute("omega_fe", [*SMALL, *places(tmp_path)])
    assert np.all(pipeline.open_plane("omega_fe", root=tmp_path / "store").tree["status"].values == 2)


@pytest.mark.costly
def test_figures_are_shown_whatever_style_is_in_force(plane):
    import matplotlib

    assert plane.plot.map()._repr_png_().startswith(b"\x89PNG")
    first = plane.plot.curves(f_e=0.2)
    with matplotlib.rc_context({"font.size": 20.0, "lines.linewidth": 5.0}):
        assert plane.plot.curves(f_e=0.2)._repr_png_() == first._repr_png_()
    for wanted, figure in ((2, first), (6, plane.plot.curves()), (4, plane.plot.multipliers(f_e=[0.2, 0.23]))):
        # Insets have no labels of their own.
        assert sum(bool(axes.get_ylabel()) for axes in figure.axes) == wanted
    assert plane.plot.backbone().axes and plane.plot.map(window=(0.5, 0.8, 0.1, 0.3)).axes


def test_figures_that_are_not_there_are_refused(plane):
    for wrong in (
        lambda: plane.plot.curves(f_e=7.0),
        lambda: plane.plot.curves(b=0.5),
        lambda: plane.plot.multipliers(),
        lambda: plane.plot.multipliers(f_e=7.0),
        lambda: plane.plot.map(window=(0.8, 0.5, 0.1, 0.3)),
        lambda: plane.plot.map(stability="both"),
        lambda: plane.plot.backbone(units="physical"),
    ):
        with pytest.raises(ConfigurationError):
            wrong()


def test_everything_as_xarray(plane):
    tree = plane.to_xarray()
    assert isinstance(tree, xr.DataTree) and set(tree.children) == set(plane.tree.children)
    tree["amplitude"][...] = 0.0
    assert np.nanmax(plane.tree["amplitude"].values) > 0.0


def test_it_says_what_it_is(plane):
    said = plane.describe()
    for part in ("omega", "f_e", "40", "5 of 5", str(plane.path), "first order", "boundaries"):
        assert part in said and part in plane._repr_html_()
    assert repr(plane) in said


@pytest.mark.costly
def test_a_script_needs_no_guard(tmp_path):
    """Workers do not run the script that started them."""
    script = tmp_path / "script.py"
    window = ["plane.sweep.min=0.55", "plane.sweep.max=0.65", "plane.parameter.min=0.15", "plane.parameter.max=0.25"]
    small = ["plane.sweep.num=11", "plane.parameter.num=3", *window]
    script.write_text(
        textwrap.dedent(
            f"""
            import pipeline
            print("once")
            plane = pipeline.compute("omega_fe", {[*small, "cluster.workers=1", *places(tmp_path)]!r})
            print(plane.label_near(omega=0.6, f_e=0.2))
            """
        )
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout.split()) == (0, ["once", "2/0-1"]), done.stderr
