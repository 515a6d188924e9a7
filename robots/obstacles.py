"""Obstacles around a robot: boxes and spheres in its base frame, and the clearance from them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
import yaml
from numpy.typing import NDArray

from robots.arguments import as_float, as_floats
from robots.errors import ObstacleError
from robots.rotations import UNIT_TOLERANCE, matrix_from_quaternion
from robots.shapes import BOX, SPHERE
from robots.suggestions import unknown_name

Array = NDArray[np.float64]

UPRIGHT = (1.0, 0.0, 0.0, 0.0)  # the quaternion that turns nothing


@dataclass(frozen=True)
class Box:
    """A solid box.

    Attributes:
        position: Its centre x y z in the base frame [m].
        size: Its edges [m].
        orientation: Unit quaternion qw qx qy qz.
    """

    position: tuple[float, float, float]
    size: tuple[float, float, float]
    orientation: tuple[float, float, float, float] = UPRIGHT

    def __post_init__(self) -> None:
        """Refuse edges that are none and quaternions that are not unit."""
        _tuple(self, "position", 3)
        if min(_tuple(self, "size", 3)) <= 0.0:
            raise ObstacleError(f"expected a box with edges above 0 m, got {self.size}")
        norm = math.hypot(*_tuple(self, "orientation", 4))
        if abs(norm - 1.0) > UNIT_TOLERANCE:
            raise ObstacleError(
                f"expected the orientation of a box as a unit quaternion qw qx qy qz, got one of "
                f"norm {norm:.6g}; divide it by its norm"
            )


@dataclass(frozen=True)
class Sphere:
    """A solid sphere.

    Attributes:
        position: Its centre x y z in the base frame [m].
        radius: Its radius [m].
    """

    position: tuple[float, float, float]
    radius: float

    def __post_init__(self) -> None:
        """Refuse a radius that is none."""
        _tuple(self, "position", 3)
        object.__setattr__(self, "radius", as_float(self.radius, "radius", ObstacleError))
        if not 0.0 < self.radius < math.inf:
            raise ObstacleError(f"expected a sphere with a radius above 0 m, got {self.radius}")


@dataclass(frozen=True)
class Obstacles:
    """What a configuration has to be free of, beside self-collision.

    Links that no joint of the chain moves are left out: a table may carry the base.

    Attributes:
        boxes: Solid boxes.
        spheres: Solid spheres.
        clearance_m: Least distance of every link that moves from every obstacle [m].
    """

    boxes: Sequence[Box] = ()
    spheres: Sequence[Sphere] = ()
    clearance_m: float = 0.0

    def __post_init__(self) -> None:
        """Take any sequences, refuse a clearance below 0."""
        object.__setattr__(self, "boxes", tuple(self.boxes))
        object.__setattr__(self, "spheres", tuple(self.spheres))
        clearance = as_float(self.clearance_m, "clearance_m", ObstacleError)
        if not 0.0 <= clearance < math.inf:
            raise ObstacleError(f"expected clearance_m of 0 m or more, got {clearance}")
        object.__setattr__(self, "clearance_m", clearance)

    def __len__(self) -> int:
        return len(self.boxes) + len(self.spheres)

    @cached_property
    def arrays(self) -> tuple[NDArray[np.int64], Array, Array, Array]:
        """Kinds (K,), sizes (K, 3), rotations (K, 3, 3) and centres (K, 3), base frame [m]."""
        kind = np.repeat([BOX, SPHERE], [len(self.boxes), len(self.spheres)]).astype(np.int64)
        half = [[edge / 2.0 for edge in box.size] for box in self.boxes]
        size = np.array([*half, *((each.radius, 0.0, 0.0) for each in self.spheres)])
        turns = [*(box.orientation for box in self.boxes), *([UPRIGHT] * len(self.spheres))]
        turn = np.array(turns, dtype=np.float64).reshape(-1, 4)
        turn = turn / np.linalg.norm(turn, axis=1, keepdims=True)
        solids: tuple[Box | Sphere, ...] = (*self.boxes, *self.spheres)
        centre = np.array([each.position for each in solids], dtype=np.float64)
        rotation = matrix_from_quaternion(turn)
        return kind, size.reshape(-1, 3), rotation, centre.reshape(-1, 3)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """Read the plain form, that of YAML: keys are the names of the attributes.

        Raises:
            ObstacleError: A key is unknown or missing, or a value cannot be.
        """
        _check_keys("obstacles", values, cls)
        parts: dict[str, Any] = dict(values)
        for name, kind in (("boxes", Box), ("spheres", Sphere)):
            entries = parts.get(name) or ()
            if not isinstance(entries, Sequence) or isinstance(entries, str):
                raise ObstacleError(f"{name}: expected a list, got {entries!r}")
            for entry in entries:
                _check_keys(name, entry, kind)
            try:
                parts[name] = tuple(kind(**entry) for entry in entries)
            except TypeError as error:
                raise ObstacleError(f"{name}: {error}") from error
        return cls(**parts)

    @classmethod
    def from_yaml(cls, path: str | Path) -> Self:
        """Read a YAML file, see `from_dict`.

        Raises:
            ObstacleError: There is none, or it says something else.
        """
        try:
            values = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
            raise ObstacleError(f"{path}: {' '.join(str(error).split())}") from error
        return cls.from_dict(values)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read what `to_json` wrote."""
        return cls.from_dict(json.loads(text))

    def to_json(self) -> str:
        """Return the plain form in one line."""
        return json.dumps(asdict(self), separators=(",", ":"))


