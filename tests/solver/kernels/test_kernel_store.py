"""Compiled kernels on disk: whose folder is believed, and what becomes of entries that were damaged or planted."""

import json
import os
import pickle
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from solver.kernels.store import KernelStore, why_distrusted
from tests.conftest import slow_but
from tests.made_once import made_once

NOBODY = 65534
ROOT = Path(__file__).parents[3]
BY_ROOT = pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files to other users")

#: A module with kernels that take a few hundredths of a second, and a list of those that had to be compiled.
CHEAP = f"""
import sys
sys.path.insert(0, {str(ROOT)!r})
from solver.kernels import backend, types
from solver.kernels.compile import ARRAY, kernel
from solver.kernels.store import kernel_store

names, compiled = [], backend._compiled

def listed(kernel, *others):
    names.append(kernel.__name__)
    return compiled(kernel, *others)

backend._compiled = listed

def made():
    "Make the kernels and use them; names of those that had to be compiled."
    names.clear()
    @kernel(types.float64(types.float64, types.float64))
    def hypotenuse(a, b):
        return (a * a + b * b) ** 0.5
    @kernel(types.int64(types.int64))
    def cube(n):
        return n * n * n
    assert (hypotenuse(3.0, 4.0), cube(7)) == (5.0, 343)
    return list(names)
"""
BOTH = ["hypotenuse", "cube"]


class Cheap:
    """Processes that use the cheap kernels, with a cache of their own."""

    def __init__(self, folder: Path):
        self.home = folder / "home"
        self.temporary = folder / "temporary"
        self.temporary.mkdir()
        (folder / "cheap.py").write_text(CHEAP)
        self.folder = folder

    def run(self, body: str = "print(json.dumps(made()))", home: Path | None = None, **options):
        """What a process printed, read as JSON, and the lines that it wrote to standard error."""
        environment = {
            **os.environ,
            "NUMBA_CACHE_DIR": str(home or self.home),
            "TMPDIR": str(self.temporary),
            "PYTHONPATH": str(self.folder),
        }
        code = f"import json\nfrom cheap import *\n{body}"
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, env=environment, timeout=300, **options
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout), done.stderr.splitlines()

    def fill(self) -> None:
        """Put into the cache what a first run leaves there."""
        shutil.copytree(made_once("cheap-kernels", _first_run) / "home", self.home)

    @property
    def entries(self) -> list[Path]:
        found = sorted((self.home / "bevelmap").iterdir())
        assert all(entry.suffix == ".kernel" for entry in found)
        return found


def _first_run(folder: Path) -> None:
    assert Cheap(folder).run() == (BOTH, [])


@pytest.fixture
def cheap(tmp_path):
    return Cheap(tmp_path)


@pytest.fixture
def filled(cheap):
    """With the entries of a first run."""
    cheap.fill()
    return cheap


@pytest.mark.costly
def test_entries_are_found_again_and_nobody_else_can_read_them(cheap):
    assert cheap.run() == (BOTH, [])
    assert cheap.run() == ([], [])
    assert len(cheap.entries) == 2
    assert stat.S_IMODE((cheap.home / "bevelmap").stat().st_mode) == 0o700


@pytest.mark.costly
@pytest.mark.parametrize("count", [12, pytest.param(150, marks=pytest.mark.slow)])
def test_every_damaged_bit_is_noticed(count, filled):
    """Random single bits of real entries; the checksum is compared before anything is unpickled."""
    flips = """
import pickle, random
store, random = kernel_store(), random.Random(1)
entries = {path.name: path.read_bytes() for path in store.folder.iterdir()}
unpickled, loads = [], pickle.loads
pickle.loads = lambda data: unpickled.append(1) or loads(data)
outcomes = []
for _ in range(count):
    name = random.choice(sorted(entries))
    damaged = bytearray(entries[name])
    # Anywhere, in the head, or at the end.
    places = [random.randrange(len(damaged)), random.randrange(80), len(damaged) - 1 - random.randrange(80)]
    place = random.choice(places)
    damaged[place] ^= 1 << random.randrange(8)
    (store.folder / name).write_bytes(damaged)
    unpickled.clear()
    outcomes.append([made(), name.split("-")[0].split(".")[1], len(unpickled)])
    outcomes[-1].append(sorted(path.name for path in store.folder.iterdir()) == sorted(entries))
    assert store.read(name) is not None
print(json.dumps(outcomes))
"""
    outcomes, said = filled.run(f"count = {count}\n{flips}")
    assert len(outcomes) == count and said == []
    for compiled, name, unpickled, complete in outcomes:
        # The damaged one is compiled again and kept again; only the other one is read.
        assert compiled == [name] and unpickled == 1 and complete
    assert filled.run() == ([], [])


