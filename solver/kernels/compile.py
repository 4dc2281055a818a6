"""How the hot kernels are compiled and cached, and the call signatures that they share.

A kernel is compiled for its declared signature when it is first called, and kept on disk under a digest of everything
that it depends on: see `solver.kernels.content`. Numba itself is imported by then and not before.
"""

import functools
import hashlib
import threading
from collections.abc import Callable

from solver.kernels import types
from solver.kernels.content import described_code

__all__ = ["ARRAY", "RESIDUAL_AND_JACOBIAN", "CORRECTOR", "FLAGS", "MATRIX", "TEST_FUNCTIONS", "Kernel", "kernel"]

ARRAY = types.float64[::1]
MATRIX = types.float64[:, ::1]
FLAGS = types.int8[::1]

#: residual_and_jacobian(parameters, parameter_slope, y, residual, jacobian): residual (n,) and jacobian (n, n + 1) at
#: y = (unknowns, axis value).
RESIDUAL_AND_JACOBIAN = types.FunctionType(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))

#: test_functions(parameters, parameter_slope, y, values, gradient): values[0] is the amplitude, events lie where the
#: others vanish; gradient (m, n + 1) holds their derivatives.
TEST_FUNCTIONS = types.FunctionType(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))

#: corrector(residual_and_jacobian, parameters, parameter_slope, scale, y, normal, tolerance, max_iterations, work) ->
#: iterations, or -1.
CORRECTOR = types.FunctionType(
    types.int64(RESIDUAL_AND_JACOBIAN, ARRAY, ARRAY, ARRAY, ARRAY, ARRAY, types.float64, types.int64, MATRIX)
)

_LOCK = threading.RLock()


class Kernel:
    """A function that is compiled for its signatures when it is first called, alone or by another kernel.

    Parameters
    ----------
    function : function
    signatures : tuple of solver.kernels.types.Declared
    inline, inner, shared : bool
        As for `kernel`.
    """

    def __init__(self, function: Callable, signatures: tuple, inline: bool, inner: bool, shared: bool):
        functools.update_wrapper(self, function)
        self.signatures, self.inline, self.inner, self.shared = signatures, inline, inner, shared

    def __repr__(self):
        return f"<kernel {self.__module__}.{self.__qualname__}>"

    def __reduce__(self):
        return self.__qualname__

    def __call__(self, *arguments):
        return self.callable(*arguments)

    @functools.cached_property
    def callable(self):
        """What Python calls."""
        self.prepare()
        return self.__dict__["callable"]

    def prepare(self, wait: bool = True) -> bool:
        """Compile the kernel or read it from the cache; whether it is ready.

        Parameters
        ----------
        wait : bool
            Whether to wait for another process that is compiling it right now.
        """
        with _LOCK:
            if "callable" not in self.__dict__ and (ready := _backend().callable_of(self, wait)) is not None:
                self.__dict__["callable"] = ready
        return "callable" in self.__dict__

    def is_kept(self) -> bool:
        """Whether it is ready or in the cache, so that its first call does not wait for the compiler."""
        return "callable" in self.__dict__ or _backend().is_kept(self)

    @functools.cached_property
    def calls(self) -> tuple:
        """Kernels that the function finds outside."""
        function = self.__wrapped__
        outside = [function.__globals__.get(name) for name in function.__code__.co_names]
        outside += [cell.cell_contents for cell in function.__closure__ or ()]
        return tuple(dict.fromkeys(value for value in outside if isinstance(value, Kernel)))

    @functools.cached_property
    def content(self) -> str:
        """Digest of everything that the compiled kernel depends on within this package."""
        text = described_code(self.__wrapped__, Kernel)
        names = (self.__module__, self.__qualname__, repr(self.signatures), self.inline, self.shared)
        return hashlib.sha256(repr((names, text)).encode()).hexdigest()

    @functools.cached_property
    def _address(self) -> int:
        return _backend().address_of(self)

    def __wrapper_address__(self) -> int:
        """What numba asks for where this kernel is an argument."""
        return self._address


@functools.cache
def _backend():
    from solver.kernels import backend

    backend.register(Kernel)
    return backend


def kernel(*signatures, inline: bool = False, inner: bool = False, shared: bool = False):
    """Compile a function for what is declared, without the interpreter, and cache the result on disk.

    Parameters
    ----------
    *signatures : solver.kernels.types.Declared
        What the function is compiled for, usually one; callers convert to it.
    inline
        Let LLVM inline the function at every call (small functions of the inner loop). It is then an inner one.
    inner
        The function is called by other kernels: it is compiled with them and is part of what they keep on disk.
    shared
        Other kernels call the function, which is compiled once and kept on its own: for large ones that several kernels
        need. Nothing of it is inlined.

    Returns
    -------
    callable
        Decorator. Division by zero gives inf or nan as in NumPy; no fast-math, so results do not depend on how
        the compiler groups sums.
    """
    return lambda function: Kernel(function, signatures, inline, inner or inline, shared)
