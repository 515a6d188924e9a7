"""Stage reach: a map of where a robot reaches how many orientations, and its figure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.containers import to_dict
from pipeline.data.files import write_sealed_json
from pipeline.data.tables import write_table
from pipeline.evaluation.cache import ChunkCache, clear_chunks, solver_identity
from pipeline.progress import bar
from pipeline.reachability.figures import write_map
from pipeline.reachability.voxels import COLUMNS, grid, reach_map
from pipeline.solvers import check_solvers
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.stages.solvers import code_of, solver_of

if TYPE_CHECKING:
    from pipeline.settings import Config


def check(config: Config) -> None:
    """Refuse a run whose solver cannot run, before anything is made."""
    check_solvers(config.reach.solvers_by_key(), robot_of(config))


def run(config: Config) -> list[Path]:
    """Write the map as Parquet, its card and its figure; a killed run continues."""
    robot = robot_of(config)
    solver = solver_of(config.reach.solver, robot, config)
    folder = artifacts(config).reach(robot.name)
    cache = artifacts(config).root / "checkpoint" / f"reach-{robot.name}"
    facts = {
        "robot": robot.name,
        "urdf_checksum": robot.urdf_checksum,
        "base": robot.base,
        "tip": robot.tip,
        "solver_identity": solver_identity(solver),
        "code": code_of(__name__, {"solver": [config.reach.solver]}, config),
        "reach": to_dict(config.reach),
    }
    with exclusive(folder):
        places = grid(robot, config.reach.spacing_m)
        with bar(len(places), "place", f"reach {robot.name}") as shown:
            chunks = ChunkCache(cache, facts)
            rows = reach_map(robot, solver, places, config.reach, chunks, shown.update)
        made = provenance.signature(config.profile)
        card = provenance.card("reach", config=config, columns=COLUMNS, **facts, **made)
        table = folder / "map.parquet"
        write_table(table, rows, card)
        write_sealed_json(folder / "card.json", card)
        figures = write_map(robot, rows, folder, config.report.dpi)
        clear_chunks(cache)
    return [table, folder / "card.json", *figures]
