"""`instructions`: an agent on the suite of instructions, rows and tables."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import Any

import pandas as pd

from pipeline import provenance
from pipeline.agent import Agent
from pipeline.agent.loading import agent_factory, kind_of
from pipeline.artifacts import exclusive
from pipeline.commands.arguments import command_parser, flag, split_keys, with_defaults
from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.data.files import sha256
from pipeline.data.rows import RowCheckpoint
from pipeline.data.tables import write_table
from pipeline.evaluation.cache import solver_identity
from pipeline.grasping.trial import required_scene
from pipeline.instructions.execution import World
from pipeline.instructions.suite import SUITE, read_suite, row_of
from pipeline.presentation.origin import origin_of
from pipeline.progress import bar
from pipeline.provenance import digest
from pipeline.reporting.instructions import (
    EXECUTED,
    confusion,
    execution_success,
    plan_success,
)
from pipeline.settings import Config
from pipeline.solvers import check_solvers, network_of
from pipeline.stages.graph import STAGES
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.stages.running import with_weights
from pipeline.stages.solvers import code_of, solver_of

EXECUTE = "execute"  # key of the command: whether plans are carried out
DESCRIPTION = """\
instructions [execute=true] [agent=policy|endpoint|local|replay|none] [robot=nicol] [key=value ...]

Gives an agent the 120 instructions of the suite, twelve families of ten, of which five are held
out; compares its plans with the right ones and prints plan success and confusion by family. A plan
is an agent's first reply. With execute=true the robot carries each plan out in simulation, where
it is told the places, and a third table tells how many right plans were right deeds; killed and
called again it goes on.
"""


def instructions(arguments: list[str]) -> int:
    """Run the suite with one agent."""
    given = command_parser("instructions", DESCRIPTION).takes_overrides().parse(arguments).overrides
    own, overrides = split_keys(given, (EXECUTE,))
    config = compose(with_defaults(overrides, {"agent": "policy", "robot": "nicol"}))
    agents = agent_factory(config.agent, config.robot.name)
    name = kind_of(config.agent, agents().model)
    world = load_world(config) if flag(EXECUTE, own.get(EXECUTE, "false")) else None
    folder = artifacts(config).instructions(config.agent.kind)
    with exclusive(folder):
        rows = _rows(config, agents, name, world)
        frame, confidence = pd.DataFrame(rows), config.report.confidence
        networks = map(network_of, world.solvers) if world else ()
        signed = {"network": ", ".join(filter(None, networks))}
        card = {**provenance.card(config=config), **provenance.signature(config.profile), **signed}
        write_table(folder / "plans.parquet", frame, card)
        for old in folder.glob(f"{EXECUTED}.*"):  # of plans that are gone now
            old.unlink()
        tables = [plan_success(frame, confidence), confusion(frame)]
        tables += [execution_success(frame, confidence)] if world else []
        command = shlex.join(["python", "-m", "pipeline", "instructions", *arguments])
        for table in tables:
            table.origin = origin_of(command, [card], config.profile)
            print(table.to_markdown())
            table.write(folder)
        _kept(config, world).clear()
    print(folder)
    return 0


def _rows(
    config: Config, agents: Callable[[], Agent], name: str, world: World | None
) -> list[dict[str, Any]]:
    """Raw rows of all instructions; those that are carried out are kept as they are made."""
    suite, rows = read_suite(), []
    kept = _kept(config, world)
    if world is not None:
        for each in suite:
            world.check(each)
    with bar(len(suite), "instruction", f"instructions {config.agent.kind}") as shown:
        for each in suite:
            row = kept.get(each.number)
            if row is None and world is not None:
                row = world.row(each, agents(), name)
                kept.put(row)
            rows.append(row or row_of(each, agents().instruct(each.says, each.seen), name))
            shown.update()
    return rows


def _kept(config: Config, world: World | None) -> RowCheckpoint:
    """The file of finished rows; another name where anything differs that they depend on."""
    facts: list[Any] = [sha256(SUITE), to_dict(config.agent), config.seed, world is not None]
    if world is not None:
        solvers = [solver_identity(each) for each in world.solvers]
        code = code_of(__name__, config.grasp.solvers_by_key(), config)
        facts += [to_dict(config.grasp), world.robot.urdf_checksum, solvers, code]
    name = f"instructions-{digest([*facts, provenance.versions()])}.jsonl"
    return RowCheckpoint(artifacts(config).root / "checkpoint" / name, ("number",))


def load_world(config: Config) -> World:
    """Load the robot that carries instructions out, with its solvers.

    Args:
        config: Of the run.

    Raises:
        PipelineError: The robot has no scene, or a solver is missing.
    """
    robot = robot_of(config)
    required_scene(config.grasp, robot.name)
    check_solvers(config.grasp.solvers_by_key(), robot)
    config = with_weights(config, STAGES["grasp"].solver_names(config))
    grasp = config.grasp
    return World(
        robot,
        grasp,
        solver_of(grasp.solver, robot, config),
        solver_of(grasp.repair, robot, config) if grasp.repair else None,
        config.seed,
    )
