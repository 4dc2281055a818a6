"""Stores in an object store, in this process: the files of a folder, and whole or not there in every order of crash."""

import contextlib
import itertools
import math
import pickle
import socket
import subprocess
import sys

import numpy as np
import obstore
import pytest
import xarray as xr
from obstore.exceptions import BaseError
from obstore.store import S3Store

from pipeline import store
from pipeline.config.places import ObjectPlace, place_of
from pipeline.errors import ConfigurationError, StoreError
from pipeline.plan.layers import Layer
from pipeline.plan.row_blocks import RowBlocks
from pipeline.run.rows import sweep_block
from pipeline.store import groups
from pipeline.store.extraction import extract_layer
from pipeline.store.files import files_at
from pipeline.store.groups import Arrays, Variable
from pipeline.store.listing import listing
from pipeline.store.names import METADATA, STORE_FILE
from pipeline.store.objects import said_of
from pipeline.store.repair import remove_left_overs, repair
from pipeline.store.row_groups import RowArray, RowGroup, set_aside
from tests.pipeline.planes import small_plan, small_store

PLAN = small_plan(columns=9, rows=4)
_NUMBERS = itertools.count()


@pytest.fixture(autouse=True, scope="module")
def one_by_one():
    """Requests one after the other, so that a moment is one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pipeline.store.object_files._TOGETHER", 1)
        yield


def new_root():
    return place_of("store.root", f"memory://test-{next(_NUMBERS)}/stores")


def copied(path, root):
    """The store of a folder as objects."""
    place, folder = root / path.name, files_at(path)
    contents = {name: folder.read(name, size) for name, size in folder.sizes().items()}
    files_at(place).appear(contents)
    return place


def contents_of(files):
    return {name: files.read(name, size) for name, size in files.sizes().items()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return small_store(tmp_path_factory.mktemp("folder") / "plane.zarr", PLAN)


@pytest.fixture
def place(folder):
    return copied(folder, new_root())


def boundaries(value):
    """A small group of the name, with which one it is."""
    places = Variable(("curve",), np.arange(3.0) + value, {"long_name": "curve"})
    return Arrays({"curve": places, "which": Variable(("curve",), np.full(3, value), {})}, ("curve",), {"value": value})


def which(place):
    """The group as anybody reads it: by the list of the root alone; None if it lists none."""
    try:
        found = xr.open_zarr(files_at(place).zarr(), group="boundaries", chunks=None)
    except (FileNotFoundError, KeyError):
        return None
    values = found.which.values.tolist()
    assert values == [found.attrs["value"]] * 3 and np.array_equal(found.curve.values, np.arange(3.0) + values[0])
    return values[0]


class Ended(BaseException):
    """As a process that is killed."""


@contextlib.contextmanager
def ending(monkeypatch, requests):
    """The process ends at its next request that changes anything, after so many; yields the requests that it made."""
    made = []
    honest = {name: getattr(obstore, name) for name in ("put", "copy", "delete")}

    def counted(name):
        def request(bucket, *arguments, **options):
            if name == "delete" and len(arguments[0]) > 1:
                # Several at once are several, in any order.
                for one in arguments[0][::-1]:
                    request(bucket, [one])
                return
            if len(made) == requests:
                raise Ended
            made.append(name)
            honest[name](bucket, *arguments, **options)

        return request

    with monkeypatch.context() as patch:
        for name in honest:
            patch.setattr(obstore, name, counted(name))
        with contextlib.suppress(Ended):
            yield made


def every_end(monkeypatch, begin, act, stride=1):
    """Let an act end at its requests in turn, from the same beginning; yields what it was begun on.

    At all of the first and last five, of those between at every `stride`-th; at last it is not ended.
    """
    done = begin()
    with ending(monkeypatch, math.inf) as requests:
        act(done)
    for moment in range(len(requests)):
        if 5 <= moment < len(requests) - 5 and moment % stride:
            continue
        begun = begin()
        with ending(monkeypatch, moment):
            act(begun)
        yield begun
    yield done


def test_a_place_is_named_and_joined_as_a_path_is_and_tells_nobody_its_options():
    place = place_of("store.root", "s3://bucket//planes/", {"secret_access_key": "abracadabra", "retries": 3})
    path = place / "omega_fe.zarr"
    assert (str(path), path.name, path.stem, path.suffix) == (
        "s3://bucket/planes/omega_fe.zarr",
        "omega_fe.zarr",
        "omega_fe",
        ".zarr",
    )
    assert path.parent == place and str(path.with_name("b")) == "s3://bucket/planes/b" and path.resolve() == path
    assert (path.bucket, path.key, path.scheme) == ("s3://bucket", "planes/omega_fe.zarr", "s3")
    assert str((place_of("x", "gs://bucket") / "a").parent) == "gs://bucket"
    again = pickle.loads(pickle.dumps(path))
    assert again == path and again.storage_options["secret_access_key"] == "abracadabra"
    assert "abra" not in f"{path} {path!r} {files_at(place)!r}"


def test_rows_computed_into_objects_have_the_bytes_of_a_folder(folder):
    place = new_root() / "plane.zarr"
    store.create(place, PLAN, "plane", "configuration: test\n")
    assert store.check(place, PLAN) and not store.statuses(place).any()
    for block in PLAN.blocks:
        sweep_block(place, PLAN, block)
    objects, files = files_at(place), files_at(folder)
    # These two say when the store was made.
    dated = {METADATA, f"branches/{METADATA}"}
    assert objects.sizes().keys() == files.sizes().keys()
    expected = contents_of(files)
    assert {name for name, content in contents_of(objects).items() if content != expected[name]} <= dated
    assert store.find_damage(place) == [] and set(files_at(place.parent).folders()) == {"plane.zarr"}
    assert len(files_at(place.parent).sizes()) == len(expected), "something is left beside the store"
    with xr.open_zarr(objects.zarr()) as told, xr.open_zarr(folder) as reference:
        assert told.drop_attrs().load().identical(reference.drop_attrs().load())


def test_rows_are_read_kept_and_gone_on_with(place, folder):
    first, second = PLAN.blocks[:2]
    files_at(place).remove(f"status/c/{first.start}")
    assert store.pending_blocks(place, PLAN) == [first]
    assert store.kept_rows(place, PLAN, first) == {} and len(store.kept_rows(place, PLAN, second)) == 1
    sweep_block(place, PLAN, first)
    assert contents_of(files_at(place)) == contents_of(files_at(folder))


def test_a_store_appears_whole_or_is_not_there(monkeypatch):
    """After every request of its making: nobody opens it, lists it or goes on with it, and the next run makes it."""
    seen = []
    for place in every_end(
        monkeypatch, lambda: new_root() / "plane.zarr", lambda place: store.create(place, PLAN, "plane", ""), 11
    ):
        files = files_at(place)
        there = store.exists(place)
        assert store.check(place, PLAN) == there == files.has(METADATA)
        found = listing(place.parent)
        assert (len(found.entries), found.foreign) == (int(there), ())
        if there:
            assert store.find_damage(place) == []
        else:
            with pytest.raises(FileNotFoundError):
                xr.open_zarr(files.zarr())
            with pytest.raises(StoreError, match="there is no store at"):
                store.read_plan(place)
            store.refuse_foreign(place)
            store.create(place, PLAN, "plane", "")
            assert store.find_damage(place) == []
        seen.append(there)
    assert seen.count(False) > 10 and seen[-2:] == [True, True]


@pytest.mark.costly
def test_a_store_that_is_overwritten_goes_as_a_whole(monkeypatch, folder):
    for place in every_end(
        monkeypatch, lambda: copied(folder, new_root()), lambda place: files_at(place).clear(STORE_FILE), 23
    ):
        if store.exists(place):
            assert store.find_damage(place) == []
        else:
            assert not store.check(place, PLAN) and listing(place.parent).foreign == ()
            store.create(place, PLAN, "plane", "")
            assert store.find_damage(place) == [] and not store.statuses(place).any()


def test_a_store_that_lost_its_root_is_damaged_and_not_gone(place):
    files_at(place).remove(METADATA)
    assert store.exists(place)
    with pytest.raises(StoreError, match=f"{METADATA} is missing"):
        store.check(place, PLAN)
    repair(place, store.find_damage(place))
    assert store.find_damage(place) == [] and store.check(place, PLAN)


@pytest.mark.costly
def test_a_group_is_replaced_as_a_whole(monkeypatch, folder):
    """Whoever reads it finds the old one, none or the new one, never a part; and the next run goes on."""
    seen = []

    def begin():
        place = copied(folder, new_root())
        groups.write_group(place, "boundaries", boundaries(1))
        return place

    for place in every_end(monkeypatch, begin, lambda place: groups.write_group(place, "boundaries", boundaries(2))):
        seen.append(which(place))
        assert store.find_damage(place) == []
        remove_left_overs(place)
        # Another stage gathers what is whole.
        store.consolidate(place)
        assert which(place) in (None, 1, 2) and store.find_damage(place) == []
        groups.write_group(place, "boundaries", boundaries(2))
        assert which(place) == 2
    assert [one for one, _ in itertools.groupby(seen)] == [1, None, 2]


def test_a_group_is_taken_away_as_a_whole(monkeypatch, folder):
    """It is not listed before anything of it goes; what is removed halfway never comes back."""

    def begin():
        place = copied(folder, new_root())
        groups.write_group(place, "boundaries", boundaries(1))
        return place

    for place in every_end(monkeypatch, begin, groups.remove_added):
        assert which(place) in (1, None) and store.find_damage(place) == []
        groups.remove_added(place)
        assert which(place) is None
        assert not [name for name in files_at(place).sizes() if name.startswith("boundaries/")]


@pytest.mark.costly
def test_a_layer_is_taken_out_as_a_whole(monkeypatch, tmp_path):
    volume = small_plan("plane=omega_b_fe", "plane.parameter2.num=2", columns=9, rows=3)
    source, plan = small_store(tmp_path / "volume.zarr", volume), volume.layer(1)
    extract_layer(Layer(source, 1), tmp_path / "layer.zarr", plan, "layer", "")
    expected = contents_of(files_at(tmp_path / "layer.zarr"))

    def take_out(place):
        extract_layer(Layer(source, 1), place, plan, "layer", "")

    for place in every_end(monkeypatch, lambda: new_root() / "layer.zarr", take_out, 60):
        if not store.exists(place):
            assert listing(place.parent).entries == ()
            take_out(place)
        found = contents_of(files_at(place))
        assert found.keys() == expected.keys() and store.find_damage(place) == []
        assert {name for name in found if found[name] != expected[name]} <= {METADATA, f"branches/{METADATA}"}


ROWS = RowBlocks((4,), 2)
ARRAYS = {
    "kind": RowArray(("x",), (3,), "int8", 0, {"long_name": "kind"}),
    "message": RowArray((), (), "str", "", {"long_name": "why"}),
}
LABEL = RowArray(("x",), (3,), "int16", 0, {"long_name": "label"})


def group_of(place):
    places = {"p": (("p",), np.arange(4.0), {"long_name": "p"})}
    return RowGroup(place, "attractors", ROWS, ("p",), ARRAYS, places, {"made_from": "a"})


def write_blocks(group):
    group.begin()
    for block in ROWS.all:
        rows = np.arange(block.start, block.stop)
        texts = np.array([f"row {row}" for row in rows], dtype=object)
        group.write(block, {"kind": np.tile(rows[:, None], 3).astype(np.int8), "message": texts})


def finish(group):
    group.finish({"label": (LABEL, np.ones((4, 3), np.int16))})


@pytest.mark.costly
def test_a_group_in_blocks_is_finished_as_a_whole(monkeypatch, folder):
    def begin():
        group = group_of(copied(folder, new_root()))
        write_blocks(group)
        return group

    finished = []
    for group in every_end(monkeypatch, begin, finish, 3):
        assert store.find_damage(group.store) == []
        remove_left_overs(group.store)
        finished.append(group.is_finished)
        if not group.is_finished:
            group.begin()
            assert all(group.read(block) is not None for block in ROWS.all), "a block was lost"
            finish(group)
        told = xr.open_zarr(files_at(group.store).zarr(), group="attractors", chunks=None)
        assert told.kind.values[:, 0].tolist() == [0, 1, 2, 3] and told.label.values.all()
        assert not group.folder.exists() and store.find_damage(group.store) == []
    assert finished.count(False) > 8 and finished[-1]


@pytest.mark.costly
def test_a_damaged_group_in_blocks_is_set_aside_and_gone_on_with(monkeypatch, folder):
    def begin():
        group = group_of(copied(folder, new_root()))
        write_blocks(group)
        finish(group)
        files_at(group.store).remove("attractors/kind/c/1/0")
        return group

    for group in every_end(monkeypatch, begin, lambda group: set_aside(group.store, "attractors"), 4):
        if damage := store.find_damage(group.store):
            repair(group.store, damage)
        assert store.find_damage(group.store) == [] and not group.is_finished
        group.begin()
        kept = [group.read(block) is not None for block in ROWS.all]
        assert kept in ([True, False], [False, False])
        write_blocks(group)
        finish(group)
        assert group.is_finished and store.find_damage(group.store) == []


def test_attempts_are_noted_where_one_was_lost(place):
    from pipeline.store.attempts import MOST_ATTEMPTS, AttemptLog, forget_attempts

    for lost in range(MOST_ATTEMPTS + 1):
        tries = AttemptLog(place, 2, None)
        # The first attempt only leaves that there was one; from then on each row is noted before it begins.
        assert tries.count(3) == max(0, lost - 1)
        tries.__enter__()
        with contextlib.suppress(Ended), tries.attempt(3):
            raise Ended
    assert AttemptLog(place, 2, None).verdict(3)
    raising = AttemptLog(place, 5, None)
    with raising:
        raising.raised(5, "no\nway")
    assert AttemptLog(place, 5, None).count(5) == 1
    forget_attempts(place)
    assert AttemptLog(place, 2, None).count(3) == 0 and AttemptLog(place, 5, None).count(5) == 0


def test_what_is_no_file_of_this_program_is_neither_removed_nor_overwritten(place):
    files_at(place).write({"thesis.tex": b"mine"})
    for act in (lambda: files_at(place).clear(STORE_FILE), lambda: store.refuse_foreign(place)):
        with pytest.raises(StoreError, match=r"thesis\.tex"):
            act()
    assert store.find_damage(place) == [] and files_at(place).has("thesis.tex")


@pytest.mark.parametrize(
    ("url", "options", "name"),
    [
        ("ftp://host/a", {}, "ftp://host/a"),
        ("s3:///a", {}, "s3:///a"),
        ("s3://bucket/../a", {}, "s3://bucket"),
        ("s3://key:word@bucket/a", {}, "storage_options"),
        ("s3://bucket/a?key=word", {}, "storage_options"),
        ("folder", {"region": "x"}, "storage_options"),
        ("s3://bucket/a", {"region": object()}, "storage_options"),
    ],
)
def test_urls_that_no_store_can_have(url, options, name):
    with pytest.raises(Exception, match=name) as refused:
        place_of("store.root", url, options)
    assert "word" not in str(refused.value) and "store.root" in str(refused.value) or name == "storage_options"


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({"secrett": "abracadabra"}, "secrett"),
        ({"client_options": "abracadabra"}, "client_options"),
        ({"client_options": {"timeout": "abracadabra"}}, "timeout"),
        ({"client_options": {"abra": 1}}, "client_options|storage_options"),
        ({"region": ["abracadabra"]}, "region"),
    ],
)
def test_options_that_no_object_store_has(options, name):
    with pytest.raises(Exception, match=name) as refused:
        files_at(ObjectPlace("s3://bucket/a", place_of("x", "s3://bucket/a", options).options)).exists()
    assert "abracadabra" not in str(refused.value) and "\n" not in str(refused.value)


def test_without_the_extra_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "obstore", None)
    monkeypatch.delitem(sys.modules, "pipeline.store.object_files")
    with pytest.raises(ConfigurationError, match=r"bevelmap\[objects\]"):
        files_at(new_root())


def test_a_folder_loads_nothing_that_object_stores_need(folder, tmp_path):
    words = [f"store.root={folder.parent}", f"output.root={tmp_path}", "stages=[list,check]", "store.name=plane"]
    code = f"import sys; from pipeline.__main__ import main; assert main({words!r}) == 0; "
    code += "print([name for name in sys.modules if name.startswith('obstore') or 'object_files' in name])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, "") and done.stdout.splitlines()[-1] == "[]"


def test_an_address_where_nothing_listens_is_said_to_be_one():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        address = f"http://127.0.0.1:{found.getsockname()[1]}"
    options = {"client_options": {"allow_http": True}, "retry_config": {"max_retries": 0}}
    bucket = S3Store("planes", endpoint=address, access_key_id="key", secret_access_key="secret", **options)
    with pytest.raises(BaseError) as caught:
        obstore.list(bucket).collect()
    said = said_of(caught.value)
    assert "cannot be reached" in said and "secret" not in said and address not in said
