"""Bring any other robot: from a URDF to a folder under `robots/` and a file in `conf/robot/`."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from robots.description import FILE, FOLDER, Description
from robots.errors import RobotError, SamplingError
from robots.locations import conf_dir
from robots.package_source import package_source
from robots.robot import Robot, load_robot
from robots.urdf import Urdf
from robots.urdf_reader import read_urdf
from robots.urdf_writer import write_urdf
from robots.views import default_view

Array = NDArray[np.float64]

CONF = conf_dir() / "robot"
# The robot whose experiment values a new one starts from.
MODEL = "panda"
# Random configurations behind the share in collision and the search for a free home.
SAMPLES = 1000
# Share of random configurations above which a pair that touches is worth a look, and how many of
# these configurations are looked at pair by pair.
LONGEST_NAME = 100  # bytes: files and folders are named by it, with more around it
OFTEN, PAIR_SAMPLES = 0.5, 300
# Words that YAML or the command line takes for something else than a name.
RESERVED = frozenset(("null", "none", "nil", "nan", "inf", "infinity", "true", "false"))
TRUTH_WORDS = frozenset(("yes", "no", "on", "off"))


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
    base: str | None = None,
    tip: str | None = None,
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
        RobotError: If base or tip is missing (the message proposes a chain), or the name is taken
            or no name at all.
    """
    if not base or not tip:
        raise RobotError(_proposal(read_urdf(urdf), base, tip))
    given = load_robot(urdf=urdf, base=base, tip=tip)
    name = _checked_name(name, given.urdf.name, into, conf)
    conf_text = _conf_text(name, conf)
    allowed = tuple(given.find_allowed_collisions())
    title = given.urdf.name.replace("_", " ")
    description = replace(
        given.description,
        name=name,
        title=title,
        allowed_collisions=allowed,
        source=package_source(Path(urdf)),
    )
    robot = Robot(description, given.urdf)
    samples = robot.sample(SAMPLES, collision_free=False)
    colliding = robot.in_collision(samples)
    share = float(colliding.mean())
    home, problem = _free_home(robot, samples[~colliding])
    facts = (
        f"{robot.dof} joints from {base} to {tip}: {', '.join(robot.joint_names)}",
        f"{len(robot.collision.pairs)} pairs of links are checked for collision, "
        f"{len(allowed)} may touch; {share:.0%} of uniform configurations collide",
        "reach of the tip [m]: " + " ".join(f"{v:.2f}" for v in robot.workspace.ravel()),
    )
    points = [
        f"{share:.0%} of uniform configurations are in collision",
        *_touching(robot, samples[:PAIR_SAMPLES]),
        *robot.urdf.notes,
        *_unknown(robot),
        *problem,
    ]
    into.mkdir(parents=True, exist_ok=True)
    conf.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{name}-", dir=into))
    conf_aside = conf / f".{name}.yaml.{os.getpid()}"
    try:
        _write_folder(aside, robot, home, points)
        conf_aside.write_text(conf_text, encoding="utf-8")
        aside.chmod(0o755)
        aside.rename(into / name)
        conf_aside.replace(conf / f"{name}.yaml")
    finally:
        shutil.rmtree(aside, ignore_errors=True)
        conf_aside.unlink(missing_ok=True)
    return Report(name, into / name, conf / f"{name}.yaml", facts, tuple(points))


def _proposal(urdf: Urdf, base: str | None, tip: str | None) -> str:
    """Say which links a chain may run between, and propose the longest one."""
    top = base or urdf.root
    parents = {joint.parent for joint in urdf.joints.values()}
    ends = [tip] if tip else [link for link in urdf.links if link not in parents]
    lengths = {}
    for end in ends:
        above = urdf.links_above(end)
        if end == top or (top in urdf.links and top not in above):
            continue
        path = urdf.path_between(top, end)
        lengths[end] = sum(joint.movable and not joint.mimic for joint in path)
    missing = " and ".join(f"--{k}" for k, v in (("base", base), ("tip", tip)) if not v)
    verb = "are" if " and " in missing else "is"
    if not any(lengths.values()):
        return (
            f"{urdf.path}: {missing} {verb} missing; the root is '{urdf.root}', and no joint "
            f"moves from '{top}' to {', '.join(map(repr, ends))}"
        )
    order = sorted(lengths, key=lambda end: -lengths[end])
    listed = ", ".join(f"'{end}' ({lengths[end]} joints)" for end in order[:8])
    more = f" and {len(order) - 8} more" if len(order) > 8 else ""
    return (
        f"{urdf.path}: {missing} {verb} missing; the root is '{urdf.root}', the ends are "
        f"{listed}{more}; the longest chain is --base '{top}' --tip '{order[0]}'"
    )


