"""The cache of compiled kernels: damaged, on a full disk, in a folder that others can write. A run does without it."""

import shutil
import subprocess

import pytest

from pipeline.run.kernels import kernels_for
from solver.kernels import backend
from solver.kernels.store import KernelStore, kernel_store
from solver.kernels.warm import kernels_of, warm
from tests.pipeline.faults.runs import finished, same, start

#: Kernels of rows that take a second to compile.
SMALL = ("correctors._newton", "describing_function.residual_and_jacobian", "describing_function.test_functions")


@pytest.fixture
def cache(tmp_path):
    """A copy of the entries that a run reads, in a folder of the test's own."""
    kernels = kernels_of(kernels_for(["sweep", "boundaries"], "describing_function"))
    warm(kernels)
    folder = tmp_path / "cache/bevelmap"
    folder.mkdir(mode=0o700, parents=True)
    for name in {name for kernel in kernels for name in backend.entries_of(kernel)}:
        shutil.copy(kernel_store().folder / name, folder)
    return folder


def _small(folder):
    found = [entry for entry in folder.iterdir() if any(f".{name}-" in entry.name for name in SMALL)]
    assert len(found) >= len(SMALL)
    return sorted(found)


@pytest.mark.costly
def test_damaged_entries_are_compiled_again(cache, tmp_path, undisturbed):
    harms = [lambda data: b"", lambda data: data[: len(data) // 2], lambda data: data[:-9] + b"\xff" + data[-8:]]
    for i, entry in enumerate(_small(cache)):
        entry.write_bytes(harms[i % len(harms)](entry.read_bytes()))
    run = finished(tmp_path / "run", "cluster=none", environment={"NUMBA_CACHE_DIR": str(cache.parent)})
    assert (run.code, run.err) == (0, ""), run.err
    same(run.path, undisturbed)
    # Those that the run needed are sound again; the others belong to other versions of the sources.
    needed = {entry.name for entry in _small(kernel_store().folder)} & {entry.name for entry in _small(cache)}
    sound = [name for name in needed if (cache / name).read_bytes().startswith(KernelStore._HEAD)]
    assert len(sound) >= len(SMALL)


@pytest.mark.slow
def test_a_full_cache_disk_is_one_line(cache, tmp_path, undisturbed):
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=64m,mode=700", "tmpfs", str(disk)]
    made = subprocess.run(mount, capture_output=True, text=True)
    if made.returncode:
        pytest.skip(f"no file system can be mounted here: {made.stderr.strip()}")
    try:
        for entry in _small(cache):
            entry.unlink()
        shutil.copytree(cache, disk / "bevelmap", copy_function=shutil.copy)
        (disk / "bevelmap").chmod(0o700)
        with pytest.raises(OSError, match="No space"), (disk / "ballast").open("wb", buffering=0) as ballast:
            while ballast.write(bytes(2**12)) == 2**12:
                pass
            raise OSError("No space left for a whole page")
        run = finished(tmp_path / "run", "cluster=none", environment={"NUMBA_CACHE_DIR": str(disk)})
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=True)
    assert run.code == 0 and len(run.err.splitlines()) == 1, run.err
    assert run.err.startswith("note: compiled kernels are kept for this run only: ") and "No space left" in run.err
    same(run.path, undisturbed)


@pytest.mark.slow
def test_a_cache_folder_that_others_can_write_is_not_used(cache, tmp_path, undisturbed):
    cache.chmod(0o777)
    environment = {"NUMBA_CACHE_DIR": str(cache.parent), "TMPDIR": str(tmp_path)}
    before = {entry.name: entry.stat().st_mtime_ns for entry in cache.iterdir()}
    run = start(tmp_path / "run", "cluster=local", "cluster.workers=2", environment=environment).end(1200.0)
    assert run.code == 0 and len(run.err.splitlines()) == 1, run.err
    assert run.err.startswith(f"note: compiled kernels are kept for this run only: {cache} can be written by other")
    same(run.path, undisturbed)
    assert before == {entry.name: entry.stat().st_mtime_ns for entry in cache.iterdir()}
    assert list(tmp_path.glob("bevelmap-*")) == []
