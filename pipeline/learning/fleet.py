"""Several trainings side by side on one accelerator, each a CUDA graph of a few steps.

The networks of Table I are trained in batches of 100 to 300 poses, which fill a small part of a
GPU: a step is a chain of some hundred kernels that wait for each other. Trainings of other robots,
seeds and settings run in between, each on a stream of its own. What a run computes does not depend
on what runs beside it: batches, learning rates and first weights are those of
`pipeline.learning.trainer` with the same seed.
"""

from __future__ import annotations

import gc
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, field
from typing import Any

import torch
from torch import Tensor

from pipeline.learning.batches import Batches
from pipeline.learning.config import FLOAT32, ModelConfig, TrainConfig
from pipeline.learning.factory import build_network
from pipeline.learning.fused import FusedCycleLoss
from pipeline.learning.losses import position_error_mm, rotation_error_deg
from pipeline.learning.networks import IkNetwork
from pipeline.learning.precision import HIGHEST, MEDIUM, matmul_precision
from pipeline.learning.rotation import quaternion_from_matrix
from pipeline.learning.step import WARM_UPS, branchless_update
from robots import Robot

AHEAD = 4  # replays that wait in a stream: the device never idles, the host is never far ahead
END = ""  # of the jobs
LOOK_AHEAD = 4  # jobs whose weights are drawn early
CHUNK = 20_000  # poses a forward pass outside training


@dataclass(frozen=True)
class FleetJob:
    """One training.

    Attributes:
        label: Names it in results.
        robot: Gives limits and kinematics.
        model: Of a network with one head.
        train: Loss, batch, rate, epochs.
        seed: Of first weights and of the order of batches.
        poses: (N, 7) float32, on the device.
        held_out: (V, 7) float32, on the device.
        steps: Steps after which it ends, 0 for the whole schedule.
        validations: Times that the held-out poses are evaluated.
        urgent: Whether its kernels go before those of other runs.
        rounded_until: Share of the schedule over which forward products may be rounded too (TF32
            on CUDA: tensor cores take a small batch several times as fast); float32 ends it.
    """

    label: str
    robot: Robot
    model: ModelConfig
    train: TrainConfig
    seed: int
    poses: Tensor
    held_out: Tensor
    steps: int = 0
    validations: int = 10
    urgent: bool = False
    rounded_until: float = 0.0


