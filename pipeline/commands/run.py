"""Stages from the command line: one run, a sweep of runs, or all stages for several robots."""

from __future__ import annotations

import re
from pathlib import Path

from omegaconf import OmegaConf

from pipeline.config import CONF_DIR, bench_lists, compose, group_choices, sweep, to_yaml
from pipeline.data.files import write_text
from pipeline.errors import ConfigError, PipelineError, choices
from pipeline.progress import LOGGER
from pipeline.settings import Config
from pipeline.stages import PER_ROBOT, STAGES, run_stage, stage_module

SWEEP_FLAGS = ("-m", "--multirun")
HELP_FLAGS = ("-h", "--help")
SEEING = ("perception=camera", "agent=policy")  # the trials of robots that have eyes


def stage(name: str, arguments: list[str]) -> int:
    """Run one stage, or with ``-m`` one run for each combination of the values given."""
    if any(flag in arguments for flag in HELP_FLAGS):
        return _help(name)
    overrides = [argument for argument in arguments if argument not in SWEEP_FLAGS]
    _refuse_flags(overrides)
    if len(overrides) == len(arguments):
        _run(name, compose(overrides))
        return 0
    runs = sweep(overrides)
    profiles = {item for run in runs for item in run if item.startswith("profile=")}
    configs = [compose(run) for run in runs]  # a typo in the last run stops before the first
    for number, (run, config) in enumerate(zip(runs, configs, strict=True), start=1):
        folder = Path(config.results_dir) / "sweep" / run_name(run, with_profile=len(profiles) > 1)
        LOGGER.info("run %d of %d: %s", number, len(runs), " ".join(run))
        config.results_dir = str(folder)
        write_text(_absolute(folder) / "config.yaml", to_yaml(config))
        _run(name, config)
    return 0


def everything(arguments: list[str]) -> int:
    """Run all stages for every robot of ``robots=[...]`` (conf/bench.yaml where left out)."""
    if any(flag in arguments for flag in HELP_FLAGS):
        print("python -m pipeline all [robots=[panda,nico]] [profile=smoke] [key=value ...]")
        return 0
    _refuse_flags(arguments)
    bench = bench_lists()
    kinds = ("robots", "tune_robots", "detector_robots", "grasp_robots")
    lists = {key: bench[key] for key in kinds}
    chosen = [argument for argument in arguments if argument.startswith("robots=")]
    overrides = [argument for argument in arguments if not argument.startswith("robots=")]
    if chosen:
        lists["robots"] = _robot_list(chosen[-1])
    for robot in lists["robots"]:
        for name in PER_ROBOT:
            if robot in lists.get(f"{name}_robots", [robot]):
                _run(name, compose([*overrides, f"robot={robot}"]))
        if robot in lists["detector_robots"] and robot in lists["grasp_robots"]:
            _run("grasp", compose([*SEEING, *overrides, f"robot={robot}"]))
    _run("report", compose(overrides))
    return 0


def run_name(overrides: list[str], with_profile: bool = False) -> str:
    """Return a folder name that says what was overridden, such as ``robot=nico,seed=1``.

    The results folder is not named, nor is the profile unless it is swept: the name stands below
    both.
    """
    silent = ("results_dir=",) if with_profile else ("results_dir=", "profile=")
    told = [item for item in overrides if not item.startswith(silent)]
    return re.sub(r"[^\w=.,+-]", "_", ",".join(told)) or "default"


def _run(name: str, config: Config) -> None:
    for path in run_stage(name, config):
        print(path)


def _absolute(folder: Path) -> Path:
    from pipeline.provenance import ROOT

    return folder if folder.is_absolute() else ROOT / folder


def _robot_list(argument: str) -> list[str]:
    value = argument.partition("=")[2].strip("[]")
    names = [name.strip() for name in value.split(",") if name.strip()]
    for name in names:
        if name not in group_choices("robot"):
            raise ConfigError(choices("robot", name, group_choices("robot")))
    return names


def _refuse_flags(arguments: list[str]) -> None:
    for argument in arguments:
        if argument.startswith("-"):
            raise PipelineError(f"there is no option {argument}; overrides read key=value")


def _help(name: str) -> int:
    module = stage_module(name)
    print(f"python -m pipeline {name} [key=value ...] [-m]\n\n{module.__doc__}")
    group = name if (CONF_DIR / name).is_dir() else None
    if group:
        print(f"Keys of the group {group} and their values with profile=quick:\n")
        print(OmegaConf.to_yaml(OmegaConf.create({group: getattr(compose(), group)})))
    print(f"Stages: {', '.join(STAGES)}. Robots: {', '.join(group_choices('robot'))}.")
    return 0
