"""Activations of small perceptrons, compiled, float32 or float64, as loops that become vectors."""

from __future__ import annotations

import math

import numpy as np
from numba import types
from numba.extending import overload

from robots.compiled import njit

GELU_SLOPE = math.sqrt(2 / math.pi)  # with GELU_CUBE: Hendrycks and Gimpel, arXiv 1606.08415
GELU_CUBE = 0.044715
# tanh(x) = x P(x²) / Q(x²) up to an end beyond which it is taken for 1, fitted by weighted least
# squares to the least relative error: 2e-8 for float32, where evaluation makes it 4e-7 at most, and
# 4e-10 for float64. All coefficients are positive, so that nothing cancels.
TANH_END = 9.0
_P0, _P1, _P2, _P3, _P4 = (
    np.float32(number)
    for number in (1.0, 0.133810134, 0.00349557356, 2.06088445e-05, 1.3354341e-08)
)
_Q0, _Q1, _Q2, _Q3, _Q4 = (
    np.float32(number) for number in (1.0, 0.46714329, 0.0258769268, 0.000328561103, 7.77642494e-07)
)
WIDE_END = 11.0
_W0, _W1, _W2, _W3, _W4, _W5 = (
    0.99999999959750088, 0.14023200187337943, 0.0043251885594748437,
    3.9724372688500586e-05, 9.7113138446723523e-08, 2.8528355670963921e-11,
)  # fmt: skip
_V1, _V2, _V3, _V4, _V5 = (
    0.47356533128981107, 0.028846971951182869, 0.00048158691963981414,
    2.3709580938760283e-06, 2.4451581065886438e-09,
)  # fmt: skip


@njit(error_model="numpy", fastmath={"contract"})
def tanh_rational(x):  # type: ignore[no-untyped-def]
    """Hyperbolic tangent of a float32, to 4e-7: no branch and no call."""
    x = min(max(x, np.float32(-TANH_END)), np.float32(TANH_END))
    s = x * x
    above = _P0 + s * (_P1 + s * (_P2 + s * (_P3 + s * _P4)))
    below = _Q0 + s * (_Q1 + s * (_Q2 + s * (_Q3 + s * _Q4)))
    return x * above / below


@njit(error_model="numpy", fastmath={"contract"})
def tanh_wide(x):  # type: ignore[no-untyped-def]
    """Hyperbolic tangent of a float64, to 5e-10: no branch and no call."""
    x = min(max(x, -WIDE_END), WIDE_END)
    s = x * x
    above = _W0 + s * (_W1 + s * (_W2 + s * (_W3 + s * (_W4 + s * _W5))))
    below = 1.0 + s * (_V1 + s * (_V2 + s * (_V3 + s * (_V4 + s * _V5))))
    return x * above / below


def _tanh(x):  # type: ignore[no-untyped-def]
    """Stand for one of the two, by the type of its argument."""
    raise NotImplementedError


@overload(_tanh, inline="always")
def _tanh_of(x):  # type: ignore[no-untyped-def]
    return (lambda x: tanh_rational(x)) if x is types.float32 else (lambda x: tanh_wide(x))


@njit(_nrt=False, error_model="numpy", fastmath={"contract"})
def gelu_values(values, begin, end):  # type: ignore[no-untyped-def]
    """GELU, by its tanh, of values[begin:end], in place."""
    line = values[begin:end]  # indices from 0 on, or every one is tested for its sign
    real = line.dtype.type
    half, one, slope, cube = real(0.5), real(1), real(GELU_SLOPE), real(GELU_CUBE)
    for k in range(end - begin):
        x = line[k]
        line[k] = half * x * (one + _tanh(slope * (x + cube * x * x * x)))


@njit(_nrt=False, error_model="numpy", fastmath={"contract"})
def tanh_values(values, begin, end):  # type: ignore[no-untyped-def]
    """Hyperbolic tangent of values[begin:end], in place."""
    line = values[begin:end]
    for k in range(end - begin):
        line[k] = _tanh(line[k])
