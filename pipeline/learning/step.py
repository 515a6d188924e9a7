"""One optimiser step: decided on the host, or one CUDA graph that decides for itself.

torch.compile is not offered: on two cores it gains 1 to 3 % with Table I's networks, loses as much
with the compact one, and needs a C++ compiler.
"""

from __future__ import annotations

import gc
import warnings
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor, nn

from pipeline.learning.checkpoint import Progress
from pipeline.learning.config import BFLOAT16, TrainConfig
from pipeline.learning.networks import IkNetwork
from pipeline.learning.objective import CapturableObjective, Objective
from pipeline.learning.precision import MatmulPrecision, matmul_precision

WARM_UPS = 3  # PyTorch's advice: libraries ask for memory in their first calls, which no graph may


class TrainingError(ValueError):
    """A training that cannot be started or cannot go on."""


@dataclass(frozen=True)
class TrainState:
    """What every step of a training works on.

    Attributes:
        objective: Gives the loss of a batch.
        network: Its parameters are trained.
        optimizer: Adam, fused.
        products: Precision of the matrix products.
        clip: Largest norm of the gradient.
    """

    objective: Objective
    network: nn.Module
    optimizer: torch.optim.Optimizer
    products: MatmulPrecision
    clip: float

    @property
    def parameters(self) -> list[nn.Parameter]:
        """Those of the network."""
        return list(self.network.parameters())

    def gradient_norm(self) -> Tensor:
        """Norm of all gradients together."""
        return total_gradient_norm(self.parameters)


def total_gradient_norm(parameters: list[nn.Parameter]) -> Tensor:
    """Norm of the gradients of all parameters together, a scalar."""
    return nn.utils.get_total_norm([p.grad for p in parameters if p.grad is not None])


def branchless_update(
    loss: Tensor,
    parameters: list[nn.Parameter],
    optimizer: Any,
    clip: float,
    backward: str,
    enabled: Tensor,
) -> Tensor:
    """Take an optimiser step from a loss without a decision or a number on the host.

    Clipping and leaving out are left to the fused optimiser, which divides gradients by its
    ``grad_scale`` and changes nothing where its ``found_inf`` is one: what PyTorch's gradient
    scaler uses for mixed precision.

    Args:
        loss: Scalar, with its graph.
        parameters: Those that are trained.
        optimizer: Adam, fused; its learning rate is set.
        clip: Largest norm of the gradient.
        backward: Precision of the matrix products of the backward pass.
        enabled: Scalar, 1 to learn, 0 to change nothing.

    Returns:
        (3,) the loss if the step was taken, and the numbers of steps taken and left out because
        their gradient was not finite, one of them 1 unless the step is not enabled.
    """
    optimizer.zero_grad(set_to_none=True)
    with matmul_precision(backward):
        loss.backward()
    norm = total_gradient_norm(parameters)
    finite = torch.isfinite(norm).float() * enabled
    optimizer.grad_scale = (norm / clip).clamp(min=1.0)
    optimizer.found_inf = 1.0 - finite
    optimizer.step()
    learned = torch.where(finite > 0, loss.detach(), 0.0)
    return torch.stack((learned, finite, enabled - finite))


class EagerStep:
    """A step that any network and device takes.

    Args:
        state: What it works on.
    """

    def __init__(self, state: TrainState) -> None:
        self.state = state

    def __call__(
        self, poses: Tensor, joints: Tensor, progress: Progress, total: int, rate: float
    ) -> None:
        """Take a step; a gradient that is not finite changes nothing and is counted.

        Args:
            poses: (N, 7) targets.
            joints: (N, dof) that they were made from.
            progress: Counts the step and sums its loss.
            total: Steps of the run.
            rate: Learning rate of this step.
        """
        state = self.state
        for group in state.optimizer.param_groups:
            group["lr"] = rate
        done = progress.step / total
        with state.products.forward_pass(state.network, done):
            loss = state.objective.loss(poses, joints, progress.step, done)
        state.optimizer.zero_grad(set_to_none=True)
        with matmul_precision(state.products.backward):
            loss.backward()
        norm = state.gradient_norm()
        if torch.isfinite(norm):
            # Gradients that are small enough are not written again, which takes a while.
            if norm > state.clip:
                nn.utils.clip_grads_with_norm_(state.parameters, state.clip, norm)
            state.optimizer.step()
            progress.loss_sum += float(loss.detach())
            progress.loss_steps += 1
        else:
            progress.skipped += 1
        progress.step += 1

    def flush(self, progress: Progress) -> None:
        """Bring losses that are summed up elsewhere to the progress: here there are none."""


