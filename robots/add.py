"""Bring any other robot: from a URDF to a folder under `robots/` and a file in `conf/robot/`."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robots.description import FILE, FOLDER, Description
from robots.errors import RobotError, SamplingError
from robots.locations import conf_dir
from robots.robot import Robot, load_robot
from robots.urdf import Urdf
from robots.urdf_writer import write_urdf

Array = NDArray[np.float64]

CONF = conf_dir() / "robot"
# The robot whose experiment values a new one starts from.
MODEL = "panda"
# Random configurations behind the share in collision and the search for a free home.
SAMPLES = 1000


@dataclass(frozen=True)
class Report:
    """What was written for a new robot and what could not be found out.

    Attributes:
        name: The name `load_robot` knows it by.
        folder: Its folder.
        config: Its file in `conf/robot`.
        facts: What was found out, one sentence each.
        open_points: What was not, or needs a look, one sentence each.
    """

    name: str
    folder: Path
    config: Path
    facts: tuple[str, ...]
    open_points: tuple[str, ...]

    def __str__(self) -> str:
        lines = [f"added robot '{self.name}': {self.folder} and {self.config}"]
        lines += [f"  {fact}" for fact in self.facts]
        lines += ["what to look at:"] + [f"  - {point}" for point in self.open_points]
        return "\n".join(lines)


def add_robot(
    urdf: str | Path,
    base: str,
    tip: str,
    name: str | None = None,
    into: Path = FOLDER,
    conf: Path = CONF,
) -> Report:
    """Write `robots/<name>/` and `conf/robot/<name>.yaml` for a robot given by its URDF.

    The URDF is rewritten from what was understood of it, with its meshes copied beside it; what
    the URDF does not say (home, reach, pairs that may touch) is found by sampling.

    Args:
        urdf: The URDF file.
        base: Link whose frame poses are given in.
        tip: Link whose pose is wanted.
        name: Name of the robot; the URDF's if not given.
        into: Folder of the robots.
        conf: Folder of the robots' experiment values.

    Raises:
        UrdfError: If the URDF cannot be used.
        RobotError: If the name is taken or no name at all.
    """
    given = load_robot(urdf=urdf, base=base, tip=tip)
    name = _checked_name(name or given.name, into, conf)
    conf_text = _conf_text(name, conf)
    allowed = tuple(given.find_allowed_collisions())
    description = replace(given.description, name=name, allowed_collisions=allowed)
    robot = Robot(description)
    share = float(robot.in_collision(robot.sample(SAMPLES, collision_free=False)).mean())
    home, problem = _free_home(robot)
    facts = (
        f"{robot.dof} joints from {base} to {tip}: {', '.join(robot.joint_names)}",
        f"{len(robot.collision.pairs)} pairs of links are checked for collision, "
        f"{len(allowed)} may touch; {share:.0%} of uniform configurations collide",
        "reach of the tip [m]: " + " ".join(f"{v:.2f}" for v in robot.workspace.ravel()),
    )
    points = [*robot.urdf.notes, *_unknown(robot), *problem]
    into.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{name}-", dir=into))
    try:
        _write_folder(aside, robot, home, points)
        aside.chmod(0o755)
        aside.rename(into / name)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    _write_aside(conf / f"{name}.yaml", conf_text)
    return Report(name, into / name, conf / f"{name}.yaml", facts, tuple(points))


def _checked_name(name: str, into: Path, conf: Path) -> str:
    name = re.sub(r"\W+", "_", name.strip()).strip("_").lower()
    if not name or name[0].isdigit():
        raise RobotError(
            f"'{name}' is no name for a robot; give name= letters, digits, underscores"
        )
    for path in (into / name, conf / f"{name}.yaml"):
        if path.exists():
            raise RobotError(f"{path} exists already; give another name= or remove it first")
    return name


def _conf_text(name: str, conf: Path) -> str:
    """Experiment values of the model robot under a new name."""
    model = next((p for p in (conf, CONF) if (p / f"{MODEL}.yaml").exists()), CONF)
    lines = (model / f"{MODEL}.yaml").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not line.startswith("#")]
    kept = [f"name: {name}" if line.startswith("name:") else line for line in kept]
    header = [
        f"# Experiment values of this robot; its description is robots/{name}/{FILE}.",
        f"# The paper has none for it: table_one holds those of {MODEL}, as a start.",
    ]
    return "\n".join([*header, *kept]) + "\n"


def _free_home(robot: Robot) -> tuple[Array, list[str]]:
    """Return the default home, or the free configuration nearest to it, and what was wrong."""
    if not robot.in_collision(robot.home)[0]:
        return robot.home, ["home is zero where limits allow, else mid-range: choose a better one"]
    pairs = robot.collision.pairs
    touching = [pairs[k] for k in np.flatnonzero(robot.collision.touching(robot.home[None])[0])]
    named = ", ".join(f"{first} and {second}" for first, second in touching[:5])
    try:
        free = robot.sample(SAMPLES)
    except SamplingError:
        return robot.home, [
            f"no configuration is free of collision; at home {named} touch: allow pairs in {FILE} "
            f"or give joints outside the chain a posture"
        ]
    distance = np.linalg.norm((free - robot.home) / (robot.upper - robot.lower), axis=1)
    return free[np.argmin(distance)], [
        f"at zero or mid-range {named} touch, so home is the nearest free sample: choose a better "
        f"one, and allow the pair in {FILE} if it is harmless"
    ]


def _unknown(robot: Robot) -> Iterable[str]:
    """What the URDF leaves open, one sentence each."""
    urdf = robot.urdf
    if bare := [n for n, link in urdf.links.items() if _shapes(urdf, n) and not link.inertial]:
        yield f"no inertia for {_some(bare)}: simulation will need them"
    if hollow := [n for n, link in urdf.links.items() if link.visuals and not link.collisions]:
        yield f"no collision shape for {_some(hollow)}: they cannot collide"
    if not any(link.collisions for link in urdf.links.values()):
        yield "no collision shapes at all: every configuration counts as free"
    names = zip(robot.joint_names, robot.velocity_limit, strict=True)
    if slow := [joint for joint, limit in names if not np.isfinite(limit)]:
        yield f"no velocity limit for {_some(slow)}"
    if endless := [j for j in robot.joint_names if urdf.joints[j].kind == "continuous"]:
        yield f"{_some(endless)} turn without end and are sampled from -pi to pi"
    if coupled := [j.name for j in urdf.path_between(robot.base, robot.tip) if j.mimic]:
        yield f"{_some(coupled)} of the chain mimic others; not every solver can follow"
    others = [n for n, j in urdf.joints.items() if j.movable and not j.mimic]
    if still := [n for n in others if n not in robot.joint_names]:
        yield f"held still at zero or the nearer limit: {_some(still)}; see posture in {FILE}"
    yield "the hand is unknown: grasping needs `hand` filled in"


def _shapes(urdf: Urdf, link: str) -> bool:
    return bool(urdf.links[link].collisions or urdf.links[link].visuals)


def _some(names: list[str]) -> str:
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return ", ".join(names[:4]) + more


def _write_folder(folder: Path, robot: Robot, home: Array, points: list[str]) -> None:
    meshes: dict[Path, str] = {}

    def place(mesh: Path) -> str:
        if mesh not in meshes:
            taken = set(meshes.values())
            stem, suffix = mesh.stem, mesh.suffix.lower()
            names = (f"meshes/{stem}{k or ''}{suffix}" for k in range(len(taken) + 1))
            meshes[mesh] = next(n for n in names if n not in taken)
            (folder / "meshes").mkdir(exist_ok=True)
            shutil.copyfile(mesh, folder / meshes[mesh])
        return meshes[mesh]

    name = robot.name
    (folder / f"{name}.urdf").write_text(write_urdf(robot.urdf, mesh_name=place), "utf-8")
    (folder / FILE).write_text(_description_text(robot.description, robot, home), "utf-8")
    lines = [f"# {robot.description.title}", "", f"From `{robot.urdf_path.name}`. Open points:", ""]
    (folder / "README.md").write_text("\n".join([*lines, *(f"- {p}" for p in points), ""]), "utf-8")


def _description_text(description: Description, robot: Robot, home: Array) -> str:
    low, high = robot.workspace
    idle = np.clip(home, robot.lower, robot.upper)
    pairs = [f"  - [{', '.join(map(_quoted, p))}]" for p in description.allowed_collisions or ()]
    rows = [
        f"# Made from {robot.urdf_path.name} by sampling; everything here may be edited.",
        f"name: {description.name}",
        f"title: {_quoted(description.title)}",
        f"urdf: {description.name}.urdf # relative to this file",
        f"base: {_quoted(description.base)}",
        f"tip: {_quoted(description.tip)}",
        "joints: # base to tip",
        *(f"  - {_quoted(joint)}" for joint in robot.joint_names),
        "lower: null # sampling limits [rad or m]; null: the URDF's",
        "upper: null",
        f"home: {_numbers(idle)} # idle configuration [rad or m]",
        "workspace: # box of the tip in the base frame [m]: reach of uniform samples",
        f"  lower: {_numbers(np.floor(low * 1000) / 1000)}",
        f"  upper: {_numbers(np.ceil(high * 1000 + 1e-6) / 1000)}",
        "posture: {} # fixed angle of joints outside the chain [rad or m]; all others 0",
        f"allowed_collisions: {'' if pairs else '[] '}# pairs never checked: [link, link, reason]",
        *pairs,
        "hand: null # what grasping needs; see the README of panda or nico",
    ]
    return "\n".join(rows) + "\n"


def _numbers(values: Array) -> str:
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"


def _quoted(text: str) -> str:
    """Return a YAML string; plain where it cannot be mistaken for anything else."""
    plain = re.fullmatch(r"[A-Za-z_][\w ]*\w", text) and text.lower() not in ("null", "yes", "no")
    return text if plain else "'" + text.replace("'", "''") + "'"


def _write_aside(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f".{path.name}.{os.getpid()}")
    aside.write_text(text, encoding="utf-8")
    aside.replace(path)
