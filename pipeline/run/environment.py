"""What the numbers of a process depend on beside its input: sources, libraries, and the arithmetic of its machine.

Two processes with equal facts compute equal bits. Sources are compared file by file, since a version says nothing of an
edited checkout. Machines are compared by what they compute and not by their names: the C library, NumPy and LAPACK
choose their code by processor, and where that changes the last digits of a few thousand sines or of a small eigenvalue
problem, it changes those of a map.
"""

import functools
import hashlib
import importlib.metadata
import importlib.util
import math
import platform
import sys
from collections.abc import Mapping
from pathlib import Path

__all__ = ["ARITHMETIC", "differences", "differences_of_scheduler", "digest_of", "facts", "packages_of_scheduler"]

_PACKAGES = ("pipeline", "solver")
_LIBRARIES = ("numpy", "scipy", "numba", "llvmlite")
#: Name of the fact that a digest of computed numbers is.
ARITHMETIC = "arithmetic"
#: Name of the fact that says nothing of its own: sources may differ within a version, and be the same uninstalled.
_VERSION = "bevelmap"
#: What a scheduler needs in the same version as its client to understand it.
_OF_SCHEDULER = ("dask", "distributed")
#: What it need not have; but where it has another version, it is not the scheduler that was meant.
_OF_WORKERS = (_VERSION, "numpy")
_CHANGED = "changed since it was loaded"
#: Differences that are named one by one.
_MOST_NAMED = 4


def _files(packages: tuple[str, ...] = _PACKAGES) -> dict[str, Path]:
    """Source files by their names within the packages, whether loaded or not."""
    found = {}
    for package in packages:
        # A package that is not there has no files, which is a difference like any other.
        if (spec := importlib.util.find_spec(package)) is not None and spec.origin is not None:
            folder = Path(spec.origin).parent
            found |= {f"{package}/{file.relative_to(folder).as_posix()}": file for file in folder.rglob("*.py")}
    return found


def _digests(files: Mapping[str, Path]) -> dict[str, str]:
    return {name: _digest(file) for name, file in files.items()}


def _digest(file: Path) -> str:
    try:
        return hashlib.blake2b(file.read_bytes(), digest_size=16).hexdigest()
    except OSError:
        return "unreadable"


# Read when this module is loaded, which is before the solver is: what the process computes with.
_LOADED = _digests(_files())


def _changed() -> set[str]:
    """Files of the solver that are no longer as they were: what is loaded from now on would not fit the rest."""
    states = tuple((name, file, _state(file)) for name, file in sorted(_files(("solver",)).items()))
    now = _digests_in(states)
    return {name for name in _LOADED.keys() | now if name.startswith("solver/") and now.get(name) != _LOADED.get(name)}


def _state(file: Path) -> tuple[int, int] | None:
    """When a file was written, and its size; None where it has just gone."""
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


@functools.lru_cache(maxsize=1)
def _digests_in(states: tuple) -> dict[str, str]:
    """Digests of files, read again when the state of one has changed."""
    return _digests({name: file for name, file, _ in states})


@functools.cache
def _arithmetic() -> str:
    """Digest of elementary functions, of C and of NumPy, and of what LAPACK makes of a small matrix."""
    import numpy as np

    x = np.linspace(0.01, 12.0, 4001)
    of_numpy = (np.sin, np.cos, np.tan, np.exp, np.log, np.arctan, np.tanh, np.sqrt)
    of_c = (math.sin, math.cos, math.tan, math.exp, math.log, math.atan)
    results = [function(x) for function in of_numpy]
    results += [np.array([function(value) for value in x.tolist()]) for function in of_c]
    results += [x**1.7, np.arctan2(x, x[::-1]), np.hypot(x, x[::-1])]
    matrix = np.sin(np.arange(144.0) ** 1.1).reshape(12, 12)
    results += [np.linalg.eigvals(matrix), np.linalg.solve(matrix, matrix.T), *np.linalg.svd(matrix), matrix @ matrix.T]
    digest = hashlib.blake2b(digest_size=16)
    for result in results:
        digest.update(np.ascontiguousarray(result).tobytes())
    return digest.hexdigest()


def _version(library: str) -> str:
    try:
        return importlib.metadata.version(library)
    except importlib.metadata.PackageNotFoundError:
        return "not there"


@functools.cache
def _constant_facts() -> dict[str, str]:
    """What does not change while a process lives."""
    # Sums of floats are rounded otherwise from one minor version of Python to the next.
    return {
        "python": ".".join(map(str, sys.version_info[:2])),
        **{library: _version(library) for library in _LIBRARIES},
        "system": f"{platform.system()} {platform.machine()}",
        ARITHMETIC: _arithmetic(),
        _VERSION: _version(_VERSION),
    }


def facts() -> dict[str, str]:
    """What the results of this process depend on, by name.

    Returns
    -------
    dict
        Digests of the source files of `pipeline` and `solver` as they were when this module was loaded, versions of
        Python and of numerical libraries, operating system and processor, and a digest of computed numbers. A file of
        the solver that has changed since is said to have.
    """
    return {**_LOADED, **dict.fromkeys(_changed(), _CHANGED), **_constant_facts()}


def digest_of(found: Mapping[str, str]) -> str:
    """Some facts as one word, for comparison."""
    compared = sorted((name, value) for name, value in found.items() if name != _VERSION)
    return hashlib.blake2b(repr(compared).encode(), digest_size=16).hexdigest()


def differences(there: Mapping[str, str], here: Mapping[str, str]) -> str:
    """In which facts another process differs from this one, in words; empty where it does not.

    Examples
    --------
    >>> differences({"numpy": "2.0.0", "solver/row.py": "d1"}, {"numpy": "2.1.0", "solver/row.py": "d2"})
    'numpy is 2.0.0 there and 2.1.0 here, solver/row.py differs'
    """
    words = []
    for name in sorted(there.keys() | here.keys(), key=lambda name: (name != _VERSION, name)):
        other, own = there.get(name), here.get(name)
        if other == own:
            continue
        if name == ARITHMETIC:
            words.append("its processor or C library rounds otherwise")
        elif not name.endswith(".py"):
            words.append(f"{name} is {other} there and {own} here")
        elif _CHANGED in (other, own):
            words.append(f"{name} has {_CHANGED}")
        elif None in (other, own):
            words.append(f"{name} is {'missing there' if other is None else 'not here'}")
        else:
            words.append(f"{name} differs")
    more = len(words) - _MOST_NAMED
    return ", ".join(words[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def differences_of_scheduler(versions: Mapping[str, str | None], python: str) -> str:
    """In which versions a scheduler differs from this process, in words; empty where it does not.

    Parameters
    ----------
    versions : mapping
        Of its packages, None where it has none; `packages_of_scheduler` are asked for.
    python : str
        Its own, such as 3.12.4.final.0.
    """
    here = {name: _version(name) for name in packages_of_scheduler()}
    there = {name: versions.get(name) or "not there" for name in here}
    for name in _OF_WORKERS:
        if "not there" in (there[name], here[name]):
            del there[name], here[name]
    there["python"], here["python"] = ".".join(python.split(".")[:2]), _constant_facts()["python"]
    return differences(there, here)


def packages_of_scheduler() -> tuple[str, ...]:
    """Packages whose versions a scheduler is asked for."""
    return (*_OF_SCHEDULER, *_OF_WORKERS)
