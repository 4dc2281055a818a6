"""Whole runs on an S3 server: every stage, the bytes of a folder, faults of the server, and nobody's secrets told."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr
from obstore.store import from_url
from zarr.storage import ObjectStore

import pipeline
from pipeline import store
from pipeline.__main__ import main
from pipeline.config.places import place_of
from pipeline.errors import ConfigurationError, StoreError, Unreachable
from pipeline.explorer.background_run import new_plane
from pipeline.explorer.opened import Opened
from pipeline.store import groups
from pipeline.store.files import files_at
from pipeline.store.names import METADATA, STORE_FILE
from tests.object_server import FaultKind
from tests.pipeline.store.test_object_files import contents_of

#: Whole runs; the same steps on a store in memory are in `test_object_files`.
pytestmark = pytest.mark.costly

SIZES = ("plane=omega_fe", "plane.sweep.num=9", "plane.parameter.num=4", "cluster=none", "store.name=plane")
#: A few cells of everything that is stored.
STAGES = ("stages=[sweep,boundaries,attractors]", "attractors.columns=2", "attractors.rows=2", "attractors.starts=1")
FEW = ("attractors.branches=1", "attractors.max_periods=800")
SECRET = "test-secret-nobody-may-see"
#: These two say when the store was made, and by which configuration.
DATED = {METADATA, f"branches/{METADATA}"}


class Remote:
    """A prefix of the server, with what is typed for it."""

    def __init__(self, server, prefix: str, **more):
        self.server, self.url = server, server.url(prefix)
        self.options = server.options | more
        self.place = place_of("store.root", self.url, self.options) / "plane.zarr"
        self.files = files_at(self.place)

    def words(self) -> list[str]:
        """Overrides."""
        return [f"store.root={self.url}", f"store.storage_options={_written(self.options)}"]

    def copy_to(self, prefix: str, **more) -> "Remote":
        """The same store at another prefix."""
        other = Remote(self.server, prefix, **more)
        other.files.appear(contents_of(self.files))
        return other


def _written(value) -> str:
    if isinstance(value, dict):
        return "{" + ",".join(f"{name}:{_written(one)}" for name, one in value.items()) + "}"
    return str(value).lower() if isinstance(value, bool) else f"'{value}'" if isinstance(value, str) else str(value)


def run(remote, capsys, folder, *words, expected=0):
    code = main([*SIZES, *remote.words(), f"output.root={folder}", *words])
    out, err = capsys.readouterr()
    told = out + err + "".join(file.read_text() for file in Path(folder).rglob("*") if file.suffix in (".yaml", ".log"))
    assert SECRET not in told and "Traceback" not in told
    assert code == expected, (code, out, err)
    return out, err


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The same plane in a folder."""
    root = tmp_path_factory.mktemp("folder")
    assert main([*SIZES, *STAGES, *FEW, f"output.root={root}"]) == 0
    return root / "store/plane.zarr"


@pytest.fixture(scope="module")
def whole(object_server, tmp_path_factory):
    """The plane on the server, made once."""
    remote = Remote(object_server, "whole")
    assert main([*SIZES, *STAGES, *FEW, *remote.words(), f"output.root={tmp_path_factory.mktemp('runs')}"]) == 0
    return remote


@pytest.fixture(scope="module")
def swept(object_server, tmp_path_factory):
    """Rows and boundaries alone, for tests that harm a copy."""
    remote = Remote(object_server, "swept")
    words = [*SIZES, *remote.words(), "stages=[sweep,boundaries]", f"output.root={tmp_path_factory.mktemp('runs')}"]
    assert main(words) == 0
    return remote


def test_every_object_has_the_bytes_of_the_file(whole, folder):
    expected, found = contents_of(files_at(folder)), contents_of(whole.files)
    assert found.keys() == expected.keys()
    assert {name for name in found if found[name] != expected[name]} <= DATED
    assert store.find_damage(whole.place) == []
    # Nothing is left beside it but what says that nobody holds it.
    beside = {name for name in files_at(whole.place.parent).sizes() if not name.startswith("plane.zarr/")}
    assert beside == {".plane.zarr.lease"}


