"""How the hot kernels are compiled and cached, and the call signatures that they share.

Numba keeps one cache entry per file and looks only at that file's time stamp, so a kernel that calls into a
second file would go stale when that second file changes. The cache folder is therefore named after a digest of
all sources of this package: any edit gives a new folder, and two checkouts with equal sources share one.
"""

import hashlib
import os
import tempfile
from pathlib import Path

import numba
from numba import types

__all__ = ["ARRAY", "BALANCE", "CORRECTOR", "FLAGS", "MATRIX", "MONITOR", "cache_folder", "kernel"]

ARRAY = types.float64[::1]
MATRIX = types.float64[:, ::1]
FLAGS = types.int8[::1]

#: balance(theta, direction, y, residual, jacobian): residual (n,) and jacobian (n, n + 1) at y = (unknowns, axis value).
BALANCE = types.FunctionType(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))

#: monitor(theta, direction, y, values, gradient): values[0] is the amplitude, the others are event functions;
#: gradient (m, n + 1) holds their derivatives.
MONITOR = types.FunctionType(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))

#: corrector(balance, theta, direction, scale, y, normal, tolerance, max_iterations, work) -> iterations, or -1.
CORRECTOR = types.FunctionType(
    types.int64(BALANCE, ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, types.float64, types.int64, MATRIX)
)


def _source_digest() -> str:
    digest = hashlib.sha256(f"{numba.__version__}".encode())
    root = Path(__file__).parent
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> str | None:
    """Where compiled kernels are kept, or None where no folder can be written (then they are compiled every time)."""
    homes = [os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"), Path.home() / ".cache"]
    for home in [Path(h) for h in homes if h] + [Path(tempfile.gettempdir()) / f"bevelmap-{os.getuid()}"]:
        folder = home / "bevelmap" / f"kernels-{_source_digest()}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return str(folder)
    return None


_FOLDER = cache_folder()


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
        a process which finds those does not load it (100 functions take a second). The signature says what it is made for.

    Returns
    -------
    callable
        Decorator. Division by zero gives inf or nan as in NumPy; no fast-math, so results do not depend on how
        the compiler groups sums.
    """

    def decorate(function):
        previous = numba.config.CACHE_DIR
        if _FOLDER is not None:
            numba.config.CACHE_DIR = _FOLDER
        try:
            compiled = numba.njit(
                None if inline or inner else signature,
                cache=_FOLDER is not None,
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
