"""What numba makes of kernels. Only this module and `lowering` import numba, when the first kernel is needed.

Numba by itself optimises and compiles every function alone, and then again within each of its callers. Here a kernel is
typed and lowered once (`_Lowered`); it is optimised and compiled only as part of what Python calls or hands on
(`_Callable`), together with all that it calls.
"""

import functools
import hashlib
import pickle
import sys
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba.core import compiler, compiler_machinery, errors, typed_passes, typing, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.imputils import lower_constant
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.typing.typeof import Purpose
from numba.extending import models, register_model, typeof_impl

from solver.kernels import lowering
from solver.kernels.lowering import KernelLowering, call_of, calling_kernels, owns_arrays
from solver.kernels.store import kernel_store

__all__ = ["address_of", "callable_of"]

#: Seconds to wait for another process that compiles the same kernel; then both do.
_PATIENCE = 120.0

_OPTIONS = {"nopython": True, "error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class _Lowered(JITCodeLibrary):
    """A kernel's code before optimisation, with that of what it calls."""

    def finalize(self):
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        self._finalized = True


class _Callable(JITCodeLibrary):
    """A kernel's code and all that it calls, of which nothing else can be seen from outside."""

    def _optimize_final_module(self):
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name == "linkonce_odr":
                function.linkage = "internal"
        super()._optimize_final_module()


#: What numba does with a kernel: as much of its usual course as kernels need, which have no closures and no generators.
_PASSES = (
    untyped_passes.TranslateByteCode,
    untyped_passes.FixupArgs,
    untyped_passes.IRProcessing,
    untyped_passes.GenericRewrites,
    untyped_passes.ReconstructSSA,
    typed_passes.NopythonTypeInference,
    typed_passes.PreLowerStripPhis,
    typed_passes.IRLegalization,
    typed_passes.AnnotateTypes,
    KernelLowering,
    typed_passes.NoPythonBackend,
)


class _Compiler(compiler.CompilerBase):
    """Numba's compiler; symbols are named after contents, so that two of one name from several processes are equal."""

    content = ""

    def define_pipelines(self):
        passes = compiler_machinery.PassManager("kernel")
        for one in _PASSES:
            passes.add_pass(one, one.__name__)
        passes.finalize()
        return [passes]

    def _compile_bytecode(self):
        self.state.func_id.unique_name = f"{self.state.func_id.func_qualname}${self.content[:32]}"
        return super()._compile_bytecode()


class _KernelType(numba.types.Callable, numba.types.Opaque):
    """Type of a kernel among the globals of a compiled function, which calls it with what it declares."""

    def __init__(self, kernel):
        self._kernel, self._lowered = kernel, {}
        super().__init__(f"{kernel!r} {id(kernel)}")

    def get_call_type(self, context, args, kws):
        if kws:
            raise errors.TypingError(f"{self._kernel!r} is called with keywords: {', '.join(kws)}")
        wanted = [declared.numba for declared in self._kernel.signatures if declared.numba.args == args]
        signatures = [self.lowered(wanted[0]).signature] if wanted else self.get_call_signatures()[0]
        return typing.make_concrete_template(self._kernel.__name__, self, signatures)(context).apply(args, kws)

    def get_call_signatures(self):
        return [self.lowered(declared.numba).signature for declared in self._kernel.signatures], False

    def get_impl_key(self, signature):
        return self, signature.args

    def lowered(self, signature) -> compiler.CompileResult:
        """The kernel for one signature, without machine code."""
        if signature not in self._lowered:
            flags, context = compiler.Flags(), cpu_target.target_context
            options = {"forceinline": self._kernel.inline, "_nrt": owns_arrays(self._kernel)}
            cpu_target.options.parse_as_flags(flags, {**_OPTIONS, **options})
            flags.no_compile = True
            library = _Lowered(context.codegen(), self._kernel.__qualname__)
            made = _Compiler(
                cpu_target.typing_context, context, library, signature.args, signature.return_type, flags, {}
            )
            made.content = self._kernel.content
            result = made.compile_extra(self._kernel.__wrapped__)
            implemented = call_of(result.fndesc, library)
            context.insert_func_defn([(implemented, self.get_impl_key(signature), signature.args)])
            self._lowered[signature] = result
        return self._lowered[signature]


register_model(_KernelType)(models.OpaqueModel)


@lower_constant(_KernelType)
def _(context, builder, kernel_type, kernel):
    return context.get_dummy_value()


@functools.cache
def _kernel_type(kernel) -> _KernelType:
    return _KernelType(kernel)


@functools.cache
def _function_type(kernel) -> numba.types.FunctionType:
    (declared,) = kernel.signatures
    return numba.types.FunctionType(declared.numba)


def _type_of(kernel, context):
    """Compiled functions call it directly where it is one of their globals, through a pointer where it is handed in."""
    return _kernel_type(kernel) if context.purpose is Purpose.constant else _function_type(kernel)


def register(kernel_class: type) -> None:
    """Tell numba what objects of a class are: `solver.kernels.compile.Kernel`."""
    typeof_impl.register(kernel_class)(_type_of)


@functools.cache
def _declare(argument: numba.types.NamedTuple) -> None:
    """Take tuples of a class for what a kernel declares: to look at their fields at every call would take 40 us."""
    typeof_impl.register(argument.instance_class)(lambda value, context: argument)


def callable_of(kernel, wait: bool):
    """What Python calls: compiled, or read from the cache, for what a kernel declares and for nothing else.

    None if another process is compiling it right now, and `wait` is False.
    """
    if numba.config.DISABLE_JIT:
        return kernel.__wrapped__
    dispatcher = numba.njit(error_model="numpy")(kernel.__wrapped__)
    # Compiled code calls numba's runtime, which numba itself starts before it compiles.
    rtsys.initialize(cpu_target.target_context)
    for declared in kernel.signatures:
        for argument in declared.numba.args:
            if isinstance(argument, numba.types.NamedTuple):
                _declare(argument)
        name = _entry_name(kernel, declared.numba)
        if (result := _read(name)) is None:
            with kernel_store().claimed(name, _PATIENCE if wait else 0.0) as mine:
                if not (mine or wait):
                    return None
                result = _read(name) or _compiled(kernel, declared.numba, name)
        dispatcher.add_overload(result)
    dispatcher.disable_compile()
    return dispatcher


def is_kept(kernel) -> bool:
    """Whether the cache has what `callable_of` needs."""
    return numba.config.DISABLE_JIT or all(
        kernel_store().has(_entry_name(kernel, declared.numba)) for declared in kernel.signatures
    )


def address_of(kernel) -> int:
    """Address of what other kernels call when they were given this one as an argument."""
    (result,) = kernel.callable.overloads.values()
    return result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name)


