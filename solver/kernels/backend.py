"""What numba makes of kernels; the only module that imports numba, and the last one to be imported."""

import hashlib
import os
import pickle
import sys
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba.core import compiler, typing
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult
from numba.core.registry import cpu_target
from numba.core.serialize import dumps
from numba.core.typing.typeof import Purpose
from numba.extending import lower_builtin, models, register_model, typeof_impl
from numba.core.imputils import lower_constant

from solver.kernels.compile import Kernel
from solver.kernels.store import kernel_store

__all__ = ["dispatcher_of"]

OPT = os.environ.get("KOPT", "1")
OPTIONS = {"error_model": "numpy"}


class _Linked(JITCodeLibrary):
    """Code of an inner kernel as numba made it: it is optimised and compiled within the kernel that it is linked to."""

    def _optimize_functions(self, ll_module):
        ll_module.data_layout = self._codegen._data_layout
        if "f" in OPT:
            super()._optimize_functions(ll_module)

    def finalize(self):
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        self._finalized = True


class KernelType(numba.types.Callable, numba.types.Opaque):
    """Type of a kernel among the globals of another one."""

    def __init__(self, kernel):
        self.kernel = kernel
        self.compiled = {}
        super().__init__(f"kernel {kernel.__module__}.{kernel.__qualname__} {id(kernel)}")

    def get_call_type(self, context, args, kws):
        assert not kws
        template = typing.make_concrete_template(self.kernel.__name__, self, list(self._signatures()))
        signature = template(context).apply(args, kws)
        return signature

    def _signatures(self):
        for declared in self.kernel.signatures:
            signature = declared.numba
            if signature.args not in self.compiled:
                self.compiled[signature.args] = self._compile(signature)
            yield self.compiled[signature.args].signature

    def _compile(self, signature):
        flags = compiler.Flags()
        cpu_target.options.parse_as_flags(
            flags,
            {**OPTIONS, "nopython": True, "forceinline": self.kernel.inline, "no_cpython_wrapper": True,
             "no_cfunc_wrapper": True},
        )
        flags.no_compile = True
        context = cpu_target.target_context
        function = self.kernel.__wrapped__
        library = _Linked(context.codegen(), function.__qualname__)
        result = compiler.compile_extra(
            cpu_target.typing_context, context, function, signature.args, signature.return_type, flags, {},
            library=library,
        )
        context.insert_user_function((self, signature.args), result.fndesc, [library])
        return result

    def get_call_signatures(self):
        return list(self._signatures()), False

    def get_impl_key(self, signature):
        return (self, signature.args)


register_model(KernelType)(models.OpaqueModel)


@lower_constant(KernelType)
def _(context, builder, kernel_type, value):
    return context.get_dummy_value()


_TYPES = {}

@typeof_impl.register(Kernel)
def _(kernel: Kernel, context):
    """Among a kernel's globals another one is called directly; as an argument it is a function of its signature."""
    if context.purpose is Purpose.constant:
        if kernel not in _TYPES:
            _TYPES[kernel] = KernelType(kernel)
        return _TYPES[kernel]
    (signature,) = kernel.signatures
    return numba.types.FunctionType(signature.numba)


def dispatcher_of(kernel: Kernel):
    """Numba's dispatcher of a kernel, compiled or read from the cache for what it declares and for nothing else."""
    dispatcher = numba.njit(**OPTIONS)(kernel.__wrapped__)
    dispatcher._cache = _Cache(kernel)
    for signature in kernel.signatures:
        dispatcher.compile(signature.numba)
    dispatcher.disable_compile()
    return dispatcher


def wrapper_address(kernel: Kernel) -> int:
    """Address of the function that other kernels call when they were given this one as an argument."""
    (result,) = kernel.dispatcher.overloads.values()
    return result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name)


_VERSIONS = repr((sys.version, numba.__version__, llvmlite.__version__, np.__version__, Path(__file__).read_bytes()))


class _Cache:
    """The cache of one kernel, as a numba dispatcher asks for it."""

    cache_path = None

    def __init__(self, kernel: Kernel):
        self._kernel = kernel

    def _entry(self, target_context) -> str:
        """Name of the entry's file."""
        key = repr((self._kernel.content, _VERSIONS, target_context.codegen().magic_tuple()))
        name = f"{self._kernel.__module__}.{self._kernel.__qualname__}".replace("<locals>", "")
        return f"{name}-{hashlib.sha256(key.encode()).hexdigest()[:32]}.kernel"

    def load_overload(self, signature, target_context):
        """A stored compile result, or None."""
        target_context.refresh()
        name = self._entry(target_context)
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
        if kernel_store().folder is not None and not result.library.has_dynamic_globals:
            kernel_store().write(self._entry(result.target_context), dumps(result._reduce()))