@dataclass
class FleetRun:
    """A training under way.

    Args:
        job: What is trained.
        network: With its first weights, on the CPU.
        device: Where it is trained; a graph is captured on a CUDA device only.
        unroll: Steps in a graph.

    Attributes:
        step: Steps handed to the device so far.
        curve: (step, position [mm], rotation [deg]) of validations, as tensors until `finish`.
    """

    job: FleetJob
    network: IkNetwork
    device: torch.device
    unroll: int = 8
    step: int = 0
    curve: list[tuple[int, Tensor, Tensor]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Lay out what the graph reads, and capture it."""
        job, train, size = self.job, self.job.train, self.job.train.batch_size
        if train.negate_input or train.constraints:
            raise ValueError("a fleet trains without negate_input and without constraints")
        self.started = time.perf_counter()
        on_cuda = self.device.type == "cuda"
        self.stream = torch.cuda.Stream(priority=-1 if job.urgent else 0) if on_cuda else None
        self._copies = torch.cuda.Stream() if on_cuda else None
        self.network = self.network.to(self.device)
        self.loss = FusedCycleLoss(job.robot.chain, train, self.device)
        self.optimizer: Any = torch.optim.AdamW(
            self.network.parameters(),
            lr=train.learning_rate,
            weight_decay=train.weight_decay,
            fused=True,
            capturable=self.stream is not None,
        )
        per_epoch = len(job.poses) // size
        self.total = per_epoch * train.epochs
        self.last = min(job.steps or self.total, self.total)
        self._batches = Batches(len(job.poses), size, job.seed)
        self._order = self._epoch(0)
        steps = torch.arange(self.total + self.unroll, dtype=torch.float64)
        warm = ((steps + 1) / (train.warm_up_steps + 1)).clamp(max=1.0)
        rates = train.learning_rate * warm * (1 - steps / self.total).clamp(min=0.0)
        self._rates = rates.float().to(self.device)
        self._enabled = (steps < self.last).float().to(self.device)
        self._batch = torch.zeros(self.unroll, size, dtype=torch.int32, device=self.device)
        self._rate, self._enable = torch.zeros(2, self.unroll, device=self.device)
        self.sums = torch.zeros(3, dtype=torch.float64, device=self.device)
        self.marks = {
            max(1, round(self.last * (index + 1) / job.validations))
            for index in range(job.validations)
        }
        self._events: list[torch.cuda.Event] = []
        self._exact_from = round(job.rounded_until * self.total)
        self._graphs: dict[str, torch.cuda.CUDAGraph] = {}
        if self.stream is not None:
            for forward in {self._forward(0), HIGHEST}:
                self._graphs[forward] = self._captured(forward)

    @property
    def done(self) -> bool:
        """Whether all steps were handed to the device."""
        return self.step >= self.last

    @property
    def ready(self) -> bool:
        """Whether the device has few enough replays of this run left to do."""
        self._events = [event for event in self._events if not event.query()]
        return len(self._events) < AHEAD

    @property
    def idle(self) -> bool:
        """Whether the device has done all that it was handed."""
        return self.ready and not self._events

    def advance(self) -> None:
        """Hand the next steps to the device."""
        with torch.cuda.stream(self.stream) if self.stream is not None else nullcontext():
            self._feed()
            forward = self._forward(self.step)
            if self._graphs:
                self._graphs[forward].replay()
                event = torch.cuda.Event()
                event.record()
                self._events.append(event)
            else:
                self._body(forward)
            before, self.step = self.step, min(self.step + self.unroll, self.last)
            if any(before < mark <= self.step for mark in self.marks):
                position, rotation = self.errors(self.job.held_out)
                self.curve.append((self.step, position.mean(), rotation.mean()))

    def finish(self) -> list[dict[str, float]]:
        """Wait for the device and return the curve in mm and deg."""
        if self.stream is not None:
            self.stream.synchronize()
        return [
            {"step": step, "position_error_mm": float(p), "rotation_error_deg": float(r)}
            for step, p, r in self.curve
        ]

    @torch.no_grad()
    def answers(self, poses: Tensor) -> Tensor:
        """Joints (N, dof) for poses (N, 7), float32 products."""
        with matmul_precision(HIGHEST):
            return torch.cat([self.network(part)[:, 0] for part in poses.split(CHUNK)])

    @torch.no_grad()
    def errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Euclidean and geodesic errors (N,) in mm and deg of answers to poses (N, 7)."""
        with matmul_precision(HIGHEST):
            _, tip = self.loss.frames(self.answers(poses))
        turned = quaternion_from_matrix(tip[:, :3, :3].contiguous())
        return position_error_mm(tip[:, :3, 3], poses[:, :3]), rotation_error_deg(
            turned, poses[:, 3:]
        )

    def _epoch(self, number: int) -> Tensor:
        size, count = self.job.train.batch_size, self._batches.per_epoch
        order = self._batches.epoch(number)[: count * size].view(count, size).to(torch.int32)
        if self.stream is None or self._copies is None:
            return order
        # On a stream of its own the copy does not wait for the replays that are queued.
        with torch.cuda.stream(self._copies):
            moved = order.to(self.device)
        self.stream.wait_stream(self._copies)
        moved.record_stream(self.stream)
        return moved

    def _feed(self) -> None:
        """Copy indices, rates and switches of the next steps to where the graph reads them."""
        count, first = self._batches.per_epoch, self.step
        filled = 0
        while filled < self.unroll:
            epoch, place = divmod(first + filled, count)
            if place == 0 and first + filled > 0 and first + filled < self.total:
                self._order = self._epoch(epoch)
            take = min(self.unroll - filled, count - place)
            self._batch[filled : filled + take].copy_(self._order[place : place + take])
            filled += take
        self._rate.copy_(self._rates[first : first + self.unroll])
        self._enable.copy_(self._enabled[first : first + self.unroll])

    def _forward(self, step: int) -> str:
        """Precision of the products of the forward pass in the steps from this one on."""
        return MEDIUM if step < self._exact_from else HIGHEST

    def _body(self, forward: str) -> None:
        train, optimizer = self.job.train, self.optimizer
        backward = HIGHEST if train.precision == FLOAT32 else MEDIUM
        parameters = list(self.network.parameters())
        for index in range(self.unroll):
            poses = self.job.poses.index_select(0, self._batch[index])
            with matmul_precision(forward):
                answers = self.network(poses)[:, 0]
            with matmul_precision(HIGHEST):
                loss = self.loss(answers, poses)
            for group in optimizer.param_groups:
                group["lr"] = self._rate[index]
            clip, enabled = train.max_gradient_norm, self._enable[index]
            self.sums += branchless_update(loss, parameters, optimizer, clip, backward, enabled)

    def _captured(self, forward: str) -> torch.cuda.CUDAGraph:
        """Capture without `torch.cuda.graph`, which would wait until all other runs stand still."""
        assert self.stream is not None
        graph = torch.cuda.CUDAGraph()
        gc.collect()  # the end of an older graph in the middle of a capture makes it fail
        self.stream.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(self.stream), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of an optimiser that could be captured and is not
            unroll, self.unroll = self.unroll, 1
            for _ in range(WARM_UPS):  # with every switch off: nothing is learned
                self._body(forward)
            self.unroll = unroll
            self.sums.zero_()
            self.optimizer.zero_grad(set_to_none=True)
            graph.capture_begin(capture_error_mode="thread_local")
            self._body(forward)
            graph.capture_end()
        return graph


def build(job: FleetJob) -> IkNetwork:
    """Return the network of a job with the first weights that its seed stands for."""
    torch.manual_seed(job.seed)
    return build_network(job.robot, job.model)


def run_fleet(
    jobs: Iterable[FleetJob | None],
    device: torch.device,
    beside: int,
    deadline: float,
    finished: Callable[[FleetRun], None],
) -> list[str]:
    """Train jobs, so many at a time, and return the labels of those that time did not allow.

    Args:
        jobs: In the order of their importance. None stands for "nothing yet": a generator whose
            next jobs depend on results yields it until they are there.
        device: Where.
        beside: Runs at a time.
        deadline: `time.perf_counter` at which what is unfinished is dropped.
        finished: Called with each finished run; its network may be read.
    """
    waiting: Iterator[FleetJob | None] = iter(jobs)
    active: list[FleetRun] = []
    gc.freeze()  # what is there now stays; captures collect what came after
    with ThreadPoolExecutor(1) as builder:
        queue = _Queue(waiting, builder)
        while True:
            open_ = time.perf_counter() < deadline
            while open_ and len(active) < beside and (job := queue.take()) is not None:
                active.append(FleetRun(job[0], job[1].result(), device))
            if not open_ or (not active and queue.exhausted):
                break
            if not _advance(active, finished):
                time.sleep(1e-4)
        return [run.job.label for run in active] + queue.labels()


class _Queue:
    """Jobs whose first weights are drawn on another thread before they are due."""

    def __init__(self, waiting: Iterator[FleetJob | None], builder: ThreadPoolExecutor) -> None:
        self._waiting, self._builder = waiting, builder
        self._built: deque[tuple[FleetJob, Future[IkNetwork]]] = deque()
        self.exhausted, self._end = False, False

    def take(self) -> tuple[FleetJob, Future[IkNetwork]] | None:
        """Return the next job and its network to come, None where there is none at present."""
        while not self.exhausted and len(self._built) < LOOK_AHEAD:
            job = next(self._waiting, END)
            if job is None:
                break
            if isinstance(job, str):
                self._end = True
                break
            self._built.append((job, self._builder.submit(build, job)))
        if not self._built:
            self.exhausted = self._end
            return None
        return self._built.popleft()

    def labels(self) -> list[str]:
        """Names of the jobs that were not begun, up to the first that waits for results."""
        labels = [job.label for job, _ in self._built]
        for job in self._waiting:
            if job is None:
                break
            labels.append(job.label)
        return labels


def _advance(active: list[FleetRun], finished: Callable[[FleetRun], None]) -> bool:
    """Hand steps of all runs to the device, and tell whether there was anything to do."""
    moved = False
    for run in list(active):
        if run.done and run.idle:
            active.remove(run)
            finished(run)
            moved = True
        elif not run.done and run.ready:
            run.advance()
            moved = True
    return moved
