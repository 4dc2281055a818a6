"""How the hot kernels are compiled and cached, and the call signatures that they share.

An entry of the cache is one file, named after a digest of the kernel's module and of everything in this package that it
imports: an edit gives new names to the kernels that can feel it and to no others, and two checkouts with equal sources
share them.

What is read is unpickled and its machine code runs, so whoever can write an entry can run code as this user. The cache
folder must therefore belong to this user with mode 0700, and nobody else may be able to exchange it or one of its
parents. An entry that is empty, cut short or damaged is removed and compiled again.
"""

import atexit
import contextlib
import functools
import hashlib
import logging
import os
import pickle
import re
import shutil
import stat
import sys
import tempfile
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba import types
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

__all__ = [
    "ARRAY",
    "BALANCE",
    "CORRECTOR",
    "FLAGS",
    "MATRIX",
    "MONITOR",
    "KernelStore",
    "is_cold",
    "kernel",
    "kernel_store",
    "module_digest",
    "why_distrusted",
]

ARRAY = types.float64[::1]
MATRIX = types.float64[:, ::1]
FLAGS = types.int8[::1]

#: balance(theta, direction, y, residual, jacobian): residual (n,) and jacobian (n, n + 1) at y = (unknowns, axis
#: value).
BALANCE = types.FunctionType(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))

#: monitor(theta, direction, y, values, gradient): values[0] is the amplitude, the others are event functions;
#: gradient (m, n + 1) holds their derivatives.
MONITOR = types.FunctionType(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))

#: corrector(balance, theta, direction, scale, y, normal, tolerance, max_iterations, work) -> iterations, or -1.
CORRECTOR = types.FunctionType(
    types.int64(BALANCE, ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, types.float64, types.int64, MATRIX)
)


_ROOT = Path(__file__).parents[1]
_IMPORT = re.compile(r"^(?:from|import) solver((?:\.\w+)*)(?: import (.*))?$", re.MULTILINE)
_LOG = logging.getLogger(__name__)


def _imports(path: Path) -> set[Path]:
    """The files of this package that one of them imports at its top."""
    found = set()
    for dotted, names in _IMPORT.findall(path.read_text(encoding="utf-8")):
        base = _ROOT.joinpath(*dotted.split(".")[1:])
        # What is imported from a package may be a module of it.
        candidates = [base.with_suffix(".py"), base / "__init__.py"]
        candidates += [base / f"{name.strip()}.py" for name in names.split(",") if base.is_dir()]
        found.update(
            candidate for candidate in candidates if candidate != _ROOT / "__init__.py" and candidate.is_file()
        )
    return found


