"""Stage evaluate-protocol: solvers as another group measures them, one raw row an answer."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import baselines
from pipeline.errors import ConfigError
from pipeline.evaluation.config import HOME, row_name
from pipeline.evaluation.task import EvaluationTask
from pipeline.progress import LOGGER
from pipeline.protocols.problems import questions, with_protocol
from pipeline.stages import evaluate
from pipeline.stages.evaluate import Job, each_solver, write_rows
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.stages.solvers import code_of, solver_of

if TYPE_CHECKING:
    from pipeline.settings import Config

# Settings by which solvers are told when to stop, all in m or rad.
TOLERANCES = ("position_tolerance_m", "rotation_tolerance_rad", "epsilon")


def check(config: Config) -> None:
    """Refuse a run that no solver is left for, or whose starts are not those of the protocol."""
    if config.evaluate.seeded_by != HOME:
        raise ConfigError(
            f"evaluate.seeded_by={config.evaluate.seeded_by}: a protocol says where solvers start; "
            "leave it at home, or use the stage evaluate"
        )
    for name, why in left_out(config).items():
        LOGGER.warning("solver '%s' is left out: %s", name, why)
    evaluate.check(_as_protocol(config))


def left_out(config: Config) -> dict[str, str]:
    """Return why solvers of ``protocol.solvers`` cannot run here or for the robot, by solver."""
    robot = robot_of(config)
    reasons = {name: baselines.skip(name, robot) for name in config.protocol.solvers}
    return {name: why for name, why in reasons.items() if why is not None}


def rows_name(batch_size: int) -> str:
    """Return the name of the table of a batch size, in the folder of a solver."""
    return f"batch{batch_size}.parquet"


def run(config: Config) -> list[Path]:
    """Write the raw rows of every solver that can run, a folder for each, in it one table a batch.

    Budget, start, calls and tolerance are the protocol's; threads, cores and chunks those of
    ``evaluate``.
    """
    return each_solver(_as_protocol(config), _one)


def _as_protocol(config: Config) -> Config:
    """The run with the solvers, the budget and the tolerance of its protocol."""
    protocol = config.protocol
    skipped = left_out(config)
    able = [name for name in protocol.solvers if name not in skipped]
    if not able:
        named = "; ".join(f"{name}: {why}" for name, why in skipped.items())
        raise ConfigError(f"protocol.solvers: none can run for {config.robot.name}: {named}")
    changed = replace(
        config.evaluate,
        solvers=able,
        time_s=protocol.time_s,
        time_factor={},
        iterations=protocol.iterations,
        error_batch_size={},
        trajectories=0,
    )
    return replace(config, evaluate=changed, solver=_told(config))


def _told(config: Config) -> dict[str, dict[str, Any]]:
    """Settings of all solvers, with the tolerance of the protocol where they have one."""
    tolerance = config.protocol.tolerance
    if tolerance is None:
        return config.solver
    return {
        name: {key: tolerance if key in TOLERANCES else value for key, value in own.items()}
        for name, own in config.solver.items()
    }


def _one(job: Job) -> Path:
    config, name = job
    robot, protocol = robot_of(config), config.protocol
    asked = questions(robot, protocol, config.seed, config.robot.workspace_filter)
    label = row_name(name, config.evaluate.pinned)
    folder = artifacts(config).evaluate_protocol(robot.name, protocol.name, label)
    code = code_of(__name__, {"solver": [name]}, config)
    rules = {key: value for key, value in asdict(protocol).items() if key != "solvers"}
    for size, count in protocol.calls().items():
        part = asked.first(count)
        warm_up = protocol.warm_up_calls * size
        settings = replace(config.evaluate, batch_sizes=[size], warm_up=warm_up)
        task = EvaluationTask(
            robot,
            solver_of(name, robot, config),
            part.poses,
            config.seed,
            label,
            initial=part.start,
            code=code,
        )
        write_rows(
            task,
            replace(config, evaluate=settings),
            folder / rows_name(size),
            f"evaluate_protocol-{robot.name}-{protocol.name}-{label}-{size}",
            {"protocol": rules},
            partial(with_protocol, asked=part, robot=robot, protocol=protocol),
        )
    return folder
