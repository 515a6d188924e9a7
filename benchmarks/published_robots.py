"""Robots that others published: added, loaded, sampled and solved, whatever their shape.

    python benchmarks/published_robots.py [--robots 40] [--poses 200] [--only stretch]

Takes URDFs out of installed packages (of the extra `test`, roboticstoolbox's rtbdata, pybullet, and
hello-robot-stretch-urdf: `pip install --no-deps` will do, only its files count), the longest chain
of each, brings it in as `robot add` does, solves poses with every solver that does not skip it, and
checks every answer by a forward kinematics of its own, from the original file. Writes
results/studies/published_robots.{csv,md}; with --only what it has of other robots stays.
"""

from __future__ import annotations

import argparse
import re
import sysconfig
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import baselines
from baselines import Budget
from baselines.registry import settings
from pipeline import provenance
from pipeline.presentation.origin import Origin
from pipeline.presentation.table import write_origin
from robots import Robot, RobotError, load_robot
from robots.add import add_robot
from robots.description import find_description
from robots.rotations import rotation_angle
from robots.urdf import Urdf
from robots.urdf_reader import read_urdf

Array = NDArray[np.float64]

OUT = Path(__file__).parents[1] / "results" / "studies" / "published_robots"
PACKAGES = (
    "cmeel.prefix/share/example-robot-data/robots",
    "airo_models",
    "jvrc_description",
    "orca_arm",
    "stretch_urdf",
    "rtbdata/xacro",
    "pybullet_data",
)
DATA = ("share/iCub/robots",)  # of packages that lay their files beside the libraries
# Objects and scenes of pybullet_data, which are no robots.
NO_ROBOTS = ("random_urdfs", "toys", "dinnerware", "objects", "lego", "/link", "table", "cube")
MOST_OF_A_FOLDER = 2
UNNAMED = "model"  # the stem of files that are called by their folder
BUDGET_S = 0.05
# Answers that are called found and are further off than the loosest claim of any solver are wrong.
WRONG_M, WRONG_RAD = 1e-3, 2e-3


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--robots", type=int, default=40)
    parser.add_argument("--poses", type=int, default=200)
    parser.add_argument("--only", default="", help="robots whose name has this; others stay")
    options = parser.parse_args()
    rows: list[dict[str, Any]] = []
    robots = 0
    for path in urdf_files():
        if options.only not in name_of(path) or (found := chain_of(path)) is None:
            continue
        rows += study(path, *found, options.poses)
        robots += 1
        print(f"{robots}: {rows[-1]['robot']}", flush=True)
        if robots == options.robots:
            break
    table = pd.DataFrame(rows)
    if options.only:
        former = pd.read_csv(OUT.with_suffix(".csv"))
        table = pd.concat([former[~former.robot.isin(table.robot)], table], ignore_index=True)
    OUT.parent.mkdir(parents=True, exist_ok=True)
    table.to_csv(OUT.with_suffix(".csv"), index=False)
    command = f"python benchmarks/published_robots.py --robots {robots} --poses {options.poses}"
    machine = provenance.machine()["processor"]
    signed = provenance.signature("none: installed packages")
    made_by = Origin(command, **signed, processor=machine, seeds="1")
    text = f"{report(table)}\n{made_by.sentence()}\n"
    OUT.with_suffix(".md").write_text(text, encoding="utf-8")
    write_origin(OUT.parent, OUT.stem, made_by)


def urdf_files() -> Iterator[Path]:
    """URDFs in the packages, not more than a few of each folder, whose files are alike."""
    taken: dict[Path, int] = {}
    libraries, data = Path(sysconfig.get_path("purelib")), Path(sysconfig.get_path("data"))
    for folder in [*(libraries / name for name in PACKAGES), *(data / name for name in DATA)]:
        for path in sorted(folder.rglob("*.urdf")):
            if any(word in f"/{path.relative_to(folder)}" for word in NO_ROBOTS):
                continue
            group = path.parent if path.stem != UNNAMED else path.parent.parent
            taken[group] = taken.get(group, 0) + 1
            if taken[group] <= MOST_OF_A_FOLDER:
                yield path