@functools.cache
def module_digest(module: Path) -> str:
    """Digest of a module's source, of all that it imports from this package, and of what compiles it."""
    files, waiting = set(), {module, Path(__file__)}
    while waiting:
        file = waiting.pop()
        files.add(file)
        waiting |= _imports(file) - files
    versions = (sys.version, numba.__version__, llvmlite.__version__, np.__version__)
    digest = hashlib.sha256(repr(versions).encode())
    for file in sorted(files):
        digest.update(file.name.encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _trusted_owners() -> set[int]:
    """This user and root, and what root outside a user namespace (a container without privileges) shows as inside."""
    owners = {0, os.geteuid()}
    with contextlib.suppress(OSError, ValueError):
        unmapped = int(Path("/proc/sys/fs/overflowuid").read_text())
        ranges = [[int(word) for word in line.split()] for line in Path("/proc/self/uid_map").read_text().splitlines()]
        if not any(first <= unmapped < first + count for first, _, count in ranges):
            owners.add(unmapped)
    return owners


def why_distrusted(folder: Path) -> str | None:
    """Why another user could have put something into a folder, None where nobody could; links are not followed."""
    others_write, owners = stat.S_IWGRP | stat.S_IWOTH, _trusted_owners()
    for part in (folder, *folder.parents):
        state = part.lstat()
        mode = stat.S_IMODE(state.st_mode)
        if not stat.S_ISDIR(state.st_mode):
            return f"{part} is not a folder"
        if state.st_uid != os.geteuid() and (part == folder or state.st_uid not in owners):
            return f"{part} belongs to another user"
        # Where the sticky bit is set, as in /tmp, others can neither move nor remove what is not theirs.
        if mode & others_write and (part == folder or not mode & stat.S_ISVTX):
            return f"{part} can be written by other users (mode {mode:04o})"
    return None


def _own_folder(home: Path) -> Path:
    """The folder for kernels in `home`, made if need be; raises OSError where it cannot be trusted or written."""
    home.mkdir(mode=0o700, parents=True, exist_ok=True)
    folder = home.resolve() / "bevelmap"
    folder.mkdir(mode=0o700, exist_ok=True)
    reason = why_distrusted(folder)
    if reason is None and not os.access(folder, os.W_OK | os.X_OK):
        reason = f"{folder} cannot be written"
    if reason is not None:
        raise PermissionError(reason)
    folder.chmod(0o700)
    return folder


class KernelStore:
    """Compiled kernels by name: in the user's cache folder, else in a private one for this run, else nowhere.

    The folder is `bevelmap` in NUMBA_CACHE_DIR, else XDG_CACHE_HOME, else ~/.cache. A private one is removed when this
    process ends; processes that it starts find it in NUMBA_CACHE_DIR.
    """

    _HEAD = b"bevelmap kernel 1\n"

    def __init__(self):
        self._keeps, self._is_private = True, False
        self._folders: list[Path] = []
        try:
            home = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
            self._folders.append(_own_folder(Path(home) if home else Path.home() / ".cache"))
        except (OSError, RuntimeError) as error:  # RuntimeError: there is no home directory
            self._retreat(error)

    @property
    def folder(self) -> Path | None:
        """Where new entries are kept; None if nowhere."""
        return self._folders[-1] if self._keeps else None

    def _retreat(self, error: Exception) -> None:
        """Keep new entries in a private folder, or nowhere where that has failed as well."""
        kept = "not kept"
        self._keeps, self._is_private = not self._is_private, True
        if self._keeps:
            try:
                home = tempfile.mkdtemp(prefix="bevelmap-")
                atexit.register(shutil.rmtree, home, ignore_errors=True)
                self._folders.append(_own_folder(Path(home)))
                os.environ["NUMBA_CACHE_DIR"] = home
                kept = "kept for this run only"
            except OSError:
                self._keeps = False
        _LOG.warning("note: compiled kernels are %s: %s", kept, error)

    def read(self, name: str) -> bytes | None:
        """The content of an entry, None if there is none; one that is damaged or another user's is removed."""
        for folder in self._folders:
            try:
                content = self._read(folder / name)
            except FileNotFoundError:
                continue
            except (OSError, ValueError):
                self._remove(folder / name)
                continue
            return content
        return None

    def _read(self, path: Path) -> bytes:
        with os.fdopen(os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
            state = os.fstat(file.fileno())
            if not stat.S_ISREG(state.st_mode) or state.st_uid != os.geteuid():
                raise PermissionError(f"{path} is not this user's")
            data = file.read()
        head, content = data[: len(self._HEAD) + 32], data[len(self._HEAD) + 32 :]
        if head != self._head(path.name, content):
            raise ValueError(f"{path} is damaged")
        return content

    def _head(self, name: str, content: bytes) -> bytes:
        """What an entry starts with: its checksum holds under its own name only."""
        return self._HEAD + hashlib.sha256(name.encode() + b"\n" + content).digest()

    def write(self, name: str, content: bytes) -> None:
        """Keep an entry, which appears whole or not at all."""
        while self._keeps:
            try:
                handle, partial = tempfile.mkstemp(dir=self._folders[-1], suffix=".partial")
                try:
                    with os.fdopen(handle, "wb") as file:
                        file.write(self._head(name, content) + content)
                    Path(partial).replace(self._folders[-1] / name)
                except BaseException:
                    self._remove(Path(partial))
                    raise
            except OSError as error:
                self._retreat(error)
            else:
                return

    def drop(self, name: str) -> None:
        """Remove an entry."""
        for folder in self._folders:
            self._remove(folder / name)

    @staticmethod
    def _remove(path: Path) -> None:
        with contextlib.suppress(OSError):
            path.unlink()


@functools.cache
def kernel_store() -> KernelStore:
    """The store of this process."""
    return KernelStore()


def is_cold(module: Path) -> bool:
    """Whether kernels are kept, but none yet of a module as it is now."""
    folder = kernel_store().folder
    return folder is not None and not any(folder.glob(f"{module.stem}-{module_digest(module)}-*"))


class _KernelCache:
    """The cache of one kernel, as a numba dispatcher asks for it."""

    cache_path = None

    def __init__(self, function, module: Path):
        self._name = f"{module.stem}-{module_digest(module)}-{function.__name__}"
        self._key = (function.__qualname__, function.__code__.co_firstlineno)

    def entry(self, signature, target_context) -> str:
        """Name of an entry's file."""
        key = repr((self._key, str(signature), target_context.codegen().magic_tuple()))
        return f"{self._name}-{hashlib.sha256(key.encode()).hexdigest()[:32]}.kernel"

    def load_overload(self, signature, target_context):
        """A stored compile result, or None."""
        target_context.refresh()
        name = self.entry(signature, target_context)
        content = kernel_store().read(name)
        if content is None:
            return None
        try:
            return CompileResult._rebuild(target_context, *pickle.loads(content))
        except Exception:  # whatever an entry of other software does: it is as good as none
            kernel_store().drop(name)
            return None

    def save_overload(self, signature, result) -> None:
        """Store a compile result."""
        name = self.entry(signature, result.target_context)
        if kernel_store().folder is not None and not result.library.has_dynamic_globals:
            kernel_store().write(name, dumps(result._reduce()))


def kernel(signature, inline: bool = False, inner: bool = False):
    """Compile a function for one signature, without the interpreter, and cache the result on disk.

    Parameters
    ----------
    signature
        The numba signature; compiling happens at import, so that no call ever pays for it.
    inline
        Let LLVM inline the function at every call (small functions of the inner loop). It is then an inner one.
    inner
        The function is called by other kernels: it is compiled with them and is part of what they keep on disk, so that
        a process which finds those does not load it (100 functions take a second). The signature says what it is made
        for.

    Returns
    -------
    callable
        Decorator. Division by zero gives inf or nan as in NumPy; no fast-math, so results do not depend on how
        the compiler groups sums.
    """

    def decorate(function):
        compiled = numba.njit(error_model="numpy", forceinline=inline)(function)
        module = Path(function.__code__.co_filename)
        if module.is_file():
            compiled._cache = _KernelCache(function, module)
        if inline or inner:
            return compiled
        compiled.compile(signature)
        compiled.disable_compile()
        # Passed as an argument, a kernel is looked up by signature at every call, which takes 40 us. It has only one.
        (result,) = compiled.overloads.values()
        compiled.get_compile_result = lambda _: result
        return compiled

    return decorate