@global_compiler_lock
def _compiled(kernel, signature, name: str) -> compiler.CompileResult:
    # What numba can compile, which takes half a second to load and is not needed to read what is kept.
    cpu_target.typing_context.refresh()
    cpu_target.target_context.refresh()
    lowered = _kernel_type(kernel).lowered(signature)
    context = calling_kernels(lowered.target_context)
    library = _Callable(context.codegen(), lowered.fndesc.qualname)
    library.enable_object_caching()
    library.add_linking_library(lowered.library)
    wrapped = library, lowered.fndesc, lowered.environment, lowered.call_helper
    # So that other threads go on meanwhile: `pipeline.cli.process` ends a run whose kernel does not.
    context.create_cpython_wrapper(*wrapped, release_gil=True)
    context.create_cfunc_wrapper(*wrapped)
    entry_point = context.get_executable(library, lowered.fndesc, lowered.environment)
    result = lowered._replace(library=library, entry_point=entry_point)
    if kernel_store().folder is not None and not library.has_dynamic_globals:
        # The last part would set the environments of all that it calls. Only what Python calls needs one, its own.
        kernel_store().write(name, dumps((*result._reduce()[:-1], ())))
    return result


def _read(name: str) -> compiler.CompileResult | None:
    content = kernel_store().read(name)
    if content is None:
        return None
    try:
        return compiler.CompileResult._rebuild(cpu_target.target_context, *pickle.loads(content))
    except Exception:  # whatever an entry of other software does: it is as good as none
        kernel_store().drop(name)
        return None


@functools.cache
def _surroundings() -> str:
    """What compiled code depends on beside the kernel."""
    settings = [getattr(numba.config, name) for name in ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK")]
    versions = sys.version, numba.__version__, llvmlite.__version__, np.__version__
    sources = [Path(file).read_bytes() for file in (__file__, lowering.__file__)]
    return repr((versions, cpu_target.target_context.codegen().magic_tuple(), settings, sources))


def _entry_name(kernel, signature) -> str:
    key = hashlib.sha256(repr((kernel.content, str(signature), _surroundings())).encode()).hexdigest()
    return f"{kernel.__module__}.{kernel.__name__}-{key[:32]}.kernel"
