"""`benchmark`: the numerical field on the test poses of all robots, unattended and resumable."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pipeline.commands.arguments import command_parser, count, names_in
from pipeline.commands.run import chosen_profile
from pipeline.config import bench_lists, compose
from pipeline.engine.config import LOCAL, EngineConfig
from pipeline.engine.cores import usable_cores
from pipeline.engine.running import one_machine, workers_of
from pipeline.errors import PipelineError
from pipeline.evaluation.side_by_side import EvaluationJob, jobs_in_turns, run_jobs
from pipeline.solvers import check_solvers
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.stages.running import make_dataset

LISTS = ("robots", "numerical", "unpinned")
DESCRIPTION = """\
benchmark [robots=[panda,nico]] [numerical=[lm,placo]] [unpinned=[trac_ik]] [processes=2]
          [engine=slurm] [profile=paper] [key=value ...]

Evaluates every solver of `numerical` on every robot, `processes` at a time, each pinned to a core
of its own and robot by robot in turns, then those of `unpinned` alone on all cores. What is left
out comes from conf/bench.yaml or the profile's own file beside it; `processes` is `engine.workers`
in short, and on another engine than local that key counts. Tables of the same key are kept: killed
and called again it continues. Datasets that are missing are made first.
"""


def benchmark(arguments: list[str]) -> int:
    """Run the field; status 1 if an evaluation failed."""
    options = command_parser("benchmark", DESCRIPTION).takes_overrides().parse(arguments)
    lists, overrides = _lists(options.overrides)
    engine = _engine(lists, overrides)
    robots, solvers, unpinned = (lists[name] for name in LISTS)
    for robot in robots:  # a typo or a missing package stops before the first hour, not after it
        config = compose([*overrides, f"robot={robot}"])
        check_solvers({"numerical": solvers, "unpinned": unpinned}, robot_of(config))
        make_dataset(config)
    jobs = jobs_in_turns(robots, solvers, unpinned)
    root = artifacts(compose(overrides)).root

    alone = [item for item in overrides if not item.startswith(("engine=", "engine."))]

    def command(job: EvaluationJob, beside: int) -> list[str]:
        return [
            "evaluate",
            *alone,
            f"robot={job.robot}",
            f"evaluate.solvers=[{job.solver}]",
            f"evaluate.pinned={str(job.pinned).lower()}",
            f"evaluate.side_by_side={beside}",
            "evaluate.keep=true",
        ]

    failed = run_jobs(jobs, command, engine, root / "checkpoint")
    print(root / "evaluate")
    if failed:
        print(f"{len(failed)} of {len(jobs)} failed: {', '.join(str(job) for job in failed)}")
    return int(bool(failed))


def _engine(lists: dict[str, Any], overrides: list[str]) -> EngineConfig:
    """The engine of the run; `processes` says how many jobs a single machine takes."""
    engine = compose(overrides).engine
    if lists["given"] or (engine.name == LOCAL and engine.workers == 1):
        engine = replace(engine, workers=int(lists["processes"]))
    workers = workers_of(engine)
    return replace(engine, workers=min(workers, usable_cores()) if one_machine(engine) else workers)


def _lists(arguments: list[str]) -> tuple[dict[str, Any], list[str]]:
    """Split the command's own keys, bench.yaml filling the gaps, from overrides of the stage."""
    bench = bench_lists(chosen_profile(arguments))
    own = {name: bench[name] for name in (*LISTS, "processes")} | {"given": False}
    overrides = []
    for argument in arguments:
        key, _, value = argument.partition("=")
        if key in LISTS:
            own[key] = names_in(value)
        elif key == "processes":
            own |= {key: count(key, value), "given": True}
        elif key in ("robot", "evaluate.solvers"):
            raise PipelineError(f"benchmark takes robots=[...] and numerical=[...], got {argument}")
        else:
            overrides.append(argument)
    return own, overrides
