"""`paper`: all of the paper, unattended and resumable, two tasks that hold one core each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipeline.commands.arguments import command_parser
from pipeline.commands.run import chosen_profile, split_lists, step_overrides
from pipeline.config import bench_lists, compose
from pipeline.engine.unattended import CoreTask, run_on_cores
from pipeline.errors import PipelineError
from pipeline.progress import LOGGER
from pipeline.stages.forecast import RATES, rates
from pipeline.stages.graph import NETWORKS
from pipeline.stages.whole_run import (
    DONE,
    LEFT,
    TO_DO,
    Unit,
    left_out,
    units,
    write_left_out,
)

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
    processes = int(_number("processes", own["processes"] or str(bench["processes"])))
    lists, overrides = split_lists(typed)
    folder = Path(compose(overrides).results_dir)
    networks = {NETWORKS: bench[NETWORKS]}
    every = units(
        lists, lambda step, axes: step_overrides(step, axes | networks, overrides), compose
    )
    reasons = left_out(every, most)
    print(plan_text(every, reasons, processes), flush=True)
    if own["plan"] == "true":
        return 0
    write_left_out(folder, every, reasons)
    return _run(every, reasons, processes, folder)


def _run(every: Sequence[Unit], reasons: dict[str, str], processes: int, folder: Path) -> int:
    wanted = [unit for unit in every if not unit.is_done and unit.name not in reasons]
    by_name = {unit.name: unit for unit in wanted}
    tasks = [_task(unit, {*by_name}, processes) for unit in wanted if unit.step.name != "report"]
    count = 0

    def ended(task: CoreTask, status: int, seconds: float) -> None:
        nonlocal count
        count += 1
        how = "failed" if status else "done"
        LOGGER.info("%d of %d: %s %s in %.0f s", count, len(tasks), task.name, how, seconds)
        if not status:
            by_name[task.name].sign(seconds)

    logs = folder / "logs"
    failed = run_on_cores(tasks, processes, logs, ended)
    reports = [unit for unit in every if unit.step.name == "report"]
    failed |= run_on_cores([_task(unit, set(), 1) for unit in reports], 1, logs, lambda *_: None)
    print(folder / "report.html")
    for name, why in failed.items():
        print(f"{name}: {why} (see {logs / name}.log)")
    return int(bool(failed))


def _task(unit: Unit, wanted: set[str], processes: int) -> CoreTask:
    beside = [f"evaluate.side_by_side={processes}"] if unit.step.stage == "evaluate" else []
    needs = tuple(name for name in unit.needs if name in wanted)
    return CoreTask(unit.name, (unit.step.stage, *unit.overrides, *beside), needs)


def plan_text(every: Sequence[Unit], reasons: dict[str, str], processes: int) -> str:
    """Return what will be done, by step, with hours and where their rates were measured.

    Args:
        every: All units.
        reasons: Why some are left out, by name.
        processes: Tasks at a time.
    """
    lines = [f"{'step':<20} {'tasks':>5} {DONE:>5} {LEFT:>9} {'core hours ' + TO_DO:>17}"]
    total = 0.0
    for name in dict.fromkeys(unit.step.name for unit in every):
        mine = [unit for unit in every if unit.step.name == name]
        done = sum(unit.is_done for unit in mine)
        left = sum(unit.name in reasons for unit in mine)
        hours = sum(u.hours for u in mine if not u.is_done and u.name not in reasons)
        total += hours
        lines.append(f"{name:<20} {len(mine):>5} {done:>5} {left:>9} {hours:>17.2f}")
    machines = ", ".join(dict.fromkeys(rates().machine))
    lines.append(
        f"about {total / processes:.1f} hours, {processes} tasks at a time, each on a core"
    )
    lines += [f"left out: {name} {why}" for name, why in reasons.items()]
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
