"""Settings of jobs: what is allowed, and one line with exit status 2 for the rest; SLURM is not needed."""

import importlib.util
import shutil
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.__main__ import main
from pipeline.config.compose import compose
from pipeline.errors import ConfigurationError
from pipeline.run.cluster_settings import check_cluster, jobs_of
from tests.pipeline.schedulers import ROOT


@pytest.fixture
def commands(monkeypatch):
    """The commands of SLURM are on the PATH, but those that a test takes away."""
    missing, which = set(), shutil.which
    ours = ("sbatch", "squeue", "scancel")
    monkeypatch.setattr(
        "pipeline.run.slurm_settings.shutil.which",
        lambda name: (None if name in missing else f"/usr/bin/{name}") if name in ours else which(name),
    )
    return missing


def settings(*overrides):
    return compose(["cluster=slurm", *overrides]).config.cluster


def test_settings_are_as_sbatch_and_dask_take_them(commands, tmp_path):
    found = jobs_of(settings("cluster.cores=8", "cluster.walltime=1-02:03:04", f"cluster.folder={tmp_path}"))
    assert (found.memory, found.walltime, found.folder) == (16_000_000_000, "1-02:03:04", tmp_path)
    assert found.lifetime == 86400 + 2 * 3600 + 3 * 60 + 4 - 300
    # Workers have time to leave, and to do something before.
    assert jobs_of(settings("cluster.walltime=1")).lifetime == 45
    assert jobs_of(settings("cluster.cores=8", "cluster.memory=32GB")).memory == 32_000_000_000
    check_cluster(settings("cluster.queue=long-one.2", "cluster.account=gears", "cluster.host=login1.example.org"))


@given(st.integers(60, 366 * 86400))
def test_every_wall_time_is_read_as_it_is_written(seconds):
    from pipeline.run.slurm_settings import _seconds

    days, rest = divmod(seconds, 86400)
    assert _seconds(f"{days}-{rest // 3600}:{rest // 60 % 60:02}:{rest % 60:02}") == seconds
    assert _seconds(f"{seconds // 3600}:{seconds // 60 % 60}:{seconds % 60}") == seconds
    assert _seconds(f"{seconds // 60}:{seconds % 60}") == seconds


REFUSED = [
    ("cores", "0"),
    ("cores", "null"),
    ("cores", "many"),
    ("memory", "1GB"),
    ("memory", "much"),
    ("walltime", "0:30"),
    ("walltime", "soon"),
    ("walltime", "400-0"),
    ("walltime", "null"),
    ("minimum_jobs", "-1"),
    ("minimum_jobs", "11"),
    ("maximum_jobs", "0"),
    ("maximum_jobs", "100000"),
    ("queue", "'a b'"),
    ("account", "'a;b'"),
    ("host", "'a b'"),
    ("directives", "[constraint]"),
    ("directives", "--exclusive"),
    ("folder", "'with a space'"),
    ("folder", "s3://bucket/jobs"),
    ("folder", "null"),
]


@pytest.mark.parametrize(("key", "value"), REFUSED)
def test_a_value_that_is_not_allowed_is_one_line(key, value, commands, tmp_path, capsys):
    words = [f"output.root={tmp_path / 'outputs'}", "cluster=slurm", f"cluster.{key}={value}"]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ") and said.count("\n") == 1 and f"cluster.{key}" in said, said
    assert not (tmp_path / "outputs").exists()


def test_settings_of_jobs_are_of_no_other_cluster():
    with pytest.raises(ConfigurationError, match=r"cluster\.queue is not allowed here: .*cluster=slurm"):
        compose(["cluster.queue=compute"])


@pytest.mark.parametrize("command", ["sbatch", "squeue", "scancel"])
def test_a_machine_without_slurm_is_one_line(command, commands):
    commands.add(command)
    with pytest.raises(ConfigurationError, match=rf"cluster = slurm is not allowed here: there is no {command}"):
        check_cluster(settings())


def test_without_dask_jobqueue_the_extra_is_named(commands, monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        "pipeline.run.slurm_settings.importlib.util.find_spec",
        lambda name: None if name == "dask_jobqueue" else find(name),
    )
    with pytest.raises(ConfigurationError, match=r"pip install 'bevelmap\[slurm\]'"):
        check_cluster(settings())


_INTERRUPTED = """
import signal, threading
signal.signal(signal.SIGINT, handler := lambda *_: None)
def load():
    import pipeline.run.jobqueue
    print("loaded")
thread = threading.Thread(target=load)
thread.start()
thread.join()
print(signal.getsignal(signal.SIGINT) is handler)
"""


def test_dask_jobqueue_loads_in_any_thread_and_leaves_interrupts_to_the_run():
    done = subprocess.run([sys.executable, "-c", _INTERRUPTED], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout == "loaded\nTrue\n"
