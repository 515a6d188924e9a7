"""Stage plan: Bezier motions between random poses of a robot, by several solvers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.containers import to_dict
from pipeline.data.files import write_sealed_json
from pipeline.data.rows import RowCheckpoint
from pipeline.data.tables import write_table
from pipeline.evaluation.cache import solver_identity
from pipeline.planning.benchmark import (
    KEY,
    benchmark,
    plan_both,
    plan_by_rule,
    prepared,
    random_pairs,
    shown_pair,
    shown_route,
)
from pipeline.planning.figures import write_figures, write_route
from pipeline.progress import bar
from pipeline.seeding import derive_seed
from pipeline.solvers import check_solvers, network_of
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.stages.solvers import code_of, solver_of

if TYPE_CHECKING:
    from pipeline.settings import Config


def check(config: Config) -> None:
    """Refuse a run whose solvers cannot run, before anything is made."""
    check_solvers(config.plan.solvers_by_key(), robot_of(config))


def run(config: Config) -> list[Path]:
    """Write the raw rows of the planner benchmark and figures of one motion."""
    robot = robot_of(config)
    folders = artifacts(config)
    folder = folders.plan(robot.name)
    solvers = {
        name: prepared(solver_of(name, robot, config), config.plan) for name in config.plan.solvers
    }
    repair = solver_of(config.plan.repair, robot, config) if config.plan.repair else None
    seed = derive_seed(config.seed, "plan", robot.name)
    everyone = {**solvers, "repair": repair}
    who = {name: solver_identity(each) for name, each in everyone.items() if each is not None}
    code = code_of(__name__, config.plan.solvers_by_key(), config)
    made_with = [to_dict(config.plan), seed, robot.urdf_checksum, who, provenance.made_by(), code]
    path = folders.root / "checkpoint" / f"plan-{robot.name}-{provenance.digest(made_with)}.jsonl"
    total = len(solvers) * config.plan.pairs
    with exclusive(folder), bar(total, "plan", f"plan {robot.name}") as shown:
        kept = RowCheckpoint(path, KEY)
        rows = benchmark(robot, solvers, config.plan, seed, kept, repair, shown.update)
        pairs = random_pairs(robot, config.plan.pairs, seed)
        pair = shown_pair(robot, pairs, config.plan.figure)
        motions = {
            name: plan_by_rule(robot, solver, pair, config.plan.figure, repair)
            for name, solver in solvers.items()
        }
        write_figures(robot, pair, motions, config.plan, folder)
        if (example := shown_route(rows)) is not None:
            name, number = example
            both = plan_both(robot, solvers[name], pairs[number], config.plan, repair)
            write_route(robot, *both, name, folder)
        card = provenance.card(
            "plan",
            config=config,
            robot=robot.name,
            pairs_seed=seed,
            **provenance.signature(config.profile),
        )
        used = [network_of(each) for each in solvers.values()]
        facts = {"plan": to_dict(config.plan), "network": ", ".join(filter(None, used))}
        write_table(folder / "plans.parquet", rows, {**card, **facts})
        write_sealed_json(folder / "card.json", card)
        kept.clear()
    return [folder]
