"""Rounds of descents in torch: each pose's seeds in order, then random configurations.

All poses take their first seed together, those that are left their next ones, and so on. Where few
poses are left they try several starts side by side, so that a device stays busy, and what counts
is what the starts would have given one after the other. So a row depends on its pose and seeds
alone, as in `baselines.lm_kernel`.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import torch
from torch import Tensor

from baselines import lm_kernel
from baselines.descent_torch import Descents, descend
from baselines.linearise_torch import TorchChain, target_frames
from baselines.lm_kernel import LmOptions
from baselines.random_torch import pose_keys, uniforms
from baselines.seed_library import ROTATION_SHARE, SeedLibrary

if TYPE_CHECKING:
    from robots import Robot

# Descents side by side that keep a device busy.
FILL = {"cpu": 256, "cuda": 1 << 14}
MOST_AT_ONCE = 64
UNDECIDED = -1
# Poses whose distances to all remembered configurations are held at once.
NEIGHBOUR_BATCH = 2048


class DeviceChain(NamedTuple):
    """Where and how a batch is computed: what `refine_place` makes of a robot and two settings.

    Attributes:
        device: Torch device.
        exact: The chain in float64.
        fast: The chain in which descents run: in float32 where the precision is mixed.
        robot: Whose chain it is; without, joints that turn for ever stay where a descent left them.
    """

    device: torch.device
    exact: TorchChain
    fast: TorchChain
    robot: Robot | None = None


@dataclass
class Outcome:
    """N poses and what became of them so far.

    Attributes:
        joints: (dof, N) best joints met.
        least: (N,) squared error there.
        status: (N,) status of the kernel, or UNDECIDED.
        used: (N,) iterations, summed over starts.
        starts: (N,) starts descended from.
    """

    joints: Tensor
    least: Tensor
    status: Tensor
    used: Tensor
    starts: Tensor


def solve_rounds(
    place: DeviceChain,
    poses: Tensor,
    seeds: Tensor,
    options: LmOptions,
    deadline: float | None,
    library: SeedLibrary | None,
) -> Outcome:
    """Let poses (N, 7) descend round after round until every one is decided.

    Args:
        place: Robot, device and precision.
        poses: (N, 7) targets, float64, on the device.
        seeds: (N, K, dof) configurations to start from, float64, on the device.
        options: Tolerances, damping and budget.
        deadline: `time.perf_counter` after which no round begins [s]; None for no limit.
        library: Configurations to start from after the seeds, the nearest first.
    """
    count, device = len(poses), place.device
    none = torch.zeros(count, dtype=torch.int64, device=device)
    outcome = Outcome(
        torch.zeros(place.exact.dof, count, dtype=torch.float64, device=device),
        torch.full((count,), torch.inf, dtype=torch.float64, device=device),
        none + UNDECIDED,
        none.clone(),
        none.clone(),
    )
    goal, target = target_frames(poses)
    keys = pose_keys(poses)
    rows = torch.arange(count, device=device)
    fresh = True
    while len(rows):
        if library is not None and (not fresh or seeds.shape[1] == 0):
            seeds = _with_library_seeds(library, poses, seeds, rows)
            library = None
        width = _width(len(rows), FILL[device.type], fresh)
        fresh = False
        attempts = outcome.starts[rows, None] + torch.arange(width, device=device)
        starts = _starts(place.exact, seeds[rows], keys[rows], attempts)
        limit = (options.iterations - outcome.used[rows])[:, None].expand(-1, width)
        work = Descents.start(
            goal[..., rows, None].expand(-1, -1, -1, width).flatten(2),
            target[:, rows, None].expand(-1, -1, width).flatten(1),
            starts.flatten(1),
            limit.flatten(),
        )
        _fold(outcome, rows, _descend(place, work, options), width, options)
        if deadline is not None and time.perf_counter() >= deadline:
            late = outcome.status == UNDECIDED
            outcome.status[late] = lm_kernel.OUT_OF_TIME
        rows = (outcome.status == UNDECIDED).nonzero().squeeze(1)
    return outcome


def _width(poses: int, fill: int, fresh: bool) -> int:
    """How many starts of each pose run side by side; the first runs alone, most need no other."""
    return 1 if fresh else min(MOST_AT_ONCE, max(1, fill // poses))


def _with_library_seeds(library: SeedLibrary, poses: Tensor, seeds: Tensor, rows: Tensor) -> Tensor:
    """Seeds (N, K + neighbours, dof); those behind the K given are filled in for some rows only."""
    goal, target = target_frames(poses[rows])
    centre, scale = (
        torch.as_tensor(v, device=poses.device)[:, None] for v in (library.centre, library.scale)
    )
    # The memory holds matrices row by row, frames here are column by column.
    turned = ROTATION_SHARE * goal.transpose(0, 1).flatten(0, 1)
    wanted = torch.cat(((target - centre) / scale, turned)).to(torch.float32)
    features = torch.as_tensor(library.features, device=poses.device)
    nearest = []
    for part in wanted.split(NEIGHBOUR_BATCH, dim=1):
        distances = torch.zeros(part.shape[1], features.shape[1], device=poses.device)
        for value, remembered in zip(part, features, strict=True):
            distances += (remembered - value[:, None]).square()
        nearest.append(distances.topk(library.neighbours, largest=False).indices)
    known = torch.as_tensor(library.joints, device=poses.device)
    more = seeds.new_zeros(len(seeds), library.neighbours, seeds.shape[2])
    more[rows] = known[torch.cat(nearest)]
    return torch.cat((seeds, more), dim=1)


def _starts(chain: TorchChain, seeds: Tensor, keys: Tensor, attempts: Tensor) -> Tensor:
    """Configurations (dof, N, W) to start from: the seeds in order, then random ones.

    Args:
        chain: Gives the limits.
        seeds: (N, K, dof) rad or m.
        keys: (N,) streams of random numbers.
        attempts: (N, W) which start it is.
    """
    count, dof = seeds.shape[1:]
    joint = torch.arange(dof, device=keys.device)[:, None, None]
    shares = uniforms(keys[:, None], (attempts - count) * dof + joint)
    lower, upper = chain.lower[..., None], chain.upper[..., None]
    drawn = lower + shares * (upper - lower)
    if count == 0:
        return drawn
    index = attempts.clamp(max=count - 1)[..., None].expand(-1, -1, dof)
    given = seeds.gather(1, index).permute(2, 0, 1)
    return torch.where(attempts < count, torch.clamp(given, lower, upper), drawn)


def _descend(place: DeviceChain, work: Descents, options: LmOptions) -> Descents:
    """Run descents; in mixed precision complete in float64 what float32 has found."""
    if place.fast is place.exact:
        return descend(place.exact, work, options)
    single = torch.float32
    rough = descend(
        place.fast,
        Descents.start(
            work.goal.to(single), work.target.to(single), work.joints.to(single), work.limit
        ),
        options,
    )
    rough.best = torch.clamp(rough.best.double(), place.exact.lower, place.exact.upper)
    rough.least = rough.least.double()
    rows = rough.found.nonzero().squeeze(1)
    done = descend(
        place.exact,
        Descents.start(
            work.goal[..., rows],
            work.target[:, rows],
            rough.best[:, rows],
            (work.limit - rough.iterations)[rows],
        ),
        options,
    )
    rough.best[:, rows], rough.least[rows], rough.found[rows] = done.best, done.least, done.found
    rough.iterations[rows] += done.iterations
    return rough


def _fold(
    outcome: Outcome, rows: Tensor, descents: Descents, width: int, options: LmOptions
) -> None:
    """Add to the outcome of some poses what their next starts gave, one after the other.

    Starts behind the one that decides a pose count for nothing. One that would have been cut off
    by the iterations of those before it, which ran beside it, is left for the next round.

    Args:
        outcome: Of all poses; changed.
        rows: (n,) the poses concerned.
        descents: n W descents, W = `width` a pose.
        width: Starts a pose.
        options: Give the budget.
    """

    def by_pose(values: Tensor) -> Tensor:
        return values.unflatten(-1, (len(rows), width))

    order = torch.arange(width, device=rows.device)
    total = outcome.used[rows, None] + by_pose(descents.iterations).cumsum(1)
    cut = total > options.iterations
    found = by_pose(descents.found) & ~cut
    spent = total >= options.iterations
    out_of_starts = outcome.starts[rows, None] + order + 1 >= options.starts
    ends = found | spent | out_of_starts
    last = torch.where(ends.any(1), ends.int().argmax(1), width - 1)
    # The first start of a round is never cut: it knew its limit.
    last -= cut.gather(1, last[:, None])[:, 0].long()
    at = last[:, None]
    found, spent, out_of_starts = (
        values.gather(1, at)[:, 0] for values in (found, spent, out_of_starts)
    )
    status = torch.full_like(last, UNDECIDED)
    status[out_of_starts] = lm_kernel.OUT_OF_STARTS
    status[spent] = lm_kernel.OUT_OF_ITERATIONS
    status[found] = lm_kernel.FOUND
    least = by_pose(descents.least).masked_fill(order > at, torch.inf)
    # The solution is taken even where an earlier start came nearer in the sum of squares.
    best = torch.where(found, last, least.argmin(1))
    least = least.gather(1, best[:, None])[:, 0]
    better = found | (least < outcome.least[rows])
    chosen = by_pose(descents.best).gather(2, best[None, :, None].expand(len(descents.best), -1, 1))
    joints = torch.where(better, chosen[..., 0], outcome.joints[:, rows])
    outcome.joints[:, rows] = joints
    outcome.least[rows] = torch.where(better, least, outcome.least[rows])
    outcome.status[rows] = status
    outcome.used[rows] = total.gather(1, at)[:, 0]
    outcome.starts[rows] += last + 1