def test_what_is_there_is_kept(whole, tmp_path, capsys):
    before = whole.files.versions()
    out, _ = run(whole, capsys, tmp_path, *STAGES, *FEW)
    assert out.count("nothing to do") > 1 and whole.files.versions() == before


def test_secrets_are_in_no_text(swept, tmp_path, capsys):
    out, _ = run(swept, capsys, tmp_path, "--cfg", "job")
    assert "secret_access_key: '***'" in out and "endpoint: '***'" in out
    assert not any(SECRET.encode() in content for content in contents_of(swept.files).values())
    _, err = run(swept, capsys, tmp_path, "gear.b=0.7", expected=2)
    assert "store.storage_options=***" in err and "python -m pipeline" in err
    _, err = run(swept, capsys, tmp_path, f"store.storage_options.nothing='{SECRET}", expected=2)
    assert "store.storage_options.nothing=***" in err
    _, err = run(swept, capsys, tmp_path, f"store.storage_options={SECRET}", expected=2)


def test_list_check_figures_and_page(whole, tmp_path, capsys):
    out, _ = run(whole, capsys, tmp_path, "stages=[list,check,figures,page]", "figures.formats=[png]", "page.rows=2")
    assert re.search(r"plane +omega 9 x f_e 4 .* complete .* attractors boundaries", out)
    assert "list: 1 store in s3://" in out and "every file of s3://" in out
    assert {"map.png", "attractors.png"} <= {file.name.rpartition("-")[2] for file in tmp_path.rglob("*.png")} | {
        file.name for file in tmp_path.rglob("*.png")
    }
    assert list(tmp_path.rglob("*.html"))
    out, _ = run(whole, capsys, tmp_path, "stages=[figures]", "figures.formats=[png]")
    assert "up to date" in out


def test_margins_motion_and_a_row(whole, tmp_path, capsys):
    out, _ = run(whole, capsys, tmp_path, "stages=[margins]", "margins.point=[0.9,0.1]")
    assert "margins" in out
    run(whole, capsys, tmp_path, "debug.row=1")
    out, _ = run(whole, capsys, tmp_path, "stages=[check]", "check.recompute=2")
    assert "2 rows are bit by bit" in out


def test_python_opens_it_by_its_url(whole, folder, monkeypatch):
    plane, reference = pipeline.open_plane(str(whole.place), storage_options=whole.options), pipeline.open_plane(folder)
    assert plane.label_near(omega=0.9, f_e=0.2) == reference.label_near(omega=0.9, f_e=0.2)
    assert np.array_equal(plane.tree["amplitude"], reference.tree["amplitude"], equal_nan=True)
    assert plane.attractors_at(omega=0.9, f_e=0.2).equals(reference.attractors_at(omega=0.9, f_e=0.2))
    assert SECRET not in repr(plane)
    for name, value in whole.server.environment.items():
        monkeypatch.setenv(name, value)
    assert pipeline.open_plane("plane", root=whole.url).label_near(omega=0.9, f_e=0.2)
    with pytest.raises(StoreError, match="there is no store at s3://"):
        pipeline.open_plane("nothing", root=whole.url)


def test_a_page_sees_it_change_and_go(swept):
    remote = swept.copy_to("shown")
    opened = Opened(remote.place, "python -m pipeline plane=omega_fe 'store.storage_options=***'")
    first = opened.content()
    assert first.plane.domain.shape == (4, 9) and opened.content() is first
    groups.remove_group(remote.place, "boundaries")
    assert opened.content() is not first
    with pytest.raises(ConfigurationError, match="environment"):
        new_plane(opened.command, first.plan, {"b": 0.5})
    remote.files.clear(STORE_FILE)
    with pytest.raises(StoreError, match="is gone"):
        opened.content()


