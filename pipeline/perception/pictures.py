"""Sets of labelled pictures, rendered in chunks that any engine can run and a kill cannot lose."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.data.files import FileError, read_json, replacing, sha256, write_sealed_json
from pipeline.engine.config import EngineConfig
from pipeline.engine.running import run_tasks
from pipeline.grasping.config import GraspConfig
from pipeline.perception.config import DomainConfig, EyeConfig
from pipeline.perception.pinhole import Pinhole
from pipeline.perception.studio import Label, Shot, Studio
from pipeline.progress import bar
from pipeline.seeding import derive_seed
from robots import load_robot

Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Chunk:
    """Some pictures of a set: all that their rendering depends on.

    Attributes:
        robot: Name of the robot.
        grasp: Scenes and objects.
        eye: How pictures are rendered where the domain does not say.
        domain: What to draw from.
        visible: Least visible share of a disc of an object's height.
        size: Width and height [pixels].
        first: Number of the first picture.
        count: How many.
        seed: Root of the pictures' seeds.
        path: File of the pictures; the labels lie beside it.
    """

    robot: str
    grasp: GraspConfig
    eye: EyeConfig
    domain: DomainConfig
    visible: float
    size: tuple[int, int]
    first: int
    count: int
    seed: int
    path: Path


@dataclass(frozen=True)
class Pictures:
    """Labelled pictures on disk.

    Attributes:
        images: (N, height, width, 3), a chunk in memory at a time.
        labels: What is true of each.
        cameras: What took each.
        core_s: Processor time that rendering took [s].
    """

    images: list[Image]
    labels: list[list[Label]]
    cameras: list[Pinhole]
    core_s: float

    def __len__(self) -> int:
        return len(self.labels)


def render_pictures(chunks: list[Chunk], engine: EngineConfig, title: str) -> Pictures:
    """Render what is not on disk yet and open all of it, in the order of the chunks.

    Args:
        chunks: Pieces of one set.
        engine: Where they are rendered.
        title: Of the progress bar.
    """
    missing = [chunk for chunk in chunks if not is_rendered(chunk.path)]
    total = sum(chunk.count for chunk in chunks)
    with bar(total, "picture", title, total - sum(chunk.count for chunk in missing)) as shown:
        run_tasks(engine, render_chunk, missing, lambda _, count: shown.update(count), title)
    images: list[Image] = []
    labels: list[list[Label]] = []
    cameras: list[Pinhole] = []
    core_s = 0.0
    for chunk in chunks:
        images.extend(np.load(chunk.path, mmap_mode="r", allow_pickle=False))
        content = read_json(labels_path(chunk.path))
        core_s += content["core_s"]
        for row in content["pictures"]:
            labels.append([_label(label) for label in row["labels"]])
            cameras.append(_camera(row["camera"]))
    return Pictures(images, labels, cameras, core_s)


def render_chunk(chunk: Chunk) -> int:
    """Render a chunk and write its pictures and, last, its labels; returns how many they are."""
    begin, shots = time.process_time(), []
    robot = _robot(chunk.robot)
    with Studio(robot, chunk.grasp, chunk.eye, chunk.visible) as studio:
        for number in range(chunk.first, chunk.first + chunk.count):
            draw = np.random.default_rng(derive_seed(chunk.seed, "picture", number))
            shots.append(studio.shoot(draw, chunk.domain, chunk.size))
    with replacing(chunk.path) as partial:
        np.save(partial, np.stack([shot.image for shot in shots]), allow_pickle=False)
    rows = [_row(shot) for shot in shots]
    core_s = time.process_time() - begin
    facts = {"pictures": rows, "core_s": core_s, "sha256": sha256(chunk.path)}
    write_sealed_json(labels_path(chunk.path), facts)
    return chunk.count


def is_rendered(path: Path) -> bool:
    """Whether pictures and labels of a chunk are there and as they were written."""
    try:
        return bool(read_json(labels_path(path))["sha256"] == sha256(path))
    except (FileNotFoundError, FileError):
        return False


def labels_path(path: Path) -> Path:
    """File of the labels of a chunk's pictures."""
    return path.with_suffix(".json")


@cache
def _robot(name: str) -> Any:
    return load_robot(name)


def _row(shot: Shot) -> dict[str, Any]:
    camera = {**asdict(shot.camera), "pose": shot.camera.pose.tolist()}
    return {"labels": [asdict(label) for label in shot.labels], "camera": camera}


def _label(row: dict[str, Any]) -> Label:
    return Label(row["name"], tuple(row["box"]), tuple(row["centroid"]), tuple(row["position"]))


def _camera(row: dict[str, Any]) -> Pinhole:
    return Pinhole(**{**row, "pose": np.array(row["pose"])})
