"""`instructions`: an agent on the suite of instructions, rows and tables."""

from __future__ import annotations

import shlex

import pandas as pd

from pipeline import provenance
from pipeline.agent.loading import agent_factory, kind_of
from pipeline.artifacts import exclusive
from pipeline.commands.arguments import command_parser, flag, split_keys, with_defaults
from pipeline.config import compose
from pipeline.data.tables import write_table
from pipeline.embodiment.perception import make_perception
from pipeline.instructions.execution import World, executed_rows
from pipeline.instructions.suite import read_suite, rows_of
from pipeline.presentation.origin import origin_of
from pipeline.progress import bar
from pipeline.reporting.instructions import confusion, execution_success, plan_success
from pipeline.settings import Config
from pipeline.solvers import check_solvers, network_of
from pipeline.stages.eyes import detector_of
from pipeline.stages.graph import STAGES
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.stages.running import with_weights
from pipeline.stages.solvers import solver_of

DESCRIPTION = """\
instructions [execute=true] [agent=policy|endpoint|local|replay|none] [robot=nicol] [key=value ...]

Gives an agent the 120 instructions of the suite, twelve families of ten, of which five are held
out; compares its plans with the right ones and prints plan success and confusion by family. A plan
is an agent's first reply. With execute=true the robot carries each plan out in simulation, and a
third table tells how many right plans were right deeds.
"""


def instructions(arguments: list[str]) -> int:
    """Run the suite with one agent."""
    given = command_parser("instructions", DESCRIPTION).takes_overrides().parse(arguments).overrides
    own, overrides = split_keys(given, ("execute",))
    config = compose(with_defaults(overrides, {"agent": "policy", "robot": "nicol"}))
    suite = read_suite()
    agents = agent_factory(config.agent, config.robot.name)
    name = kind_of(config.agent, agents().model)
    networks = ""
    if flag("execute", own.get("execute", "false")):
        world = load_world(config)
        networks = ", ".join(filter(None, map(network_of, world.solvers)))
        made = executed_rows(suite, agents, name, world)
        makers = [plan_success, confusion, execution_success]
    else:
        made, makers = rows_of(suite, agents, name), [plan_success, confusion]
    rows = []
    with bar(len(suite), "instruction", f"instructions {config.agent.kind}") as shown:
        for row in made:
            rows.append(row)
            shown.update()
    frame = pd.DataFrame(rows)
    signed = {**provenance.signature(config.profile), "network": networks}
    card = {**provenance.card(config=config), **signed}
    command = shlex.join(["python", "-m", "pipeline", "instructions", *arguments])
    folder = artifacts(config).instructions(config.agent.kind)
    with exclusive(folder):
        write_table(folder / "plans.parquet", frame, card)
        for make in makers:
            table = make(frame, config.report.confidence)
            table.origin = origin_of(command, [card], config.profile)
            print(table.to_markdown())
            table.write(folder)
    print(folder)
    return 0


def load_world(config: Config) -> World:
    """Load the robot that carries instructions out, with its solvers and senses.

    Args:
        config: Of the run.

    Raises:
        PipelineError: The robot has no scene, or a solver or its detector is missing.
    """
    robot = robot_of(config)
    check_solvers(config.grasp.solvers_by_key(), robot)
    config = with_weights(config, STAGES["grasp"].solver_names(config))
    grasp = config.grasp
    detector = detector_of(robot, config) if config.perception.source == "camera" else None
    return World(
        robot,
        grasp,
        solver_of(grasp.solver, robot, config),
        solver_of(grasp.repair, robot, config) if grasp.repair else None,
        make_perception(config.perception, grasp, robot, detector, config.seed),
    )
