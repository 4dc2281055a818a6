"""A store made with other numbers than those typed: refused by every stage that reads one, with the ways on."""

import shlex
import shutil
from pathlib import Path

import pytest

from pipeline.__main__ import main
from pipeline.config.compose import compose
from pipeline.plan.differences import by_key
from pipeline.plan.planning import asked_numbers, plan
from pipeline.run.job import command
from pipeline.stages import STAGES
from tests.pipeline.planes import small_plan, small_store

_OF_ONE_PLANE = [entry.name for entry in STAGES if not entry.several_planes and entry.name != "debug"]


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A folder with one complete store, under another name than its numbers have."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "outputs/store").mkdir(parents=True)
    small_store(folder / "outputs/store/mine.zarr", small_plan("gear.b=0.5", columns=9, rows=3))
    return folder


@pytest.fixture
def folder(made, tmp_path, monkeypatch) -> Path:
    shutil.copytree(made, tmp_path / "here")
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "here"


def _refused(capsys, *words: str) -> str:
    assert main([*words, "cluster=none"]) == 2
    out, err = capsys.readouterr()
    assert out == "" and len(err.splitlines()) == 1
    return err


@pytest.mark.parametrize("stage", _OF_ONE_PLANE)
def test_every_stage_refuses_what_it_cannot_honour(stage, folder, capsys):
    said = _refused(capsys, f"stages=[{stage}]", "store.name=mine", "gear.b=0.6", "gear.f_pm=0.4")
    if stage != "sweep":
        assert "gear.b: stored 0.5, asked 0.6; gear.f_pm: stored 0.5, asked 0.4)" in said
    beside, again = said.rstrip().split("; another store beside it: ")[1].split("; this one computed again: ")
    # Both are whole: they can be typed as they stand.
    assert shlex.split(again)[:3] == ["python", "-m", "pipeline"]
    typed = {"plane=omega_fe", "gear.b=0.6", "gear.f_pm=0.4", "cluster=none"}
    assert set(shlex.split(again)[3:]) == typed | {"store.name=mine", "store.overwrite=true"}
    assert set(shlex.split(beside)[3:]) == typed
    assert compose(shlex.split(beside)[3:]).store_name == "omega_fe-b=0.6-f_pm=0.4"


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ("plane=omega_b", "plane.parameter.name: stored f_e, asked b"),
        ("gear=antiphase", "gear.alpha_phase: stored 0.0"),
        ("gear=miter", "gear.physical"),
        ("quality=draft", "plane.sweep.num: stored 9, asked 160"),
        ("quality.sweep=10", "plane.sweep.num: stored 9, asked 10"),
        ("plane.parameter.num=4", "plane.parameter.num: stored 3, asked 4"),
        ("plane.sweep.max=1.5", "plane.sweep.max: stored 2.0, asked 1.5"),
        ("plane.omega=0.5", "plane.omega: stored nothing, asked 0.5"),
        ("gear.f_e=0.3", "gear.f_e: stored nothing, asked 0.3"),
        ("plane.parameter2={name:f_pm,min:0.1,max:0.5,num:2}", "plane.parameter2"),
        ("solver=hb", "solver.balance"),
        ("solver.tolerance=1e-9", "solver.tolerance"),
        ("store.max_points=99", "store.max_points: stored 2048, asked 99"),
        ("gear.b=-1", "gear.b: stored 0.5, asked -1"),
    ],
)
def test_whatever_was_typed_must_hold(words, named, folder, capsys):
    assert named in _refused(capsys, "stages=[figures]", "store.name=mine", *words.split())


@pytest.mark.parametrize(
    "words",
    ["", "gear.b=0.5", "plane.sweep.num=9 plane.parameter.num=3", "plane=omega_fe gear.b=0.5", "figures.dpi=60"],
)
def test_what_holds_or_was_not_typed_is_no_matter(words, folder):
    read = ["stages=[check]", "store.name=mine", "cluster=none"]
    assert main([*read, *words.split()]) == 0


def test_under_the_default_name_another_store_is_named_too(folder, capsys):
    shutil.copytree("outputs/store/mine.zarr", "outputs/store/omega_fe-b=0.5.zarr")
    said = _refused(capsys, "stages=[figures]", "gear.b=0.5", "plane.sweep.num=10")
    assert "store.name=omega_fe-b=0.5-2" in said and "plane.sweep.num: stored 9, asked 10" in said


@pytest.mark.costly
def test_another_gear_has_another_store(folder, capsys):
    shutil.copytree("outputs/store/mine.zarr", "outputs/store/omega_fe-b=0.5.zarr")
    assert "omega_fe-b=0.6.zarr" in _refused(capsys, "stages=[figures]", "gear.b=0.6")
    small = ["figures.formats=[png]", "figures.dpi=30", "cluster=none"]
    assert main(["stages=[figures]", "gear.b=0.5", *small]) == 0
    assert (folder / "outputs/figures/omega_fe-b=0.5/map.png").exists()


def test_tables_look_for_what_was_typed(folder, capsys):
    said = _refused(capsys, "stages=[tables]", "gear.b=0.6", "gear.kappa=0.4")
    for name, gear in (("omega_b-kappa=0.4", ""), ("omega_alpha-b=0.6-kappa=0.4", " gear.b=0.6")):
        assert f"{name}.zarr" in said and f"plane={name.split('-')[0]}{gear} gear.kappa=0.4" in said


def test_the_report_is_of_the_published_gear(folder, capsys):
    assert "gear.b is not allowed" in _refused(capsys, "stages=[report]", "gear.b=0.6")


def test_a_missing_store_is_answered_with_the_whole_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    typed = ["gear.kappa=[0.5,0.4]", "plane.sweep.num=9", "store.root=there", "figures.dpi=90"]
    said = _refused(capsys, *typed, "stages=[figures]")
    words = shlex.split(said[said.index("python -m pipeline") : said.rindex(" makes it")])
    assert words[3:] == ["plane=omega_fe", *typed, "cluster=none"]
    (tmp_path / "a b").mkdir()
    assert shlex.split(command(compose([], "a b")))[3:] == ["--config-dir=a b", "plane=omega_fe"]


@pytest.mark.parametrize("overrides", [[], ["gear=miter"], ["plane=b_fe"], ["plane=omega_b_fe"], ["solver=hb"]])
def test_what_is_asked_is_what_is_planned(overrides):
    settings = compose(overrides)
    asked, planned = by_key(asked_numbers(settings)), by_key(plan(settings).inputs)
    assert {key: value for key, value in planned.items() if value is not None} == {
        key: value for key, value in asked.items() if key in planned and value is not None
    }
    axes = {f"gear.{axis.name}" for axis in plan(settings).axes}
    assert {key for key in asked.keys() - planned.keys() if asked[key] is not None} <= axes