class BranchlessStep:
    """The same step without a decision or a number on the host, by `branchless_update`.

    Args:
        state: What it works on; its objective must be a `CapturableObjective`.
        size: Poses in each batch.
    """

    def __init__(self, state: TrainState, size: int) -> None:
        assert isinstance(state.objective, CapturableObjective)
        self.state, self.objective = state, state.objective
        device = state.parameters[0].device
        self._network_input, self._poses = torch.zeros(2, size, 7, device=device)
        self._rate, self._enabled = torch.zeros((), device=device), torch.ones((), device=device)
        self._sums = torch.zeros(3, device=device, dtype=torch.float64)

    def __call__(
        self, poses: Tensor, joints: Tensor, progress: Progress, total: int, rate: float
    ) -> None:
        """Take a step, see `EagerStep`; `flush` reports the losses."""
        self._poses.copy_(poses)
        self._network_input.copy_(self.objective.network_input(poses, progress.step))
        self._rate.fill_(rate)
        self._run()
        progress.step += 1

    def flush(self, progress: Progress) -> None:
        """Bring sum and number of losses and of steps left out to the progress."""
        loss, steps, skipped = self._sums.tolist()
        progress.loss_sum += loss
        progress.loss_steps += int(steps)
        progress.skipped += int(skipped)
        self._sums.zero_()

    def _run(self) -> None:
        self._bind_rate()
        self._body()

    def _bind_rate(self) -> None:
        """Let the optimiser read the rate from its tensor, also after it was restored."""
        for group in self.state.optimizer.param_groups:
            group["lr"] = self._rate

    def _body(self) -> None:
        state = self.state
        with matmul_precision(state.products.forward):
            loss = self.objective.loss_of(self._network_input, self._poses)
        self._sums += branchless_update(
            loss,
            state.parameters,
            state.optimizer,
            state.clip,
            state.products.backward,
            self._enabled,
        )


class CapturedStep(BranchlessStep):
    """That step as one CUDA graph, captured at the first call and replayed from then on.

    A step of a small batch is some hundred kernels of microseconds each, which take longer to
    launch than to run; a graph launches them at once. It needs an optimiser that is ``capturable``.
    """

    _graph: torch.cuda.CUDAGraph | None = None

    def _run(self) -> None:
        if self._graph is None:
            self._graph = self._captured()
        self._graph.replay()

    def _captured(self) -> torch.cuda.CUDAGraph:
        self._bind_rate()
        graph, stream = torch.cuda.CUDAGraph(), torch.cuda.Stream()
        try:
            stream.wait_stream(torch.cuda.current_stream())
            with torch.cuda.stream(stream), warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of an optimiser that could be captured and is not
                self._enabled.zero_()
                for _ in range(WARM_UPS):
                    self._body()
                self._enabled.fill_(1.0)
                self._sums.zero_()
            torch.cuda.current_stream().wait_stream(stream)
            self.state.optimizer.zero_grad(set_to_none=True)
            gc.collect()  # the end of an older graph in the middle of a capture makes it fail
            with torch.cuda.graph(graph):
                self._body()
        except torch.OutOfMemoryError:
            raise
        except RuntimeError as error:
            raise TrainingError(
                f"the training step could not be captured as a CUDA graph ({error}): "
                "train.step=eager trains without"
            ) from error
        return graph


def is_captured(train: TrainConfig, network: nn.Module, device: torch.device) -> bool:
    """Return whether ``train.step`` stands for a captured step; ``auto`` takes it where it can.

    Raises:
        TrainingError: It is requested and cannot be.
    """
    hindrances = {
        "a CUDA device (train.device)": device.type == "cuda",
        "a network of one shape for every batch (model=paper)": isinstance(network, IkNetwork)
        and network.capturable,
        "train.kinematics=auto or products": train.kinematics in ("auto", "products"),
        "one train.precision for the whole run": train.precision != BFLOAT16,
    }
    missing = [name for name, met in hindrances.items() if not met]
    if train.step == "captured" and missing:
        raise TrainingError(f"train.step=captured needs {missing[0]}: use auto or eager")
    return train.step != "eager" and not missing
