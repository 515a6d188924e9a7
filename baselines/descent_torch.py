"""Batched Levenberg-Marquardt descents in torch, the arithmetic of `baselines.lm_kernel`.

Every descent of a batch starts at the same tick, so that the iteration count and the test of
patience are the same number for all of them and never leave the host. Nothing in an iteration
waits for an accelerator; only the removal of descents that have ended does, every few iterations.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from baselines.linearise_torch import TorchChain
from baselines.lm_kernel import LmOptions

# Iterations between two looks at which descents have ended: each look waits for the device.
LOOK_EVERY = {"cpu": 1, "cuda": 4}
# Share of a batch that must have ended before the rest is moved together.
WORTH_MOVING = 0.1


@dataclass
class Descents:
    """N descents, each from its own start, and what became of them.

    Attributes:
        goal: (3, 3, N) rotations of the targets, column by column.
        target: (3, N) positions of the targets [m].
        joints: (dof, N) where each stands [rad or m].
        limit: (N,) iterations that each may take.
        best: (dof, N) best joints met.
        least: (N,) squared error there.
        found: (N,) whether the tolerances are met.
        iterations: (N,) iterations taken.
    """

    goal: Tensor
    target: Tensor
    joints: Tensor
    limit: Tensor
    best: Tensor
    least: Tensor
    found: Tensor
    iterations: Tensor

    @classmethod
    def start(cls, goal: Tensor, target: Tensor, joints: Tensor, limit: Tensor) -> Descents:
        """Descents that have not begun."""
        return cls(
            goal,
            target,
            joints,
            limit,
            joints.clone(),
            torch.full_like(joints[0], torch.inf),
            torch.zeros_like(limit, dtype=torch.bool),
            torch.zeros_like(limit),
        )


def descend(chain: TorchChain, work: Descents, options: LmOptions) -> Descents:
    """Let all descents run until they converge, stall, or have used up their limit.

    Args:
        chain: The chain, on the device and in the precision of `work`.
        work: Descents that have not begun; left as they are.
        options: Tolerances, damping, patience and active-set passes; budgets are those of `work`.
    """
    result = Descents.start(work.goal, work.target, work.joints, work.limit)
    look_every = LOOK_EVERY.get(work.joints.device.type, LOOK_EVERY["cuda"])
    part = result
    rows: Tensor | None = None
    active = torch.ones_like(work.found)
    reference = part.least
    tick = 0
    while True:
        active, reference = _tick(chain, part, options, active, reference, tick)
        tick += 1
        if tick % look_every:
            continue
        left = int(active.sum())
        if left > (1 - WORTH_MOVING) * len(active):
            continue
        if rows is not None:
            _put(result, part, rows)
        if left == 0:
            return result
        kept = active.nonzero().squeeze(1)
        rows = kept if rows is None else rows[kept]
        part = _take(part, kept)
        active, reference = active[kept], reference[kept]


def _tick(
    chain: TorchChain,
    part: Descents,
    options: LmOptions,
    active: Tensor,
    reference: Tensor,
    tick: int,
) -> tuple[Tensor, Tensor]:
    """One iteration of all descents that are active; returns which still are, and the reference."""
    at = chain.linearise(part.joints, part.goal, part.target)
    squared = at.distance2 + at.angle2
    hit = (at.distance2 <= options.position_tolerance_m**2) & (
        at.angle2 <= options.rotation_tolerance_rad**2
    )
    hit &= active
    better = active & (squared < part.least)
    part.best = torch.where(better | hit, part.joints, part.best)
    part.least = torch.where(better, squared, part.least)
    part.found = part.found | hit
    active = active & ~hit & (part.limit > tick)
    if tick % options.patience == 0:
        active &= squared <= 0.5 * reference
        reference = squared
    damping = options.damping + options.damping_gain * squared
    step = limited_step(
        chain, part.joints, at.jacobian, at.error, damping, options.max_active_set_passes
    )
    moved = torch.clamp(part.joints + step, chain.lower, chain.upper)
    part.joints = torch.where(active, moved, part.joints)
    part.iterations = part.iterations + active
    return active, reference


def limited_step(
    chain: TorchChain,
    joints: Tensor,
    jacobian: Tensor,
    error: Tensor,
    damping: Tensor,
    max_active_set_passes: int,
) -> Tensor:
    """Damped steps (dof, N) with joints frozen that stand at a limit and push outward.

    Args:
        chain: Gives the limits.
        joints: (dof, N) inside the limits [rad or m].
        jacobian: (dof, 6, N) one row a joint.
        error: (6, N) from tip to target [m, rad].
        damping: (N,) λ > 0.
        max_active_set_passes: How often a step is solved again with joints frozen.
    """
    step = (jacobian * damped_solve(jacobian, jacobian, error, damping)).sum(1)
    at_lower, at_upper = joints <= chain.lower, joints >= chain.upper
    free = torch.ones_like(at_lower)
    for _ in range(max_active_set_passes):
        pushing = (at_lower & (step < 0.0)) | (at_upper & (step > 0.0))
        free &= ~pushing
        if joints.device.type == "cpu":
            # To ask costs nothing here, and few rows are concerned.
            rows = pushing.any(0).nonzero().squeeze(1)
            if len(rows) == 0:
                break
            step[:, rows] = _free_step(
                jacobian[..., rows], free[:, rows], error[:, rows], damping[rows]
            )
        else:
            step = _free_step(jacobian, free, error, damping)
    return step


def _free_step(jacobian: Tensor, free: Tensor, error: Tensor, damping: Tensor) -> Tensor:
    movable = jacobian * free[:, None]
    return (movable * damped_solve(movable, jacobian, error, damping)).sum(1)


def damped_solve(movable: Tensor, jacobian: Tensor, error: Tensor, damping: Tensor) -> Tensor:
    """Solve (Σ JₖᵀJₖ + λ I) y = e over the free joints, (6, N), by an L D Lᵀ factorisation.

    Golub and Van Loan, "Matrix Computations", section 4.1, a column at a time for the whole batch.

    Args:
        movable: (dof, 6, N) rows of joints that are frozen are zero.
        jacobian: (dof, 6, N) one row a joint.
        error: (6, N) right-hand sides e.
        damping: (N,) λ > 0.
    """
    normal = movable[0, :, None] * jacobian[0, None, :]
    for row, other in zip(movable[1:], jacobian[1:], strict=True):
        normal.addcmul_(row[:, None], other[None, :])
    normal.diagonal().T.add_(damping)
    y = error.clone()
    below = []
    for column in range(5):
        ratio = normal[column + 1 :, column] / normal[column, column]
        below.append(ratio)
        y[column + 1 :].addcmul_(ratio, y[column], value=-1.0)
        normal[column + 1 :, column + 1 :].addcmul_(
            ratio[:, None], normal[column + 1 :, column][None], value=-1.0
        )
    y /= normal.diagonal().T
    for column in range(4, -1, -1):
        y[column] -= (below[column] * y[column + 1 :]).sum(0)
    return y


def _take(part: Descents, rows: Tensor) -> Descents:
    fields = {name: value[..., rows] for name, value in vars(part).items()}
    return Descents(**fields)


def _put(result: Descents, part: Descents, rows: Tensor) -> None:
    """Write what became of a part back to where it came from."""
    for name in ("best", "least", "found", "iterations"):
        getattr(result, name)[..., rows] = getattr(part, name)
