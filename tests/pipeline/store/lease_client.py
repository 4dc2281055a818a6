"""A process that holds a lease and writes when told to: `python -m ...lease_client URL SECONDS wait|refuse`."""

import sys

import obstore

from pipeline.errors import StoreError
from pipeline.store import lease
from pipeline.store.lease import check_held, leased

#: The object that is leased, and the one of the lease.
DATA, NAME = "plane.zarr/data", ".plane.zarr.lease"


def say(*words: object) -> None:
    """A line for the test."""
    print(*words, flush=True)


def record(store):
    """What the lease says."""
    return lease._record(obstore.get(store, NAME).bytes().to_bytes())


def main(url: str, seconds: float, wait: bool) -> None:
    """Hold the lease until the input ends; each line of it is written into the object."""
    store = obstore.store.from_url(url)
    try:
        with leased(store, NAME, "plane.zarr", wait, lambda line: say("said", line), seconds=seconds) as waited:
            say("holds", waited)
            for line in sys.stdin:
                check_held(DATA)
                obstore.put(store, DATA, line.strip().encode())
                say("wrote", line.strip())
        say("let go")
    except StoreError as error:
        say("refused", error)


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), sys.argv[3] == "wait")
