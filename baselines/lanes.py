"""Numbers side by side in compiled code: one `Lanes` holds LANES float64 in a vector register.

Code that is written for one number works on `Lanes` as it stands where it does not branch: sums,
products and quotients go lane by lane, with a float64 beside them in every lane. Comparisons give
a `Mask`, and `select` takes what a branch would. The vector instructions do not depend on what a
compiler makes of a loop: LLVM maps a vector to one register of AVX-512, or to two of AVX2.

What is here is njit code's alone: in Python there is no such number.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

from robots.compiled import njit

LANES = 8
LINE_BYTES = 64  # of a cache line, and of a vector of eight float64
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_BITS = ir.VectorType(ir.IntType(64), LANES)
_MASK = ir.VectorType(ir.IntType(1), LANES)
_INDEX = ir.IntType(32)


class LanesType(types.Type):
    """Type of LANES float64 in one vector."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


class MaskType(types.Type):
    """Type of LANES truth values."""

    def __init__(self) -> None:
        super().__init__(name="Mask")


lanes_type, mask_type = LanesType(), MaskType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _MASK)


def _spread(builder: Any, value: Any) -> Any:
    """Put a float64 into every lane; vectors are left as they are."""
    if value.type != ir.DoubleType():
        return value
    first = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, _INDEX(0))
    nowhere = ir.Constant(ir.VectorType(_INDEX, LANES), [0] * LANES)
    return builder.shuffle_vector(first, ir.Constant(_VECTOR, ir.Undefined), nowhere)


_LANES_PAIRS = (
    (lanes_type, lanes_type),
    (lanes_type, types.float64),
    (types.float64, lanes_type),
)


def _declare(function: Any, result: types.Type, cases: Any, emit: Any) -> None:
    """Give an operator of Python a meaning for lanes or masks.

    Args:
        function: The operator, of `operator`.
        result: Type of its result.
        cases: Types of its operands, a tuple each.
        emit: Makes its instruction, from a builder and the operands, each in all lanes.
    """

    class Template(AbstractTemplate):
        def generic(self, arguments: Any, keywords: Any) -> Any:
            return signature(result, *arguments) if tuple(arguments) in cases else None

    infer_global(function)(Template)

    def lower(context: Any, builder: Any, kind: Any, values: Any) -> Any:
        return emit(builder, *(_spread(builder, value) for value in values))

    for case in cases:
        lower_builtin(function, *case)(lower)


def _negated(builder: Any, value: Any) -> Any:
    return builder.fsub(ir.Constant(_VECTOR, [-0.0] * LANES), value)


def _comparison(sign: str) -> Any:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


for _function, _name in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _declare(_function, lanes_type, _LANES_PAIRS, getattr(ir.IRBuilder, _name))
for _function, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _declare(_function, mask_type, _LANES_PAIRS, _comparison(_sign))
for _function, _name in ((operator.and_, "and_"), (operator.or_, "or_"), (operator.xor, "xor")):
    _declare(_function, mask_type, ((mask_type, mask_type),), getattr(ir.IRBuilder, _name))
_declare(operator.neg, lanes_type, ((lanes_type,),), _negated)
_declare(operator.invert, mask_type, ((mask_type,),), ir.IRBuilder.not_)


def _row(context: Any, builder: Any, kind: Any, array: Any, row: Any) -> Any:
    """Pointer to row `row` of an array (n, LANES)."""
    data = context.make_array(kind)(context, builder, array).data
    start = builder.mul(row, ir.Constant(row.type, LANES))
    return builder.bitcast(builder.gep(data, [start]), _VECTOR.as_pointer())


@intrinsic
def load(typing, array, row):  # type: ignore[no-untyped-def]
    """Return row `row` of a C-contiguous float64 array (n, LANES)."""
    if not _is_room(array):
        return None

    def emit(context: Any, builder: Any, kind: Any, values: Any) -> Any:
        return builder.load(_row(context, builder, kind.args[0], *values), align=8)

    return lanes_type(array, types.intp), emit


@intrinsic
def store(typing, array, row, value):  # type: ignore[no-untyped-def]
    """Write lanes, or a float64 into all lanes, into row `row` of a float64 array (n, LANES)."""
    if not _is_room(array) or value not in (lanes_type, types.float64):
        return None

    def emit(context: Any, builder: Any, kind: Any, values: Any) -> Any:
        pointer = _row(context, builder, kind.args[0], *values[:2])
        builder.store(_spread(builder, values[2]), pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, value), emit


def _is_room(array: Any) -> bool:
    return isinstance(array, types.Array) and (array.ndim, array.layout) == (2, "C")


@intrinsic
def lanes_of(typing, value):  # type: ignore[no-untyped-def]
    """Put a float64 into every lane."""
    if value != types.float64:
        return None

    def emit(context: Any, builder: Any, kind: Any, values: Any) -> Any:
        return _spread(builder, values[0])

    return lanes_type(value), emit


@intrinsic
def select(typing, mask, yes, no):  # type: ignore[no-untyped-def]
    """Return `yes` in the lanes where a mask holds, `no` in the others; each lanes or float64."""
    if mask != mask_type or not {yes, no} <= {lanes_type, types.float64}:
        return None

    def emit(context: Any, builder: Any, kind: Any, values: Any) -> Any:
        return builder.select(values[0], _spread(builder, values[1]), _spread(builder, values[2]))

    return lanes_type(mask, yes, no), emit


def _call(builder: Any, name: str, *values: Any) -> Any:
    """Call an intrinsic function of LLVM on vectors."""
    kind = ir.FunctionType(_VECTOR, [_VECTOR] * len(values))
    function = cgutils.get_or_insert_function(builder.module, kind, f"{name}.v{LANES}f64")
    return builder.call(function, values)


@intrinsic
def root(typing, value):  # type: ignore[no-untyped-def]
    """Square root of every lane."""
    if value != lanes_type:
        return None

    def emit(context: Any, builder: Any, kind: Any, values: Any) -> Any:
        return _call(builder, "llvm.sqrt", values[0])

    return lanes_type(value), emit


@intrinsic
def bit(typing, value, index):  # type: ignore[no-untyped-def]
    """Whether bit `index` of the float64's 64 bits is set, the lowest first."""
    if value != lanes_type or not isinstance(index, types.IntegerLiteral):
        return None
    number = index.literal_value

    def emit(context: Any, builder: Any, kind: Any, values: Any) -> Any:
        wanted = ir.Constant(_BITS, [1 << number] * LANES)
        bits = builder.and_(builder.bitcast(values[0], _BITS), wanted)
        return builder.icmp_unsigned("!=", bits, ir.Constant(_BITS, [0] * LANES))

    return mask_type(value, index), emit


@intrinsic
def mask_bits(typing, mask):  # type: ignore[no-untyped-def]
    """Return a mask as a whole number, lane k in bit k."""
    if mask != mask_type:
        return None

    def emit(context: Any, builder: Any, kind: Any, values: Any) -> Any:
        return builder.zext(builder.bitcast(values[0], ir.IntType(LANES)), ir.IntType(64))

    return types.int64(mask), emit


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def least(a, b):  # type: ignore[no-untyped-def]
    """Lane by lane the smaller one."""
    return select(a < b, a, b)


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def greatest(a, b):  # type: ignore[no-untyped-def]
    """Lane by lane the greater one."""
    return select(a > b, a, b)
