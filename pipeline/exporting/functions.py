"""Functions in float64 by what runtimes of ONNX have in float64: no arcsine and no error function.

For both, ONNX's standard allows float64 and onnxruntime implements float32 alone.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import torch
from numpy.polynomial import Chebyshev
from scipy.special import erfcx
from torch import Tensor
from torch.nn.functional import gelu

DEGREE = 24  # of the polynomial; the error function is right to 1e-13


def arc_sine(x: Tensor) -> Tensor:
    """Angle of sines in [0, 1], to the precision that they have.

    The float32 function, then one step of Newton's method. From 1/2 on by
    arcsin(x) = pi / 2 - 2 arcsin(sqrt((1 - x) / 2)), so that the cosine is never near zero.
    """
    upper = x > 0.5
    small = torch.where(upper, ((1 - x) / 2).sqrt(), x)
    angle = torch.asin(small.float()).to(x.dtype)
    angle = angle + (small - torch.sin(angle)) / torch.cos(angle)
    return torch.where(upper, math.pi / 2 - 2 * angle, angle)


def exact_gelu(x: Tensor) -> Tensor:
    """GELU by the error function, x / 2 (1 + erf(x / sqrt(2)))."""
    if x.dtype != torch.float64:
        return gelu(x)
    return x * (0.5 + 0.5 * torch.sign(x) * (1 - _erfc(x.abs() / math.sqrt(2))))


@torch.jit.script
def smooth_gelu(x: Tensor) -> Tensor:
    """GELU by its tanh, sqrt(2 / pi) in full (Hendrycks and Gimpel, arXiv 1606.08415)."""
    return 0.5 * x * (1.0 + torch.tanh(0.7978845608028654 * x * (1.0 + 0.044715 * x * x)))


def _erfc(z: Tensor) -> Tensor:
    """1 - erf(z) of z >= 0 as exp(-z²) t P(t) with t = 2 / (2 + z), P a polynomial.

    The form is W. Press et al., *Numerical Recipes*, section 6.2, without their logarithm.
    """
    t = 2 / (2 + z)
    u = 2 * t - 1
    *rest, total = _coefficients()
    value = torch.full_like(u, total)
    for coefficient in reversed(rest):
        value = value * u + coefficient
    return torch.exp(-z * z) * t * value


@cache
def _coefficients() -> tuple[float, ...]:
    """P in powers of 2 t - 1, interpolated at the nodes of Chebyshev."""

    def scaled(u: np.ndarray) -> np.ndarray:
        t = (u + 1) / 2
        return np.asarray(erfcx(2 / t - 2) / t)

    series = Chebyshev.interpolate(scaled, DEGREE)
    return tuple(map(float, series.convert(kind=np.polynomial.Polynomial).coef))