def _checked_name(given: str | None, urdf_name: str, into: Path, conf: Path) -> str:
    """Return a name that is a folder, a Python-like word, and sayable on a command line."""
    name = unicodedata.normalize("NFC", given or urdf_name).strip()
    plain = re.sub(r"\W+", "_", name).strip("_").lower()
    if not plain or plain[0].isdigit() or plain in RESERVED | TRUTH_WORDS:
        raise RobotError(
            f"'{name}' is no name for a robot: expected letters, digits and underscores that are "
            f"no number and no word of YAML; give another one, such as --name robot_{plain}"
        )
    if given and re.search(r"[/\\]|^[.]", given):
        raise RobotError(
            f"'{name}' is no name for a robot: expected letters, digits and underscores; give "
            f"another one, such as --name {plain}"
        )
    if len(plain.encode()) > LONGEST_NAME:
        raise RobotError(
            f"'{plain[:20]}...' has {len(plain.encode())} bytes, and a name of a robot at most "
            f"{LONGEST_NAME}: give a shorter --name"
        )
    name = plain
    for path in (into / name, conf / f"{name}.yaml"):
        if path.exists():
            raise RobotError(f"{path} exists already; give another --name or remove it first")
    return name


def _conf_text(name: str, conf: Path) -> str:
    """Experiment values of the model robot under a new name."""
    model = next((p for p in (conf, CONF) if (p / f"{MODEL}.yaml").exists()), CONF)
    lines = (model / f"{MODEL}.yaml").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not line.startswith("#")]
    named = f"name: {_scalar(name)} # folder of robots/"
    kept = [named if line.startswith("name:") else line for line in kept]
    header = [
        f"# Experiment values of this robot; its description is robots/{name}/{FILE}.",
        f"# The paper has none for it: table_one holds those of {MODEL}, as a start.",
    ]
    return "\n".join([*header, *kept]) + "\n"


def _free_home(robot: Robot, free: Array) -> tuple[Array, list[str]]:
    """Return the default home, or the free configuration nearest to it, and what was wrong.

    Args:
        robot: The robot.
        free: Configurations (N, dof) that are known to be free: where many shapes are nearly
            touching, as many again would take minutes.
    """
    if not robot.in_collision(robot.home)[0]:
        return robot.home, ["home is zero where limits allow, else mid-range: choose a better one"]
    pairs = robot.collision.pairs
    touching = [pairs[k] for k in np.flatnonzero(robot.collision.touching(robot.home[None])[0])]
    named = ", ".join(f"{first} and {second}" for first, second in touching[:5])
    try:
        free = free if len(free) else robot.sample(1)
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
        yield f"{_some(endless)} turn without end: sampled from -pi to pi, solved all the way round"
    yield from robot.followers()
    others = [n for n, j in urdf.joints.items() if j.movable and not j.mimic]
    if still := [n for n in others if n not in robot.joint_names]:
        yield f"held still at zero or the nearer limit: {_some(still)}; see posture in {FILE}"
    yield "the hand is unknown: grasping needs `hand` filled in"


def _touching(robot: Robot, samples: Array) -> Iterable[str]:
    """Pairs that touch in many configurations, the most frequent first, one sentence each."""
    shares = robot.collision.touching(samples).mean(axis=0)
    for k in np.argsort(-shares, kind="stable"):
        if shares[k] > OFTEN:
            first, second = robot.collision.pairs[k]
            yield (
                f"{first} and {second} touch in {shares[k]:.0%} of them: allow the pair in {FILE} "
                f"if its shapes are only too fat"
            )


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
    xml = write_urdf(robot.urdf, mesh_name=place, continuous=True)
    (folder / f"{name}.urdf").write_text(xml, "utf-8")
    (folder / FILE).write_text(_description_text(robot.description, robot, home), "utf-8")
    lines = [f"# {robot.description.title}", "", f"From `{robot.urdf_path.name}`. Open points:", ""]
    (folder / "README.md").write_text("\n".join([*lines, *(f"- {p}" for p in points), ""]), "utf-8")


def _description_text(description: Description, robot: Robot, home: Array) -> str:
    low, high = robot.workspace
    idle = np.clip(home, robot.lower, robot.upper)
    pairs = [f"  - {_scalar(list(p))}" for p in description.allowed_collisions or ()]
    view = default_view(robot, idle)
    rows = [
        f"# Made from {robot.urdf_path.name} by sampling; everything here may be edited.",
        f"name: {_scalar(description.name)}",
        f"title: {_scalar(description.title)}",
        f"urdf: {_scalar(description.name + '.urdf')} # relative to this file",
        f"source: {_source(description)} # package that the URDF came with; null: none",
        f"base: {_scalar(description.base)}",
        f"tip: {_scalar(description.tip)}",
        "joints: # base to tip",
        *(f"  - {_scalar(joint)}" for joint in robot.joint_names),
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
        f"picture: # python -m pipeline robot picture {description.name}",
        f"  target: {_numbers(view.target)} # middle of the picture [m]",
        f"  distance: {view.distance!r} # from camera to target [m]",
        f"  yaw: {view.yaw!r} # of the camera about the vertical [deg]",
        f"  pitch: {view.pitch!r} # of the line of sight, negative looks down [deg]",
        f"  seed: {view.seed} # of the five random postures",
    ]
    return "\n".join(rows) + "\n"


def _source(description: Description) -> str:
    return "null" if description.source is None else _scalar(description.source)


def _numbers(values: Array) -> str:
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"


def _scalar(value: str | list[str]) -> str:
    """Return text as YAML writes it, on one line and quoted where it would read as another type."""
    written = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=2**20)
    return str(written).removesuffix("...\n").strip()
