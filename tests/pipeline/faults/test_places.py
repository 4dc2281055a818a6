"""Disks that fill, folders that cannot be written or go away, clocks that jump, and two runs on one store."""

import io
import json
import os
import re
import resource
import shutil
import signal
import subprocess

import pytest
from filelock import lock_descriptor

from pipeline import store
from pipeline.__main__ import main
from pipeline.run import rows
from tests.pipeline.faults.runs import COMMAND, INJECTED, KEPT, continued, finished, same, start, until
from tests.pipeline.faults.test_damage import run as run_here
from tests.pipeline.planes import small_plan, traced_store


def _one_line(run, *parts):
    assert run.code in (1, 2) and len(run.err.splitlines()) == 1 and run.err.startswith("error: "), run.err
    for part in parts:
        assert part in run.err


@pytest.mark.costly
def test_a_full_disk_by_limit(tmp_path, undisturbed, capsys):
    biggest = max(file.stat().st_size for file in undisturbed.rglob("*") if file.is_file() and "c" in file.parts)

    root = (undisturbed / "zarr.json").stat().st_size
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    # The template fits, not every chunk.
    resource.setrlimit(resource.RLIMIT_FSIZE, (biggest - 1, before[1]))
    try:
        code, _, err = run_here(tmp_path, capsys, "stages=[sweep]")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    path = tmp_path / "outputs/store/plane.zarr"
    assert code == 1 and err.startswith("error: ") and err.count("\n") == 1, err
    assert "File too large" in err and KEPT in err
    if biggest > root:
        assert store.find_damage(path) == []
    continued(tmp_path, capsys)
    same(path, undisturbed)


