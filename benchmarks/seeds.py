"""Where does a start of the descent come from, what does it cost to have, and when does it pay?

    python -m benchmarks.seeds [--robots panda ...] [--poses 5000] [--rounds 5] [--write]

Every source of seeds feeds the same kernel, that of `lm`, on the same poses and one core: home and
random configurations, which cost nothing; the nearest of remembered configurations (`lookup`),
which are drawn; CycleIK's best hypothesis and its four in order, which are trained; and a start ten
degrees from a solution in every joint, as in a control loop. The poses lie where the network was
trained, which for NICOL is a box before it. Times are medians over rounds in turns and include the
seeding. *pays after*: queries after which what was prepared is won back against home, by seconds of
a core; a network's preparation is its training, by results/rates.csv.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from baselines.lm import LevenbergMarquardt
from baselines.lookup import Lookup
from baselines.refine import Refined, refine
from benchmarks.studies import STUDIES, write_study
from pipeline import load_robot, load_solver
from pipeline.learning.refined import RefinedSolver
from pipeline.presentation.naming import robot_title
from pipeline.presentation.style import LOOKS, panels, save, styled
from robots import Robot, available_robots

Array = NDArray[np.float64]

NAME = "seeds"
POSE_SEED, RANDOM_SEED = 31, 32
SIZES = (2_048, 20_000, 200_000)  # of lookups
NEIGHBOURS = 4
HEADS = 4
WARM_DEG = 10.0
NOTHING_S, DPI = 0.01, 150  # where the figure puts what costs nothing; its pixels an inch
SPARE = 20  # times the poses are drawn, of which those in the network's box are taken
RATES = Path(__file__).parents[1] / "results" / "rates.csv"


@dataclass(frozen=True)
class Source:
    """Where seeds come from.

    Attributes:
        name: For people.
        seeds: Poses (N, 7) to configurations (N, K, dof) [rad or m].
        preparation_s: Processor seconds until it can answer.
        memory_mb: What it remembers.
    """

    name: str
    seeds: Callable[[Array], Array]
    preparation_s: float = 0.0
    memory_mb: float = 0.0


def main() -> None:
    """Measure, print and, if asked, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--robots", nargs="+", default=[*available_robots()])
    parser.add_argument("--poses", type=int, default=5000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--write", action="store_true", help="into results/studies")
    options = parser.parse_args()
    torch.set_num_threads(1)
    rows = []
    for name in options.robots:
        rows += measured(load_robot(name), options.poses, options.rounds)
        print(f"{name} done", flush=True)
    table = pd.DataFrame(rows)
    text = "\n".join(["# Where seeds come from, and when they pay", "", *described(table)])
    print(text)
    if options.write:
        which = " ".join(("--robots", *options.robots, "--poses", str(options.poses)))
        command = f"python -m benchmarks.seeds {which} --rounds {options.rounds}"
        seeds = f"of poses {POSE_SEED}, of random starts {RANDOM_SEED}"
        write_study(NAME, table, text, f"{command} --write", seeds)
        with styled():
            save(draw(table), STUDIES, NAME, DPI)


def sources(robot: Robot, joints: Array, refined: RefinedSolver) -> list[Source]:
    """All sources of a robot.

    Args:
        robot: The robot.
        joints: (N, dof) solutions of the poses that are asked for, which warm starts are made from.
        refined: Whose network answers.
    """
    generator = np.random.default_rng(RANDOM_SEED)
    home = np.broadcast_to(robot.home, (len(joints), 1, robot.dof))
    random = generator.uniform(robot.chain.lower, robot.chain.upper, joints.shape)[:, None]
    turns = np.radians(WARM_DEG) * generator.choice([-1.0, 1.0], joints.shape)
    warm = np.clip(joints + turns, robot.chain.lower, robot.chain.upper)[:, None]
    found = [Source("home", lambda poses: home), Source("random", lambda poses: random)]
    found += [lookup(robot, size) for size in SIZES]
    folder = refined.weights or refined.proposer.weights
    assert folder is not None
    seconds = training_s(folder)
    size_mb = sum(p.numel() * p.element_size() for p in refined.proposer.network.parameters()) / 1e6
    for count, name in ((1, "CycleIK, best hypothesis"), (HEADS, "CycleIK, four in order")):

        def heads(poses: Array, count: int = count) -> Array:
            return refined.proposals(poses, count)

        found.append(Source(name, heads, seconds, size_mb))
    found.append(Source(f"warm, {WARM_DEG:g} deg away", lambda poses: warm))
    return found


def lookup(robot: Robot, size: int) -> Source:
    """A lookup, prepared and timed."""
    load_solver("lookup", robot, remembered=1, neighbours=1).tree.query(np.zeros(12))  # imports
    begin = time.process_time()
    solver = load_solver("lookup", robot, remembered=size, neighbours=NEIGHBOURS)
    assert isinstance(solver, Lookup)
    features = solver.tree.data
    seconds = time.process_time() - begin
    kept = solver.joints.nbytes + features.nbytes
    return Source(f"lookup, {size:,}", solver.nearest, seconds, kept / 1e6)


def training_s(folder: Path) -> float:
    """Processor seconds of a training, by the poses that it saw and results/rates.csv."""
    card = json.loads((folder / "card.json").read_text(encoding="utf-8"))
    poses = card["validation"]["best"]["step"] * card["config"]["train"]["batch_size"]
    rates = pd.read_csv(RATES).set_index(["stage", "what"]).core_seconds
    return float(poses * rates["train", card["config"]["model"]["name"]])


def measured(robot: Robot, count: int, rounds: int) -> list[dict[str, object]]:
    """Rows of a robot, a source each."""
    kernel, refined = load_solver("lm", robot), load_solver("cycleik_refined", robot)
    assert isinstance(kernel, LevenbergMarquardt)
    assert isinstance(refined, RefinedSolver)
    joints = robot.sample(SPARE * count, seed=POSE_SEED)
    joints = joints[refined.proposer.in_domain(robot.forward_kinematics(joints))][:count]
    poses = robot.forward_kinematics(joints)
    options = kernel.options(None)
    known = sources(robot, joints, refined)
    count = len(joints)
    outcomes: dict[str, Refined] = {}
    times: dict[str, list[tuple[float, float]]] = {each.name: [] for each in known}
    for turn in range(rounds + 1):
        for each in known:
            begin = time.perf_counter()
            seeds = np.ascontiguousarray(each.seeds(poses))
            seeded = time.perf_counter()
            outcomes[each.name] = refine(robot, poses, seeds, options)
            ended = time.perf_counter()
            if turn:  # the first one compiles and fills caches
                times[each.name].append((seeded - begin, ended - begin))
    rows = []
    home_us = 1e6 * median(whole for _, whole in times["home"]) / count
    for each in known:
        outcome = outcomes[each.name]
        whole_us = 1e6 * median(whole for _, whole in times[each.name]) / count
        gain_us = home_us - whole_us
        rows.append(
            {
                "robot": robot.name,
                "source": each.name,
                "iterations": float(outcome.iterations.mean()),
                "first_start": float((outcome.found & (outcome.starts == 1)).mean()),
                "found": float(outcome.found.mean()),
                "seeding_us": 1e6 * median(seeding for seeding, _ in times[each.name]) / count,
                "time_us": whole_us,
                "memory_mb": each.memory_mb,
                "preparation_s": each.preparation_s,
                "pays_after": 1e6 * each.preparation_s / gain_us if gain_us > 0 else np.inf,
            }
        )
    return rows


def described(table: pd.DataFrame) -> list[str]:
    """The table for people."""
    lines = [
        "One core, batches, times with the seeding. *first start*: share solved by the descent",
        "from the first seed. *pays after*: queries that win the preparation back against home.",
        "",
        "| robot | source | iterations | first start | found | seeding, us | time a pose, us "
        "| memory, MB | preparation, s | pays after |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in table.to_dict("records"):
        pays = row["pays_after"]
        if row["source"] == "home":
            after = "–"
        else:
            after = "never" if np.isinf(pays) else "at once" if pays == 0 else f"{pays:.1e}"
        lines.append(
            f"| {robot_title(row['robot'])} | {row['source']} | {row['iterations']:.2f} "
            f"| {row['first_start']:.1%} | {row['found']:.2%} | {row['seeding_us']:.2f} "
            f"| {row['time_us']:.2f} | {row['memory_mb']:.1f} | {row['preparation_s']:.1f} "
            f"| {after} |"
        )
    return lines


def draw(table: pd.DataFrame) -> Figure:
    """What a seed costs to have against the iterations that it leaves and the time of a pose."""
    shown = table[~table.source.str.startswith("warm")]
    figure, axes = panels(2, 4.5, 3.6)
    marks = dict(zip(shown.source.unique(), "oXsDP^v", strict=True))
    colours = {name: look.colour for name, look in zip(table.robot.unique(), LOOKS, strict=False)}
    columns = {
        "iterations": "iterations a pose",
        "time_us": "time a pose with the seeding [µs]",
    }
    for axis, (column, title) in zip(axes, columns.items(), strict=True):
        for row in shown.to_dict("records"):
            cost = max(row["preparation_s"], NOTHING_S)
            look = {"marker": marks[row["source"]], "color": colours[row["robot"]]}
            axis.plot(cost, row[column], linestyle="", markersize=6, **look)
        axis.set_xscale("log")
        axis.set_yscale("log" if column == "time_us" else "linear")
        axis.set_xlabel(f"preparation [s of a core]; {NOTHING_S:g} stands for none")
        axis.set_title(title)
    handles = [Line2D([], [], marker=m, linestyle="", color="0.3") for m in marks.values()]
    handles += [Line2D([], [], color=colour, linewidth=3) for colour in colours.values()]
    names = [*marks, *(robot_title(name) for name in colours)]
    figure.legend(handles, names, loc="outside lower center", ncols=4)
    return figure


if __name__ == "__main__":
    main()
