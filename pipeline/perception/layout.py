"""Random layouts of a table: which objects lie where, under which light, before which camera."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from pipeline.grasping.config import ObjectConfig, SceneConfig
from pipeline.perception.config import DomainConfig, EyeConfig
from pipeline.perception.pinhole import Pinhole
from robots.rotations import matrix_from_axis_angle

Array = NDArray[np.float64]
Colour = tuple[float, float, float]
TRIES = 60  # draws of a place before an object is left out


@dataclass(frozen=True)
class Laid:
    """An object on the table.

    Attributes:
        name: Its class.
        place: x and y of its centre, base frame [m].
        yaw: About the vertical [rad].
    """

    name: str
    place: tuple[float, float]
    yaw: float


def lay_out(
    draw: Generator, domain: DomainConfig, scene: SceneConfig, objects: dict[str, ObjectConfig]
) -> list[Laid]:
    """Draw which objects of a scene's set lie where; none in a bin, none upon another.

    Args:
        draw: Random numbers.
        domain: Reach beyond the action area, least gap, chance of being absent.
        scene: Set of objects, action area and bins.
        objects: Shapes of the objects.
    """
    laid: list[Laid] = []
    low, high = np.transpose([scene.area.x, scene.area.y])
    names = draw.permutation([name for name in scene.objects if draw.random() >= domain.absent])
    for name in names:
        radius = footprint(objects[name])
        for _ in range(TRIES):
            place = draw.uniform(low - domain.reach, high + domain.reach)
            if _free(place, radius, laid, domain, scene, objects):
                yaw = float(draw.uniform(-np.pi, np.pi))
                laid.append(Laid(str(name), (float(place[0]), float(place[1])), yaw))
                break
    return laid


def _free(
    place: Array,
    radius: float,
    laid: list[Laid],
    domain: DomainConfig,
    scene: SceneConfig,
    objects: dict[str, ObjectConfig],
) -> bool:
    for other in laid:
        least = radius + footprint(objects[other.name]) + domain.gap
        if np.hypot(*(place - other.place)) < least:
            return False
    for box in scene.bins.values():
        outside = np.abs(place - box.centre) - 0.5 * np.array(box.size[:2])
        if np.hypot(*np.maximum(outside, 0.0)) < radius + domain.gap:
            return False
    return True


def footprint(obj: ObjectConfig) -> float:
    """Radius of the circle about an object's centre that holds its parts' middles and girths [m].

    The ends of a long part stick out of it: two bananas may lie closer than a circle about each.
    """
    reaches = [0.5 * obj.height]
    for part in obj.parts:
        girth = part.size[0] if part.shape != "box" else 0.5 * max(part.size[:2])
        reaches.append(float(np.linalg.norm(part.position[:2])) + girth)
    return max(reaches)


def between(draw: Generator, ends: Sequence[float]) -> float:
    """Draw a number between two ends."""
    low, high = ends
    return float(draw.uniform(low, high))


def moved(draw: Generator, domain: DomainConfig, camera: Pinhole) -> Pinhole:
    """Turn a camera about a random axis and move it in a random direction, within the domain."""
    pose = camera.pose.copy()
    axis, direction = (vector / np.linalg.norm(vector) for vector in draw.normal(size=(2, 3)))
    angle = np.deg2rad(between(draw, domain.tilt))
    pose[:3, :3] = pose[:3, :3] @ matrix_from_axis_angle(axis, angle)
    pose[:3, 3] += between(draw, domain.shift) * direction
    return replace(camera, pose=pose)


def lit(draw: Generator, domain: DomainConfig, eye: EyeConfig) -> EyeConfig:
    """Draw direction and strength of the light."""
    azimuth, elevation = np.deg2rad(
        [between(draw, domain.azimuth), between(draw, domain.elevation)]
    )
    light = [
        float(np.cos(azimuth) * np.cos(elevation)),
        float(np.sin(azimuth) * np.cos(elevation)),
        float(np.sin(elevation)),
    ]
    ambient, diffuse = between(draw, domain.ambient), between(draw, domain.diffuse)
    return replace(eye, light=light, ambient=ambient, diffuse=diffuse)


def colour(draw: Generator, domain: DomainConfig) -> Colour:
    """Draw a colour of the surroundings: red, green, blue of 0 to 1."""
    return _colour(draw, domain.hue, domain.saturation, domain.value)


def distractor_colour(draw: Generator, domain: DomainConfig) -> Colour:
    """Draw a colour of an object of no class: red, green, blue of 0 to 1."""
    return _colour(draw, domain.distractor_hue, domain.distractor_saturation, domain.value)


def _colour(draw: Generator, *ends: Sequence[float]) -> Colour:
    hue, saturation, value = (between(draw, each) for each in ends)
    return colorsys.hsv_to_rgb(hue, saturation, value)