@pytest.fixture
def small_disk(tmp_path):
    """A file system of sixteen megabytes; its own mount, which ends with the test."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", str(folder)]
    made = subprocess.run(mount, capture_output=True, text=True)
    if made.returncode:
        pytest.skip(f"no file system can be mounted here: {made.stderr.strip()}")
    yield folder
    subprocess.run(["mount", "-o", "remount,rw", str(folder)], capture_output=True)
    subprocess.run(["umount", "-l", str(folder)], check=True)


@pytest.mark.slow
def test_a_full_disk(small_disk, undisturbed, capsys):
    run = start(small_disk, "cluster=none")
    until(run, 6)
    # Something else takes the rest of the disk.
    with pytest.raises(OSError, match="No space"), (small_disk / "ballast").open("wb", buffering=0) as ballast:
        while ballast.write(bytes(2**12)) == 2**12:
            pass
        raise OSError("No space left for a whole page")
    run.end()
    said = [line for line in run.err.splitlines() if not line.startswith("note: the log cannot be written any more")]
    assert run.code == 1 and len(said) == 1 and "No space left on device" in said[0] and said[0].endswith(KEPT), run.err
    (small_disk / "ballast").unlink()
    assert store.find_damage(run.path) == []
    assert "continues" in continued(small_disk, capsys)
    same(run.path, undisturbed)


@pytest.mark.costly
def test_a_folder_that_cannot_be_written(tmp_path, request):
    folder = tmp_path / "outputs"
    if os.getuid():
        folder.mkdir(mode=0o500)
    else:
        # Permissions do not bind root; a file system that is read-only does.
        disk = request.getfixturevalue("small_disk")
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        folder = disk / "outputs"
    run = finished(tmp_path, "cluster=none", f"output.root={folder}")
    # The terminal has it as seen from the current folder.
    _one_line(run, f"output.root = {str(folder.relative_to(tmp_path))!r} is not allowed", "can be written")
    assert run.code == 2


@pytest.mark.costly
def test_a_store_that_cannot_be_written_is_read_by_all_that_only_read(small_disk, tmp_path, capsys):
    root = small_disk / "store"
    root.mkdir()
    traced_store(root / "plane.zarr", small_plan(columns=9, rows=4))
    sizes = ["plane.sweep.num=9", "plane.parameter.num=4", "solver.certify_columns=197", f"store.root={root}"]
    before = {file: file.stat().st_mtime_ns for file in root.rglob("*")}
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    drawn = "figures.formats=[png] figures.dpi=30"
    reading = [f"stages=[figures,margins] margins.point=[0.9,0.1] {drawn}", "debug.row=3", "stages=[check]"]
    for words in [*reading, "stages=[check] check.recompute=1", "stages=[list]"]:
        code, out, err = run_here(tmp_path, capsys, *words.split(), *sizes)
        assert (code, err) == (0, ""), (words, err)
    # Two of them write nothing at all, so that all folders may be as they are.
    for words in ["stages=[check]", "stages=[list]"]:
        assert run_here(tmp_path, capsys, words, *sizes, f"output.root={small_disk}")[::2] == (0, "")
    for words in ["stages=[boundaries]", "stages=[check] check.repair=true"]:
        code, out, err = run_here(tmp_path, capsys, *words.split(), *sizes)
        assert code == 2 and "store.root" in err and err.count("\n") == 1, (words, err)
    assert before == {file: file.stat().st_mtime_ns for file in root.rglob("*")}


@pytest.mark.parametrize("link", ["outputs", "outputs/store", "outputs/store/plane.zarr"])
def test_a_link_that_leads_to_itself_is_one_line(link, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / link).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / link).symlink_to((tmp_path / link).name)
    for stage in ("sweep", "list", "figures"):
        code, _, err = run_here(tmp_path, capsys, f"stages=[{stage}]")
        assert code in (1, 2) and link in err and err.count("\n") == 1
    assert (tmp_path / link).is_symlink()


def test_a_current_folder_that_is_gone_is_one_line(tmp_path, monkeypatch, capsys):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    assert main(["stages=[list]"]) == 2
    assert "current folder" in capsys.readouterr().err


def test_the_home_folder_is_expanded(tmp_path, monkeypatch, undisturbed, capsys):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)
    shutil.copytree(undisturbed, tmp_path / "home/stores/plane.zarr")
    code, out, err = run_here(tmp_path, capsys, "stages=[sweep]", "store.root=~/stores")
    assert (code, err) == (0, "") and "in home/stores/plane.zarr already, nothing to do" in out
    assert [file.name for file in tmp_path.iterdir()] == ["home"]
    code, _, err = run_here(tmp_path, capsys, "stages=[sweep]", "store.root=~no.such.user/stores")
    assert code == 2 and "store.root" in err and err.count("\n") == 1


@pytest.mark.parametrize(
    ("key", "url"),
    [
        *(("output.root", url) for url in ("s3://bucket/store", "file:///stores", "memory://x", "https://host/stores")),
        *(("store.root", url) for url in ("https://host/stores", "simplecache::s3://x", "s3:///x", "file://host/x")),
    ],
)
def test_a_url_is_never_made_as_a_folder(key, url, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for stage in ("sweep", "list"):
        code = main(["plane=omega_fe", "store.name=plane", f"stages=[{stage}]", "cluster=none", f"{key}='{url}'"])
        err = capsys.readouterr().err
        assert code == 2 and key in err and url in err and err.count("\n") == 1
    assert not list(tmp_path.iterdir())


#: Clears the screen, renames the window, turns the direction of reading, begins a line.
STEERING = "\x1b[2J\x1b]0;x\x07\u202e\x9b\n\r"


@pytest.mark.costly
def test_nothing_that_is_stored_steers_the_terminal(tmp_path, undisturbed, capsys):
    path = tmp_path / "outputs/store/plane.zarr"
    shutil.copytree(undisturbed, path)
    lock, said = path.with_name(".plane.zarr.lock"), []

    def run(*words):
        code, out, err = run_here(tmp_path, capsys, *words)
        said.append(out + err)
        return code

    lock.write_text(json.dumps({"host": f"a{STEERING}", "pid": 7, "since": STEERING}))
    assert run("stages=[sweep]") == 0 and "going on" in said[-1]
    lock.write_text(json.dumps({"host": f"a{STEERING}", "pid": 7, "since": STEERING}))
    with lock.open("r+") as held:
        lock_descriptor(held.fileno())
        assert run("stages=[sweep]") == 2 and "is in use by" in said[-1]
    # What is said of a row, the name of a store, the name of a file, and what a store says of itself.
    plan = store.read_plan(path)
    for block, state in ((plan.blocks[3], store.COMPLETE), (plan.blocks[5], store.FAILED)):
        values = store.row_values(plan, f"something{STEERING}")
        values["status"][...] = state
        store.write_block(path, plan, block, [values] * (block.stop - block.start))
    assert run("stages=[sweep]") == 0 and said[-1].count("something") == 3
    shutil.copytree(path, path.with_name(f"a{STEERING}.zarr"))
    assert run("stages=[list]") == 0
    attributes = json.loads((path / "zarr.json").read_text())
    attributes["attributes"]["numbers"] = json.dumps({"plane": STEERING})
    (path / "zarr.json").write_text(json.dumps(attributes))
    assert run("stages=[figures]") in (1, 2)
    (path / f"zarr{STEERING}.json").mkdir()
    (path / f"zarr{STEERING}.json/x").symlink_to(path)
    assert run("stages=[check]") in (1, 2) and run("stages=[figures]") in (1, 2)
    for text in said:
        assert all(letter.isprintable() or letter == "\n" for letter in text), text


@pytest.fixture
def during(monkeypatch, tmp_path, capsys):
    """A run in this process to which something happens when two blocks are stored: status, output and errors."""

    def run(happens):
        honest, written = rows.sweep_block, []

        def sweep_block(*arguments):
            receipt = honest(*arguments)
            written.append(receipt)
            if len(written) == 2:
                happens()
            return receipt

        with monkeypatch.context() as patch:
            patch.setattr(rows, "sweep_block", sweep_block)
            return run_here(tmp_path, capsys, "stages=[sweep]")

    return run


@pytest.mark.costly
def test_a_store_that_turns_unwritable_during_the_run(tmp_path, undisturbed, capsys, during):
    path, made = tmp_path / "outputs/store/plane.zarr", []

    def turn():
        # Not even root writes into a folder with this attribute.
        made.append(subprocess.run(["chattr", "-R", "+i", str(path)], capture_output=True).returncode == 0)

    try:
        code, _, err = during(turn)
    finally:
        subprocess.run(["chattr", "-R", "-f", "-i", str(path)], capture_output=True)
    if made == [False]:
        pytest.skip("no folder can be made unwritable here")
    assert code == 1 and err.count("\n") == 1, err
    assert "Operation not permitted" in err and err.endswith(f"{KEPT}\n")
    assert "continues" in continued(tmp_path, capsys)
    same(path, undisturbed)


@pytest.mark.costly
@pytest.mark.parametrize("gone", ["outputs/store/plane.zarr", pytest.param("outputs", marks=pytest.mark.slow)])
def test_a_store_that_vanishes_during_the_run(tmp_path, undisturbed, gone, capsys, during):
    code, _, err = during(lambda: (tmp_path / gone).rename(tmp_path / "away"))
    said = [line for line in err.splitlines() if not line.startswith("note: the log cannot be written any more")]
    assert code == 1 and len(said) == 1 and said[0].startswith("error: "), err
    shutil.rmtree(tmp_path / "away")
    continued(tmp_path, capsys)
    same(tmp_path / "outputs/store/plane.zarr", undisturbed)


class Listening(io.StringIO):
    """Standard output of which some words make something happen."""

    def __init__(self, words: str, happens):
        super().__init__()
        self.words, self.happens = words, happens

    def write(self, text: str) -> int:
        if self.words in text:
            self.happens()
        return super().write(text)


@pytest.mark.costly
def test_the_second_run_on_a_store_says_who_has_it(tmp_path, capsys, undisturbed, monkeypatch):
    first = start(tmp_path, "cluster=none")
    until(first, 3)
    # It holds the store for as long as this takes, however quick it is.
    first.process.send_signal(signal.SIGSTOP)
    code, _, err = run_here(tmp_path, capsys, "stages=[sweep]")
    assert code == 2 and re.fullmatch(
        rf"error: {re.escape(str(first.path))} is in use by process {first.process.pid} on \S+ since "
        r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00: wait for it, or say store.wait=true\n",
        err,
    ), err
    # The others of a multirun have their turn.
    shutil.copytree(undisturbed, first.path.with_name("other.zarr"))
    code, out, err = run_here(tmp_path, capsys, "-m", "stages=[sweep]", "store.name=plane,other")
    assert code == 1 and len(err.splitlines()) == 1 and "is in use by" in err
    assert "other.zarr already, nothing to do" in out
    heard = Listening(f"is in use by process {first.process.pid}", lambda: first.process.send_signal(signal.SIGCONT))
    with monkeypatch.context() as patch:
        patch.setattr("sys.stdout", heard)
        code, _, err = run_here(tmp_path, capsys, "stages=[sweep]", "store.wait=true")
    assert (code, err) == (0, "") and heard.words in heard.getvalue() and "nothing to do" in heard.getvalue()
    first.end()
    assert (first.code, first.err) == (0, "")
    same(first.path, undisturbed)


@pytest.mark.costly
def test_waiting_for_a_killed_run_goes_on_with_its_work(tmp_path, undisturbed, capsys, monkeypatch):
    first = start(tmp_path, "cluster=none")
    until(first, 3)
    first.process.send_signal(signal.SIGSTOP)
    heard = Listening("waiting", first.process.kill)
    monkeypatch.setattr("sys.stdout", heard)
    code, _, err = run_here(tmp_path, capsys, "stages=[sweep]", "store.wait=true")
    said = heard.getvalue()
    assert (code, err) == (0, "") and "sweep: continues: " in said
    assert f"is in use by process {first.process.pid} on" in said
    first.end()
    same(first.path, undisturbed)


def test_a_lock_that_nobody_holds_is_recognised(tmp_path, undisturbed, capsys):
    path = tmp_path / "outputs/store/plane.zarr"
    shutil.copytree(undisturbed, path)
    lock = path.with_name(".plane.zarr.lock")
    elsewhere = json.dumps({"host": "elsewhere", "pid": 7, "since": "2020-01-01T00:00:00+00:00"})
    for text in (elsewhere, "[" * 10_000, '{"pid": "x"}'):
        lock.write_text(text)
        code, out, err = run_here(tmp_path, capsys, "stages=[sweep]")
        assert (code, err) == (0, "") and f"ended without letting go of {path}, going on" in out and not lock.exists()
    assert "store: another process ended" in out
    with lock.open("w") as held:
        lock_descriptor(held.fileno())
        code, _, err = run_here(tmp_path, capsys, "stages=[sweep]")
    assert code == 2 and "is in use by another process" in err


@pytest.mark.costly
@pytest.mark.parametrize("cluster", ["cluster=none", pytest.param("cluster.workers=1", marks=pytest.mark.slow)])
def test_clocks_and_time_zones_change_nothing(cluster, tmp_path, undisturbed):
    environment = {"PYTHONPATH": str(INJECTED), "BEVELMAP_TEST_FAULT": "clock", "TZ": "Pacific/Kiritimati"}
    run = finished(tmp_path, cluster, environment=environment)
    assert (run.code, run.err) == (0, ""), run.err
    same(run.path, undisturbed)
    said, told = (json.loads((path / "zarr.json").read_text())["attributes"] for path in (run.path, undisturbed))
    differing = {key for key in said if said[key] != told[key]}
    assert differing <= {"created", "digest", "configuration"} and said["created"].endswith("+00:00")
    assert said["configuration_hash"] == told["configuration_hash"] and COMMAND


def test_two_runs_at_the_same_moment_keep_both_logs(tmp_path, monkeypatch):
    from datetime import datetime

    from pipeline.config.compose import compose
    from pipeline.run import job
    from pipeline.run.progress import Reporter

    class Stopped(datetime):
        @classmethod
        def now(cls, tz=None):
            return datetime(2026, 1, 1, tzinfo=tz)

    monkeypatch.setattr(job, "datetime", Stopped)
    settings, logs = compose([f"output.root={tmp_path}"]), []
    for _ in range(3):
        reporter = Reporter()
        job.open_log(job.Job(settings, None), reporter)
        logs.append(reporter.log)
    assert len(set(logs)) == 3 and all(log.is_file() for log in logs)
