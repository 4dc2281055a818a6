"""Power is lost: what was not yet on the disk is empty, cut or gone; the same command goes on, and takes none of it.

The losses follow from what a run has asked the disk for by `fsync`: of any other file only the name may be left.
"""

import os
import shutil
from pathlib import Path

import pytest

from pipeline import store
from pipeline.__main__ import main
from tests.pipeline.faults.runs import COMMAND, ROWS, complete, continued, same
from tests.pipeline.faults.test_damage import run as run_here

#: What becomes of a file that is not on the disk.
LOSSES = {
    "empty": lambda file: file.write_bytes(b""),
    "cut": lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2]),
    "gone": Path.unlink,
}


class Disk:
    """Watches what a run in this process has on the disk, and keeps what a power loss would have left at times.

    Parameters
    ----------
    folder : Path
        Of the run.
    moments : range
        Calls of `fsync` before which the power is lost.
    kept : Path
        Folder for what is left.
    """

    def __init__(self, folder: Path, moments: range, kept: Path):
        self.folder, self.moments, self.kept = folder, moments, kept
        self.calls, self.safe, self.left, self.lost = 0, {}, [], 0
        self._fsync = os.fsync

    def fsync(self, descriptor: int) -> None:
        """In place of `os.fsync`."""
        if self.calls in self.moments:
            self._lose()
        self.calls += 1
        self._fsync(descriptor)
        status = os.fstat(descriptor)
        self.safe[status.st_ino] = status.st_mtime_ns

    def _lose(self) -> None:
        for name, loss in LOSSES.items():
            left = self.kept / f"{name}-{self.calls}"
            # What threads have half written is not there any more when it is copied.
            shutil.copytree(self.folder, left, ignore=shutil.ignore_patterns("*.partial"))
            for file in (file for file in left.rglob("*") if file.is_file()):
                status = (self.folder / file.relative_to(left)).stat()
                if self.safe.get(status.st_ino) != status.st_mtime_ns:
                    loss(file)
                    self.lost += 1
            self.left.append(left)


@pytest.fixture(scope="module")
def losses(tmp_path_factory):
    """Folders of runs as power losses have left them, all over a sweep."""
    folder, kept = tmp_path_factory.mktemp("run"), tmp_path_factory.mktemp("left")
    disk = Disk(folder / "outputs/store", range(5, 10**6, 41), kept)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", disk.fsync)
        # One after the other, so that a moment is one.
        patch.setattr("pipeline.store.durable._TOGETHER", 1)
        assert main([*COMMAND, "cluster=none", f"output.root={folder / 'outputs'}"]) == 0
    assert disk.lost > 10 and len(disk.left) > 20
    return disk.left


@pytest.mark.costly
@pytest.mark.parametrize("step", [8, pytest.param(2, marks=pytest.mark.slow)])
def test_a_run_whose_power_was_lost_goes_on(step, losses, tmp_path, undisturbed, capsys):
    rows = set()
    # Each kind of loss at early and late moments.
    for number, left in enumerate(losses[::step]):
        shutil.copytree(left, tmp_path / f"{number}/outputs/store")
        path = tmp_path / f"{number}/outputs/store/plane.zarr"
        rows.add(complete(path) if path.exists() else 0)
        continued(tmp_path / str(number), capsys)
        same(path, undisturbed)
        assert store.find_damage(path) == []
    assert len(rows) > 2 and max(rows) > ROWS // 2


@pytest.mark.parametrize("harm", ["empty", "gone"])
def test_a_complete_row_without_its_numbers_is_not_taken_as_done(harm, tmp_path, undisturbed, capsys):
    """As a disk may leave it that says it has what it has not."""
    path = tmp_path / "outputs/store/plane.zarr"
    shutil.copytree(undisturbed, path)
    LOSSES[harm](path / "mean/c/3/0/0")
    code, _, err = run_here(tmp_path, capsys, "stages=[sweep]")
    assert code == 1 and "mean/c/3/0/0 is " in err and err.count("\n") == 1
    assert run_here(tmp_path, capsys, "stages=[check]", "check.repair=true")[0] == 0
    same(path, undisturbed)


@pytest.mark.costly
def test_no_status_says_complete_before_its_rows_are_on_the_disk(losses):
    """By what is left alone: whatever is complete can be read whole."""
    seen = 0
    for path in (left / "plane.zarr" for left in losses):
        if not (path / "zarr.json").exists():
            continue
        plan = store.read_layout(path, going_on=True).plan
        for block in plan.blocks:
            seen += len(store.kept_rows(path, plan, block))
    assert seen > 5 * ROWS
