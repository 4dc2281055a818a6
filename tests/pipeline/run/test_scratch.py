"""Folders of runs in the temporary folder: those of runs that were killed go with the next run, all others stay."""

import os
import signal
import subprocess
import sys
import tempfile

import pytest

from pipeline.run.scratch import scratch_folder
from tests.pipeline.schedulers import ROOT

_RUN = (
    "import sys\nfrom pipeline.run.scratch import scratch_folder\n"
    "with scratch_folder() as folder:\n    (folder / 'deep').mkdir()\n    print(folder, flush=True)\n"
    "    sys.stdin.read()\n"
)


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """The temporary folder of this process and of those that it starts."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    return tmp_path


def _start() -> subprocess.Popen:
    streams = dict(stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    return subprocess.Popen([sys.executable, "-c", _RUN], cwd=ROOT, **streams)


def test_a_folder_is_private_and_goes_in_the_end(temporary):
    with scratch_folder() as folder:
        assert folder.parent == temporary and folder.stat().st_mode & 0o077 == 0
        (folder / "deep").mkdir()
        # It is not taken for one that was left behind.
        with scratch_folder() as other:
            assert folder.exists() and other != folder
    assert list(temporary.iterdir()) == []


def test_what_a_killed_run_left_behind_goes_with_the_next_run_and_nothing_else(temporary):
    killed, lives = _start(), _start()
    left, held = (temporary / run.stdout.readline().strip() for run in (killed, lives))
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    foreign = temporary / "bevelmap-run-of-somebody"
    foreign.mkdir()
    (foreign / "thesis.tex").write_text("mine")
    (temporary / "bevelmap-run-link").symlink_to(foreign)
    assert left.exists() and held.exists()
    with scratch_folder():
        assert not left.exists() and held.exists()
    lives.communicate("")
    assert {path.name for path in temporary.iterdir()} == {foreign.name, "bevelmap-run-link"}
    assert (foreign / "thesis.tex").exists()


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="there are no owners")
def test_a_folder_of_another_user_stays(temporary, monkeypatch):
    with scratch_folder() as folder:
        name = folder
    name.mkdir()
    (name / "held").touch()
    monkeypatch.setattr(os, "getuid", lambda: name.stat().st_uid + 1)
    with scratch_folder():
        pass
    assert name.exists()
    monkeypatch.undo()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    with scratch_folder():
        assert not name.exists()
