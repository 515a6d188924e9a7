"""`watch`: a grasp trial in the browser, simulated again from its number."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from pipeline.commands.arguments import command_parser
from pipeline.commands.view import with_group
from pipeline.config import compose
from pipeline.embodiment.loading import is_embodied, setting_name
from pipeline.grasping.trial import required_scene
from pipeline.settings import Config
from pipeline.stages.graph import STAGES
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.stages.running import with_weights
from pipeline.viewing.errors import ViewError
from pipeline.viewing.trial_rows import conditions_of, trial_row

DESCRIPTION = """\
watch robot=nicol trial=17 [rows=FILE] [film=out.mp4] [port=8080] [open=false] [key=value ...]

Simulates a grasp trial once more and shows it in the browser; a trial is a function of its number,
the seed and the keys of `grasp`, so take those of the run. rows=FILE (CSV or Parquet) takes solver,
seed, friction, tension, physics, perception and agent of the trial's row. Keys of conf/view may
stand without `view.`; Ctrl-C ends.
"""


def watch(arguments: list[str]) -> int:
    """Show one trial until Ctrl-C."""
    overrides = command_parser("watch", DESCRIPTION).takes_overrides().parse(arguments).overrides
    overrides = with_group(overrides)
    config = compose(overrides)
    row: Mapping[str, Any] | None = None
    if config.view.rows is not None:
        row = trial_row(Path(config.view.rows), config.robot.name, config.view.trial)
        typed = {each.partition("=")[0] for each in overrides}
        taken = [f"{k}={v}" for k, v in conditions_of(row).items() if k not in typed]
        print(f"of the row: {' '.join(taken)}", flush=True)
        config = compose([*overrides, *taken])
    config = _quiet(config)
    row = row or _own_row(config)
    from pipeline.stages import grasp

    grasp.check(config)
    config = with_weights(config, STAGES["grasp"].solver_names(config))
    _show(config, row)
    return 0


def _show(config: Config, row: Mapping[str, Any] | None) -> None:
    from pipeline.stages.grasp_units import load_runner
    from pipeline.viewing.replay import Replay
    from pipeline.viewing.trial import run_again

    runner, number = load_runner(config), config.view.trial
    camera = required_scene(config.grasp, config.robot.name).camera
    page = Replay(robot_of(config), config.view, f"trial {number}", camera)
    try:
        page.announce()
        film = Path(config.view.film) if config.view.film else None
        recording, again = run_again(runner, number, config.view.rate, film, page.show)
        outcome = f"{again['object']}: {again['class']}, {again['reason']}"
        if row is not None:
            same = (row["class"], row["reason"]) == (again["class"], again["reason"])
            outcome += (
                " (as in the row)" if same else f" (the row: {row['class']}, {row['reason']})"
            )
        print(outcome, flush=True)
        if film is not None:
            print(film, flush=True)
        page.play(recording, outcome)
        page.run()
    finally:
        page.close()


def _quiet(config: Config) -> Config:
    """The run without windows, films and studies of its own."""
    return replace(config, grasp=replace(config.grasp, gui=False, video="none", ablation=None))


def _own_row(config: Config) -> Mapping[str, Any] | None:
    """The row of the trial in the run's folder; None where it has none, as of later trials."""
    folders, robot = artifacts(config), config.robot.name
    folder = folders.grasp(robot)
    if is_embodied(config):
        folder = folders.grasp_agent(robot, setting_name(config))
    path = folders.find(folder.relative_to(folders.root) / "trials.parquet")
    if path is None:
        return None
    with suppress(ViewError):
        return trial_row(path, robot, config.view.trial)
    return None
