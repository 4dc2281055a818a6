"""How the hot kernels are compiled and cached, and the call signatures that they share.

Numba keeps one cache entry per file and looks only at that file's time stamp, so a kernel that calls into a second file
would go stale when that second file changes. The cache folder of a module is therefore named after a digest of its
source and of everything in this package that it imports: an edit gives new folders to the modules that can feel it and
to no others, and two checkouts with equal sources share them.
"""

import functools
import hashlib
import os
import re
import tempfile
from pathlib import Path

import numba
from numba import types

__all__ = ["ARRAY", "BALANCE", "CORRECTOR", "FLAGS", "MATRIX", "MONITOR", "cache_folder", "cache_root", "kernel"]

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
def _digest(module: Path) -> str:
    """Digest of a module's source and of all that it imports from this package."""
    files, waiting = set(), {module, Path(__file__)}
    while waiting:
        file = waiting.pop()
        files.add(file)
        waiting |= _imports(file) - files
    digest = hashlib.sha256(f"{numba.__version__}".encode())
    for file in sorted(files):
        digest.update(file.name.encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


@functools.cache
def cache_root() -> Path | None:
    """Where compiled kernels are kept, or None where no folder can be written (then they are compiled every time)."""
    homes = [os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"), Path.home() / ".cache"]
    for home in [Path(h) for h in homes if h] + [Path(tempfile.gettempdir()) / f"bevelmap-{os.getuid()}"]:
        folder = home / "bevelmap"
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return None


def cache_folder(module: Path) -> str | None:
    """The cache folder of one module's kernels; None if there is no `cache_root`, or the module is no file."""
    root = cache_root()
    return None if root is None or not module.is_file() else str(root / f"{module.stem}-{_digest(module)}")


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
        previous, folder = numba.config.CACHE_DIR, cache_folder(Path(function.__code__.co_filename))
        if folder is not None:
            numba.config.CACHE_DIR = folder
        try:
            compiled = numba.njit(
                None if inline or inner else signature,
                cache=folder is not None,
                error_model="numpy",
                forceinline=inline,
            )(function)
        finally:
            numba.config.CACHE_DIR = previous
        if inline or inner:
            return compiled
        # Passed as an argument, a kernel is looked up by signature at every call, which takes 40 us. It has only one.
        (result,) = compiled.overloads.values()
        compiled.get_compile_result = lambda _: result
        return compiled

    return decorate
