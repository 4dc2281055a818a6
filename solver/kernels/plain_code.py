"""How the code of what kernels do most is written: elements of arrays, sums and products of numbers, loops over ranges.

The instructions are those that remain of numba's after LLVM has cleaned them up. Numba's own are three to five times as
many, and are still written for everything else.
"""

import operator

from llvmlite import ir as llvm
from numba import types
from numba.core import ir, lowering

__all__ = ["PlainCode"]

#: Fields of an array as numba keeps it: (owner, parent, items, bytes an item, data, shape, strides).
_ITEMS, _DATA, _SHAPE, _STRIDES = 2, 4, 5, 6

#: Instructions for two numbers of type float64, and for two of type int64; they are those of numba.
_FLOAT = {
    operator.add: lambda builder, a, b: builder.fadd(a, b),
    operator.sub: lambda builder, a, b: builder.fsub(a, b),
    operator.mul: lambda builder, a, b: builder.fmul(a, b),
    operator.truediv: lambda builder, a, b: builder.fdiv(a, b),
    operator.eq: lambda builder, a, b: builder.fcmp_ordered("==", a, b),
    operator.ne: lambda builder, a, b: builder.fcmp_unordered("!=", a, b),
    operator.lt: lambda builder, a, b: builder.fcmp_ordered("<", a, b),
    operator.le: lambda builder, a, b: builder.fcmp_ordered("<=", a, b),
    operator.gt: lambda builder, a, b: builder.fcmp_ordered(">", a, b),
    operator.ge: lambda builder, a, b: builder.fcmp_ordered(">=", a, b),
}
_INTEGER = {
    operator.add: lambda builder, a, b: builder.add(a, b),
    operator.sub: lambda builder, a, b: builder.sub(a, b),
    operator.mul: lambda builder, a, b: builder.mul(a, b),
    operator.eq: lambda builder, a, b: builder.icmp_signed("==", a, b),
    operator.ne: lambda builder, a, b: builder.icmp_signed("!=", a, b),
    operator.lt: lambda builder, a, b: builder.icmp_signed("<", a, b),
    operator.le: lambda builder, a, b: builder.icmp_signed("<=", a, b),
    operator.gt: lambda builder, a, b: builder.icmp_signed(">", a, b),
    operator.ge: lambda builder, a, b: builder.icmp_signed(">=", a, b),
}
_OPERATIONS = {(types.float64, types.float64): _FLOAT, (types.int64, types.int64): _INTEGER}


def _int64(number: int):
    return llvm.Constant(llvm.IntType(64), number)


