"""Products of matrices with vectors, eight rows at a time, as instructions of LLVM."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled, inlined

Array = NDArray[np.float64]

LANES = 8  # rows of every matrix are a multiple of it; where the processor has shorter vectors, LLVM splits them
FAST = ("contract",)


def _product(plus: bool, absolute: bool) -> Any:
    """An intrinsic: out = M v, or v + M v, or M |v|; see ``product``.

    LLVM's own vector loops start at several vectors a turn, and leave a matrix of 16 rows to single numbers.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        lanes, word = ir.VectorType(ir.DoubleType(), LANES), ir.IntType(64)

        def pointer(k: int) -> Any:
            kind = signature.args[k]
            return builder.gep(context.make_array(kind)(context, builder, arguments[k]).data, [arguments[k + 1]])

        def block(base: Any, at: Any) -> Any:
            return builder.bitcast(builder.gep(base, [at]), lanes.as_pointer())

        def spread(number: Any) -> Any:
            one = builder.insert_element(ir.Constant(lanes, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
            zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
            return builder.shuffle_vector(one, ir.Constant(lanes, ir.Undefined), zeros)

        matrix, vector, out = pointer(0), pointer(3), pointer(6)
        width, columns = arguments[2], arguments[5]
        size = context.get_function(abs, types.float64(types.float64)) if absolute else None
        sums = [cgutils.alloca_once(builder, lanes) for _ in range(2)]  # two, since one would wait for itself
        nothing = ir.Constant(lanes, [0.0] * LANES)
        number = ir.Constant
        with cgutils.for_range_slice(builder, number(word, 0), width, number(word, LANES), word) as (row, _):
            builder.store(builder.load(block(vector, row), align=8) if plus else nothing, sums[0])
            builder.store(nothing, sums[1])
            with cgutils.for_range_slice(builder, number(word, 0), columns, number(word, 2), word) as (first, _):
                for k, total in enumerate(sums):
                    column = builder.add(first, number(word, k))
                    value = builder.load(builder.gep(vector, [column]))
                    if size is not None:
                        value = size(builder, [value])
                    at = builder.add(builder.mul(column, width), row)
                    term = builder.fmul(builder.load(block(matrix, at), align=8), spread(value), flags=FAST)
                    builder.store(builder.fadd(builder.load(total), term, flags=FAST), total)
            both = builder.fadd(builder.load(sums[0]), builder.load(sums[1]))
            builder.store(both, block(out, row), align=8)
        return context.get_dummy_value()

    def product(typing: Any, m: Any, m_at: Any, width: Any, v: Any, v_at: Any, columns: Any, out: Any, at: Any) -> Any:
        whole = types.int64
        return types.void(m, whole, whole, v, whole, whole, out, whole), generate

    return intrinsic(product)


_times, _advance, _sizes = _product(False, False), _product(True, False), _product(False, True)


@inlined
def times(m: Array, m_at: int, width: int, v: Array, v_at: int, columns: int, out: Array, at: int) -> None:
    """out = M v: M is stored by columns of ``width`` rows from m[m_at] on, v from v[v_at] on, out from out[at] on.

    Arrays are contiguous, whatever their shape; ``width`` is a multiple of eight, ``columns`` even.
    What is written is not what is read.
    """
    _times(m, m_at, width, v, v_at, columns, out, at)


@inlined
def advance(m: Array, m_at: int, width: int, v: Array, v_at: int, columns: int, out: Array, at: int) -> None:
    """out = v + M v, as ``times``; M is square, but for columns of zeros."""
    _advance(m, m_at, width, v, v_at, columns, out, at)


@inlined
def times_sizes(m: Array, m_at: int, width: int, v: Array, v_at: int, columns: int, out: Array, at: int) -> None:
    """out = M |v|, as ``times``."""
    _sizes(m, m_at, width, v, v_at, columns, out, at)


@compiled
def matrix_product(left: Array, right: Array, out: Array) -> None:
    """out (m, n) = left (m, k) right (k, n), with n a multiple of eight and k even; ``out`` is neither."""
    width, inner = right.shape
    for i in range(len(left)):
        times(right, 0, inner, left, i * width, width, out, i * inner)


@compiled
def solve(matrix: Array, right: Array, count: int) -> None:
    """Put the solution of matrix[:count, :count] x = right[:count] (m, k) into ``right``; overwrites the matrix.

    Elimination with row pivots: for the few frictions that rest together, without a call to a library.
    """
    wide = right.shape[1]
    for k in range(count):
        best = k
        for i in range(k + 1, count):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        if best != k:
            for j in range(count):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
            for j in range(wide):
                right[k, j], right[best, j] = right[best, j], right[k, j]
        for i in range(k + 1, count):
            factor = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, count):
                matrix[i, j] -= factor * matrix[k, j]
            for j in range(wide):
                right[i, j] -= factor * right[k, j]
    for k in range(count - 1, -1, -1):
        for j in range(wide):
            total = right[k, j]
            for i in range(k + 1, count):
                total -= matrix[k, i] * right[i, j]
            right[k, j] = total / matrix[k, k]
