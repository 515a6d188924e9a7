"""Compiled layers of small perceptrons, four rows at a time, float32.

One core reaches with them what the linear algebra of NumPy and torch reaches on these sizes, and
they can be called from inside other compiled loops, where no thread of a library wakes up.
"""

from __future__ import annotations

import numpy as np
from numba import njit

ROWS = 4  # poses that share one load of a weight
DEPTH = 8  # inputs added per pass over the outputs; layers are padded to a multiple of it
# Beyond this |x|, tanh is 1 to 1e-4 and so is its approximation below.
TANH_END = 4.9
GELU_SLOPE = 0.7978845608  # sqrt(2 / pi); with GELU_CUBE: Hendrycks and Gimpel, arXiv 1606.08415
GELU_CUBE = 0.044715
FAST = {"contract", "nsz", "arcp", "reassoc"}


@njit(cache=True, no_cpython_wrapper=True, fastmath=FAST)
def linear_rows(values, weight, bias, out):  # type: ignore[no-untyped-def]
    """Four rows through a linear layer: out (4, m) = values (4, n) weight (n, m) + bias (m,).

    Written so that the compiler keeps four rows of sums in vector registers: each weight is loaded
    once for four rows, each sum is loaded and stored once for eight products.
    """
    n, m = weight.shape
    a, b, c, d = values[0], values[1], values[2], values[3]
    p, q, r, s = out[0], out[1], out[2], out[3]
    for j in range(m):
        p[j] = q[j] = r[j] = s[j] = bias[j]
    for k in range(0, n, DEPTH):
        a0, a1, a2, a3, a4, a5, a6, a7 = (
            a[k], a[k + 1], a[k + 2], a[k + 3], a[k + 4], a[k + 5], a[k + 6], a[k + 7],
        )  # fmt: skip
        b0, b1, b2, b3, b4, b5, b6, b7 = (
            b[k], b[k + 1], b[k + 2], b[k + 3], b[k + 4], b[k + 5], b[k + 6], b[k + 7],
        )  # fmt: skip
        c0, c1, c2, c3, c4, c5, c6, c7 = (
            c[k], c[k + 1], c[k + 2], c[k + 3], c[k + 4], c[k + 5], c[k + 6], c[k + 7],
        )  # fmt: skip
        d0, d1, d2, d3, d4, d5, d6, d7 = (
            d[k], d[k + 1], d[k + 2], d[k + 3], d[k + 4], d[k + 5], d[k + 6], d[k + 7],
        )  # fmt: skip
        for j in range(m):
            w0, w1, w2, w3 = weight[k, j], weight[k + 1, j], weight[k + 2, j], weight[k + 3, j]
            w4, w5, w6, w7 = weight[k + 4, j], weight[k + 5, j], weight[k + 6, j], weight[k + 7, j]
            p[j] += a0*w0 + a1*w1 + a2*w2 + a3*w3 + a4*w4 + a5*w5 + a6*w6 + a7*w7  # fmt: skip
            q[j] += b0*w0 + b1*w1 + b2*w2 + b3*w3 + b4*w4 + b5*w5 + b6*w6 + b7*w7  # fmt: skip
            r[j] += c0*w0 + c1*w1 + c2*w2 + c3*w3 + c4*w4 + c5*w5 + c6*w6 + c7*w7  # fmt: skip
            s[j] += d0*w0 + d1*w1 + d2*w2 + d3*w3 + d4*w4 + d5*w5 + d6*w6 + d7*w7  # fmt: skip


@njit(cache=True, fastmath=FAST)
def _tanh(x):  # type: ignore[no-untyped-def]
    """Seventh convergent of Lambert's continued fraction: no branch, no call, so vectors."""
    x = min(max(x, np.float32(-TANH_END)), np.float32(TANH_END))
    s = x * x
    above = np.float32(135135) + s * (np.float32(17325) + s * (np.float32(378) + s))
    below = np.float32(62370) + s * (np.float32(3150) + s * np.float32(28))
    return x * above / (np.float32(135135) + s * below)


@njit(cache=True, no_cpython_wrapper=True, fastmath=FAST)
def gelu_rows(values, count):  # type: ignore[no-untyped-def]
    """GELU, by its tanh, of the first `count` numbers of four rows, in place."""
    half, one = np.float32(0.5), np.float32(1)
    slope, cube = np.float32(GELU_SLOPE), np.float32(GELU_CUBE)
    for row in range(ROWS):
        line = values[row]
        for k in range(count):
            x = line[k]
            line[k] = half * x * (one + _tanh(slope * (x + cube * x * x * x)))


@njit(cache=True, no_cpython_wrapper=True, fastmath=FAST)
def tanh_rows(values, count):  # type: ignore[no-untyped-def]
    """Hyperbolic tangent of the first `count` numbers of four rows, in place."""
    for row in range(ROWS):
        line = values[row]
        for k in range(count):
            line[k] = _tanh(line[k])
