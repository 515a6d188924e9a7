"""`all` and `paper`: every step of the graph, unattended and resumable, several tasks at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pipeline.commands.arguments import (
    command_parser,
    count,
    flag,
    split_keys,
    with_defaults,
)
from pipeline.commands.run import chosen_profile, split_lists, step_overrides
from pipeline.config import bench_lists, compose
from pipeline.engine.scheduler import LOGS, Scheduler
from pipeline.errors import PipelineError
from pipeline.locations import RATES_FILE
from pipeline.progress import log_file
from pipeline.stages.forecast import rates
from pipeline.stages.graph import NETWORKS
from pipeline.stages.whole_run import REPORT, Unit, UnitTasks, left_out, units, write_left_out

WHAT_IT_DOES = """
`processes` tasks at a time, each on cores of its own, and makes the report. First it prints what
each step is expected to take, by the rates in results/rates.csv, then it shows one bar; what tasks
say goes to the logs below the results folder. A task that would take more than `hours` of one core
is left out and stands in the table of what was not run. Killed and called again it goes on; what
an edit has made stale is made again. plan=true prints the steps and runs nothing.
"""
ALL = f"""\
all [robots=[panda,nico]] [profile=smoke] [processes=2] [hours=24] [plan=true] [key=value ...]

Runs what `make reproduce` runs, without DVC: every step of the graph for each robot,
{WHAT_IT_DOES.strip()}

Lists such as robots and numerical are those of conf/bench.yaml if left out, or of the profile's
own file beside it.
"""
PAPER = f"""\
paper [hours=24] [processes=2] [robots=[nico]] [plan=true] [key=value ...]

Runs every step of the graph with profile=paper (unless another is named),
{WHAT_IT_DOES.strip()}
"""
OWN = {"hours": "24", "processes": "", "plan": "false"}  # keys of the command, and their defaults


def everything(arguments: list[str]) -> int:
    """Run what is not done at any scale; status 1 if a task failed."""
    return _whole("all", ALL, arguments, {})


def paper(arguments: list[str]) -> int:
    """Run what is not done at the paper's scale; status 1 if a task failed."""
    return _whole("paper", PAPER, arguments, {"profile": "paper"})


def _whole(name: str, description: str, arguments: list[str], defaults: Mapping[str, str]) -> int:
    given = command_parser(name, description).takes_overrides().parse(arguments).overrides
    typed_own, rest = split_keys(given, OWN)
    own, typed = {**OWN, **typed_own}, with_defaults(rest, defaults)
    for item in typed:
        if item.startswith("robot="):
            raise PipelineError(f"{name} takes robots=[...], got {item}")
    # What cannot be is refused before anything is composed.
    most, plan_alone = _hours(own["hours"]), flag("plan", own["plan"])
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
    if plan_alone:
        return 0
    write_left_out(folder, every, reasons)
    with log_file(folder / LOGS / f"{name}.log"):
        scheduler.run(stale)
        scheduler.run([REPORT])  # of what there is, whether or not all of that succeeded
        scheduler.report()
    print(folder / "report.html")
    return int(bool(scheduler.failed))


def plan_text(
    every: Sequence[Unit], stale: set[str], reasons: Mapping[str, str], scheduler: Scheduler
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
    return "\n".join([*lines, f"rates of results/{RATES_FILE}: {machines}"])


def _hours(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not value > 0:  # nor is nan
        raise PipelineError(f"hours must be a number greater than 0, got {text!r}")
    return value
