"""A wall of thumbnails: every trial of a series at a glance, linked to what is kept of it."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from PIL import Image

from pipeline.presentation.columns import plain
from pipeline.presentation.naming import ordered_robots, robot_title
from pipeline.reporting.results import EVIDENCE, VIDEOS, Results
from pipeline.reporting.topics.agent import setting_title
from pipeline.reporting.topics.grasps import CLASSES, COLOURS

AGENT, ALONE = "grasp_agent", "grasp"  # stages whose trials are shown
THUMBNAIL = (112, 84)  # pixels at most
QUALITY = 70  # of its JPEG: some 3 kB


@dataclass(frozen=True)
class Tile:
    """One trial.

    Attributes:
        trial: Its number.
        object: What was to be grasped.
        outcome: Class.
        colour: Of that class, as in the figures.
        reason: Why it is of that class.
        thumbnail: Data URI of what the eye saw, empty where no picture was kept.
        links: Files from the report, by what they are: picture, transcript, film.
    """

    trial: int
    object: str
    outcome: str
    colour: str
    reason: str
    thumbnail: str
    links: dict[str, str]


@dataclass(frozen=True)
class Wall:
    """The trials of one robot in one setting.

    Attributes:
        title: Robot and setting.
        tiles: In the order of the trials.
        legend: Colour and number of trials, by class.
    """

    title: str
    tiles: list[Tile]
    legend: dict[str, tuple[str, int]]


def walls(results: Results) -> list[Wall]:
    """Return a wall for each series of trials on disk, robots in the order of all tables."""
    return [_wall(results.folder, *series) for series in _series(results)]


def _series(results: Results) -> Iterator[tuple[str, Path, pd.DataFrame]]:
    """Title, folder and raw rows."""
    for robot in ordered_robots({robot for robot, _ in results.grasp_agents}):
        for name, setting in sorted(results.grasp_agents):
            if name == robot:
                folder = results.folder / AGENT / robot / setting
                title = f"{robot_title(robot)}: {setting_title(setting)}"
                yield title, folder, results.grasp_agents[robot, setting]
    for robot in ordered_robots(results.grasp):
        folder = results.folder / ALONE / robot
        yield f"{robot_title(robot)}: known places, no agent", folder, results.grasp[robot]


def _wall(root: Path, title: str, folder: Path, rows: pd.DataFrame) -> Wall:
    films = {path.stem.split("_")[0]: path for path in folder.rglob("*") if path.suffix in VIDEOS}
    colours = dict(zip(CLASSES, COLOURS, strict=True))
    counted = rows["class"].value_counts()
    legend = {name: (colours[name], int(counted[name])) for name in CLASSES if name in counted}
    tiles = []
    for row in rows.sort_values("trial").to_dict("records"):
        picture = _kept(folder, row, "picture")
        paths = {
            "picture": picture,
            "transcript": _kept(folder, row, "transcript"),
            "film": films.get(f"trial{row['trial']:03d}"),
        }
        tiles.append(
            Tile(
                trial=int(row["trial"]),
                object=plain(row["object"]) if row.get("object") else "",
                outcome=row["class"],
                colour=colours[row["class"]],
                reason=str(row.get("reason") or ""),
                thumbnail=_thumbnail(picture) if picture else "",
                links={
                    name: path.relative_to(root).as_posix() for name, path in paths.items() if path
                },
            )
        )
    return Wall(title, tiles, legend)


def _kept(folder: Path, row: dict[Any, Any], column: str) -> Path | None:
    """File of evidence that a row names, None where it names none or the file is gone."""
    name = row.get(column)
    path = folder / EVIDENCE / str(name)
    return path if name and path.is_file() else None


def _thumbnail(path: Path) -> str:
    """A small copy as a data URI; empty where the picture is damaged: the trial still counts."""
    try:
        with Image.open(path) as picture:
            small = picture.convert("RGB")
    except OSError:
        return ""
    small.thumbnail(THUMBNAIL)
    content = io.BytesIO()
    small.save(content, "JPEG", quality=QUALITY)
    return data_uri(content.getvalue(), "image/jpeg")


def data_uri(content: bytes, kind: str) -> str:
    """Return a file's content as an address that a page can hold.

    Args:
        content: Of the file.
        kind: Its media type, such as ``image/png``.
    """
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"
