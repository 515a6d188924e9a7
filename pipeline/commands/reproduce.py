"""`reproduce`: what `dvc repro` does, several tasks at a time, with what it will take and took."""

from __future__ import annotations

from pipeline.commands.arguments import command_parser, count
from pipeline.config import bench_lists
from pipeline.engine.scheduler import LOGS, Scheduler
from pipeline.errors import PipelineError
from pipeline.locations import need_checkout
from pipeline.progress import LOGGER, log_file
from pipeline.stages.dvc_file import CODE
from pipeline.stages.dvc_tasks import DvcTasks

FAILED = 2
DESCRIPTION = """\
reproduce [processes=2]

Brings every stage of dvc.yaml up to date as `dvc repro` does, as many tasks at a time as
`processes` of conf/bench.yaml says, each on cores of its own. Says at the start what that will
take, shows one bar, and says at the end what each stage took. What a failed task does not concern
goes on. Below the results folder, in logs/, each task has its log, and reproduce.log lists them.
"""


def reproduce(arguments: list[str]) -> int:
    """Bring all stages up to date; status 2 where a task fails."""
    given = command_parser("reproduce", DESCRIPTION).takes_overrides().parse(arguments).overrides
    bench = bench_lists()
    processes = int(bench["processes"])
    for argument in given:
        key, _, value = argument.partition("=")
        if key != "processes":
            raise PipelineError(f"reproduce takes processes=N, got {argument}")
        processes = count(key, value)
    folder = need_checkout("reproduce")
    results = folder / "results" / str(bench["profile"])
    log = log_file(results / LOGS / "reproduce.log")
    with log, DvcTasks(folder, results) as tasks:
        scheduler = Scheduler(tasks, results, processes, cores=0)
        scheduler.run([CODE])  # says what code the others depend on
        if not scheduler.failed:
            others = [name for name in tasks.needs if name != CODE]
            stale = scheduler.stale(others)
            LOGGER.info("%s", scheduler.plan(others, stale))
            scheduler.run(stale)
        scheduler.report()
    return FAILED if scheduler.failed else 0
