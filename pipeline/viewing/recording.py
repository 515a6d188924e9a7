"""States of a grasp trial over time: the robot's joints and where the other bodies are."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pybullet
from numpy.typing import NDArray

from pipeline.grasping.video import Recorder
from robots.rotations import canonical
from robots.urdf import Shape

if TYPE_CHECKING:
    from pipeline.grasping.config import VideoConfig
    from pipeline.grasping.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """The world at one time.

    Attributes:
        time: Simulated time from the first frame [s].
        joints: Position of each movable joint of the robot by name [rad or m].
        bodies: Poses of the other bodies, world frame [m, quaternion w x y z], shape (K, 7).
    """

    time: float
    joints: dict[str, float]
    bodies: Array


@dataclass
class Recording:
    """What happened in a trial.

    Attributes:
        shapes: Primitives of each body besides the robot, in its frame; a capsule is a cylinder and
            two spheres.
        frames: The world, frame by frame.
        phases: Time at which each phase ended [s], and its name.
    """

    shapes: list[list[Shape]] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)
    phases: list[tuple[float, str]] = field(default_factory=list)

    @property
    def duration(self) -> float:
        """From the first frame to the last [s]."""
        return self.frames[-1].time if self.frames else 0.0

    def at(self, time: float) -> Frame:
        """The last frame that is not after a time [s]; the first one before all."""
        after = bisect_right(self.frames, time, key=lambda frame: frame.time)
        return self.frames[max(after - 1, 0)]

    def phase(self, time: float) -> str:
        """Name of the phase that a time [s] is in; empty after the last."""
        return next((name for end, name in self.phases if time < end), "")


class StateRecorder(Recorder):
    """Records the states of a trial, and its film where that is wanted.

    Attributes:
        recording: What has been recorded.
    """

    def __init__(
        self,
        config: VideoConfig,
        rate: float,
        film: bool,
        shown: Callable[[Recording, Frame], object] = lambda recording, frame: None,
    ) -> None:
        """Begin with nothing.

        Args:
            config: Size and rate of the film.
            rate: Frames of the recording a second of simulated time [Hz].
            film: Whether pictures are taken, too.
            shown: Called with each frame as it comes.
        """
        super().__init__(config)
        self.recording = Recording()
        self._rate, self._film, self._shown = rate, film, shown

    def attach(self, scene: Scene, begin_s: float = 0.0, end_s: float = math.inf) -> None:
        """Record a scene from now on.

        Args:
            scene: What to record; all bodies lie in it.
            begin_s: Simulated time before which nothing is recorded [s].
            end_s: Simulated time after which nothing is recorded [s].
        """
        if self._film:
            super().attach(scene, begin_s, end_s)
        client = scene.client
        others = [
            body
            for body in map(client.getBodyUniqueId, range(client.getNumBodies()))
            if body != scene.body
        ]
        self.recording.shapes = [body_shapes(client, body) for body in others]
        names = movable_joints(client, scene.body)
        start, due = max(scene.time_s, begin_s), max(scene.time_s, begin_s)
        film_step, film_phase = scene.on_step, scene.on_phase

        def on_step() -> None:
            nonlocal due
            if film_step is not None:
                film_step()
            if due <= scene.time_s <= end_s:
                due += 1.0 / self._rate
                frame = _frame(client, scene.body, names, others, scene.time_s - start)
                self.recording.frames.append(frame)
                self._shown(self.recording, frame)

        def on_phase(name: str) -> None:
            if film_phase is not None:
                film_phase(name)
            if begin_s <= scene.time_s <= end_s:
                self.recording.phases.append((scene.time_s - start, name))

        scene.on_step, scene.on_phase = on_step, on_phase


def movable_joints(client: Any, body: int) -> dict[str, int]:
    """Numbers of the joints of a body that move, by name."""
    infos = [client.getJointInfo(body, k) for k in range(client.getNumJoints(body))]
    return {info[1].decode(): info[0] for info in infos if info[2] != pybullet.JOINT_FIXED}


def body_shapes(client: Any, body: int) -> list[Shape]:
    """Primitives of a body without joints, in its frame, as shapes of a URDF.

    Args:
        client: PyBullet client.
        body: PyBullet's number of the body.
    """
    found: list[Shape] = []
    for _, _, kind, size, _, place, turn, colour, *_ in client.getVisualShapeData(body):
        origin = np.eye(4)
        origin[:3, :3] = np.reshape(pybullet.getMatrixFromQuaternion(turn), (3, 3))
        origin[:3, 3] = place
        found += _primitives(kind, size, origin, tuple(colour))
    return found


def _primitives(
    kind: int, size: tuple[float, ...], origin: Array, colour: tuple[float, ...]
) -> list[Shape]:
    """One shape of PyBullet, sizes as `getVisualShapeData` tells them: length before radius."""
    if kind == pybullet.GEOM_BOX:
        return [Shape("box", tuple(size), origin, colour=colour)]
    if kind == pybullet.GEOM_SPHERE:
        return [Shape("sphere", (size[0],), origin, colour=colour)]
    length, radius = size[0], size[1]
    cylinder = Shape("cylinder", (radius, length), origin, colour=colour)
    if kind == pybullet.GEOM_CYLINDER:
        return [cylinder]
    ends = []
    for side in (-0.5, 0.5):
        end = origin.copy()
        end[:3, 3] += side * length * origin[:3, 2]
        ends.append(Shape("sphere", (radius,), end, colour=colour))
    return [cylinder, *ends]


def _frame(client: Any, body: int, names: dict[str, int], others: list[int], time: float) -> Frame:
    states = client.getJointStates(body, [*names.values()])
    joints = {name: state[0] for name, state in zip(names, states, strict=True)}
    poses = np.array([[*sum(client.getBasePositionAndOrientation(each), ())] for each in others])
    poses = poses.reshape(-1, 7)
    turns = canonical(poses[:, [6, 3, 4, 5]])
    return Frame(time, joints, np.hstack([poses[:, :3], turns]))
