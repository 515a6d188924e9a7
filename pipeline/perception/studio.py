"""A robot's table as a photo studio: random layouts, lights and cameras, with labels for free."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from pipeline.grasping.config import GraspConfig
from pipeline.grasping.scene import Scene
from pipeline.grasping.shapes import make_object
from pipeline.grasping.trial import required_scene
from pipeline.perception.camera import body_and_link, mounted, take_picture
from pipeline.perception.config import DomainConfig, EyeConfig
from pipeline.perception.distractors import lay_distractors
from pipeline.perception.layout import (
    Laid,
    between,
    colour,
    distractor_colour,
    lay_out,
    lit,
    moved,
)
from pipeline.perception.pinhole import Pinhole
from pipeline.perception.textures import pattern

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
ATTEMPTS = 8  # layouts drawn before one with hidden objects is taken without their labels
FLOOR = 0.7  # m below the table's top: the plane that the pattern of the surroundings lies on


@dataclass(frozen=True)
class Label:
    """What is true of one object in a picture.

    Attributes:
        name: Its class.
        box: x0, y0, x1, y1 around its visible pixels.
        centroid: u, v of its centre [pixels].
        position: x, y, z of its centre, base frame [m].
    """

    name: str
    box: tuple[float, float, float, float]
    centroid: tuple[float, float]
    position: tuple[float, float, float]


@dataclass(frozen=True)
class Shot:
    """A picture, the camera that took it, and its labels."""

    image: Image
    camera: Pinhole
    labels: list[Label]


class Studio:
    """One robot at its table, idle, for many pictures.

    Attributes:
        scene: The simulated world; its objects come and go, no time passes in it.
    """

    def __init__(self, robot: Robot, grasp: GraspConfig, eye: EyeConfig, visible: float) -> None:
        """Build table, bins and robot.

        Args:
            robot: Its description has the camera.
            grasp: Scenes and objects.
            eye: How pictures are rendered where the domain does not say.
            visible: Least visible share of a disc of an object's height.
        """
        self.scene = Scene(robot, required_scene(grasp, robot.name), grasp.physics)
        self._objects, self._eye, self._visible = grasp.objects, eye, visible
        self._camera = mounted(robot)
        self._fixed = self._bodies()
        self._table = self._find_table()

    def __enter__(self) -> Studio:
        return self

    def __exit__(self, *problem: object) -> None:
        self.scene.__exit__(*problem)

    def shoot(self, draw: Generator, domain: DomainConfig, size: tuple[int, int]) -> Shot:
        """Take a picture of a random layout.

        Args:
            draw: Random numbers; they fix everything.
            domain: What to draw from.
            size: Width and height of the picture [pixels]; the view stays that of the eye.
        """
        for _ in range(ATTEMPTS - 1):
            shot, hidden = self._attempt(draw, domain, size)
            if not hidden:
                return shot
        return self._attempt(draw, domain, size)[0]

    def photograph(self, laid: list[Laid], camera: Pinhole, eye: EyeConfig) -> Shot:
        """Take a picture of a given layout, without surroundings or distractors drawn."""
        bodies = self._lay(laid)
        try:
            image, pixels = take_picture(self.scene.client, camera, eye, mask=True)
            assert pixels is not None
            labels = self._labels(bodies, body_and_link(pixels)[0], camera)[0]
        finally:
            self._clear()
        return Shot(image, camera, labels)

    def _attempt(
        self, draw: Generator, domain: DomainConfig, size: tuple[int, int]
    ) -> tuple[Shot, bool]:
        camera = _resized(moved(draw, domain, self._camera), size)
        laid = lay_out(draw, domain, self.scene.config, self._objects)
        bodies = self._lay(laid)
        try:
            count = int(draw.integers(domain.distractors[0], domain.distractors[1] + 1))
            lay_distractors(
                self.scene.client,
                self.scene.config,
                count,
                draw,
                [obj.place for obj in laid],
                lambda: distractor_colour(draw, domain),
            )
            self._paint(draw, domain)
            eye = lit(draw, domain, self._eye)
            image, pixels = take_picture(self.scene.client, camera, eye, mask=True)
            assert pixels is not None
            numbers, links = body_and_link(pixels)
            labels, hidden = self._labels(bodies, numbers, camera)
        finally:
            self._clear()
        table = (numbers == self._table[0]) & (links == self._table[1])
        image = _patterned(draw, domain, image, table, numbers < 0, camera, self._height)
        return Shot(image, camera, labels), hidden

    @property
    def _height(self) -> float:
        return self.scene.config.table.height

    def _lay(self, laid: list[Laid]) -> list[tuple[int, str]]:
        client = self.scene.client
        return [
            (make_object(client, self._objects[t.name], t.place, t.yaw, self._height), t.name)
            for t in laid
        ]

    def _labels(
        self, bodies: list[tuple[int, str]], numbers: NDArray[np.int32], camera: Pinhole
    ) -> tuple[list[Label], bool]:
        """Labels of the objects that are seen well, and whether one is not."""
        labels, hidden = [], False
        for body, name in bodies:
            position = np.array(self.scene.client.getBasePositionAndOrientation(body)[0])
            rows, columns = np.nonzero(numbers == body)
            u, v = camera.pixels_of(position)[0]
            distance = float(np.linalg.norm(position - camera.pose[:3, 3]))
            disc = 0.25 * np.pi * (camera.focal * self._objects[name].height / distance) ** 2
            inside = 0.0 <= u <= camera.width and 0.0 <= v <= camera.height
            if not inside or len(rows) < self._visible * disc:
                hidden = True
                continue
            box = (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
            x0, y0, x1, y1 = (float(side) for side in box)
            x, y, z = (float(number) for number in position)
            labels.append(Label(name, (x0, y0, x1, y1), (float(u), float(v)), (x, y, z)))
        return labels, hidden

    def _paint(self, draw: Generator, domain: DomainConfig) -> None:
        """Give table and bins colours of the domain; the bins keep one colour all over."""
        client, (table, link) = self.scene.client, self._table
        client.changeVisualShape(table, link, rgbaColor=[*colour(draw, domain), 1.0])
        bins = [*colour(draw, domain), 1.0]
        for body in self._fixed:
            if body not in (table, self.scene.body):
                client.changeVisualShape(body, -1, rgbaColor=bins)

    def _bodies(self) -> list[int]:
        client = self.scene.client
        return [client.getBodyUniqueId(index) for index in range(client.getNumBodies())]

    def _clear(self) -> None:
        for body in self._bodies():
            if body not in self._fixed:
                self.scene.client.removeBody(body)

    def _find_table(self) -> tuple[int, int]:
        """Body and link whose top is the table's: the widest that ends at that height."""
        client = self.scene.client
        best, widest = (-2, -2), 0.0
        for body in self._fixed:
            for link in range(-1, client.getNumJoints(body)):
                if not client.getCollisionShapeData(body, link):
                    continue
                low, high = np.array(client.getAABB(body, link))
                area = float(np.prod(high[:2] - low[:2]))
                if abs(high[2] - self._height) < 0.01 and area > widest:
                    best, widest = (body, link), area
        return best


def _resized(camera: Pinhole, size: tuple[int, int]) -> Pinhole:
    focal = camera.focal * size[1] / camera.height
    return replace(camera, focal=focal, width=size[0], height=size[1])


def _patterned(
    draw: Generator,
    domain: DomainConfig,
    image: Image,
    table: NDArray[np.bool_],
    nothing: NDArray[np.bool_],
    camera: Pinhole,
    height: float,
) -> Image:
    """Lay a pattern on the table and another, with a colour, on what lies beyond everything."""
    rows, columns = np.indices(table.shape)
    pixels = np.stack([columns + 0.5, rows + 0.5], axis=-1)
    shaded: Array = image.astype(np.float64)
    shaded[nothing] = 255.0 * np.array(colour(draw, domain))
    for where, plane in ((table, height), (nothing, height - FLOOR)):
        kind, contrast = str(draw.choice(list(domain.textures))), between(draw, domain.contrast)
        if where.any():
            points = camera.project(pixels[where], plane)[:, :2]
            shaded[where] *= 1.0 + contrast * pattern(draw, kind, points)[:, None]
    return np.clip(np.round(shaded), 0.0, 255.0).astype(np.uint8)
