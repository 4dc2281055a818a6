"""The stage that verifies: what it says, what takes its group away, and input that is not allowed."""

import pytest
import zarr

from pipeline import store
from pipeline.__main__ import main
from pipeline.analysis import boundaries
from pipeline.store import groups
from tests.pipeline.planes import contents

SMALL = [
    "plane=omega_fe",
    "store.name=omega_fe",
    "plane.sweep.min=0.5",
    "plane.sweep.max=0.9",
    "plane.sweep.num=9",
    "plane.parameter.num=3",
    "cluster=none",
    "verify.samples=10",
    "verify.beside=2",
    "verify.max_periods=600",
]


def test_the_stage(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[sweep,verify,figures]", "figures.formats=[png]", "figures.dpi=50"]) == 0
    said = capsys.readouterr().out
    assert (tmp_path / "outputs/figures/omega_fe/verification.png").stat().st_size > 5000
    assert "right by integration" in said and "omega_fe.csv, omega_fe.md" in said
    path = tmp_path / "outputs/store/omega_fe.zarr"
    before = contents(path)
    assert any(name.startswith("verification/") for name in before)
    assert main([*SMALL, "stages=[verify]"]) == 0
    assert "nothing to do" in capsys.readouterr().out
    # Settings of the verification are no part of what identifies the sweep.
    assert main([*SMALL, "verify.seed=3", "stages=[sweep,verify]"]) == 0
    said = capsys.readouterr().out
    assert "rows are in" in said and "verify: " in said and said.count("nothing to do") == 1
    # A sweep that computes rows takes all added groups away.
    boundaries.trace(path, store.read_plan(path))
    zarr.open_group(path, mode="r+")["status"][1] = store.FAILED
    assert main([*SMALL, "stages=[sweep]"]) == 0
    assert groups.open_group(path, "verification") is None and groups.open_group(path, "boundaries") is None
    assert set(zarr.open_group(path).group_keys()) == {"branches"} and not (path / "verification").exists()


def test_failures_are_the_exit_status(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[sweep]"]) == 0

    def broken(*arguments, **options):
        raise ArithmeticError("the step is lost")

    monkeypatch.setattr("solver.timedomain.settle", broken)
    capsys.readouterr()
    assert main([*SMALL, "stages=[verify]"]) == 1
    assert "could not be integrated: ArithmeticError: the step is lost" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("verify.samples=0", "verify.samples = 0 is not allowed: it must be from 1 to 1e+06"),
        ("verify.beside=-1", "verify.beside = -1 is not allowed: it must be from 0 to 1e+06"),
        ("verify.seed=-1", "verify.seed = -1 is not allowed: it must be from 0 to"),
        ("verify.order=33", "verify.order = 33 is not allowed: it must be from 1 to 32"),
        ("verify.columns=1", "verify.columns = 1 is not allowed: it must be from 2 to 1e+06"),
        ("verify.delta=1.5", "verify.delta = 1.5 is not allowed: it must be from 0 to 1"),
        ("verify.delta=nan", "verify.delta = nan is not allowed: it must be from 0 to 1"),
        ("verify.max_periods=10", "verify.max_periods = 10 is not allowed: it must be from 300 to 1e+07"),
        ("verify.tolerance=0", "verify.tolerance = 0.0 is not allowed: it must be above 0 and at most 1"),
        ("verify.samples=many", "verify.samples"),
        ("verify.sample=5", "verify.sample is not a key of the configuration: did you mean verify.samples?"),
    ],
)
def test_bad_input_is_one_line(tmp_path, monkeypatch, capsys, override, message):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[sweep,verify]", override]) == 2
    error = capsys.readouterr().err
    assert message in error and len(error.splitlines()) == 1 and not list(tmp_path.iterdir())


def test_without_a_store(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[verify]"]) == 2
    assert "there is no store at" in capsys.readouterr().err and not list(tmp_path.iterdir())
