"""Forward kinematics as sums of columns, which runtimes of ONNX are quicker at than at matrices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import torch
from torch import Tensor

from robots.chain import Chain

NOTHING = 1e-15  # what a turn by a quarter leaves of a cosine; such terms are left out

Frame = tuple[Tensor, Tensor, Tensor, Tensor]  # axes x, y and z (N, 3), then origin (N, 3) [m]


def tip_frames(chain: Chain, joints: Tensor) -> Frame:
    """Return the frames of the tip for joints (N, dof) [rad or m], of the same type."""
    constants = [
        torch.cat((torch.as_tensor(R.T), torch.as_tensor(t[None]))).tolist()
        for R, t in zip(chain.rotations, chain.translations, strict=True)
    ]
    x, y, z, origin = (torch.tensor(row, dtype=joints.dtype)[None] for row in constants[0])
    for k, slides in enumerate(chain.prismatic.tolist()):
        value = joints[:, int(chain.variable[k]), None]
        value = value * float(chain.multiplier[k]) + float(chain.offset[k])
        if slides:
            origin = origin + z * value
        else:
            cosine, sine = value.cos(), value.sin()
            x, y = x * cosine + y * sine, y * cosine - x * sine
        axes = (x, y, z)
        *turned, shift = (_combined(axes, row) for row in constants[k + 1])
        x, y, z = (axis for axis in turned if axis is not None)
        origin = origin if shift is None else origin + shift
    return x, y, z, origin


def _combined(axes: Sequence[Tensor], factors: Iterable[float]) -> Tensor | None:
    """Sum axes times factors; None where all of them are zero."""
    total = None
    for axis, factor in zip(axes, factors, strict=True):
        if abs(factor) > NOTHING:
            term = axis if factor == 1.0 else axis * factor
            total = term if total is None else total + term
    return total
