"""Products of matrices for small perceptrons in compiled code, at the processor's rate.

One tile is a few rows by a few vectors of outputs, whose sums stay in registers while it runs over
all inputs; a weight is read once for all rows of a tile. The tile is written as vector instructions
for LLVM, which splits a vector of 64 bytes into what the processor has, because its optimiser does
not find this form from loops. Weights are packed once, see `pack_layer`. All of it is compiled for
float32 or float64, whichever the arrays hold.

A sum is the bias and then one product after the other, whatever rows stand beside it, so that an
answer does not depend on its batch; libraries of linear algebra do not promise that.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils, codegen, config
from numba.extending import intrinsic
from numpy.typing import DTypeLike, NDArray

from robots.compiled import njit

BYTES = 64  # of a vector: 16 floats, or 8 of twice the size
VECTOR = 16  # widths of layers are padded to a multiple of it
PANELS = (4, 2, 1)  # vectors of panels, widest first; four of 128 rows fit the first cache


def _has_wide_registers() -> bool:
    """Whether this process compiles for 32 registers of 64 bytes (AVX-512), not 16 of 32."""
    features = config.CPU_FEATURES
    return "+avx512f" in (codegen.get_host_cpu_features() if features is None else features)


# Rows and vectors of a tile: 16 of 32 registers hold sums, or 12 of 16 where a vector takes two.
ROWS, MOST_VECTORS = (4, 4) if _has_wide_registers() else (6, 1)
WIDE, MIDDLE, NARROW = (min(vectors, MOST_VECTORS) for vectors in PANELS)


def panels(width: int, dtype: DTypeLike) -> list[int]:
    """Return the widths of the panels that a layer of a width, a multiple of `VECTOR`, is cut into.

    Args:
        width: Outputs of the layer.
        dtype: Of its numbers.
    """
    cut: list[int] = []
    for vectors in PANELS:
        panel = vectors * BYTES // np.dtype(dtype).itemsize
        while width - sum(cut) >= panel:
            cut.append(panel)
    return cut


def pack_layer(
    weight: NDArray[np.float64], bias: NDArray[np.float64], dtype: DTypeLike
) -> NDArray[np.floating]:
    """Pack layers for `linear`: panel by panel, of each the biases and then the rows of weights.

    Args:
        weight: (E, n, m) of E networks, m a multiple of `VECTOR`.
        bias: (E, m).
        dtype: float32 or float64, in which the layers compute.

    Returns:
        (E, (n + 1) m).
    """
    both = np.concatenate((bias[:, None], weight), axis=1).astype(dtype)
    edges = np.cumsum(panels(both.shape[2], dtype))[:-1]
    parts = np.split(both, edges, axis=2)
    return np.concatenate([part.reshape(len(both), -1) for part in parts], axis=1)


class _TileBuilder:
    """Writes the instructions of one tile.

    Args:
        builder: Where they go.
        rows: Rows of the tile.
        vectors: Vectors of outputs.
        bits: Of a number, 32 or 64.
    """

    def __init__(self, builder: Any, rows: int, vectors: int, bits: int) -> None:
        self.builder, self.rows, self.vectors = builder, rows, vectors
        self.align, self.lanes = bits // 8, 8 * BYTES // bits
        self.vector = ir.VectorType(ir.FloatType() if bits == 32 else ir.DoubleType(), self.lanes)
        form = ir.FunctionType(self.vector, [self.vector] * 3)
        # Unlike llvm.fma it is two instructions, not a call, where the processor cannot fuse them.
        self.multiply_add = cgutils.get_or_insert_function(
            builder.module, form, f"llvm.fmuladd.v{self.lanes}f{bits}"
        )

    def _pointer(self, base: Any, offset: Any, index: int) -> Any:
        constant = ir.Constant(offset.type, self.lanes * index)
        at = self.builder.gep(base, [self.builder.add(offset, constant)])
        return self.builder.bitcast(at, self.vector.as_pointer())

    def _load(self, base: Any, offset: Any) -> list[Any]:
        return [
            self.builder.load(self._pointer(base, offset, index), align=self.align)
            for index in range(self.vectors)
        ]

    def _spread(self, number: Any) -> Any:
        """Return a vector whose numbers are all this one."""
        unset = ir.Constant(self.vector, ir.Undefined)
        first = self.builder.insert_element(unset, number, ir.Constant(ir.IntType(32), 0))
        mask = ir.Constant(ir.VectorType(ir.IntType(32), self.lanes), [0] * self.lanes)
        return self.builder.shuffle_vector(first, unset, mask)

    def write(self, values: Any, depth: Any, panel: Any, width: Any, out: Any, step: Any) -> None:
        """Write out[r, j] = panel[0, j] + the sum over k of values[r, k] panel[1 + k, j].

        Args:
            values: Pointer to the inputs; a row is `depth` after the one before.
            depth: Inputs.
            panel: Pointer to the biases of the tile, `width` before its first row of weights.
            width: Of the panel.
            out: Pointer to the outputs; a row is `step` after the one before.
            step: Numbers from row to row of the outputs.
        """
        builder, zero = self.builder, ir.Constant(depth.type, 0)
        biases = self._load(panel, zero)
        # LLVM turns these places in memory into registers.
        sums = [
            [cgutils.alloca_once_value(builder, bias) for bias in biases] for _ in range(self.rows)
        ]
        lines = [
            builder.gep(values, [builder.mul(depth, ir.Constant(depth.type, row))])
            for row in range(self.rows)
        ]
        weights = builder.gep(panel, [width])
        with cgutils.for_range(builder, depth) as loop:
            shared = self._load(weights, builder.mul(loop.index, width))
            for row in range(self.rows):
                value = self._spread(builder.load(builder.gep(lines[row], [loop.index])))
                for total, weight in zip(sums[row], shared, strict=True):
                    result = builder.call(self.multiply_add, [value, weight, builder.load(total)])
                    builder.store(result, total)
        for row in range(self.rows):
            offset = builder.mul(step, ir.Constant(step.type, row))
            for index, total in enumerate(sums[row]):
                at = self._pointer(out, offset, index)
                builder.store(builder.load(total), at, align=self.align)


@intrinsic(prefer_literal=True)
def _tile(  # type: ignore[no-untyped-def]
    context, rows, vectors, values, start, depth, packed, begin, width, out, place, step
):
    """One tile, see `_TileBuilder.write`; `rows` and `vectors` are literals.

    Arrays are flat, each followed by where in it the tile begins.
    """
    if not isinstance(rows, types.IntegerLiteral) or not isinstance(vectors, types.IntegerLiteral):
        return None
    size = rows.literal_value, vectors.literal_value, values.dtype.bitwidth
    signature = types.void(
        rows, vectors, values, start, depth, packed, begin, width, out, place, step
    )

    def write(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        def pointer(index: int) -> Any:
            array = context.make_array(signature.args[index])
            data = array(context, builder, arguments[index]).data
            return builder.gep(data, [arguments[index + 1]])

        # An array and its offset are followed by one length each, but for the inputs' lengths.
        values, depth, packed, width = pointer(2), arguments[4], pointer(5), arguments[7]
        _TileBuilder(builder, *size).write(values, depth, packed, width, pointer(8), arguments[10])
        return context.get_dummy_value()

    codegen_of: Callable[..., Any] = write
    return signature, codegen_of


@intrinsic
def _lanes_of(context, values):  # type: ignore[no-untyped-def]
    """Numbers of a vector, a constant for the compiler."""
    lanes = 8 * BYTES // values.dtype.bitwidth

    def write(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        return context.get_constant(types.int64, lanes)

    codegen_of: Callable[..., Any] = write
    return types.int64(values), codegen_of


@njit(inline="always")
def _panel(values, start, rows, depth, packed, begin, columns, place, step, most, vectors):  # type: ignore[no-untyped-def]
    """One panel: tiles of `ROWS` rows and `most` vectors, the rest of the rows one by one."""
    row, step_of_tiles = 0, most * _lanes_of(values)
    while row + ROWS <= rows:
        for shift in range(0, columns, step_of_tiles):
            _tile(
                ROWS, most, values, start + row * depth, depth,
                packed, begin + shift, columns, values, place + row * step + shift, step,
            )  # fmt: skip
        row += ROWS
    while row < rows:
        _tile(
            1, vectors, values, start + row * depth, depth,
            packed, begin, columns, values, place + row * step, step,
        )  # fmt: skip
        row += 1


@njit(_nrt=False)
def linear(values, start, rows, depth, packed, begin, width, place):  # type: ignore[no-untyped-def]
    """Rows through a linear layer: outputs = inputs weight + bias.

    Both lie in one flat array, and what is elsewhere is given as a place in an array: in compiled
    code a slice counts its users by two atomic instructions, which takes as long as a short row.

    Args:
        values: Holds the inputs and receives the outputs; they do not overlap.
        start: Where the inputs begin, `depth` numbers a row.
        rows: Rows.
        depth: Inputs of the layer.
        packed: Flat, holds the layer as `pack_layer` makes it.
        begin: Where in it the layer begins.
        width: Outputs of the layer, a multiple of `VECTOR`.
        place: Where the outputs begin, `width` numbers a row.
    """
    column, lanes = 0, _lanes_of(values)
    while column < width:
        if width - column >= 4 * lanes:
            columns = 4 * lanes
            _panel(
                values, start, rows, depth, packed, begin, columns, place + column, width, WIDE, 4
            )
        elif width - column >= 2 * lanes:
            columns = 2 * lanes
            _panel(
                values, start, rows, depth, packed, begin, columns, place + column, width, MIDDLE, 2
            )  # fmt: skip
        else:
            columns = lanes
            _panel(
                values, start, rows, depth, packed, begin, columns, place + column, width, NARROW, 1
            )  # fmt: skip
        column += columns
        begin += (depth + 1) * columns
