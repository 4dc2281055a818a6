"""Several planes by one command against each plane alone: the same stores, whatever fails or interrupts."""

import contextlib
import csv
import io
import shutil
from datetime import UTC, datetime

import numpy as np
import pytest

import pipeline
from pipeline import store
from pipeline.__main__ import main
from pipeline.errors import StoreError
from pipeline.multirun.index import begun_index, read_index
from pipeline.multirun.reporting import PlaneReporter, StudyProgress
from pipeline.run import rows
from pipeline.run.progress import Reporter, RowProgress
from pipeline.store.lock import exclusive_lock
from tests.made_once import made_once

SMALL = ["cluster=none", "plane.sweep.num=15", "plane.parameter.num=4"]
FEW = ["attractors.columns=2", "attractors.rows=2", "attractors.starts=1"]
ALL = [*SMALL, *FEW, "stages=[sweep,boundaries,attractors]"]
SWEPT = [*SMALL, "stages=[sweep]"]
VALUES = ("0.5", "0.6")


@pytest.fixture(autouse=True)
def at_one_moment(monkeypatch, tmp_path):
    """Stores are made at one moment, so that all their bytes can be compared."""

    class Clock(datetime):
        @classmethod
        def now(cls, tz=None):
            return datetime(2026, 1, 1, tzinfo=UTC)

    monkeypatch.setattr("pipeline.store.template.datetime", Clock)
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def alone(tmp_path):
    """A folder with every plane computed by a command of its own."""

    def make(folder):
        with contextlib.chdir(folder):
            for value in VALUES:
                assert main([f"gear.b={value}", *ALL]) == 0

    here = made_once("planes-alone", make)
    return here / "outputs/store"


