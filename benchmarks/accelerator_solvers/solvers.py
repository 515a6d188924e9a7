"""The solvers that are measured, each with its calls on the host and on the device."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import baselines
from baselines.lm_cuda import LmCuda
from baselines.lm_kernel import LmOptions
from baselines.seed_library import SeedLibrary
from robots import Robot, load_robot

Array = NDArray[np.float64]

BLOCKS = (32, 64, 128)  # threads that share a pose
# Tolerances of the solvers [m, rad]: those of conf/solver/lm.yaml, and a ten-thousandth of a mm.
TOLERANCES = ((1e-4, 1e-4), (1e-7, 1e-7))


class Calls(NamedTuple):
    """How one solver is called.

    Attributes:
        name: Of the solver.
        on_host: Takes poses on the host, returns a `Refined` there.
        on_device: Takes poses on the device, and returns once the answers are there; None for a
            processor.
    """

    name: str
    on_host: Callable[[Any], Any]
    on_device: Callable[[Any], Any] | None


def options_of(robot: Robot, position: float, rotation: float) -> LmOptions:
    solver = baselines.load("lm", robot)
    assert isinstance(solver, baselines.lm.LevenbergMarquardt)
    return solver.options(None)._replace(
        position_tolerance_m=position, rotation_tolerance_rad=rotation
    )


def solvers_of(
    robot: Robot, options: LmOptions, library: SeedLibrary, all_mappings: bool
) -> list[Calls]:
    """The solvers to measure; with `all_mappings` also every mapping of poses to threads."""
    made = [_lm("lm_cuda", robot, options, library)]
    refined = _refined(robot, options, library)
    made += [refined] if refined else []
    if all_mappings:
        made += [
            _lm("lm_cuda[not captured]", robot, options, library, captured=False),
            _lm("lm_cuda[lane]", robot, options, library, near=2, mapping="lane"),
            *(
                _lm(f"lm_cuda[block {n}]", robot, options, library, mapping="block", lanes=n)
                for n in BLOCKS
            ),
        ]
        twin = _torch_twin(robot, options, library)
        made += [twin] if twin else []
    return made


def _lm(
    name: str, robot: Robot, options: LmOptions, library: SeedLibrary, **settings: Any
) -> Calls:
    settings = {"captured": can_capture(), **settings}
    solver = LmCuda(robot, options, library, **settings)
    return Calls(name, solver.solve, solver.solve_on_device)


def _refined(robot: Robot, options: LmOptions, library: SeedLibrary) -> Calls | None:
    try:
        from pipeline.learning.card import shipped_weights
        from pipeline.learning.refined_cuda import RefinedCuda
        from pipeline.learning.weights import load_network

        network = load_network(shipped_weights(robot.name), robot)
        solver = RefinedCuda(robot, network, options, library, captured=can_capture())
    except (ImportError, ValueError, OSError) as error:
        print(f"no cycleik_refined_cuda for {robot.name}: {error}", flush=True)
        return None
    return Calls("cycleik_refined_cuda", solver.solve, solver.solve_on_device)


def _torch_twin(robot: Robot, options: LmOptions, library: SeedLibrary) -> Calls | None:
    try:
        import torch

        from baselines.refine_torch import refine_place, refine_torch
    except ImportError as error:
        print(f"no lm_torch: {error}", flush=True)
        return None
    if not torch.cuda.is_available():
        return None
    place = refine_place(robot, "cuda", "float64")

    def solve(poses: Any) -> Any:
        home = np.broadcast_to(robot.home, (len(poses), 1, robot.dof))
        return refine_torch(place, poses, home, options, library)

    return Calls("lm_torch", solve, None)


@cache
def can_capture() -> bool:
    """Whether torch is there to record launches, and records them."""
    robot = load_robot("panda")
    poses = robot.forward_kinematics(robot.home[None])
    try:
        import torch

        if not torch.cuda.is_available():
            return False
        solver = LmCuda(robot, options_of(robot, *TOLERANCES[0]), captured=True)
        answers = [solver.solve(poses).joints for _ in range(3)]
    except Exception as error:
        print(f"launches are not recorded: {type(error).__name__}: {error}", flush=True)
        return False
    return bool(np.array_equal(answers[0], answers[2]))
