"""What a view gives to be saved: figures of the right kind, and numbers that are those of the plane."""

import io
import json
import shlex

import pandas as pd
import pytest
import xarray as xr

import pipeline
from pipeline.errors import ConfigurationError
from pipeline.explorer import answers
from pipeline.explorer.background_run import BackgroundRun, NewPlane, new_plane
from pipeline.explorer.downloads import FORMATS, download, file_name
from pipeline.explorer.opened import Opened
from pipeline.explorer.view_state import ViewState
from pipeline.store import read_plan
from tests.pipeline.explorer.serving import served_plane
from tests.pipeline.planes import COARSE

STARTS = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}
VIEW = ViewState(at=(0.6, 0.2))


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    return Opened(served_plane(tmp_path_factory.mktemp("taken"))).content()


@pytest.mark.costly
@pytest.mark.parametrize(
    ("what", "kind", "view"),
    [
        ("map", "svg", ViewState(layer="dynamic", window=(0.5, 0.8, 0.1, 0.3))),
        ("curves", "pdf", ViewState(at=(0.6, 0.2), fixed=(("b", 0.5),))),
        ("motions", "png", VIEW),
    ],
)
def test_figures_are_of_the_kind_that_was_asked_for(content, what, kind, view):
    assert download(content, view, what, kind).startswith(STARTS[kind])
    assert file_name(content, view, what, kind).endswith(f".{kind}")


@pytest.mark.parametrize("layer", ["domains", pytest.param("rms", marks=pytest.mark.costly)])
def test_a_map_is_of_the_part_that_is_in_sight(content, layer):
    whole, part, again = (
        download(content, ViewState(layer=layer, window=window), "map", "png")
        for window in (None, (0.5, 0.8, 0.1, 0.3), (0.5, 0.8, 0.1, 0.3))
    )
    assert part == again != whole


def test_numbers_are_those_of_the_plane(content):
    told = pipeline.open_plane(content.path).motions_at(omega=0.6, f_e=0.2)
    table = pd.read_csv(io.BytesIO(download(content, VIEW, "motions", "csv")))
    assert table.amplitude.tolist() == pytest.approx(told.amplitude.values.tolist(), rel=1e-15)
    plain = json.loads(download(content, VIEW, "motions", "json"))
    assert plain["data_vars"]["dynamic_factor"]["data"] == told.dynamic_factor.values.tolist()
    assert "plane.motions_at(omega=0.6, f_e=0.2)" in plain["attrs"]["lines"]
    with xr.open_dataset(io.BytesIO(download(content, VIEW, "curves", "nc"))) as curves:
        assert curves.amplitude.values.tolist() == answers.row(content.plan, 0.2).values("amplitude").tolist()


def test_what_there_is_not_is_refused(content):
    for what, kind in (("map", "csv"), ("store", "zarr"), ("../x", "png")):
        with pytest.raises(ConfigurationError):
            download(content, VIEW, what, kind)
    with pytest.raises(ConfigurationError, match="click"):
        download(content, ViewState(), "curves", "csv")
    assert set(FORMATS) == {"map", "curves", "motions"}


@pytest.mark.costly
def test_a_changed_gear_is_computed_beside_the_page(content, tmp_path):
    command = " ".join(["python -m pipeline", *COARSE, shlex.quote(f"output.root={tmp_path}"), "cluster=none"])
    plane = new_plane(command, content.plan, {"b": 0.5, "xi_mesh": 0.06})
    assert plane.path.stem == "omega_fe-b=0.5-xi_mesh=0.06" and plane.path.is_relative_to(tmp_path)
    run = BackgroundRun()
    run.begin(plane)
    with pytest.raises(ConfigurationError, match="one at a time"):
        run.begin(plane)
    run.wait(300)
    assert run.succeeded and run.share == 1.0
    stored = read_plan(plane.path)
    assert stored.gear["b"] == 0.5 and stored.gear["xi_mesh"] == 0.06


def test_a_run_ends_with_the_server_and_says_why_it_failed(tmp_path):
    run = BackgroundRun()
    run.begin(NewPlane(("plane=omega_fe", f"output.root={tmp_path}", "cluster=none"), tmp_path / "x.zarr"))
    run.end()
    assert not run.running and not run.succeeded
    run.begin(NewPlane(("plane=nowhere",), tmp_path / "x.zarr"))
    run.wait(120)
    assert not run.succeeded and "nowhere" in run.line


@pytest.mark.parametrize(
    ("command", "fixed", "named"),
    [
        ("", {"b": 0.5}, "command"),
        ("python -m pipeline plane=omega_fe", {}, "no fixed parameter"),
        ("python -m pipeline plane=omega_fe gear=miter", {"beta": 0.5}, "beta"),
    ],
)
def test_a_plane_that_cannot_be_computed_is_refused(content, command, fixed, named):
    with pytest.raises(ConfigurationError, match=named):
        new_plane(command, content.plan, fixed)
