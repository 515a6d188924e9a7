"""What `robots/<name>/robot.yaml` says about a robot, read and checked."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from robots.errors import DescriptionError, UnknownRobotError
from robots.suggestions import unknown_name
from robots.viewpoints import Camera, Picture

Array = NDArray[np.float64]
FOLDER = Path(__file__).parent
FILE = "robot.yaml"


@dataclass(frozen=True)
class Description:
    """A robot's description; the comments in `robot.yaml` give units.

    Attributes:
        name: The name `load_robot` knows.
        title: What a person calls it.
        urdf: The URDF file.
        base: Link whose frame poses are given in.
        tip: Link whose pose is solved for.
        joints: Movable joints from base to tip; found in the URDF if not given.
        lower: (dof,) sampling limits in rad or m, the URDF's if not given.
        upper: (dof,) sampling limits in rad or m, the URDF's if not given.
        home: (dof,) idle configuration in rad or m.
        workspace: (2, 3) lower and upper corner of the tip's box in the base frame, m.
        posture: Position of joints outside the chain, rad or m.
        allowed_collisions: (link, link, reason) of pairs that are not checked; found by
            sampling if not given.
        hand: What grasping needs; see the robot's README.
        picture: How the robot's picture is taken.
        camera: What the robot sees with.
        source: Package, version and file that the URDF was taken out of; None where it came with
            this project or from elsewhere.
    """

    name: str
    title: str
    urdf: Path
    base: str
    tip: str
    joints: tuple[str, ...] | None = None
    lower: Array | None = None
    upper: Array | None = None
    home: Array | None = None
    workspace: Array | None = None
    posture: dict[str, float] = field(default_factory=dict)
    allowed_collisions: tuple[tuple[str, str, str], ...] | None = None
    hand: dict[str, Any] | None = None
    picture: Picture | None = None
    camera: Camera | None = None
    source: str | None = None


def available_robots(folder: Path = FOLDER) -> list[str]:
    """Names of the robots that have a folder with a `robot.yaml`, in alphabetical order."""
    return sorted(path.parent.name for path in folder.glob(f"*/{FILE}"))


def find_description(name: str, folder: Path = FOLDER) -> Description:
    """Read the description of a robot by name.

    Raises:
        UnknownRobotError: If there is no such robot; names the closest one.
        DescriptionError: If its `robot.yaml` is wrong.
    """
    choices = available_robots(folder)
    if name not in choices:
        raise UnknownRobotError(unknown_name("robot", name, choices))
    return read_description(folder / name / FILE)


def read_description(path: Path) -> Description:
    """Read and check one `robot.yaml`.

    Raises:
        DescriptionError: With what was expected, what came and where.
    """
    try:
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DescriptionError(f"{path}: cannot be read: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        problem = " ".join(str(error).split())
        raise DescriptionError(f"{path}: not valid YAML: {problem}") from None
    if not isinstance(values, dict):
        raise DescriptionError(f"{path}: expected keys and values, found {type(values).__name__}")
    known = {f.name for f in fields(Description)}
    if unknown := sorted(values.keys() - known):
        raise DescriptionError(f"{path}: unknown keys {unknown}, expected among {sorted(known)}")
    if missing := [k for k in ("name", "title", "urdf", "base", "tip") if values.get(k) is None]:
        raise DescriptionError(f"{path}: the keys {missing} are missing")
    reader = _Values(path, values)
    return Description(
        name=reader.text("name"),
        title=reader.text("title"),
        urdf=path.parent.absolute() / reader.text("urdf"),
        base=reader.text("base"),
        tip=reader.text("tip"),
        joints=reader.names("joints"),
        lower=reader.numbers("lower"),
        upper=reader.numbers("upper"),
        home=reader.numbers("home"),
        workspace=reader.box("workspace"),
        posture=reader.posture(),
        allowed_collisions=reader.pairs(),
        hand=reader.mapping("hand"),
        picture=reader.picture(),
        camera=reader.camera(),
        source=None if values.get("source") is None else reader.text("source"),
    )


class _Values:
    """Typed access to the values of one file."""

    def __init__(self, path: Path, values: dict[str, Any]) -> None:
        self.path = path
        self.values = values

    def text(self, key: str) -> str:
        value = self.values[key]
        if not isinstance(value, str) or not value:
            raise self._error(key, value, "text; put it in quotes")
        return value

    def numbers(self, key: str) -> Array | None:
        value = self.values.get(key)
        return None if value is None else self._array(key, value, (-1,))

    def names(self, key: str) -> tuple[str, ...] | None:
        value = self.values.get(key)
        if value is None:
            return None
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
            raise self._error(key, value, "a list of names; put those in quotes that are not text")
        return tuple(value)

    def box(self, key: str) -> Array | None:
        value = self.mapping(key)
        if value is None:
            return None
        if value.keys() != {"lower", "upper"}:
            raise self._error(key, value, "the keys lower and upper")
        box = self._array(key, [value["lower"], value["upper"]], (2, 3))
        if (box[0] >= box[1]).any():
            raise self._error(key, value, "lower below upper on every axis")
        return box

    def posture(self) -> dict[str, float]:
        posture = self.mapping("posture") or {}
        if not all(isinstance(v, int | float) and np.isfinite(v) for v in posture.values()):
            raise self._error("posture", posture, "a number for each joint")
        if not all(isinstance(k, str) for k in posture):
            raise self._error("posture", posture, "names of joints; put them in quotes")
        return {str(k): float(v) for k, v in posture.items()}

    def pairs(self) -> tuple[tuple[str, str, str], ...] | None:
        value = self.values.get("allowed_collisions")
        if value is None:
            return None
        if not isinstance(value, list) or not all(
            isinstance(v, list) and len(v) == 3 and all(isinstance(w, str) for w in v)
            for v in value
        ):
            raise self._error("allowed_collisions", value, "a list of [link, link, reason]")
        return tuple((a, b, reason) for a, b, reason in value)

    def picture(self) -> Picture | None:
        value = self.mapping("picture")
        if value is None:
            return None
        known = {f.name for f in fields(Picture)}
        if value.keys() != known:
            raise self._error("picture", value, f"the keys {sorted(known)}")
        target = self._array("picture.target", value["target"], (3,))
        distance, yaw, pitch = (
            float(self._array(f"picture.{key}", value[key], ()))
            for key in ("distance", "yaw", "pitch")
        )
        if distance <= 0.0:
            raise self._error("picture.distance", distance, "a positive distance")
        if type(value["seed"]) is not int or value["seed"] < 0:
            raise self._error("picture.seed", value["seed"], "a whole number, 0 or more")
        return Picture(target, distance, yaw, pitch, value["seed"])

    def camera(self) -> Camera | None:
        value = self.mapping("camera")
        if value is None:
            return None
        known = {f.name for f in fields(Camera)}
        if value.keys() != known:
            raise self._error("camera", value, f"the keys {sorted(known)}")
        position, rotation = (
            self._array(f"camera.{key}", value[key], (3,)) for key in ("position", "rotation")
        )
        view = float(self._array("camera.field_of_view", value["field_of_view"], ()))
        if not 0.0 < view < 180.0:
            raise self._error("camera.field_of_view", view, "an angle between 0 and 180 deg")
        for key in ("width", "height"):
            if type(value[key]) is not int or value[key] < 1:
                raise self._error(f"camera.{key}", value[key], "a whole number, 1 or more")
        link, width, height = str(value["link"]), value["width"], value["height"]
        return Camera(link, position, rotation, view, width, height)

    def mapping(self, key: str) -> dict[str, Any] | None:
        value = self.values.get(key)
        if value is not None and not isinstance(value, dict):
            raise self._error(key, value, "keys and values")
        return value

    def _array(self, key: str, value: Any, shape: tuple[int, ...]) -> Array:
        try:
            array = np.array(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise self._error(key, value, "numbers") from None
        if array.ndim != len(shape) or not np.isfinite(array).all():
            raise self._error(key, value, f"{len(shape)}-dimensional finite numbers")
        if shape != (-1,) and array.shape != shape:
            raise self._error(key, value, f"numbers of the shape {shape}")
        return array

    def _error(self, key: str, value: object, expected: str) -> DescriptionError:
        shown = str(value)
        shown = shown if len(shown) < 80 else shown[:77] + "..."
        return DescriptionError(f"{self.path}: {key} reads {shown}, expected {expected}")
