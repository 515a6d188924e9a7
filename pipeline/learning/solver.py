"""Neural solvers: a network answers a batch of poses in one pass, once or many times each."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from baselines import Budget, SettingError, Solution, Solver
from baselines.checks import check_poses
from pipeline.learning.networks import SamplingNetwork
from pipeline.learning.weights import load_network
from robots import Robot, rotations
from robots.threads import forked

NOT_PRECISE = "outside the tolerance"
ROWS = 16384  # samples of a pass of the network
_REASON_OF = np.array([NOT_PRECISE, ""], dtype=object)


class Hypotheses(NamedTuple):
    """Answers of a network with K heads to N poses, best first, with their errors.

    Attributes:
        joints: (N, K, dof) rad or m, inside the limits.
        position_mm: (N, K) Euclidean position errors.
        rotation_deg: (N, K) geodesic rotation errors.
    """

    joints: NDArray[np.float64]
    position_mm: NDArray[np.float64]
    rotation_deg: NDArray[np.float64]


@contextmanager
def torch_threads(count: int) -> Iterator[None]:
    """Let torch use ``count`` threads, 0 for as many as it has; afterwards it is as before."""
    before = torch.get_num_threads()
    count = 1 if forked() else count  # its threads do not survive a fork either
    if count and count != before:
        torch.set_num_threads(count)
    try:
        yield
    finally:
        if torch.get_num_threads() != before:
            torch.set_num_threads(before)


class NeuralSolver(Solver):
    """One forward pass, no iterations and no initial guess.

    Of several hypotheses the one with the smallest error, each measured in tolerances, is taken.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        position_tolerance_mm: Largest position error that the solver calls found.
        rotation_tolerance_deg: Largest rotation error that the solver calls found.
        threads: Threads while it solves; 0 leaves torch as it is and takes all of numba's.

    Attributes:
        kinds: Kinds of networks (``model.kind``) whose weights it takes.
        default_model: What is trained for it (conf/model) where a run's model is of another kind.
        as_proposer: Settings that differ where its answers are but seeds of a descent.
    """

    kinds: ClassVar[tuple[str, ...]]
    default_model: ClassVar[str]
    as_proposer: ClassVar[Mapping[str, Any]] = {}
    requires: ClassVar[tuple[str, ...]] = ("torch",)
    budgets: ClassVar[frozenset[str]] = frozenset()
    always_answers = True

    def __init__(
        self,
        robot: Robot,
        weights: str,
        position_tolerance_mm: float,
        rotation_tolerance_deg: float,
        threads: int,
    ) -> None:
        super().__init__(robot)
        self.network = load_network(Path(weights), robot, self.kinds)
        self.position_tolerance_mm = position_tolerance_mm
        self.rotation_tolerance_deg = rotation_tolerance_deg
        self.threads = threads

    def hypotheses(self, poses: NDArray[np.float64]) -> Hypotheses:
        """Return the network's answers to poses (N, 7), best first."""
        joints = self._answers(poses)
        position, rotation = self.errors(joints, poses)
        in_tolerances = (
            position / self.position_tolerance_mm + rotation / self.rotation_tolerance_deg
        )
        order = np.argsort(in_tolerances, axis=1, kind="stable")
        rows = np.arange(len(poses))[:, None]
        return Hypotheses(joints[rows, order], position[rows, order], rotation[rows, order])

    def in_domain(self, poses: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which poses (N, 7) lie in the workspace box whose poses the network learned.

        Its answers outside are extrapolated: worse starts of a descent than the robot's home.
        """
        centre, half = (
            buffer.numpy(force=True)
            for buffer in (self.network.position_centre, self.network.position_scale)
        )
        inside: NDArray[np.bool_] = (np.abs((poses[:, :3] - centre) / half) <= 1.0).all(axis=1)
        return inside

    def refined_query(self, tried: int) -> tuple[Any, tuple[Any, ...]] | None:
        """Return a compiled function that answers one pose and refines it, for `CompiledQuery`.

        Args:
            tried: Hypotheses that are descended from.

        Returns:
            The function and its arguments between home and `SeedLibrary`, or None for a
            network that is not compiled.
        """
        return None

    def seeding(
        self, poses: NDArray[np.float64], seeds: NDArray[np.float64]
    ) -> Callable[[slice], None] | None:
        """Return what writes the best hypotheses of some rows, for `baselines.refine`.

        Args:
            poses: (N, 7) targets.
            seeds: (N, K, dof), whose rows receive the K best, or home outside the domain.

        Returns:
            A function of the rows, which threads may call at once, or None for a network that is
            not compiled or has fewer hypotheses.
        """
        return None

    def _answers(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the network's answers (N, K, dof) to poses (N, 7), inside the limits."""
        with torch_threads(self.threads), torch.inference_mode():
            dtype = next(self.network.parameters()).dtype
            output = self.network(torch.as_tensor(poses, dtype=dtype))
        return np.clip(output.numpy().astype(np.float64), self.lower, self.upper)

    def _solve_batch(
        self, poses: NDArray[np.float64], initial: NDArray[np.float64], budget: Budget | None
    ) -> Solution:
        start = time.perf_counter()
        answers = self.hypotheses(poses)
        found = (answers.position_mm[:, 0] <= self.position_tolerance_mm) & (
            answers.rotation_deg[:, 0] <= self.rotation_tolerance_deg
        )
        seconds = time.perf_counter() - start
        return Solution(
            joints=answers.joints[:, 0],
            found=found,
            time_s=np.full(len(poses), seconds / len(poses)),
            iterations=np.ones(len(poses), dtype=np.int64),
            reason=tuple(_REASON_OF[found.astype(np.int64)].tolist()),
        )

    def errors(
        self, hypotheses: NDArray[np.float64], poses: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return errors (N, K) in mm and deg of hypotheses (N, K, dof)."""
        count, heads, dof = hypotheses.shape
        reached = self.robot.forward_kinematics(hypotheses.reshape(-1, dof))
        reached = reached.reshape(count, heads, 7)
        position = np.linalg.norm(reached[..., :3] - poses[:, None, :3], axis=2) * 1e3
        targets = np.broadcast_to(poses[:, None, 3:], (count, heads, 4))
        return position, np.degrees(rotations.rotation_angle(reached[..., 3:], targets))


class SamplingSolver(NeuralSolver):
    """The best of the solutions that a generative network samples; `sample` gives all of them.

    All poses share their random numbers, so that an answer does not depend on the poses beside it.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        samples: Samples of each pose.
        seed: Of the samples.
        **settings: Tolerances and threads, see `NeuralSolver`.
    """

    def __init__(
        self, robot: Robot, weights: str, samples: int, seed: int, **settings: Any
    ) -> None:
        super().__init__(robot, weights, **settings)
        self.samples, self.seed = samples, seed

    def sample(self, poses: ArrayLike, count: int, seed: int) -> NDArray[np.float64]:
        """Sample solutions.

        Args:
            poses: (N, 7) or one pose (7,), x y z in m, then unit qw qx qy qz.
            count: Solutions K of each pose.
            seed: Of the random numbers, which all poses share.

        Returns:
            (N, K, dof), or (K, dof) for one pose: joints [rad or m] inside the limits, not refined
            and in no order.

        Raises:
            PoseError: Poses of wrong shape, not finite or with a quaternion that is not unit.
        """
        array = np.asarray(poses, dtype=np.float64)
        sampled = self._sampled(check_poses(np.atleast_2d(array)), count, seed)
        return sampled[0] if array.ndim == 1 else sampled

    @abstractmethod
    def _sampler(self, count: int, seed: int) -> Callable[[Tensor], Tensor]:
        """Return a function from poses (N, 7) to joints (N, count, dof) with its own noise."""

    def _answers(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._sampled(poses, self.samples, self.seed)

    def _sampled(self, poses: NDArray[np.float64], count: int, seed: int) -> NDArray[np.float64]:
        sampler = self._sampler(count, seed)
        sampled = np.empty((len(poses), count, self.robot.dof))
        step = max(1, ROWS // count)
        with torch_threads(self.threads), torch.inference_mode():
            for start in range(0, len(poses), step):
                rows = slice(start, start + step)
                targets = torch.as_tensor(poses[rows], dtype=torch.float32)
                sampled[rows] = sampler(targets).numpy()
        return self.robot.nearest_turns(np.clip(sampled, self.lower, self.upper))


class LatentSolver(SamplingSolver):
    """The best of many draws of each pose, by a network whose draws are functions of latents.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        samples: Draws of each pose.
        latent_scale: Scale of the normal latents. Below 1 draws keep closer to what is likely.
        **settings: Seed, tolerances and threads, see `SamplingSolver`.

    Raises:
        SettingError: Fewer than one draw, or a negative scale.
    """

    network: SamplingNetwork

    def __init__(
        self, robot: Robot, weights: str, samples: int, latent_scale: float, **settings: Any
    ) -> None:
        super().__init__(robot, weights, samples=samples, **settings)
        if samples < 1:
            raise SettingError(f"{type(self).__name__}: expected samples >= 1, got {samples}")
        if not latent_scale >= 0:
            raise SettingError(
                f"{type(self).__name__}: expected latent_scale >= 0, got {latent_scale}"
            )
        self.latent_scale = latent_scale

    def _sampler(self, count: int, seed: int) -> Callable[[Tensor], Tensor]:
        latents = self.network.latents(1, count, seed, self.latent_scale)
        return partial(self.network.draws, latents=latents)
