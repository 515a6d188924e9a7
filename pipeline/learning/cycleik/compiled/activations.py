"""Activations of small perceptrons, compiled, float32, so that loops over them become vectors."""

from __future__ import annotations

import numpy as np

from robots.compiled import njit

GELU_SLOPE = 0.7978845608  # sqrt(2 / pi); with GELU_CUBE: Hendrycks and Gimpel, arXiv 1606.08415
GELU_CUBE = 0.044715
# Beyond this |x|, tanh rounds to 1.
TANH_END = 9.0
# tanh(x) = x P(x²) / Q(x²) on +-TANH_END, fitted by weighted least squares to the least relative
# error, 2e-8; evaluated in float32 the error is at most 4e-7. All coefficients are positive, so
# that nothing cancels.
_P0, _P1, _P2, _P3, _P4 = (
    np.float32(number)
    for number in (1.0, 0.133810134, 0.00349557356, 2.06088445e-05, 1.3354341e-08)
)
_Q0, _Q1, _Q2, _Q3, _Q4 = (
    np.float32(number) for number in (1.0, 0.46714329, 0.0258769268, 0.000328561103, 7.77642494e-07)
)


@njit(error_model="numpy", fastmath={"contract"})
def tanh_rational(x):  # type: ignore[no-untyped-def]
    """Hyperbolic tangent, to 4e-7: no branch and no call, so that loops over it become vectors."""
    x = min(max(x, np.float32(-TANH_END)), np.float32(TANH_END))
    s = x * x
    above = _P0 + s * (_P1 + s * (_P2 + s * (_P3 + s * _P4)))
    below = _Q0 + s * (_Q1 + s * (_Q2 + s * (_Q3 + s * _Q4)))
    return x * above / below


@njit(_nrt=False, error_model="numpy", fastmath={"contract"})
def gelu_values(values, begin, end):  # type: ignore[no-untyped-def]
    """GELU, by its tanh, of values[begin:end], in place."""
    half, one = np.float32(0.5), np.float32(1)
    slope, cube = np.float32(GELU_SLOPE), np.float32(GELU_CUBE)
    line = values[begin:end]  # indices from 0 on, or every one is tested for its sign
    for k in range(end - begin):
        x = line[k]
        line[k] = half * x * (one + tanh_rational(slope * (x + cube * x * x * x)))


@njit(_nrt=False, error_model="numpy", fastmath={"contract"})
def tanh_values(values, begin, end):  # type: ignore[no-untyped-def]
    """Hyperbolic tangent of values[begin:end], in place."""
    line = values[begin:end]
    for k in range(end - begin):
        line[k] = tanh_rational(line[k])
