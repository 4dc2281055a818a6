"""The S3 server of the tests: it is one, and its faults do what they say."""

import concurrent.futures
import threading
from datetime import timedelta

import obstore
import pytest
from obstore.exceptions import AlreadyExistsError, BaseError, PermissionDeniedError, PreconditionError

#: Errors come at once.
NO_RETRY = {"max_retries": 0, "retry_timeout": timedelta(seconds=5)}


@pytest.fixture
def store(object_server, request):
    """A prefix of the test's own, through a client that does not try again."""
    store = obstore.store.from_url(
        object_server.url(f"server/{request.node.name}"), **object_server.options, retry_config=NO_RETRY
    )
    object_server.count()
    return store


def version(put_result):
    """What a conditional put takes."""
    return {key: value for key, value in put_result.items() if value is not None}


def read(store, name):
    return obstore.get(store, name).bytes().to_bytes()


def test_conditional_puts(store):
    first = version(obstore.put(store, "a", b"1", mode="create"))
    with pytest.raises(AlreadyExistsError):
        obstore.put(store, "a", b"2", mode="create")
    second = version(obstore.put(store, "a", b"3", mode=first))
    assert second != first
    with pytest.raises(PreconditionError):
        obstore.put(store, "a", b"4", mode=first)
    with pytest.raises(PreconditionError):
        obstore.put(store, "missing", b"4", mode=first)
    assert read(store, "a") == b"3"


@pytest.mark.parametrize("new", [True, False])
def test_one_of_many_conditional_puts_wins(store, new):
    """At the same moment, for a name that is new and for one that is there."""
    mode = "create" if new else version(obstore.put(store, "a", b"before"))
    barrier = threading.Barrier(8)

    def attempt(number):
        barrier.wait()
        try:
            obstore.put(store, "a", str(number).encode(), mode=mode)
        except (AlreadyExistsError, PreconditionError):
            return False
        return True

    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        won = list(pool.map(attempt, range(8)))
    assert sum(won) == 1
    assert read(store, "a") == str(won.index(True)).encode()


def test_requests_are_counted(object_server, store):
    obstore.put(store, "a", b"1")
    read(store, "a")
    obstore.head(store, "a")
    assert [object_["path"] for page in obstore.list(store) for object_ in page] == ["a"]
    obstore.delete(store, "a")
    count = object_server.count()
    # A deletion is a POST of a list of names or a DELETE.
    assert (count["PUT"], count["GET"], count["HEAD"], count["POST"] + count["DELETE"]) == (1, 2, 1, 1)
    assert not object_server.count()


def test_unavailable(object_server, store):
    with object_server.fault("unavailable", times=2, methods="PUT") as fault:
        for _ in range(2):
            with pytest.raises(BaseError, match="503"):
                obstore.put(store, "a", b"1", mode="create")
        obstore.put(store, "a", b"1", mode="create")
    assert fault.hits == 2


def test_denied(object_server, store):
    obstore.put(store, "a", b"1")
    with object_server.denied():
        with pytest.raises(PermissionDeniedError):
            read(store, "a")
        with pytest.raises(PermissionDeniedError):
            obstore.put(store, "a", b"2")
    assert read(store, "a") == b"1"


def test_hang(object_server, store):
    impatient = obstore.store.from_url(
        object_server.url("server/hang"),
        **object_server.options | {"client_options": {"allow_http": True, "timeout": "200ms"}},
        retry_config=NO_RETRY,
    )
    with object_server.fault("hang", methods="PUT", name="hang/b") as fault, pytest.raises(BaseError):
        obstore.put(impatient, "b", b"1")
    assert fault.hits == 1
    with pytest.raises(FileNotFoundError):
        read(impatient, "b")


@pytest.mark.parametrize("size", [2, 3_000_000])
def test_cut_in_the_middle_of_a_put(object_server, store, size):
    obstore.put(store, "a", b"before")
    with object_server.fault("cut", methods="PUT"), pytest.raises(BaseError):
        obstore.put(store, "a", b"x" * size)
    assert read(store, "a") == b"before"


def test_cut_in_the_middle_of_an_answer(object_server, store):
    obstore.put(store, "a", b"x" * 1000)
    with object_server.fault("cut", methods="GET"), pytest.raises(BaseError):
        read(store, "a")
    assert read(store, "a") == b"x" * 1000


@pytest.mark.parametrize("kind", ["done_with_error", "done_unanswered"])
def test_done_but_not_said(object_server, store, kind):
    with object_server.fault(kind, times=1, methods="PUT"), pytest.raises(BaseError):
        obstore.put(store, "a", b"1", mode="create")
    assert read(store, "a") == b"1"


def test_only_what_a_fault_names(object_server, store):
    with object_server.fault("unavailable", name="/only/"):
        obstore.put(store, "a", b"1")
        with pytest.raises(BaseError):
            obstore.put(store, "only/a", b"1")
