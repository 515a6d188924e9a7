"""`paper`: all of the paper, unattended and resumable, two tasks that hold one core each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipeline.commands.arguments import command_parser, count
from pipeline.commands.run import chosen_profile, split_lists, step_overrides
from pipeline.config import bench_lists, compose
from pipeline.engine.scheduler import Scheduler
from pipeline.errors import PipelineError
from pipeline.stages.forecast import RATES, rates
from pipeline.stages.graph import NETWORKS
from pipeline.stages.whole_run import REPORT, Unit, UnitTasks, left_out, units, write_left_out

DESCRIPTION = """\
paper [hours=24] [processes=2] [robots=[nico]] [key=value ...]

Runs every step of the graph with profile=paper (unless another is named), `processes` tasks at a
time, each on a core of its own, and makes the report. First it prints what each step is expected to
take, by the rates in results/rates.csv. A task that would take more than `hours` of one core is
left out and stands in the table of what was not run. Killed and called again it goes on; what an
edit has made stale is made again. plan=true prints the steps and runs nothing.
"""
OWN = {"hours": "24", "processes": "", "plan": "false"}


def paper(arguments: list[str]) -> int:
    """Run what is not done; status 1 if a task failed."""
    given = command_parser("paper", DESCRIPTION).takes_overrides().parse(arguments).overrides
    own, typed = _own(given)
    if not any(item.startswith("profile=") for item in typed):
        typed = ["profile=paper", *typed]
    most = _number("hours", own["hours"])  # what cannot be is refused before anything is composed
    bench = bench_lists(chosen_profile(typed))
    processes = count("processes", own["processes"] or str(bench["processes"]))
    lists, overrides = split_lists(typed)
    folder = Path(compose(overrides).results_dir)
    networks = {NETWORKS: bench[NETWORKS]}
    every = units(
        lists, lambda step, axes: step_overrides(step, axes | networks, overrides), compose
    )
    reasons = left_out(every, most)
    scheduler = Scheduler(UnitTasks(every, processes), folder, processes)
    able = [unit.name for unit in every if unit.name not in reasons and unit.name != REPORT]
    stale = scheduler.stale(able)
    print(plan_text(every, stale, reasons, scheduler), flush=True)
    if own["plan"] == "true":
        return 0
    write_left_out(folder, every, reasons)
    scheduler.run(stale)
    scheduler.run([REPORT])  # of what there is, whether or not all of that succeeded
    print(folder / "report.html")
    scheduler.report()
    return int(bool(scheduler.failed))


def plan_text(
    every: Sequence[Unit], stale: set[str], reasons: dict[str, str], scheduler: Scheduler
) -> str:
    """Return what will be done and where its rates were measured.

    Args:
        every: All units.
        stale: Names of those that will run, besides the report.
        reasons: Why some are left out, by name.
        scheduler: Of the units.
    """
    plan = scheduler.plan([unit.name for unit in every], {*stale, REPORT}, reasons)
    machines = ", ".join(dict.fromkeys(rates().machine))
    lines = [plan, *(f"left out: {name} {why}" for name, why in reasons.items())]
    return "\n".join([*lines, f"rates of results/{RATES}: {machines}"])


def _own(given: Sequence[str]) -> tuple[dict[str, str], list[str]]:
    """Split the command's own keys from overrides."""
    own, rest = dict(OWN), []
    for item in given:
        key, _, value = item.partition("=")
        if key in own:
            own[key] = value
        elif key == "robot":
            raise PipelineError(f"paper takes robots=[...], got {item}")
        else:
            rest.append(item)
    return own, rest


def _number(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if value <= 0:
        raise PipelineError(f"{name} must be a number greater than 0, got {text!r}")
    return value