class PlainCode(lowering.Lower):
    """Writes the code of a function."""

    def lower_inst(self, inst):
        if isinstance(inst, ir.StaticSetItem) and isinstance(self.typeof(inst.target.name), types.Array):
            self.lower_setitem(inst.target, inst.index_var, inst.value, self.fndesc.calltypes[inst])
        else:
            super().lower_inst(inst)

    def lower_expr(self, resty, expr):
        if expr.op in ("getiter", "iternext", "pair_first", "pair_second"):
            kind = self.typeof(expr.value.name)
            if expr.op == "getiter" and kind == types.range_state64_type:
                if (step := self._step_of_range(expr.value)) is not None:
                    return self._begin_range(resty, self.loadvar(expr.value.name), step)
            elif expr.op == "iternext" and kind == types.range_iter64_type:
                return self._next_of_range(resty, self.loadvar(expr.value.name))
            elif expr.op.startswith("pair") and kind.first_type == types.int64:
                return self.builder.extract_value(self.loadvar(expr.value.name), int(expr.op == "pair_second"))
        if expr.op == "static_getitem" and isinstance(self.typeof(expr.value.name), types.Array):
            return self.lower_getitem(resty, expr, expr.value, expr.index_var, self.fndesc.calltypes[expr])
        return super().lower_expr(resty, expr)

    def lower_binop(self, resty, expr, op):
        signature = self.fndesc.calltypes[expr]
        write = _OPERATIONS.get(signature.args, {}).get(op)
        if write is None or resty not in (signature.return_type, types.boolean):
            return super().lower_binop(resty, expr, op)
        return write(self.builder, *map(self._cast_var, (expr.lhs, expr.rhs), signature.args))

    # Elements of arrays.

    def lower_getitem(self, resty, expr, value, index, signature):
        array_type = self.typeof(value.name)
        if (indices := self._plain_indices(array_type, index)) is None:
            return super().lower_getitem(resty, expr, value, index, signature)
        array = self.loadvar(value.name)
        pointer = self._pointer(array, array_type, indices)
        if len(indices) == array_type.ndim:
            item = self.context.unpack_value(self.builder, array_type.dtype, pointer)
            return self.context.cast(self.builder, item, array_type.dtype, resty)
        part = self._part(array, resty, pointer, len(indices))
        self.incref(resty, part)
        return part

    def lower_setitem(self, target_var, index_var, value_var, signature):
        array_type = self.typeof(target_var.name)
        indices = self._plain_indices(array_type, index_var)
        if indices is None or len(indices) < array_type.ndim:
            super().lower_setitem(target_var, index_var, value_var, signature)
            return
        pointer = self._pointer(self.loadvar(target_var.name), array_type, indices)
        value = self._cast_var(value_var, signature.args[2])
        value = self.context.cast(self.builder, value, signature.args[2], array_type.dtype)
        self.context.pack_value(self.builder, array_type.dtype, value, pointer)

    def _plain_indices(self, array_type, index) -> list | None:
        """Type and value of each index of an array that lies in one piece; None if there is anything but integers."""
        if not isinstance(array_type, types.Array) or self.context.enable_boundscheck:
            return None
        index_type = self.typeof(index.name)
        is_tuple = isinstance(index_type, types.BaseTuple)
        kinds = tuple(index_type) if is_tuple else (index_type,)
        signed = all(isinstance(kind, types.Integer) and kind.signed for kind in kinds)
        if array_type.layout != "C" or not array_type.aligned or not signed or not 0 < len(kinds) <= array_type.ndim:
            return None
        value = self.loadvar(index.name)
        values = [self.builder.extract_value(value, i) for i in range(len(kinds))] if is_tuple else [value]
        return [
            _int64(kind.literal_value)
            if isinstance(kind, types.IntegerLiteral)
            else self.context.cast(self.builder, value, kind, types.int64)
            for kind, value in zip(kinds, values, strict=True)
        ]

    def _pointer(self, array, array_type, indices: list):
        """Address of an element, or of the first of a part; negative indices count from the end."""
        builder, offset = self.builder, None
        for axis in range(array_type.ndim):
            if offset is not None:
                offset = builder.mul(offset, builder.extract_value(array, (_SHAPE, axis)))
            if axis == len(indices):
                # What is left is a part: its size scales the offset, its own first element is where it begins.
                for later in range(axis + 1, array_type.ndim):
                    offset = builder.mul(offset, builder.extract_value(array, (_SHAPE, later)))
                break
            index = self._from_the_start(array, axis, indices[axis])
            offset = index if offset is None else builder.add(offset, index)
        return builder.gep(builder.extract_value(array, _DATA), [offset])

    def _from_the_start(self, array, axis: int, index):
        builder = self.builder
        if isinstance(index, llvm.Constant):
            if index.constant >= 0:
                return index
            return builder.add(builder.extract_value(array, (_SHAPE, axis)), index)
        wrapped = builder.add(builder.extract_value(array, (_SHAPE, axis)), index)
        return builder.select(builder.icmp_signed("<", index, _int64(0)), wrapped, index)

    def _part(self, array, part_type, pointer, n_leading: int):
        """An array of what the first indices leave."""
        builder = self.builder
        part = llvm.Constant(self.context.get_value_type(part_type), llvm.Undefined)
        for field in range(_DATA):
            if field != _ITEMS:
                part = builder.insert_value(part, builder.extract_value(array, field), field)
        part = builder.insert_value(part, pointer, _DATA)
        items = None
        for axis in range(part_type.ndim):
            size = builder.extract_value(array, (_SHAPE, n_leading + axis))
            items = size if items is None else builder.mul(items, size)
            part = builder.insert_value(part, size, (_SHAPE, axis))
            stride = builder.extract_value(array, (_STRIDES, n_leading + axis))
            part = builder.insert_value(part, stride, (_STRIDES, axis))
        return builder.insert_value(part, items, _ITEMS)

    # Loops over ranges, whose state is (start, stop, step) and whose iterator is (next*, stop, step, number left*).

    def _step_of_range(self, variable) -> int | None:
        """Step of a range if it is known to be 1 or -1."""
        made = self.func_ir.get_definition(variable)
        if len(made.args) < 3:
            return 1
        step = self.typeof(made.args[2].name)
        return step.literal_value if isinstance(step, types.IntegerLiteral) and abs(step.literal_value) == 1 else None

    def _begin_range(self, iterator_type, state, step: int):
        builder = self.builder
        start, stop = (builder.extract_value(state, i) for i in range(2))
        span = builder.sub(stop, start) if step > 0 else builder.sub(start, stop)
        left = builder.select(builder.icmp_signed(">", span, _int64(0)), span, _int64(0))
        iterator = llvm.Constant(self.context.get_value_type(iterator_type), llvm.Undefined)
        for i, value in ((0, self._stored(start)), (1, stop), (2, _int64(step)), (3, self._stored(left))):
            iterator = builder.insert_value(iterator, value, i)
        return iterator

    def _stored(self, value):
        """Address of a value in the function's frame."""
        with self.builder.goto_entry_block():
            pointer = self.builder.alloca(value.type)
        self.builder.store(value, pointer)
        return pointer

    def _next_of_range(self, pair_type, iterator):
        builder = self.builder
        next_at, step, left_at = (builder.extract_value(iterator, i) for i in (0, 2, 3))
        left, value = builder.load(left_at), builder.load(next_at)
        is_valid = builder.icmp_signed(">", left, _int64(0))
        with builder.if_then(is_valid):
            builder.store(builder.sub(left, _int64(1), flags=["nsw"]), left_at)
            builder.store(builder.add(value, step), next_at)
        pair = llvm.Constant(self.context.get_value_type(pair_type), llvm.Undefined)
        return builder.insert_value(builder.insert_value(pair, value, 0), is_valid, 1)