def files_of(folder):
    found = {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    return {name: content for name, content in found.items() if name != "study.csv"}


def lines_of(path):
    return list(csv.DictReader(io.StringIO(path.read_text())))


def test_a_small_study_needs_no_workers(tmp_path, capsys):
    here = [word for word in SWEPT if not word.startswith("cluster")]
    assert main(["-m", f"gear.b={','.join(VALUES)}", *here]) == 0
    said = capsys.readouterr()
    assert said.err == "" and said.out.count("tasks run in this process") == 2
    assert [line["status"] for line in lines_of(tmp_path / "outputs/store/study.csv")] == ["complete"] * 2


def test_every_store_is_the_same_as_alone(alone, tmp_path, capsys):
    here = tmp_path / "outputs/store"
    assert main(["-m", f"gear.b={','.join(VALUES)}", *ALL]) == 0
    assert files_of(here) == files_of(alone)
    said = capsys.readouterr()
    assert said.err == "" and all(f"omega_fe-b={value}: " in said.out for value in VALUES)
    lines = lines_of(here / "study.csv")
    assert [float(line["gear.b [1]"]) for line in lines] == [0.5, 0.6]
    for line in lines:
        assert (line["status"], line["cells"], line["rows"]) == ("complete", "60", "4")
        assert int(line["domains"]) >= 1 and 0.0 <= float(line["several_motions"]) <= float(line["teeth_part"]) <= 1.0
    # The same command again finds everything done.
    before = files_of(here)
    assert main(["-m", f"gear.b={','.join(VALUES)}", *ALL]) == 0
    assert capsys.readouterr().out.count("nothing to do") == 6
    assert files_of(here) == before


def test_a_plane_that_fails_does_not_stop_the_others(tmp_path, capsys, monkeypatch):
    """One store is in use, rows of another plane raise, a program error hits a third, and the fourth is complete."""
    stored = rows.stored_row
    run = __import__("pipeline.multirun.running", fromlist=["run_plane_stages"]).run_plane_stages

    def fails(plan, *arguments):
        if plan.gear["b"] == 0.6:
            raise ArithmeticError("injected")
        return stored(plan, *arguments)

    def breaks(job, *arguments):
        if job.settings.store_name == "omega_fe-b=0.7":
            raise ZeroDivisionError("injected too")
        return run(job, *arguments)

    with monkeypatch.context() as patch:
        patch.setattr(rows, "stored_row", fails)
        patch.setattr("pipeline.multirun.running.run_plane_stages", breaks)
        (tmp_path / "outputs/store").mkdir(parents=True)
        with exclusive_lock(tmp_path / "outputs/store/omega_fe-b=0.5.zarr", False, print):
            assert main(["-m", "gear.b=0.5,0.6,0.7,0.8", *SWEPT]) == 1
    said = capsys.readouterr()
    (in_use, broken) = said.err.splitlines()
    assert in_use.startswith("error: omega_fe-b=0.5: ") and "in use" in in_use
    assert broken.startswith("error: omega_fe-b=0.7: ZeroDivisionError: injected too")
    assert "omega_fe-b=0.6: row 0" in said.out and "injected" in said.out
    lines = lines_of(tmp_path / "outputs/store/study.csv")
    assert [line["status"] for line in lines] == ["failed", "failed", "failed", "complete"]
    assert np.all(store.statuses(tmp_path / "outputs/store/omega_fe-b=0.8.zarr") == store.COMPLETE)
    # The same command goes on with what is missing, and with nothing else.
    assert main(["-m", "gear.b=0.5,0.6,0.7,0.8", *SWEPT]) == 0
    assert capsys.readouterr().out.count("nothing to do") == 1
    assert {line["status"] for line in lines_of(tmp_path / "outputs/store/study.csv")} == {"complete"}


def test_what_is_stored_is_kept_when_it_is_interrupted(alone, tmp_path, capsys, monkeypatch):
    swept, count = rows.sweep_block, []

    def interrupted(path, *arguments):
        count.append(path)
        if len(count) == 6:  # the second block of the second plane
            raise KeyboardInterrupt
        return swept(path, *arguments)

    with monkeypatch.context() as patch:
        patch.setattr(rows, "sweep_block", interrupted)
        assert main(["-m", "gear.b=0.5,0.6", *SWEPT]) == 130
    assert (
        capsys.readouterr().err
        == "error: interrupted; what is stored is kept, and the same command goes on from there\n"
    )
    here = tmp_path / "outputs/store"
    assert np.all(store.statuses(here / "omega_fe-b=0.5.zarr") == store.COMPLETE)
    assert np.sum(store.statuses(here / "omega_fe-b=0.6.zarr") == store.COMPLETE) == 1
    assert not list(here.glob(".*.lock"))
    assert [line["status"] for line in lines_of(here / "study.csv")] == ["complete", "incomplete"]
    assert main(["-m", "gear.b=0.5,0.6", *SWEPT]) == 0
    wanted = files_of(alone)
    # What a store says of itself has the stages that were asked for.
    of_rows = {name: content for name, content in files_of(here).items() if "/c/" in name}
    assert of_rows == {name: wanted[name] for name in of_rows} and len(of_rows) > 100


def test_a_damaged_store_is_named_and_the_others_are_done(alone, tmp_path, capsys):
    here = tmp_path / "outputs/store"
    shutil.copytree(alone, here)
    (here / "omega_fe-b=0.5.zarr/mean/c/0/0/0").unlink()
    shutil.rmtree(here / "omega_fe-b=0.6.zarr")
    assert main(["-m", f"gear.b={','.join(VALUES)}", *SWEPT]) == 1
    (error,) = capsys.readouterr().err.splitlines()
    assert "omega_fe-b=0.5" in error and "damaged" in error
    assert [line["status"] for line in lines_of(here / "study.csv")] == ["damaged", "complete"]


def test_what_is_not_allowed_is_found_before_anything_runs(tmp_path, capsys):
    assert main(["-m", "gear.b=0.5,thick", *SWEPT]) == 2
    assert "gear.b" in capsys.readouterr().err and list(tmp_path.iterdir()) == []


def test_planes_that_share_a_store_have_it_one_after_the_other(alone, tmp_path, capsys):
    shutil.copytree(alone, tmp_path / "outputs/store")
    seeds = ["-m", "gear.b=0.5", "attractors.seed=1,2", *SMALL, *FEW, "stages=[attractors]"]
    assert main(seeds) == 0
    assert capsys.readouterr().out.count("cells with") == 2
    assert not (tmp_path / "outputs/store/study.csv").exists()


def settings_of(*overrides):
    from pipeline.config.compose import compose, expand

    return [compose(one) for one in expand(overrides)]


def test_an_index_reads_as_it_was_written_and_grows(alone, tmp_path):
    here = tmp_path / "outputs/store"
    shutil.copytree(alone, here)
    index, note = begun_index(settings_of("gear.b=0.5,0.6", *SMALL))
    index.write()
    assert note == "" and read_index(here) == index and list(index.planes) == ["omega_fe-b=0.5", "omega_fe-b=0.6"]
    more, note = begun_index(settings_of("gear.b=0.7,0.8", *SMALL))
    assert note == "" and [plane.values for plane in more.planes.values()] == [(0.5,), (0.6,), (0.7,), (0.8,)]
    assert [plane.told["status"] for plane in more.planes.values()] == ["complete"] * 2 + ["pending"] * 2
    more.write()
    other, note = begun_index(settings_of("gear=miter,published", *SMALL))
    assert "gear.b" in note and "store.root" in note and [one.unit for one in other.varied] == [None]
    assert [plane.values for plane in other.planes.values()] == [("miter",), ("published",)]


@pytest.mark.parametrize(
    "text", ["", "\0", "a,b\n1,2\n", "store,gear.b [1],status\n", '"', "store\n" * 3, "\xff", "x" * 100]
)
def test_what_is_no_index_is_refused(text, tmp_path):
    (tmp_path / "study.csv").write_text(text, encoding="latin-1")
    with pytest.raises(StoreError, match=r"study\.csv"):
        read_index(tmp_path)


def test_no_line_of_an_index_leads_out_of_its_folder(tmp_path):
    index, _ = begun_index(settings_of("gear.b=0.5,0.6", *SMALL, f"store.root={tmp_path}"))
    index.write()
    path = tmp_path / "study.csv"
    for name in ("../outside", "", "a/b"):
        path.write_text(path.read_text().replace("omega_fe-b=0.5", name, 1) if name else path.read_text() + "\n,\n")
        with pytest.raises(StoreError, match="no line of it"):
            read_index(tmp_path)
        index.write()


def test_one_bar_over_all_planes():
    stream = io.StringIO()
    reporter = Reporter(stream)
    progress = StudyProgress(reporter, {"a": 10, "b": 20, "c": 5})
    with progress:
        a, b = (PlaneReporter(reporter, name, progress) for name in "ab")
        with RowProgress(a, 10) as bar:
            bar.advance(10, 1)
        a.line("a: said")
        a.line("  more")
        progress.ends("a")
        # Only rows that are missing count, and those of other stages do.
        with RowProgress(b, 8) as bar, RowProgress(b, 4, what="attractors") as other:
            bar.advance(8, 0)
            other.advance(4, 0)
        with RowProgress(b, 3, what="compile", unit="kernels") as bar:
            bar.advance(3, 0)
        progress.ends("b")
        progress.ends("c")
        total = progress._bar
        assert (total.what, total.done, total.failed, total.total) == ("3/3 planes", 22, 1, 22)
    assert stream.getvalue().splitlines() == ["a: said", "a: more"]


@pytest.mark.costly
def test_a_study_in_an_object_store(tmp_path, capsys):
    pytest.importorskip("obstore")
    command = ["-m", "gear.b=0.5,0.6", *SWEPT, "store.root=memory://bucket/study"]
    assert main(command) == 0
    study = pipeline.open_study("memory://bucket/study")
    assert "2 complete" in repr(study) and not (tmp_path / "outputs/store").exists()
    whole = study.to_xarray()
    assert whole.b.values.tolist() == [0.5, 0.6] and np.all(whole.status == store.COMPLETE)
    assert study.planes["omega_fe-b=0.6"].label_near(omega=0.6, f_e=0.2) != ""
    capsys.readouterr()
    assert main(command) == 0 and capsys.readouterr().out.count("nothing to do") == 2