def test_xarray_alone_reads_it(whole, folder):
    objects = ObjectStore(from_url(str(whole.place), **whole.options), read_only=True)
    for group in (None, "branches", "boundaries", "attractors"):
        with xr.open_zarr(objects, group=group) as told, xr.open_zarr(folder, group=group) as reference:
            assert told.drop_attrs().load().identical(reference.drop_attrs().load()), group


def test_a_plane_that_was_interrupted_is_gone_on_with(swept, tmp_path, capsys):
    remote = swept.copy_to("interrupted")
    for name in [name for name in remote.files.sizes() if "/c/2" in name]:
        remote.files.remove(name)
    out, _ = run(remote, capsys, tmp_path, "stages=[sweep]")
    assert "continues: 1 row " in out
    found, expected = contents_of(remote.files), contents_of(swept.files)
    # What was computed from the rows as they were is gone.
    assert {name for name in expected if found.get(name) != expected[name] and "boundaries/" not in name} <= {METADATA}
    assert not any(name.startswith("boundaries/") for name in found)


@pytest.mark.parametrize("harm", ["removed", "truncated", "empty"])
def test_what_was_harmed_is_found_and_mended(swept, tmp_path, capsys, harm):
    remote = swept.copy_to(f"harmed-{harm}")
    names = ["amplitude/c/1/0/0", "boundaries/kind/c/0", "omega/c/0", "stable/zarr.json"]
    for name in names:
        if harm == "removed":
            remote.files.remove(name)
        else:
            content = remote.files.read(name, 10**6)
            remote.files.write({name: content[: len(content) // 2] if harm == "truncated" else b""})
    with pytest.raises(StoreError, match="is damaged"):
        pipeline.open_plane(str(remote.place), storage_options=remote.options)
    _, err = run(remote, capsys, tmp_path, "stages=[check]", expected=1)
    assert all(name in err for name in names)
    out, _ = run(remote, capsys, tmp_path, "stages=[check]", "check.repair=true")
    assert "mended" in out and store.find_damage(remote.place) == []
    run(remote, capsys, tmp_path, "stages=[boundaries]")
    found, expected = contents_of(remote.files), contents_of(swept.files)
    assert {name for name in expected if found.get(name) != expected[name]} <= {METADATA}


def test_workers_write_their_blocks_themselves(object_server, folder, tmp_path):
    """Two processes that get the place with its options, and nothing of them on the terminal."""
    remote = Remote(object_server, "workers")
    words = [word for word in SIZES if word != "cluster=none"]
    command = [sys.executable, "-m", "pipeline", *words, *remote.words(), "stages=[sweep]", f"output.root={tmp_path}"]
    done = subprocess.run([*command, "cluster.workers=2", "cluster=local"], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, "") and SECRET not in done.stdout
    found, expected = contents_of(remote.files), contents_of(files_at(folder))
    assert {name for name in found if found[name] != expected[name]} <= DATED


FAULTS = {
    "503 for a while": (FaultKind.UNAVAILABLE, {"times": 6}),
    "500 although done": (FaultKind.DONE_WITH_ERROR, {"times": 4, "methods": "PUT"}),
    "cut in the middle of puts": (FaultKind.CUT, {"times": 4, "methods": "PUT"}),
    "cut in the middle of answers": (FaultKind.CUT, {"times": 3, "methods": "GET"}),
    "done and not answered": (FaultKind.DONE_UNANSWERED, {"times": 3, "methods": "PUT"}),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_that_pass_are_got_over(object_server, folder, tmp_path, capsys, name):
    kind, hits = FAULTS[name]
    remote = Remote(object_server, f"fault-{kind.value}-{hits.get('methods', 'any')}")
    with object_server.fault(kind, name="plane.zarr/", **hits) as fault:
        run(remote, capsys, tmp_path, "stages=[sweep]")
    assert fault.hits == hits["times"]
    found, expected = contents_of(remote.files), contents_of(files_at(folder))
    assert {name for name in found if found[name] != expected[name]} <= DATED


#: So that a test need not wait: seconds.
IMPATIENT = {"retry_config": {"max_retries": 1, "retry_timeout": 2}}


def test_a_bucket_without_permission_is_one_line(swept, tmp_path, capsys):
    remote = Remote(swept.server, "denied")
    with swept.server.denied():
        _, err = run(remote, capsys, tmp_path, "stages=[sweep]", expected=2)
        assert len(err.splitlines()) == 1 and remote.url in err and "refuses access" in err
        with pytest.raises(Unreachable, match="refuses access"):
            pipeline.open_plane(str(swept.place), storage_options=swept.options)
    with swept.server.fault(FaultKind.DENIED, methods="PUT POST DELETE"):
        # It can be read, and nothing is begun.
        _, err = run(remote, capsys, tmp_path, "stages=[sweep]", expected=2)
        assert len(err.splitlines()) == 1 and remote.url in err and "refuses access" in err
        run(swept, capsys, tmp_path, "stages=[list]")
    assert list(tmp_path.iterdir()) == []


def test_no_such_bucket_is_one_line(object_server, tmp_path, capsys):
    remote = Remote(object_server, "nothing")
    remote.url = remote.url.replace("s3://", "s3://no-")
    _, err = run(remote, capsys, tmp_path, "stages=[sweep]", expected=2)
    assert len(err.splitlines()) == 1 and remote.url in err and "bucket" in err


def test_a_server_that_is_gone_in_the_middle_loses_nothing(object_server, folder, tmp_path, capsys):
    remote = Remote(object_server, "gone", **IMPATIENT)
    with object_server.fault(FaultKind.UNAVAILABLE, name="amplitude/c/2", methods="PUT"):
        _, err = run(remote, capsys, tmp_path, "stages=[sweep]", expected=1)
    assert len(err.splitlines()) == 1 and "503" in err and "what is stored is kept" in err
    assert store.statuses(remote.place).tolist() == [1, 1, 0, 0]
    out, _ = run(remote, capsys, tmp_path, "stages=[sweep]")
    assert "continues: 2 rows" in out
    found, expected = contents_of(remote.files), contents_of(files_at(folder))
    assert {name for name in found if found[name] != expected[name]} <= DATED


def test_a_server_that_does_not_answer_is_one_line(swept, tmp_path, capsys):
    remote = Remote(swept.server, "swept", **IMPATIENT)
    remote.options["client_options"] = {"allow_http": True, "timeout": 1}
    with swept.server.fault(FaultKind.HANG):
        _, err = run(remote, capsys, tmp_path, "stages=[check]", expected=2)
    assert len(err.splitlines()) == 1 and "in time" in err


@pytest.mark.parametrize("name", ["boundaries/zarr.json", "zarr.json"])
def test_a_store_or_group_appears_when_the_server_says_so(swept, tmp_path, capsys, name):
    """The last put of each is the one that counts."""
    remote = Remote(swept.server, f"appears-{name.count('/')}", **IMPATIENT)
    words = ["stages=[sweep,boundaries]"]
    with swept.server.fault(FaultKind.UNAVAILABLE, name=f"plane.zarr/{name}", methods="PUT"):
        _, err = run(remote, capsys, tmp_path, *words, expected=1)
    assert "503" in err
    assert store.exists(remote.place) == ("/" in name)
    if store.exists(remote.place):
        assert store.find_damage(remote.place) == []
        assert "boundaries" not in zarr.open_group(remote.files.zarr(), mode="r")
    run(remote, capsys, tmp_path, *words)
    found, expected = contents_of(remote.files), contents_of(swept.files)
    assert {name for name in found if found[name] != expected[name]} <= DATED


def test_memory_is_of_this_process_alone(tmp_path, capsys):
    words = [*SIZES, "store.root=memory://runs/stores", f"output.root={tmp_path}", "stages=[sweep]"]
    assert main([*words, "cluster=local"]) == 2
    assert "cluster=none" in capsys.readouterr().err
    assert main(words) == 0
    assert pipeline.open_plane("plane", root="memory://runs/stores").plan.rows == 4
