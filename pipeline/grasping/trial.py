"""One grasp trial: where the object lies, what the robot does, which class comes of it."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.errors import GraspError
from pipeline.grasping.arm import Arm
from pipeline.grasping.config import PINNED, GraspConfig, SceneConfig
from pipeline.grasping.grasp import Grasp
from pipeline.grasping.grip import tip_yaw
from pipeline.grasping.hardware import Hardware
from pipeline.grasping.outcome import classify, measures
from pipeline.grasping.placements import SINGLE, Setup, pinned
from pipeline.grasping.scene import Scene
from pipeline.seeding import derive_seed

if TYPE_CHECKING:
    from baselines import Solver
    from pipeline.grasping.video import Recorder
    from robots import Robot


def trial_setup(config: GraspConfig, robot: str, number: int, seed: int) -> Setup:
    """Lay out a trial by its number alone, so that each can be run by itself.

    As in the paper, all objects of the set stand on a row, spread over the width, and rows advance
    over the depth; their order on a row and the exact place in their share of it are drawn. Where
    the placements are pinned, only the direction of the injected error is.

    Args:
        config: The experiment; its scene has the area and the objects.
        robot: Name of the robot, part of the seed.
        number: Number of the trial, from 0.
        seed: Root seed.

    Returns:
        What to lay where.
    """
    scene = required_scene(config, robot)
    names, area = list(scene.objects), scene.area
    rows = rows_of(scene)
    round_number, slot = divmod(number, len(names))
    row = round_number % rows
    order = np.random.default_rng(derive_seed(seed, "grasp", robot, "row", round_number))
    name = names[order.permutation(len(names))[slot]]
    draw = np.random.default_rng(derive_seed(seed, "grasp", robot, "trial", number))
    share = (slot + draw.uniform(0.1, 0.9)) / len(names)
    place = (area.x[0] + row * area.row_step, area.y[0] + share * (area.y[1] - area.y[0]))
    turn = draw.uniform(-180.0, 180.0)
    fixed = config.objects[name].yaw
    yaw = turn if fixed is None else tip_yaw(scene, place) + scene.grip.closing + fixed
    angle = draw.uniform(0.0, 2.0 * np.pi)
    error = config.position_error * np.array([np.cos(angle), np.sin(angle)])
    if config.placements == PINNED:
        return replace(pinned(robot, SINGLE, number)[0], error=error)
    return Setup(number, row, name, place, float(np.deg2rad(yaw)), error)


def rows_of(scene: SceneConfig) -> int:
    """Number of rows over the depth of the action area."""
    depth = scene.area.x[1] - scene.area.x[0]
    return int(np.floor(depth / scene.area.row_step + 1e-9)) + 1


def required_scene(config: GraspConfig, robot: str) -> SceneConfig:
    """The scene of a robot, its hand as strong and as rough as the experiment wants it.

    Raises:
        GraspError: If there is none.
    """
    if robot not in config.scenes:
        raise GraspError(
            f"there is no grasp scene for robot '{robot}'; there are {', '.join(config.scenes)}. "
            "Add one to conf/grasp/scene and its line to conf/grasp/default.yaml"
        )
    scene = config.scenes[robot]
    hand = replace(
        scene.hand,
        tension=config.tension_scale * scene.hand.tension,
        friction=config.friction_scale * scene.hand.friction,
    )
    return replace(scene, hand=hand)


def run_trial(
    config: GraspConfig,
    robot: Robot,
    solver: Solver,
    number: int,
    seed: int,
    repair: Solver | None = None,
    recorder: Recorder | None = None,
) -> dict[str, Any]:
    """Run one trial from an empty table to a class.

    Args:
        config: The experiment.
        robot: The robot.
        solver: Inverse kinematics of its motions.
        number: Number of the trial, from 0; with the seed it fixes everything.
        seed: Root seed.
        repair: Solver that repairs waypoints from their neighbours.
        recorder: Films the trial.

    Returns:
        One raw row: what was laid where, the class and its reason, errors, contacts, times.

    Raises:
        GraspError: If the robot has no scene or no hand.
    """
    begin = time.perf_counter()
    setup = trial_setup(config, robot.name, number, seed)
    scene_config = required_scene(config, robot.name)
    hardware = Hardware.drawn(config.hardware, robot, seed, number)
    with Scene(robot, scene_config, config.physics, config.gui, hardware) as scene:
        obj = config.objects[setup.name]
        scene.lay(obj, setup.place, setup.yaw)
        if recorder is not None:
            recorder.attach(scene)
        scene.wait(config.physics.settle_s)
        believed = scene.object_position()
        believed[:2] += setup.error
        top = believed[2] + 0.5 * obj.height
        believed[2] = max(believed[2], top - scene_config.grip.depth)
        report = Grasp(Arm(scene, config, solver, repair)).run(believed)
        simulated = scene.time_s
    outcome, reason = classify(report)
    return {
        **conditions(config, setup, robot, solver, seed),
        "position_error_mm": 1e3 * config.position_error,
        "class": outcome,
        "reason": reason,
        **measures(report),
        "simulated_s": simulated,
        "wall_s": time.perf_counter() - begin,
    }


def conditions(
    config: GraspConfig, setup: Setup, robot: Robot, solver: Solver, seed: int
) -> dict[str, Any]:
    """Columns of a raw row that say what was laid where, and by what it was to be grasped."""
    return {
        "trial": setup.number,
        "robot": robot.name,
        "solver": solver.name,
        "seed": seed,
        "object": setup.name,
        "row": setup.row,
        "x_m": setup.place[0],
        "y_m": setup.place[1],
        "yaw_rad": setup.yaw,
        "tension_scale": config.tension_scale,
        "friction_scale": config.friction_scale,
        "rate_hz": config.physics.rate,
        "iterations": config.physics.iterations,
        "placements": config.placements,
        "noise_seed": config.physics.noise_seed,
        "zero_offset_deg": float(np.rad2deg(config.hardware.zero_offset)),
        "backlash_deg": float(np.rad2deg(config.hardware.backlash)),
        "mass_spread": config.hardware.mass_spread,
    }