def name_of(path: Path) -> str:
    """Name a URDF of a package for a table: its folder's folder and the file, which may repeat."""
    return path.parent.name if path.stem == UNNAMED else f"{path.parent.parent.name}/{path.stem}"


def chain_of(path: Path) -> tuple[str, str] | None:
    """Base and tip of the longest chain, or None for a file that is no robot or a broken one."""
    try:
        urdf = read_urdf(path)
        parents = {joint.parent for joint in urdf.joints.values()}
        ends = [link for link in urdf.links if link not in parents]
        tip = max(ends, key=lambda end: _moving(urdf, end), default=urdf.root)
        base = urdf.root
        for joint in urdf.path_between(urdf.root, tip):
            base = joint.child if joint.kind in ("floating", "planar") else base
        load_robot(urdf=path, base=base, tip=tip)
    except RobotError as error:
        print(f"refused: {error}")
        return None
    return base, tip


def _moving(urdf: Urdf, end: str) -> int:
    return sum(joint.movable and not joint.mimic for joint in urdf.path_between(urdf.root, end))


def study(path: Path, base: str, tip: str, count: int) -> list[dict[str, Any]]:
    """One row a solver."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        try:
            report = add_robot(path, base, tip, "guest", Path(folder), Path(folder) / "conf")
            robot = Robot(find_description(report.name, Path(folder)))
        except RobotError as error:  # no mesh of its shapes is in the package
            print(f"not added: {error}")
            robot = load_robot(urdf=path, base=base, tip=tip)
        add_s = time.perf_counter() - began
        joints = robot.sample(count, seed=1, collision_free=False)
        poses = robot.forward_kinematics(joints)
        facts = {
            "robot": name_of(path),
            "base": base,
            "tip": tip,
            "joints": robot.dof,
            "endless": int(robot.endless.sum()),
            "add_s": round(add_s, 2),
        }
        reference = Reference(path, base, tip)
        agreement = _errors(reference.poses(robot, joints), poses)
        facts["fk_error_m"] = float(agreement[0].max())
        return [{**facts, **row} for row in _solved(robot, poses, reference)]


def _solved(robot: Robot, poses: Array, reference: Reference) -> Iterator[dict[str, Any]]:
    for name in baselines.names():
        if "weights" in settings(name) or baselines.skip(name, robot):
            continue
        solver = baselines.load(name, robot)
        budget = Budget(time_s=BUDGET_S) if "time_s" in solver.budgets else None
        solution = solver.solve(poses, budget=budget)
        distance, angle = _errors(reference.poses(robot, solution.joints), poses)
        wrong = solution.found & ((distance > WRONG_M) | (angle > WRONG_RAD))
        yield {
            "solver": name,
            "found": float(solution.found.mean()),
            "wrong": int(wrong.sum()),
            "outside": int((~robot.within_limits(solution.joints)).sum()),
            "median_ms": 1e3 * float(np.median(solution.time_s)),
        }


def _errors(reached: Array, poses: Array) -> tuple[Array, Array]:
    distance = np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
    return distance, rotation_angle(reached[:, 3:], poses[:, 3:])


class Reference:
    """The kinematics of the original file by its own elements, apart from the project's reader."""

    def __init__(self, path: Path, base: str, tip: str) -> None:
        joints = _elements(path).findall("joint")
        self._joints = {joint.get("name"): joint for joint in joints}
        carrier = {_link(joint, "child"): joint for joint in joints}
        self._path: list[Any] = []
        while tip != base:
            self._path.insert(0, carrier[tip])
            tip = _link(carrier[tip], "parent")

    def poses(self, robot: Robot, joints: Array) -> Array:
        """Poses (N, 7) of the tip for configurations (N, dof)."""
        from scipy.spatial.transform import Rotation

        values = dict(zip(robot.joint_names, joints.T, strict=True))
        turn, shift = Rotation.identity(len(joints)), np.zeros((len(joints), 3))
        for joint in self._path:
            origin, axis = joint.find("origin"), joint.find("axis")
            xyz, rpy = (
                np.array([float(v) for v in _triple(origin, k).split()]) for k in ("xyz", "rpy")
            )
            shift = shift + turn.apply(np.tile(xyz, (len(joints), 1)))
            turn = turn * Rotation.from_euler("xyz", rpy)
            text = "1 0 0" if axis is None else axis.get("xyz", "1 0 0")
            direction = np.array([float(v) for v in text.split()])
            direction = direction / (np.linalg.norm(direction) or 1.0)
            moved = self._value(joint, values, len(joints))[:, None] * direction
            if joint.get("type") == "prismatic":
                shift = shift + turn.apply(moved)
            elif joint.get("type") in ("revolute", "continuous"):
                turn = turn * Rotation.from_rotvec(moved)
        x, y, z, w = turn.as_quat().T
        return np.column_stack([shift, w, x, y, z])

    def _value(self, joint: Any, values: dict[str, Array], count: int) -> Array:
        name, mimic, limit = joint.get("name"), joint.find("mimic"), joint.find("limit")
        if name in values:
            return values[name]
        if mimic is not None:
            master = self._value(self._joints[mimic.get("joint")], values, count)
            scaled: Array = float(mimic.get("multiplier", 1)) * master
            return scaled + float(mimic.get("offset", 0))
        given = {} if limit is None else limit.attrib
        low, high = (float(given.get(k, 0)) for k in ("lower", "upper"))
        bounded = joint.get("type") in ("revolute", "prismatic")
        return np.full(count, min(max(0.0, low), high) if bounded else 0.0)