@pytest.mark.costly
def test_an_entry_of_another_length_is_made_again(filled):
    pristine = filled.entries
    harms = """
entries, outcomes = sorted(kernel_store().folder.iterdir()), []
for harm in (lambda data: b"", lambda data: data[:30], lambda data: data[:-1], lambda data: data * 2):
    for entry in entries:
        entry.write_bytes(harm(entry.read_bytes()))
    outcomes.append(made())
print(json.dumps([*outcomes, made()]))
"""
    assert filled.run(harms) == ([BOTH] * 4 + [[]], []) and filled.entries == pristine


@pytest.mark.costly
def test_an_entry_under_another_name_is_not_believed(filled):
    """A sound file in the place of another one would be the wrong machine code."""
    first, second = filled.entries
    shutil.copy(first, second)
    assert filled.run()[0] in (["cube"], ["hypotenuse"])


@pytest.mark.costly
def test_a_folder_in_the_place_of_an_entry(filled):
    first = filled.entries[0]
    first.unlink()
    first.mkdir()
    compiled, said = filled.run()
    assert len(compiled) == 1 and len(said) == 1 and "run only" in said[0]


class Evil:
    """Unpickled, it leaves a trace."""

    def __init__(self, trace: Path):
        self.trace = trace

    def __reduce__(self):
        return Path.touch, (self.trace,)


def _planted(entry: Path, content: bytes) -> None:
    entry.write_bytes(KernelStore._head(KernelStore, entry.name, content) + content)


@pytest.mark.costly
def test_what_is_planted_as_intended_here_would_run(filled):
    """The other tests plant entries that are believed when they are this user's own: the trace shows it."""
    trace = filled.folder / "trace"
    for entry in filled.entries:
        _planted(entry, pickle.dumps(Evil(trace)))
    filled.run()
    assert trace.exists()


@BY_ROOT
def test_another_users_entry_does_not_run(filled):
    trace = filled.folder / "trace"
    for entry in filled.entries:
        _planted(entry, pickle.dumps(Evil(trace)))
        os.chown(entry, NOBODY, NOBODY)
    assert filled.run() == (BOTH, []) and not trace.exists()
    assert all(entry.stat().st_uid == 0 for entry in filled.entries) and filled.run() == ([], [])


def _given(path):
    os.chown(path, NOBODY, NOBODY)


def _linked(path):
    path.rename(path.parent / "elsewhere")
    path.symlink_to(path.parent / "elsewhere")


@pytest.mark.costly
def test_a_private_folder_serves_one_run_and_its_processes(filled):
    trace = filled.folder / "trace"
    for entry in filled.entries:
        _planted(entry, pickle.dumps(Evil(trace)))
    filled.home.chmod(0o777)
    body = """
import subprocess
first = made()
child = subprocess.run([sys.executable, "-c", "import json; from cheap import *; print(json.dumps(made()))"],
                       capture_output=True, text=True, check=True)
folder = kernel_store().folder
print(json.dumps([first, json.loads(child.stdout), child.stderr, str(folder), oct(folder.stat().st_mode), made()]))
"""
    (first, child, child_said, folder, mode, again), said = filled.run(body)
    assert not trace.exists()
    assert first == BOTH and child == again == [] and child_said == ""
    assert len(said) == 1 and "run only" in said[0] and str(filled.home) in said[0]
    assert Path(folder).is_relative_to(filled.temporary) and mode == "0o40700"
    assert list(filled.temporary.iterdir()) == []


@pytest.mark.parametrize(
    ("harm", "place"),
    [
        pytest.param(_given, "outer/inner/bevelmap", marks=BY_ROOT),
        pytest.param(_given, "outer/inner", marks=BY_ROOT),
        pytest.param(_given, "outer", marks=BY_ROOT),
        (lambda path: path.chmod(0o777), "outer/inner/bevelmap"),
        (lambda path: path.chmod(0o770), "outer/inner/bevelmap"),
        (lambda path: path.chmod(0o1777), "outer/inner/bevelmap"),
        (lambda path: path.chmod(0o777), "outer/inner"),
        (lambda path: path.chmod(0o775), "outer"),
        (_linked, "outer/inner/bevelmap"),
    ],
)
def test_a_folder_that_others_can_change_is_not_used(tmp_path, monkeypatch, caplog, harm, place):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "outer/inner"))
    KernelStore().write("x.kernel", b"content")
    assert KernelStore().read("x.kernel") == b"content" and not caplog.records
    harm(tmp_path / place)
    store = KernelStore()
    assert store.read("x.kernel") is None and not store.folder.is_relative_to(tmp_path)
    (record,) = caplog.records
    assert str(tmp_path / place) in record.getMessage()
    store.write("y.kernel", b"content")
    assert KernelStore().read("y.kernel") == b"content"


