"""A worker whose client has lost the store writes on while another client makes a store of other numbers in its place.

The other one comes between any two requests of a block; whatever the late worker does then, no row of the new store is
taken for complete that is not the new store's own.
"""

import itertools

import obstore
import pytest

from pipeline import store
from pipeline.config.places import place_of
from pipeline.errors import LeaseLost, StoreError
from pipeline.store.arrays import row_layouts
from pipeline.store.files import files_at
from pipeline.store.lease import _HELD
from pipeline.store.lock import exclusive_lock
from pipeline.store.names import STORE_FILE
from tests.pipeline.planes import retold, small_plan, small_store

MINE = small_plan(columns=9, rows=4)
#: With chunks of the same sizes, which makes it worse.
OTHER = small_plan("gear.b=0.7", columns=9, rows=4)
_NUMBERS = itertools.count()


@pytest.fixture(autouse=True, scope="module")
def one_by_one():
    """Requests one after the other, so that a moment is one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pipeline.store.object_files._TOGETHER", 1)
        yield


def files_of(path):
    files = files_at(path)
    return {name: files.read(name, size) for name, size in files.sizes().items()}


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """Whole stores by their names: mine, one of the same numbers that another has made, and one of others."""
    base = tmp_path_factory.mktemp("plans")
    found = {"mine": small_store(base / "mine.zarr", MINE), "other": small_store(base / "other.zarr", OTHER)}
    found["same"] = small_store(base / "same.zarr", MINE)
    retold(found["same"], title="made by another")
    return {name: (path, files_of(path)) for name, path in found.items()}


def make(contents, place):
    """Make a store at a place, in place of what is there."""
    files_at(place).clear(STORE_FILE)
    files_at(place).appear(contents)


def template(contents):
    """A store without its rows."""
    rows = tuple(f"{name}/c/" for name in row_layouts(MINE))
    return {name: content for name, content in contents.items() if not name.startswith(rows)}


def rows_of(folder, plan, block):
    return list(store.kept_rows(folder, plan, block).values())


@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("name", ["other", "same"])
def test_another_store_comes_between_any_two_requests_of_a_block(stores, monkeypatch, name, whole):
    block, honest = MINE.blocks[0], obstore.put
    plan = OTHER if name == "other" else MINE
    mine = rows_of(stores["mine"][0], MINE, block)
    folder, theirs = stores[name]
    last = len(row_layouts(MINE))
    # Between the first and the last few, one is like another.
    for moment in [0, 1, 2, 3, last // 2, *range(last - 2, last + 2)]:
        place = place_of("store.root", f"memory://late-{next(_NUMBERS)}/plane.zarr")
        make(template(stores["mine"][1]), place)
        count = itertools.count()

        def put(*arguments, **options):
            if next(count) == moment:
                with monkeypatch.context() as patch:
                    patch.setattr(obstore, "put", honest)
                    make(theirs if whole else template(theirs), place)
            return honest(*arguments, **options)

        with monkeypatch.context() as patch:
            patch.setattr(obstore, "put", put)
            if moment <= last:
                with pytest.raises(StoreError, match="no longer"):
                    store.write_block(place, MINE, block, mine)
            else:
                store.write_block(place, MINE, block, mine)
                assert next(count) == last + 1
                make(theirs if whole else template(theirs), place)
        # Then the other client goes on.
        for left in store.pending_blocks(place, plan):
            store.write_block(place, plan, left, rows_of(folder, plan, left))
        assert files_of(place) == theirs, moment


class Ended(BaseException):
    """As a process that is killed."""


@pytest.mark.parametrize("killed", [0, 1])
def test_a_late_worker_is_killed_before_it_can_take_anything_back(stores, monkeypatch, killed):
    """Another template came while it wrote: it must not have said that the block is complete."""
    folder, theirs = stores["other"]
    last, honest = len(row_layouts(MINE)), obstore.put
    place = place_of("store.root", f"memory://late-{next(_NUMBERS)}/plane.zarr")
    make(template(stores["mine"][1]), place)
    count = itertools.count()

    def put(*arguments, **options):
        moment = next(count)
        if moment == 2:
            with monkeypatch.context() as patch:
                patch.setattr(obstore, "put", honest)
                make(template(theirs), place)
        if moment == last + killed:
            raise Ended
        return honest(*arguments, **options)

    with monkeypatch.context() as patch:
        patch.setattr(obstore, "put", put)
        with pytest.raises((Ended, StoreError)):
            store.write_block(place, MINE, MINE.blocks[0], rows_of(stores["mine"][0], MINE, MINE.blocks[0]))
    for left in store.pending_blocks(place, OTHER):
        store.write_block(place, OTHER, left, rows_of(folder, OTHER, left))
    assert files_of(place) == theirs


def test_the_same_store_is_gone_on_with_by_another_client(stores, monkeypatch):
    """What a late worker writes then is what is there."""
    folder, contents = stores["mine"]
    block, honest = MINE.blocks[0], obstore.put
    for moment in (0, 1, 5, len(row_layouts(MINE))):
        place = place_of("store.root", f"memory://late-{next(_NUMBERS)}/plane.zarr")
        make(template(contents), place)
        count = itertools.count()

        def put(*arguments, **options):
            if next(count) == moment:
                with monkeypatch.context() as patch:
                    patch.setattr(obstore, "put", honest)
                    for left in MINE.blocks:
                        store.write_block(place, MINE, left, rows_of(folder, MINE, left))
            return honest(*arguments, **options)

        with monkeypatch.context() as patch:
            patch.setattr(obstore, "put", put)
            store.write_block(place, MINE, block, rows_of(folder, MINE, block))
        assert files_of(place) == contents, moment


def test_nothing_is_written_after_another_client_took_over(stores):
    place = place_of("store.root", f"memory://late-{next(_NUMBERS)}/plane.zarr")
    folder, contents = stores["mine"]
    make(template(contents), place)
    block, lines = MINE.blocks[0], []
    before = files_at(place).versions()
    with exclusive_lock(place, False, lines.append) as waited:
        assert not waited
        bucket = files_at(place)._bucket
        (lease,) = (one["path"] for one in obstore.list(bucket).collect() if one["path"].endswith(".lease"))
        obstore.put(bucket, lease, b"another's")
        with pytest.raises(LeaseLost, match="plane.zarr"):
            _HELD[str(place)].renew()
        for write in (
            lambda: store.write_block(place, MINE, block, rows_of(folder, MINE, block)),
            lambda: files_at(place).within("boundaries").write({"zarr.json": b"{}"}),
            lambda: files_at(place).clear(STORE_FILE),
            lambda: files_at(place).remove("zarr.json"),
        ):
            with pytest.raises(LeaseLost):
                write()
    assert files_at(place).versions() == before