def _elements(path: Path) -> ElementTree.Element:
    content = path.read_bytes()
    try:
        return ElementTree.fromstring(content)
    except ElementTree.ParseError:  # a prefix that nothing declares
        return ElementTree.fromstring(re.sub(rb"([<\s]/?)[\w-]+:(?=[A-Za-z])", rb"\1", content))


def _triple(origin: Any, key: str) -> str:
    return "0 0 0" if origin is None else str(origin.get(key, "0 0 0"))


def _link(joint: Any, role: str) -> str:
    return str(joint.find(role).get("link"))


def report(table: pd.DataFrame) -> str:
    """The study as Markdown: one row a robot, and one a solver."""
    robots = table.groupby("robot", sort=False)
    solvers = table.groupby("solver")
    lines = [
        "# Robots that others published",
        "",
        f"{robots.ngroups} URDFs of installed packages; {BUDGET_S:g} s a pose where a solver takes",
        "a time; reachable poses of uniform joints. *wrong*: called found, but further off than",
        f"{1e3 * WRONG_M:g} mm or {WRONG_RAD:g} rad by an independent forward kinematics of the",
        "original file. A busy machine makes solve rates lower and times longer.",
        "",
        "| robot | joints | turning for ever | added in, s | kinematics agree to, m | `lm` found | "
        "solvers | their mean | wrong | outside limits |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, rows in robots:
        first = rows.iloc[0]
        lm = rows.loc[rows.solver == "lm", "found"].iloc[0]
        lines.append(
            f"| {name} | {first.joints} | {first.endless} | {first.add_s:.1f} | "
            f"{first.fk_error_m:.0e} | {lm:.1%} | {len(rows)} | {rows.found.mean():.1%} | "
            f"{rows.wrong.sum()} | {rows.outside.sum()} |"
        )
    lines += ["", "| solver | robots | found | median time, ms | wrong |", "|---|---|---|---|---|"]
    lines += [
        f"| {name} | {len(rows)} | {rows.found.mean():.1%} | {rows.median_ms.median():.3f} | "
        f"{rows.wrong.sum()} |"
        for name, rows in solvers
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
