"""What numba makes of kernels. Only this module, `lowering` and `plain_code` import numba, at the first kernel.

Numba by itself optimises and compiles every function alone, and then again within each of its callers. Here a kernel is
typed and lowered once (`_Lowered`); it is optimised and compiled only as part of a unit (`_Unit`), together with all
that it calls. A unit is what Python calls or hands on, or a kernel that is shared: other units call the machine code of
that one by its name.
"""

import contextlib
import copy
import functools
import gc
import hashlib
import itertools
import pickle
import sys
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba.core import compiler, compiler_machinery, errors, typed_passes, typing, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.environment import Environment
from numba.core.imputils import lower_constant
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.typing.typeof import Purpose
from numba.extending import models, register_model, typeof_impl

from solver.kernels import lowering, plain_code
from solver.kernels.lowering import KernelLowering, call_of, calling_kernels, owns_arrays
from solver.kernels.store import kernel_store

__all__ = ["address_of", "callable_of"]

#: Seconds to wait for another process that compiles the same kernel; then both do.
_PATIENCE = 120.0

_OPTIONS = {"nopython": True, "error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class _Library(JITCodeLibrary):
    """Code of functions."""

    def _optimize_functions(self, ll_module):
        # Numba would make the passes anew for each function, and for those that are declared only.
        ll_module.data_layout = self._codegen._data_layout
        passes, builder = self._codegen._function_pass_manager()
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)


class _Lowered(_Library):
    """A kernel's code before optimisation, with that of what it calls."""

    def finalize(self):
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        self._finalized = True


class _Unit(_Library):
    """A kernel's code and all that it calls, which cannot be seen from outside."""

    is_shared = False

    def _optimize_final_module(self):
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name == "linkonce_odr":
                function.linkage = "internal"
        # Numba would write every loop for vectors as well, and unroll it. Those of kernels are short, over coordinates
        # or harmonics: that doubles the code and the time to compile it, and makes nothing faster but a few loops of
        # shared kernels, which are compiled once. There, what is written side by side for four columns becomes one
        # instruction; the numbers stay the same to the bit.
        tuning = llvmlite.binding.create_pipeline_tuning_options(speed_level=2)
        tuning.loop_vectorization = tuning.loop_interleaving = False
        tuning.loop_unrolling = tuning.slp_vectorization = self.is_shared
        builder = llvmlite.binding.create_pass_builder(self._codegen._tm, tuning)
        passes = builder.getModulePassManager()
        passes.add_refprune_pass()
        passes.run(self._final_module, builder)

    def finish(self, lowered: _Lowered) -> None:
        """Compile a kernel that can be seen from outside."""
        lowered._ensure_finalized()
        self._final_module.link_in(lowered._final_module)
        self.finalize()


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


class _Typing(typing.Context):
    """Numba's knowledge of types, which remembers what a call with arguments of certain types was found to be.

    Numba looks for it anew at every call in every function, and several times in each.
    """

    @classmethod
    def of(cls, context: typing.Context):
        """The same knowledge: what either one learns the other one knows."""
        result = copy.copy(context)
        result.__class__, result._known = cls, {}
        return result

    def resolve_function_type(self, func, args, kws):
        arguments = (*args, *dict(kws).values())
        if not all(isinstance(one, numba.types.Type) for one in arguments):  # a constant index
            return super().resolve_function_type(func, args, kws)
        call = func, arguments, tuple(dict(kws))
        if (signature := self._known.get(call)) is None:
            signature = self._known[call] = super().resolve_function_type(func, args, kws)
        return signature


@functools.cache
def _typing() -> _Typing:
    return _Typing.of(cpu_target.typing_context)


