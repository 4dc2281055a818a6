"""Help, lists of stores, diaries of rows, logs and completion: what a newcomer meets."""

import csv
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import zarr

from pipeline import store
from pipeline.__main__ import main
from pipeline.cli.arguments import parse
from pipeline.cli.completion import SHELLS, candidates, script
from pipeline.cli.help import usage
from pipeline.config.compose import compose, conf_folder
from pipeline.errors import ConfigurationError
from pipeline.plan.numerics import balance_of, continuation_of, row_of, seeds_of
from pipeline.run.progress import Reporter
from pipeline.run.trace_log import row_trace
from pipeline.stages import STAGES
from pipeline.store import listing as listings
from solver import Event
from tests.pipeline.planes import contents, retold, small_plan, small_store

SMALL = ["plane=omega_fe", "plane.sweep.num=41", "plane.parameter.num=5"]


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A folder with one complete store under its usual name."""
    folder = tmp_path_factory.mktemp("comfort")
    (folder / "outputs/store").mkdir(parents=True)
    small_store(folder / "outputs/store/omega_fe.zarr", small_plan("plane=omega_fe"))
    return folder


@pytest.fixture
def folder(kept, tmp_path, monkeypatch):
    """A copy of it to work in."""
    shutil.copytree(kept, tmp_path / "here")
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "here"


# Help


def test_help_names_every_choice_and_stage_whole():
    text = usage()
    assert max(map(len, text.splitlines())) <= 100
    assert not re.search(r"\.\.\.$", text, re.MULTILINE)
    unfolded = re.sub(r"\n {20,}", " ", text)
    for entry in STAGES:
        assert entry.load().name == entry.name
        assert re.search(rf"^    {entry.name}\b +{re.escape(entry.sentence)}$", unfolded, re.MULTILINE), entry
    for file in conf_folder().glob("*/*.yaml"):
        assert re.search(rf"^  [* ] {file.stem}\b +\S", text, re.MULTILINE), file
    marked = re.findall(r"^  \* (\w+)", text, re.MULTILINE)
    assert sorted(marked) == sorted(["omega_fe", "published", "paper", "first_order", "local"])


def test_every_override_and_example_of_the_help_composes():
    text = usage()
    keys = re.search(r"overrides that people need.*?\n(.*?)\n\n", text, re.DOTALL)[1].splitlines()
    assert len(keys) == 10
    for line in keys:
        compose([line.split()[0]])
    examples = re.findall(r"^  python -m pipeline (.*?)(?:  .*)?$", text, re.MULTILINE)
    assert len(examples) == 3
    for example in examples:
        compose(example.split())


def test_a_new_file_appears_by_itself(tmp_path, capsys):
    (tmp_path / "plane").mkdir()
    (tmp_path / "plane/mine.yaml").write_text("# What I want\n# to know. Not more.\ndefaults: [omega_fe, _self_]\n")
    assert main(["--config-dir", str(tmp_path), "--help"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"^    mine +What I want to know$", said, re.MULTILINE)


def test_help_loads_neither_solver_nor_dask(tmp_path):
    code = (
        "import sys; from pipeline.__main__ import main; main(['--help']);"
        "print([name for name in ('solver', 'numba', 'dask', 'zarr', 'hydra', 'numpy') if name in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=here()).stdout
    assert said.splitlines()[-1] == "[]"


@pytest.mark.parametrize(("argument", "status"), [("--help", 0), ("--nonsense", 2)])
def test_a_run_ends_with_its_status_after_what_is_to_be_done_at_exit(argument, status):
    code = (
        "import atexit, runpy, sys, pipeline.cli.arguments as arguments\n"
        "parse = arguments.parse\n"
        "arguments.parse = lambda words: (atexit.register(print, 'tidied'), parse(words))[1]\n"
        f"sys.argv = ['bevelmap', {argument!r}]\n"
        "runpy.run_module('pipeline', run_name='__main__', alter_sys=True)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=here())
    assert done.returncode == status
    assert done.stdout.endswith("tidied\n")


@pytest.mark.parametrize(
    "wrong", [["--config-dir"], ["--nonsense"], ["--shell-completion", "ksh"], ["--shell-completion"]]
)
def test_wrong_options_are_one_line(wrong, capsys):
    assert main(wrong) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_options_are_read():
    asked = parse(["-m", "--config-dir=x", "gear.b=1", "--cfg"])
    assert (asked.multirun, asked.config_dir, asked.overrides, asked.show) == (True, "x", ("gear.b=1",), True)
    assert parse(["--complete", "bevelmap", "-m", ""]).complete == ("bevelmap", "-m", "")


# stages=[list]


@pytest.mark.costly
def test_list_says_what_there_is(folder, capsys):
    root = folder / "outputs/store"
    half, failed = (shutil.copytree(root / "omega_fe.zarr", root / f"{name}.zarr") for name in ("half", "failed"))
    zarr.open_group(half, mode="r+")["status"][3:] = store.PENDING
    zarr.open_group(failed, mode="r+")["status"][1] = store.FAILED
    damaged = shutil.copytree(root / "omega_fe.zarr", root / "damaged.zarr")
    (damaged / "zarr.json").write_text("{")
    lost = shutil.copytree(root / "omega_fe.zarr", root / "lost.zarr")
    (lost / "zarr.json").write_text("{")
    (lost / "branches/zarr.json").unlink()
    newer = shutil.copytree(root / "omega_fe.zarr", root / "newer.zarr")
    retold(newer, bevelmap_schema=99)
    other = ("plane=omega_b", "gear=antiphase", "gear.f_e=0.3", "solver=hb", "solver.order=3", "solver.period=2")
    small_store(root / "other.zarr", small_plan(*other), blocks=[])
    (root / "holiday").mkdir()
    (root / ".draft").mkdir()
    assert main(["stages=[list]"]) == 0
    said = capsys.readouterr().out
    lines = {line.split()[0]: line for line in said.splitlines()}
    assert all(text in lines["omega_fe"] for text in ("omega 41 x f_e 5", "published", "first order", "complete", "kB"))
    assert "3 of 5 rows" in lines["half"] and "1 row failed" in lines["failed"]
    assert "damaged" in lines["damaged"] and "damaged metadata" in lines["lost"]
    assert "schema 99, this program reads" in lines["newer"]
    assert all(text in lines["other"] for text in ("antiphase f_e=0.3", "hb order 3 period 2", "0 of 5 rows"))
    assert "no stores of this program: holiday\n" in said and "draft" not in said
    assert "7 stores in" in said
    # Columns stand under their titles.
    start = lines["store"].index("status")
    assert lines["omega_fe"][start:].startswith("complete") and lines["half"][start:].startswith("3 of 5")


@pytest.mark.costly
def test_list_knows_groups_size_hash_and_age(folder):
    from pipeline.analysis import boundaries

    path = folder / "outputs/store/omega_fe.zarr"
    planned = store.read_plan(path)
    boundaries.trace(path, planned)
    (entry,) = listings.listing(path.parent).entries
    assert entry.groups == ("boundaries",) and entry.digest == planned.fingerprint
    assert entry.size == sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
    assert 0.0 <= entry.age < 3600.0


def test_list_of_nothing_says_so_and_writes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["stages=[list]"]) == 0
    assert "list: no stores in" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


def test_list_on_a_terminal_is_a_table_that_obeys_no_name(folder, capsys):
    root = folder / "outputs/store"
    (root / "omega_fe.zarr").rename(root / "[red]\x1b[2Jname.zarr")
    from pipeline.run.job import Job
    from pipeline.run.listing import _run

    class Terminal(Reporter):
        on_terminal = True

    assert _run(Job(compose(["stages=[list]"]), None), None, Terminal()) == 0
    said = capsys.readouterr().out
    assert "[red]\\x1b[2J" in said and "\x1b[2J" not in said


@pytest.mark.parametrize("room", [None, 200, 90, 60, 1])
def test_a_narrow_list_leaves_whole_columns_out(room):
    entries = [
        listings.Entry("omega_fe-b=0.5", "omega 400 x f_e 200", "miter", "first order", state, 10**7, 16 * "a", 5.0, ())
        for state in ("complete", "3 of 200 rows")
    ]
    lines = listings.columns(listings.Listing(tuple(entries), ()), room)
    titles = lines[0].split()
    assert titles == [title for title in listings.TITLES if title in titles] and {"store", "status"} <= set(titles)
    assert all(
        line.startswith("omega_fe-b=0.5") and entry.status in line
        for line, entry in zip(lines[1:], entries, strict=True)
    )
    if room is None or room == 200:
        assert len(titles) == len(listings.TITLES)
    else:
        assert "hash" not in titles and (room == 1 or max(map(len, lines)) <= room)


# debug.row


def test_the_diary_of_a_row_is_that_of_the_stored_row(folder, capsys):
    before = contents(folder / "outputs/store/omega_fe.zarr")
    assert main([*SMALL, "debug.row=1"]) == 0
    said = capsys.readouterr().out
    where = folder / "outputs/debug/omega_fe"
    assert "row-1.txt, row-1.csv in outputs/debug/omega_fe" in said
    assert sorted(path.name for path in (folder / "outputs").iterdir()) == ["debug", "store"]
    text = (where / "row-1.txt").read_text()
    assert "complete in the store" in text and "trace 0: seed at parameter" in text and "left the range" in text
    stored = {name: before[f"branches/{name}"][1] for name in ("omega", "mean", "cos", "sin", "event", "n_points")}
    rows = list(csv.DictReader((where / "row-1.csv").read_text().splitlines()))
    accepted = [row for row in rows if row["outcome"] == "accepted"]
    # Every accepted step is a stored point, to the last digit, and every fold and grazing stands beside its step.
    for name in ("mean", "cos", "sin"):
        assert {float(row[name]) for row in accepted} <= set(stored[name])
    located = " ".join(row["events"] for row in rows).split()
    kinds = stored["event"][: stored["n_points"]]
    assert len(located) == np.sum((kinds > Event.NONE) & (kinds < Event.PERIOD_DOUBLING)) > 0
    assert all("refused: The tangent turned" in text for row in rows if row["outcome"] == "turned")
    for name, values in contents(folder / "outputs/store/omega_fe.zarr").items():
        np.testing.assert_array_equal(values, before[name])


def test_a_diary_needs_no_store_and_shows_where_branches_break_off(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    broken = "solver.smallest_step=0.02", "solver.first_step=0.05", "gear=antiphase"
    assert main([*SMALL, "debug.row=2", *broken]) == 0
    text = (tmp_path / "outputs/debug/omega_fe-antiphase-first_step=0.05-smallest_step=0.02/row-2.txt").read_text()
    plan = small_plan("plane=omega_fe", *broken)
    row = row_of(
        plan,
        float(plan.parameter.values[2]),
        balance_of(plan.solver),
        continuation_of(plan.solver),
        seeds_of(plan.solver),
    )
    assert row.notes and all(note in text for note in row.notes) and "there is no store yet" in text
    assert "The corrector refused every step" in text and "branch 0" in text


def test_a_diary_shows_why_a_row_fails(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "debug.row=1", "gear.f_pm=0.0"]) == 0
    text = (tmp_path / "outputs/debug/omega_fe-f_pm=0/row-1.txt").read_text()
    assert "the row fails: " in text and "continuum" in text


def test_the_diary_is_of_the_very_row(folder):
    path = folder / "outputs/store/omega_fe.zarr"
    planned = store.read_plan(path)
    found = row_trace(path, planned, 2)
    row = row_of(
        planned, found.value, balance_of(planned.solver), continuation_of(planned.solver), seeds_of(planned.solver)
    )
    np.testing.assert_array_equal(found.result.motions, row.motions)


@pytest.mark.parametrize("row", ["5", "-1", "1.5", "x"])
def test_bad_row_numbers_are_one_line(row, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, f"debug.row={row}"]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1 and "debug.row" in said
    assert list(tmp_path.iterdir()) == []


def test_stage_debug_without_a_row_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[debug]"]) == 2
    assert "debug.row = null is not allowed" in capsys.readouterr().err


# Logs


def test_every_batch_has_a_line_in_the_log_and_none_on_the_terminal(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SMALL, "stages=[sweep]", "cluster=none", "solver.certify=none"]) == 0
    assert "info batch" not in capsys.readouterr().out
    (log,) = tmp_path.glob("outputs/runs/*/*/run.log")
    lines = re.findall(
        r"^\S+ info batch: (\d+) rows \((.*)\) in [\d.]+ s on this machine, (\d+) points, 0 failed$",
        log.read_text(),
        re.MULTILINE,
    )
    assert sum(int(rows) for rows, _, _ in lines) == 5
    stored = contents(tmp_path / "outputs/store/omega_fe-certify=none.zarr")["branches/n_points"]
    assert sum(int(points) for _, _, points in lines) == stored.sum()


# Completion


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["bevelmap", "plane=omega_x"], ["plane=omega_xi", "plane=omega_xi_support"]),
        (["python", "-m", "pipeline", "qual"], ["quality.", "quality="]),
        (["python3", "-m", "pipeline", "-m", "plane=omega_b,omega_al"], ["plane=omega_b,omega_alpha"]),
        (["bevelmap", "quality=draft", "solver.corr"], ["solver.corrector="]),
        (
            ["bevelmap", "gear=miter", "gear.physical.tor"],
            ["gear.physical.torque=", "gear.physical.torque_fluctuation="],
        ),
        (["bevelmap", "gear.phys"], ["gear.physical="]),
        (["bevelmap", "stages"], ["stages="]),
        (["bevelmap", "stages=[sweep,b"], ["stages=[sweep,boundaries"]),
        (["bevelmap", "--sh"], ["--shell-completion"]),
        (["bevelmap", "gear=nonsense", "clu"], ["cluster="]),
        (["bevelmap", "hyd"], []),
        (["bevelmap", "no_such"], []),
    ],
)
def test_completion(words, expected):
    assert candidates(tuple(words)) == expected


def test_completion_offers_everything_at_first_and_no_members_of_lists():
    found = candidates(("bevelmap", ""))
    groups = {"plane=", "gear=", "quality=", "solver=", "cluster="}
    assert groups | {"stages=", "store.", "figures.", "debug."} <= set(found)
    assert not [one for one in found if one.startswith("hydra")]
    gears = sorted((conf_folder() / "gear").glob("*.yaml"))
    assert candidates(("bevelmap", "gear=")) == [f"gear={path.stem}" for path in gears]


def test_completion_knows_a_folder_of_ones_own(tmp_path):
    (tmp_path / "plane").mkdir()
    (tmp_path / "plane/mine.yaml").write_text("defaults: [omega_fe, _self_]\n")
    assert candidates(("bevelmap", "--config-dir", str(tmp_path), "plane=m")) == ["plane=mine"]


def test_the_printed_scripts_call_this_program():
    for shell in SHELLS:
        text = script(shell)
        assert f"{sys.executable} -m pipeline --complete" in text and "COMMAND" not in text
    with pytest.raises(ConfigurationError):
        script("ksh")


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("bevelmap plane=omega_fp", ["omega_fpm"]),
        ("python -m pipeline cluster.add", ["cluster.address="]),
        ("python elsewhere.py plane=omega_fp", []),
        ("bevelmap quality=draft cluster=", ["local", "none", "scheduler", "slurm"]),
    ],
)
def test_completion_in_a_real_bash(line, expected):
    program = (
        f'eval "$({sys.executable} -m pipeline --shell-completion bash)"\n'
        f'COMP_LINE={line!r} COMP_POINT={len(line)}\n_bevelmap\nprintf "%s\\n" "${{COMPREPLY[@]}}"\n'
    )
    result = subprocess.run(["bash", "--norc", "-c", program], capture_output=True, text=True, env=here(), check=True)
    assert result.stderr == "" and result.stdout.split() == expected


def here() -> dict[str, str]:
    """An environment in which this checkout is what runs."""
    return {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
