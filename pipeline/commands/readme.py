"""`readme`: figures and tables of README.md and docs/results.md; no number there is typed."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from pipeline.commands.arguments import command_parser
from pipeline.commands.overview import draw, in_words, lines_of
from pipeline.config import bench_lists
from pipeline.data.files import replacing, write_text
from pipeline.errors import MissingArtifactError
from pipeline.locations import need_checkout

PICTURES = {
    "grasp.gif": "grasp/{robot}/trial*_success.gif",
}
FIGURE = "error_time.png"
TABLE = "tables/table2_numerical_comparison.md"
COLUMNS = (
    "Robot",
    "Solver",
    "pos. [mm] ours",
    "pos. [mm] paper",
    "rot. [deg] ours",
    "rot. [deg] paper",
    "success [%] ours",
    "success [%] paper",
    "time [ms] ours",
    "time [ms] paper",
)
SOLVERS = ("CycleIK", "CycleIK refined", "LM, compiled")  # the others stand in the report


def readme(arguments: list[str]) -> int:
    """Copy pictures to results/readme/ and renew figures and tables between their marks."""
    parser = command_parser(
        "readme", "Renew README.md and docs/results.md from the run of the default profile."
    )
    parser.add_argument("robot", nargs="?", metavar="ROBOT", help="whose grasp is shown")
    parser.add_argument(
        "--figure",
        action="store_true",
        help="only error against time and its table in README.md, from results/leaderboard",
    )
    options = parser.parse(arguments)
    bench = bench_lists()
    root = need_checkout("README.md")
    if options.figure:
        lines = lines_of(root / "results")
        draw(lines, root / "results" / "readme" / FIGURE)
        renew_block(root / "README.md", "overview", in_words(lines))
        return 0
    folder = root / "results" / bench["profile"]
    robot = options.robot or bench["grasp_robots"][0]
    for name, pattern in PICTURES.items():
        source = _first(folder, pattern.format(robot=robot))
        with replacing(root / "results" / "readme" / name) as partial:
            shutil.copyfile(source, partial)
    table = _first(folder, TABLE).read_text(encoding="utf-8")
    renew_block(root / "docs" / "results.md", "table", "\n".join(_narrow(table)))
    return 0


def renew_block(path: Path, name: str, content: str) -> None:
    """Put text between the marks ``<!-- name: COMMAND -->`` and ``<!-- end of name -->``."""
    block = re.compile(rf"(<!-- {name}: [^>]*-->\n).*?(<!-- end of {name} -->)", re.DOTALL)
    text = path.read_text(encoding="utf-8")
    write_text(path, block.sub(lambda match: f"{match[1]}{content}\n{match[2]}", text))
    print(path)


def _narrow(table: str) -> list[str]:
    """Keep the columns and solvers of the first screen that this run has numbers for."""
    lines = [line.strip("|").split("|") for line in table.splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in line] for line in lines]
    kept = [cells[0].index(name) for name in COLUMNS]
    solver = cells[0].index("Solver")
    network = cells[0].index("Network") if "Network" in cells[0] else None
    wanted = [row for row in cells[2:] if row[solver] in SOLVERS and row[kept[2]] != "–"]
    for row in wanted:
        if network is not None and row[network] != "–":
            row[solver] += f", {row[network].rpartition(' (')[0]}"  # without its recipe
    rows = [[row[index] for index in kept] for row in (*cells[:2], *wanted)]
    return [f"| {' | '.join(row)} |" for row in rows]


def _first(folder: Path, pattern: str) -> Path:
    found = sorted(folder.glob(pattern))
    if not found:
        raise MissingArtifactError(f"there is no {folder / pattern}; run `make reproduce` first")
    return found[0]