class _Compiler(compiler.CompilerBase):
    """Numba's compiler; symbols are named after contents, so that two of one name from several processes are equal."""

    content = ""

    def define_pipelines(self):
        passes = compiler_machinery.PassManager("kernel")
        # Numba would analyse the whole code anew after each step, though each one does where the next needs it.
        passes._ENFORCING = False
        for one in _PASSES:
            passes.add_pass(one, one.__name__)
        passes.finalize()
        return [passes]

    def _compile_bytecode(self):
        identity = self.state.func_id
        identity.unique_id = self.content[:32]
        identity.unique_name = f"{identity.func_qualname}${identity.unique_id}"
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
        """The kernel for one signature, as other kernels call it: without machine code, or with it if it is shared."""
        if signature not in self._lowered:
            result = _shared_unit(self._kernel, signature) if self._kernel.shared else _lower(self._kernel, signature)
            libraries = [] if self._kernel.shared else [result.library]
            implemented = call_of(result.fndesc, libraries)
            context = cpu_target.target_context
            context.insert_func_defn([(implemented, self.get_impl_key(signature), signature.args)])
            self._lowered[signature] = result
        return self._lowered[signature]


def _lower(kernel, signature) -> compiler.CompileResult:
    """A kernel's code for one signature, before optimisation."""
    flags, context = compiler.Flags(), cpu_target.target_context
    options = {"forceinline": kernel.inline, "_nrt": owns_arrays(kernel)}
    cpu_target.options.parse_as_flags(flags, {**_OPTIONS, **options})
    flags.no_compile = True
    library = _Lowered(context.codegen(), kernel.__qualname__)
    made = _Compiler(_typing(), context, library, signature.args, signature.return_type, flags, {})
    made.content = kernel.content
    return made.compile_extra(kernel.__wrapped__)


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
        if (result := _unit(kernel, declared.numba, False, _PATIENCE if wait else 0.0)) is None:
            return None
        dispatcher.add_overload(result)
    dispatcher.disable_compile()
    return dispatcher


def is_kept(kernel) -> bool:
    """Whether the cache has what `callable_of` needs."""
    return numba.config.DISABLE_JIT or all(map(kernel_store().has, entries_of(kernel)))


def entries_of(kernel) -> list[str]:
    """Names of everything in the cache that `callable_of` needs."""
    needed = [(kernel, False), *((shared, True) for shared in _shared_by(kernel))]
    return [_entry_name(one, declared.numba, is_shared) for one, is_shared in needed for declared in one.signatures]


def address_of(kernel) -> int:
    """Address of what other kernels call when they were given this one as an argument."""
    (result,) = kernel.callable.overloads.values()
    return result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name)


def _unit(kernel, signature, is_shared: bool, patience: float) -> compiler.CompileResult | None:
    """A unit, read from the cache or else made and kept there; None if another process takes longer to make it."""
    name = _entry_name(kernel, signature, is_shared)
    if (result := _read(name, kernel, is_shared)) is None:
        with kernel_store().claimed(name, patience) as mine:
            if not mine and not patience:
                return None
            if (result := _read(name, kernel, is_shared)) is None:
                with _few_collections():
                    result = (_compiled_alone if is_shared else _compiled)(kernel, signature)
                _keep(name, result)
    return result


@contextlib.contextmanager
def _few_collections():
    """Python looks for garbage seldom: the many objects of a kernel that is being compiled are none."""
    thresholds = gc.get_threshold()
    gc.set_threshold(100_000, *thresholds[1:])
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)


@functools.cache
def _shared_unit(kernel, signature) -> compiler.CompileResult:
    """What other units call."""
    return _unit(kernel, signature, True, _PATIENCE)


@global_compiler_lock
def _compiled_alone(kernel, signature) -> compiler.CompileResult:
    lowered = _lower(kernel, signature)
    library = _new_unit(lowered)
    library.is_shared = True
    library.finish(lowered.library)
    return lowered._replace(library=library)