class ObstacleRows(NamedTuple):
    """Sets of obstacles for N configurations as arrays for compiled code.

    Attributes:
        kind: (T,) BOX or SPHERE.
        size: (T, 3) half edges, or the radius [m].
        poses: (T, 12) rotation row by row, then the centre, in the root's frame [m].
        radius: (T,) of the sphere around the centre that holds it [m].
        first: (N,) row of the first obstacle of each configuration, and
        number: (N,) how many it has.
        clearance: (N,) least distance from them [m].
    """

    kind: NDArray[np.int64]
    size: Array
    poses: Array
    radius: Array
    first: NDArray[np.int64]
    number: NDArray[np.int64]
    clearance: Array


def each_obstacles(
    obstacles: Obstacles | Sequence[Obstacles] | None, count: int
) -> list[Obstacles]:
    """Return one set for each of `count` poses: the same for all, or those given.

    Raises:
        ObstacleError: As many sets as poses were expected, or something else was given.
    """
    if isinstance(obstacles, Obstacles):
        return [obstacles] * count
    given: list[Any] = list(obstacles) if isinstance(obstacles, Iterable) else [obstacles]
    sets = [each for each in given if isinstance(each, Obstacles)]
    if len(sets) != len(given):
        raise ObstacleError("expected Obstacles(boxes=..., spheres=...), or one for each pose")
    if len(sets) != count:
        raise ObstacleError(f"expected one Obstacles for all poses or {count}, got {len(sets)}")
    return sets


def obstacle_rows(sets: Sequence[Obstacles], base: Array) -> ObstacleRows:
    """Return sets of obstacles as arrays; a set that is given again takes no further rows.

    Args:
        sets: One for each configuration, at least one.
        base: (4, 4) pose of the base in the root's frame [m].
    """
    distinct = list({id(each): each for each in sets}.values())
    starts = np.cumsum([0, *map(len, distinct)])
    place = {id(each): start for each, start in zip(distinct, starts[:-1], strict=True)}
    kind, size, rotation, centre = (
        np.concatenate(parts) for parts in zip(*(each.arrays for each in distinct), strict=True)
    )
    turned = base[:3, :3] @ rotation
    carried = centre @ base[:3, :3].T + base[:3, 3]
    return ObstacleRows(
        kind,
        size,
        np.concatenate([turned.reshape(-1, 9), carried], axis=1),
        np.linalg.norm(size, axis=1),
        np.array([place[id(each)] for each in sets], dtype=np.int64),
        np.array([len(each) for each in sets], dtype=np.int64),
        np.array([each.clearance_m for each in sets], dtype=np.float64),
    )


def _tuple(owner: Any, name: str, count: int) -> tuple[float, ...]:
    """Replace an attribute by a tuple of so many finite numbers."""
    values = as_floats(getattr(owner, name), name, ObstacleError)
    if values.shape != (count,) or not np.isfinite(values).all():
        raise ObstacleError(f"expected {name} as {count} finite numbers, got {values.tolist()}")
    plain = tuple(float(value) for value in values)
    object.__setattr__(owner, name, plain)
    return plain


def _check_keys(what: str, values: object, kind: type) -> None:
    known = [field.name for field in fields(kind)]
    if not isinstance(values, Mapping):
        raise ObstacleError(f"{what}: expected a mapping of {', '.join(known)}, got {values!r}")
    for key in values:
        if key not in known:
            raise ObstacleError(f"{what}: " + unknown_name("key", str(key), known))
