"""The random numbers of `baselines.clock` in torch, bit for bit, on any device.

Torch multiplies and adds int64 modulo 2⁶⁴, which is what the unsigned arithmetic there does.
"""

from __future__ import annotations

import torch
from torch import Tensor

from baselines import clock


def _signed(value: int) -> int:
    """The int64 with the bits of an unsigned 64-bit number."""
    return value - 2**64 if value >= 2**63 else value


GOLDEN, MIX_1, MIX_2 = (_signed(int(v)) for v in (clock.GOLDEN, clock.MIX_1, clock.MIX_2))


def pose_keys(poses: Tensor) -> Tensor:
    """Stream keys (N,) int64 that depend on poses (N, 7) alone, not on a quaternion's sign."""
    magnitude = torch.cat((poses[:, :3], poses[:, 3:].abs()), dim=1)
    bits = magnitude.contiguous().view(torch.int64)
    key = torch.zeros_like(bits[:, 0])
    for column in bits.unbind(1):
        key = _mix(key ^ column) + GOLDEN
    return key


def uniforms(keys: Tensor, counters: Tensor) -> Tensor:
    """Uniform numbers in [0, 1), float64, of streams and counters that broadcast together."""
    return _shifted(_mix(keys + GOLDEN * (counters + 1)), 11).to(torch.float64) * clock.TO_UNIT


def _mix(value: Tensor) -> Tensor:
    """Scramble 64 bits, as `clock.mix`."""
    value = (value ^ _shifted(value, 30)) * MIX_1
    value = (value ^ _shifted(value, 27)) * MIX_2
    return value ^ _shifted(value, 31)


def _shifted(value: Tensor, bits: int) -> Tensor:
    """Logical shift to the right: the sign is no sign here."""
    return (value >> bits) & ((1 << (64 - bits)) - 1)