@global_compiler_lock
def _compiled(kernel, signature) -> compiler.CompileResult:
    # What numba can compile, which takes half a second to load and is not needed to read what is kept.
    cpu_target.typing_context.refresh()
    cpu_target.target_context.refresh()
    lowered = _kernel_type(kernel).lowered(signature)
    if kernel.shared:
        lowered = _with_constants_of_its_own(lowered)
    context = calling_kernels(cpu_target.target_context.subtarget(enable_nrt=owns_arrays(kernel)))
    library = _new_unit(lowered)
    if not kernel.shared:
        library.add_linking_library(lowered.library)
    wrapped = library, lowered.fndesc, lowered.environment, lowered.call_helper
    # So that other threads go on meanwhile: `pipeline.cli.process` ends a run whose kernel does not.
    context.create_cpython_wrapper(*wrapped, release_gil=True)
    context.create_cfunc_wrapper(*wrapped)
    entry_point = context.get_executable(library, lowered.fndesc, lowered.environment)
    return lowered._replace(library=library, entry_point=entry_point)


def _with_constants_of_its_own(lowered: compiler.CompileResult) -> compiler.CompileResult:
    """A shared kernel for Python, whose call makes objects of constants that the shared unit does not have.

    Numba knows constants by the name of their environment. Of two units that name the same one, those that are read
    last would go without theirs.
    """
    description = copy.copy(lowered.fndesc)
    description.env_name += ".python"
    return lowered._replace(fndesc=description, environment=Environment.from_fndesc(description))


def _new_unit(lowered: compiler.CompileResult) -> _Unit:
    library = _Unit(cpu_target.target_context.codegen(), lowered.fndesc.qualname)
    library.enable_object_caching()
    return library


def _keep(name: str, result: compiler.CompileResult) -> None:
    if kernel_store().folder is not None and not result.library.has_dynamic_globals:
        result.fndesc.typemap = result.fndesc.calltypes = None
        parts = result.library.serialize_using_object_code(), result.fndesc, result.environment, result.signature
        kernel_store().write(name, dumps(parts))


def _read(name: str, kernel, is_shared: bool) -> compiler.CompileResult | None:
    content = kernel_store().read(name)
    if content is None:
        return None
    # Machine code that this one calls is found by its name when this one is loaded.
    for shared in _shared_within(kernel) if is_shared else _shared_by(kernel):
        for declared in shared.signatures:
            _shared_unit(shared, declared.numba)
    context = cpu_target.target_context
    try:
        library, description, environment, signature = pickle.loads(content)
        library = context.codegen().unserialize_library(library)
        entry_point = None if is_shared else context.get_executable(library, description, environment)
    except Exception:  # whatever an entry of other software does: it is as good as none
        kernel_store().drop(name)
        return None
    return compiler.compile_result(
        library=library,
        fndesc=description,
        environment=environment,
        signature=signature,
        entry_point=entry_point,
        objectmode=False,
    )


@functools.cache
def _shared_within(kernel) -> list:
    """Shared kernels that a kernel calls, directly or through others."""
    inside = [[one] * one.shared + _shared_within(one) for one in kernel.calls]
    return list(dict.fromkeys(itertools.chain.from_iterable(inside)))


def _shared_by(kernel) -> list:
    """What must be loaded before the unit of a kernel that Python calls."""
    return [kernel] * kernel.shared + _shared_within(kernel)


@functools.cache
def _surroundings() -> str:
    """What compiled code depends on beside the kernel."""
    settings = [getattr(numba.config, name) for name in ("OPT", "BOUNDSCHECK")]
    versions = sys.version, numba.__version__, llvmlite.__version__, np.__version__
    sources = [Path(file).read_bytes() for file in (__file__, lowering.__file__, plain_code.__file__)]
    return repr((versions, cpu_target.target_context.codegen().magic_tuple(), settings, sources))


def _entry_name(kernel, signature, is_shared) -> str:
    key = hashlib.sha256(repr((kernel.content, str(signature), is_shared, _surroundings())).encode()).hexdigest()
    return f"{kernel.__module__}.{kernel.__name__}-{key[:32]}.kernel"