@pytest.mark.costly
@pytest.mark.parametrize(
    ("place",), slow_but([("/dev/null/x",)], [("/proc/self/fdinfo",), ("/dev/null/x",), (__file__,)])
)
def test_a_place_that_cannot_be_a_folder(cheap, place):
    compiled, said = cheap.run(home=Path(place))
    assert compiled == BOTH and len(said) == 1 and "run only" in said[0]


def test_no_place_at_all(cheap):
    """Neither the cache folder nor a temporary one: kernels work, with one line."""
    body = "import tempfile\ntempfile.tempdir = '/proc/self/fdinfo'\nprint(json.dumps(made() + made()))"
    compiled, said = cheap.run(body, home=Path("/dev/null"))
    assert compiled == BOTH * 2 and len(said) == 1 and "not kept" in said[0]


@pytest.fixture
def small_disk(tmp_path):
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k,mode=700", "tmpfs", str(folder)]
    made = subprocess.run(mount, capture_output=True, text=True)
    if made.returncode:
        pytest.skip(f"no file system can be mounted here: {made.stderr.strip()}")
    yield folder
    subprocess.run(["umount", "-l", str(folder)], check=True)


def test_a_full_disk(cheap, small_disk):
    """What fits is kept there; the rest for this run only; nothing is left in part."""
    cheap.home = small_disk
    (small_disk / "ballast").write_bytes(bytes(60 * 1024))
    body = "print(json.dumps([made(), made()]))"
    (first, second), said = cheap.run(body)
    assert first == BOTH and second == [] and len(said) == 1 and "No space left" in said[0]
    assert cheap.entries == [] and list(cheap.temporary.iterdir()) == []


@pytest.mark.costly
def test_a_full_disk_everywhere(cheap, small_disk):
    cheap.home, cheap.temporary = small_disk, small_disk / "temporary"
    cheap.temporary.mkdir()
    (small_disk / "ballast").write_bytes(bytes(56 * 1024))
    compiled, said = cheap.run("print(json.dumps(made() + made()))")
    assert compiled == BOTH * 2 and 1 <= len(said) <= 2 and "not kept" in said[-1]


@pytest.mark.costly
def test_an_entry_that_cannot_be_written(cheap, monkeypatch):
    """By a limit on file sizes, which any user meets."""
    import resource

    # Python itself would keep the first part of what it compiles, and stumble over it later.
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    limit = dict(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)))
    compiled, said = cheap.run("print(json.dumps(made() + made()))", **limit)
    assert compiled == BOTH * 2 and "not kept" in said[-1] and len(said) <= 2
    assert cheap.run() == (BOTH, [])


def test_what_is_distrusted(tmp_path):
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True, mode=0o700)
    assert why_distrusted(folder) is None
    folder.parent.chmod(0o1777)
    assert why_distrusted(folder) is None
    folder.parent.chmod(0o777)
    assert "0777" in why_distrusted(folder)
    folder.parent.chmod(0o755)
    folder.chmod(0o755)
    assert why_distrusted(folder) is None


def test_of_one_kernel_the_last_few_entries_are_kept(tmp_path, monkeypatch):
    """Those that were written or read last; entries of other kernels are none of them."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    store = KernelStore()
    names = [f"solver.room.kernel-{i:032x}.kernel" for i in range(20)]
    store.write(f"solver.room.other_kernel-{0:032x}.kernel", b"other")
    for i, name in enumerate(names[:16]):
        store.write(name, b"content")
        os.utime(store.folder / name, (1e9 + i, 1e9 + i))
    assert store.read(names[0]) == b"content"
    for name in names[16:]:
        store.write(name, b"content")
    assert [store.has(name) for name in names] == [True] + 4 * [False] + 15 * [True]
    assert store.has(f"solver.room.other_kernel-{0:032x}.kernel")
