"""`instructions`: an agent on the suite of instructions, rows and tables."""

from __future__ import annotations

import shlex

import pandas as pd

from pipeline import provenance
from pipeline.agent.loading import agent_factory, kind_of
from pipeline.artifacts import exclusive
from pipeline.commands.arguments import command_parser, with_defaults
from pipeline.config import compose
from pipeline.data.tables import write_table
from pipeline.instructions.suite import read_suite, rows_of
from pipeline.presentation.origin import origin_of
from pipeline.progress import bar
from pipeline.reporting.instructions import confusion, plan_success
from pipeline.stages.inputs import artifacts

DESCRIPTION = """\
instructions [agent=policy|endpoint|local|replay|none] [robot=nicol] [key=value ...]

Gives an agent the 120 instructions of the suite, twelve families of ten, of which five are held
out; compares its plans with the right ones and prints plan success and confusion by family. No
simulation: a plan is an agent's first reply.
"""


def instructions(arguments: list[str]) -> int:
    """Run the suite with one agent."""
    given = command_parser("instructions", DESCRIPTION).takes_overrides().parse(arguments).overrides
    config = compose(with_defaults(given, {"agent": "policy", "robot": "nicol"}))
    suite = read_suite()
    agents = agent_factory(config.agent, config.robot.name)
    with bar(len(suite), "instruction", f"instructions {config.agent.kind}") as shown:
        rows = []
        for row in rows_of(suite, agents, kind_of(config.agent, agents().model)):
            rows.append(row)
            shown.update()
    frame = pd.DataFrame(rows)
    card = {**provenance.card(config=config), **provenance.signature(config.profile)}
    command = shlex.join(["python", "-m", "pipeline", "instructions", *arguments])
    folder = artifacts(config).instructions(config.agent.kind)
    with exclusive(folder):
        write_table(folder / "plans.parquet", frame, card)
        for table in (plan_success(frame, config.report.confidence), confusion(frame)):
            table.origin = origin_of(command, [card], config.profile)
            print(table.to_markdown())
            table.write(folder)
    print(folder)
    return 0
