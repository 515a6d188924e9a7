"""What the command line offers: stages and their sweeps, and commands for looking around.

A command is imported when it is called, so that `--help` does not wait for what others need.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module

from pipeline.errors import PipelineError
from pipeline.stages.graph import STAGES


@dataclass(frozen=True)
class Command:
    """A command beside the stages.

    Attributes:
        home: Module in this package and function, which takes the arguments and returns a status.
        summary: What it does, with an example.
    """

    home: str
    summary: str


RUNNING = {
    "all": Command(
        "whole.everything",
        "every stage above but those on demand (suites, sample, reach, ...): robots=[...]",
    ),
    "paper": Command(
        "whole.paper",
        "all of the paper, unattended: what it will take first; goes on where it was stopped",
    ),
    "reproduce": Command(
        "reproduce.reproduce",
        "every stale stage of dvc.yaml, several at a time, as `make reproduce` does",
    ),
    "benchmark": Command(
        "benchmark.benchmark",
        "evaluate the numerical solvers on all robots, unattended: benchmark profile=paper",
    ),
    "suites": Command(
        "suites.suites_of",
        "evaluate solvers on all suites of hard poses and print the tables: suites robot=panda",
    ),
    "protocols": Command(
        "protocols.protocols_of",
        "the same solvers as six groups measure them, six rankings: protocols robot=panda",
    ),
    "zoo": Command(
        "zoo.zoo", "many arms of others, a network each, unattended: where a neural seed pays"
    ),
    "demo": Command(
        "demo.demo", "three minutes: one robot solves, plans and grasps; a film and a page"
    ),
    "instructions": Command(
        "instructions.instructions",
        "120 instructions to an agent, plan success by family: instructions agent=policy",
    ),
    "warm": Command("warm.warm", "compile the kernels before somebody waits for them"),
    "chat": Command(
        "chat.chat", "talk to a robot at its table, by text or by speech: chat robot=nicol"
    ),
    "view": Command(
        "view.view", "drag a target in the browser, several solvers answer: view robot=nicol"
    ),
    "watch": Command(
        "watch.watch", "a grasp trial in the browser: watch robot=nicol trial=17 film=out.mp4"
    ),
}
LOOKING = {
    "robots": Command("look.robots", "the robots, their joints and limits"),
    "robot": Command(
        "look.robot", "robot add FILE: bring one of your own; robot picture NAME: draw one anew"
    ),
    "solvers": Command("look.solvers", "the inverse-kinematics solvers and what each needs"),
    "compare": Command(
        "compare.compare",
        "what two results folders changed, in configuration and figures: compare A B",
    ),
    "judge": Command(
        "judge.judge_file",
        "score answers that another solver gave to a suite: judge FILE suite=warm robot=panda",
    ),
    "leaderboard": Command(
        "leaderboard.leaderboard",
        "judge files of answers to suites and write their lines: leaderboard add FILE",
    ),
    "site": Command(
        "site.site",
        "report, paper, studies and leaderboard as pages that open from disk: site profile=quick",
    ),
    "doctor": Command("look.doctor", "versions, threads, accelerator, and what is missing"),
    "paths": Command("look.paths", "where the tables, figures and the report are"),
    "table": Command(
        "table.table", "Table II or III of the paper from the raw rows, in seconds: table table2"
    ),
    "export": Command(
        "export.export",
        "take a network or solver away as one file: export robot=panda to=onnx|torchscript|c",
    ),
    "export-weights": Command(
        "export_weights.export_weights",
        "put trained weights beside the robot's description: export-weights robot=panda",
    ),
    "claims": Command(
        "claims.claims",
        "every published number beside ours, and every claim of the paper with a verdict",
    ),
    "deviations": Command(
        "deviations.deviations",
        "write docs/deviations.md: where paper, released code and this project differ",
    ),
    "dvc": Command(
        "dvc.dvc",
        "write dvc.yaml from the graph of stages; dvc profile=smoke sets that scale as well",
    ),
    "code": Command("dvc.code", "write down what code each step depends on: DVC runs it first"),
    "readme": Command(
        "readme.readme",
        "renew figures and tables of README.md and docs/results.md: readme --figure",
    ),
}
COMMANDS = RUNNING | LOOKING
# Commands by their old names, for one release.
ALIASES = {"contest": "compare-tuned", "ship": "export-weights", "where": "paths"}


def run_command(name: str, arguments: list[str]) -> int:
    """Run a stage or a command and return its status.

    Raises:
        PipelineError: There is no command of that name, or it refuses its arguments.
    """
    name = ALIASES.get(name, name)
    if name in STAGES:
        from pipeline.commands.stage import stage

        return stage(name, arguments)
    if name not in COMMANDS:
        from robots.suggestions import unknown_name

        raise PipelineError(unknown_name("command", name, [*STAGES, *COMMANDS]))
    module, _, function = COMMANDS[name].home.partition(".")
    command = getattr(import_module(f"pipeline.commands.{module}"), function)
    return int(command(arguments))


def listing() -> str:
    """Return the list of all stages and commands with what they do."""
    running = {name: stage.summary for name, stage in STAGES.items()}
    running |= {name: command.summary for name, command in RUNNING.items()}
    looking = {name: command.summary for name, command in LOOKING.items()}
    return "\n".join(
        [
            "Stages, in the order they build on each other, and commands that run them:",
            *_lines(running),
            "",
            "Looking around:",
            *_lines(looking),
        ]
    )


def _lines(summaries: dict[str, str]) -> list[str]:
    return [f"  {name:<14}  {summary}" for name, summary in summaries.items()]
