"""How the code of kernels is written: what is left out of the code that numba would write.

Numba's own code is two thirds longer, and takes as much longer to write, to read and to compile. It hands on every
number of every array on its own at each call. It counts references to all arrays, while only kernels that make arrays
have to: the others read and fill what their callers own.
"""

import copy

from numba import types
from numba.core import callconv, cgutils, compiler_machinery, typed_passes
from numba.core.cpu import CPUContext
from numba.core.imputils import user_function
from numba.core.registry import cpu_target

from solver.kernels.plain_code import PlainCode

__all__ = ["KernelLowering", "call_of", "calling_kernels", "owns_arrays"]

#: What makes arrays in NumPy, as far as kernels use it.
_ALLOCATING = {"copy", "empty", "full", "zeros"}


def owns_arrays(kernel) -> bool:
    """Whether a kernel makes arrays, hands some out, or takes some over from what it calls.

    All others count no references. Numba refuses to make an array in one of these.
    """
    returned = [declared.numba.return_type for each in (kernel, *kernel.calls) for declared in each.signatures]
    models_of = cpu_target.target_context.data_model_manager
    makes = not _ALLOCATING.isdisjoint(kernel.__wrapped__.__code__.co_names)
    return makes or any(models_of[one].contains_nrt_meminfo() for one in returned)


class _Arguments:
    """How a kernel is handed arrays and tuples: as they are, and not taken apart before each call."""

    def __init__(self, context, argument_types):
        self.argument_types = tuple(map(context.get_value_type, argument_types))

    def as_arguments(self, builder, values):
        return tuple(values)

    def from_arguments(self, builder, arguments):
        return tuple(arguments)

    def assign_names(self, arguments, names):
        for argument, name in zip(arguments, names, strict=True):
            argument.name = name


class _Convention(callconv.CPUCallConv):
    def _get_arg_packer(self, argtypes):
        return _Arguments(self.context, argtypes)


class _CallsKernels(CPUContext):
    """Numba's context, in which all that is declared and called is a kernel."""

    @property
    def call_conv(self):
        return _Convention(self)


def calling_kernels(context: CPUContext) -> CPUContext:
    """The context in which a kernel is declared and called."""
    result = copy.copy(context)
    result.__class__ = _CallsKernels
    return result


class _Lower(PlainCode):
    """Writes the code of a kernel, which is called as kernels are."""

    @property
    def call_conv(self):
        return _Convention(self.context)

    def setup_function(self, fndesc):
        context, self.context = self.context, calling_kernels(self.context)
        super().setup_function(fndesc)
        self.context = context

    def incref(self, typ, val):
        for pointer_type, pointer in self._references(typ, val):
            super().incref(pointer_type, pointer)

    def decref(self, typ, val):
        for pointer_type, pointer in self._references(typ, val):
            super().decref(pointer_type, pointer)

    def delvar(self, name):
        if self._is_counted(self.typeof(name)):
            super().delvar(name)

    def storevar(self, value, name, argidx=None):
        kind = self.typeof(name)
        if self._is_counted(kind) or name in self._singly_assigned_vars:
            super().storevar(value, name, argidx)
        else:
            # Numba would first load what is given up.
            self._alloca_var(name, kind)
            self.builder.store(value, self.getvar(name))

    def _is_counted(self, typ) -> bool:
        return self.context.enable_nrt and self.context.data_model_manager[typ].contains_nrt_meminfo()

    def _references(self, typ, val):
        """Pointers to what counts references to the arrays of a value: numba would take arrays apart to find them."""
        if not self._is_counted(typ):
            return
        if isinstance(typ, types.Array):
            yield types.MemInfoPointer(typ.dtype), self.builder.extract_value(val, 0)
        elif isinstance(typ, types.BaseTuple):
            for i, part in enumerate(typ.types):
                yield from self._references(part, self.builder.extract_value(val, i))
        else:
            yield typ, val

    def _lower_call_FunctionType(self, fnty, expr, signature):
        # Kernels that are handed in have an address, always: numba would also look for one in other places.
        arguments = self.fold_call_args(fnty, signature, expr.args, expr.vararg, expr.kws)
        proxy = cgutils.create_struct_proxy(self.typeof(expr.func.name))
        address = proxy(self.context, self.builder, value=self.loadvar(expr.func.name)).c_addr
        function = self.builder.bitcast(address, self.context.get_value_type(fnty.ftype))
        return self.builder.call(function, arguments)


@compiler_machinery.register_pass(mutates_CFG=True, analysis_only=False)
class KernelLowering(typed_passes.NativeLowering):
    """The step of numba's course in which a kernel's code is written."""

    _name = "kernel_lowering"

    @property
    def lowering_class(self):
        return _Lower


def call_of(description, libraries):
    """What writes the call of a kernel into the code of another.

    Parameters
    ----------
    description : numba.core.funcdesc.FunctionDescriptor
        Of the kernel that is called.
    libraries : list of numba.core.codegen.CodeLibrary
        That have its code; none if it is shared.
    """
    call = user_function(description, libraries)

    def written(context, builder, signature, arguments):
        return call(calling_kernels(context), builder, signature, arguments)

    written.libs, written.signature = call.libs, call.signature
    return written
