"""`view`: drag a target in the browser and see what several solvers answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

from baselines import Solver, SolverError
from baselines.registry import file_settings, using
from pipeline.commands.arguments import command_parser
from pipeline.config import compose
from pipeline.data.tables import read_table
from pipeline.learning.card import WeightsError
from pipeline.loading import load_solver
from pipeline.planning.benchmark import Pair, random_pairs
from pipeline.seeding import derive_seed
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.viewing.config import ViewConfig
from robots import Robot

DESCRIPTION = """\
view robot=nicol [solver=cycleik_refined] [solvers=[lm,cycleik]] [port=8080] [open=false]

Opens a page in the browser: drag the target, slide the joints, play the null space of a redundant
arm and planned motions. `solver` is the robot that is drawn solid, the other solvers are ghosts in
the colours of the figures. Keys of conf/view may stand without `view.`; Ctrl-C ends.
"""
KEYS = tuple(field.name for field in fields(ViewConfig))


def view(arguments: list[str]) -> int:
    """Serve a session until Ctrl-C."""
    overrides = command_parser("view", DESCRIPTION).takes_overrides().parse(arguments).overrides
    config = compose(with_group(overrides))
    robot = robot_of(config)
    solvers = ready_solvers(config, robot)
    from pipeline.viewing.comparison import Comparison
    from pipeline.viewing.page import Page
    from pipeline.viewing.session import Session

    comparison = Comparison(robot, solvers, config.view.timed_calls)
    main = next(iter(solvers))
    session = Session(comparison, main, config.plan, config.view.self_motion)
    pairs, workspace_filter = planned_pairs(config, robot), config.robot.workspace_filter
    page = Page(session, config.view, pairs, workspace_filter)
    try:
        page.run()
    finally:
        page.close()
    return 0


def with_group(arguments: Sequence[str]) -> list[str]:
    """The overrides, keys of the group `view` with its name where that was left out."""
    return [
        f"view.{each}" if each.partition("=")[0] in KEYS and "=" in each else each
        for each in arguments
    ]


def ready_solvers(config: Config, robot: Robot) -> dict[str, Solver]:
    """Load the solvers of the view, the one to be drawn solid first; say which cannot run.

    Raises:
        UnknownSolverError: There is no solver of a name.
        SolverError: None can run.
        WeightsError: Likewise, for want of a network.
    """
    wanted = dict.fromkeys([config.view.solver, *config.view.solvers])
    found: dict[str, Solver] = {}
    problem: SolverError | WeightsError | None = None
    for name in wanted:
        file_settings(name)  # a name that no solver has is no reason to go on without it
        try:
            with using(config.solver):
                found[name] = load_solver(name, robot, profile=config.profile)
        except (SolverError, WeightsError) as error:
            problem = error
            print(f"left out: {error}", flush=True)
    if not found:
        assert problem is not None
        raise problem
    return found


def planned_pairs(config: Config, robot: Robot) -> list[Pair]:
    """Starts and targets of the planner benchmark of this run: as many as its rows have, if any."""
    folders = artifacts(config)
    rows = folders.find(folders.plan(robot.name).relative_to(folders.root) / "plans.parquet")
    count = config.plan.pairs if rows is None else int(read_table(rows)["pair"].max()) + 1
    return random_pairs(robot, count, derive_seed(config.seed, "plan", robot.name))
