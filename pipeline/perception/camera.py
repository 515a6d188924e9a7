"""A robot's head camera in simulation: its calibrated pose, its actual pose, and its images."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pybullet
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import PerceptionError
from pipeline.perception.config import CalibrationErrorConfig, EyeConfig, PerturbationConfig
from pipeline.perception.pinhole import Pinhole
from robots.rotations import matrix_from_axis_angle, matrix_from_rpy
from robots.urdf_writer import joint_motion

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]
Image = NDArray[np.uint8]


class EyeCamera:
    """The head camera of a robot.

    What it projects with is what the robot believes; perturbation and calibration error move the
    camera that the picture is taken with, which the robot does not know.

    Attributes:
        believed: The camera as calibrated.
        actual: The camera that takes the picture.
        config: How the picture is rendered, the perturbed light included.
    """

    def __init__(
        self,
        robot: Robot,
        config: EyeConfig,
        perturbation: PerturbationConfig | None = None,
        calibration_error: Array | None = None,
    ) -> None:
        """Mount the camera.

        Args:
            robot: Its description has the mount and the lens.
            config: How the picture is rendered.
            perturbation: Errors of mount and light; none if not given. Its distractors are laid
                together with the objects, see `lay_distractors`.
            calibration_error: Further transform of the mount, in the camera's frame, shape (4, 4);
                see `drawn_offset`.

        Raises:
            PerceptionError: The robot has no camera, or it hangs on a joint of the chain.
        """
        self.believed = mounted(robot)
        self.actual, self.config = self.believed, config
        if perturbation is not None:
            pose = self.believed.pose @ _offset(perturbation.shift, perturbation.tilt)
            self.actual = replace(self.believed, pose=pose)
            self.config = dimmed(config, perturbation.lighting)
        if calibration_error is not None:
            self.actual = replace(self.actual, pose=self.actual.pose @ calibration_error)

    def picture(self, client: Any) -> Image:
        """Take a picture of the simulated world, whose frame is the robot's base.

        Args:
            client: PyBullet client.

        Returns:
            Red, green, blue, shape (height, width, 3).
        """
        return take_picture(client, self.actual, self.config)[0]

    def project(self, pixels: ArrayLike, height: ArrayLike) -> Array:
        """Places of pixels (N, 2) on a level plane of a height [m], (N, 3), base frame.

        Raises:
            PerceptionError: A pixel does not look at the plane.
        """
        return self.believed.project(pixels, height)

    def pixels_of(self, points: ArrayLike) -> Array:
        """Pixels (N, 2) of points (N, 3) in the base frame [m], through the believed camera."""
        return self.believed.pixels_of(points)


def drawn_offset(config: CalibrationErrorConfig, seed: int) -> Array:
    """Draw the error of an extrinsic calibration: any direction, about any axis.

    Args:
        config: How far [m] and by which angle [rad].
        seed: Of direction and axis.

    Returns:
        Homogeneous transform of the camera, in its own frame, shape (4, 4).
    """
    normal = np.random.default_rng(seed).normal(size=(2, 3))
    direction, axis = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    pose = np.eye(4)
    pose[:3, 3] = config.translation * direction
    pose[:3, :3] = matrix_from_axis_angle(axis, config.rotation)
    return pose


def mounted(robot: Robot) -> Pinhole:
    """The camera of a robot's description, in the base frame.

    Raises:
        PerceptionError: There is none, or it hangs on a joint of the chain and so is never still.
    """
    camera = robot.description.camera
    if camera is None:
        raise PerceptionError(
            f"robot '{robot.name}' has no camera: its robot.yaml needs the key `camera`, see "
            "robots/nico/robot.yaml"
        )
    posture = robot.description.posture
    pose = np.eye(4)
    for joint in robot.urdf.path_between(robot.base, camera.link):
        if joint.name in robot.joint_names:
            raise PerceptionError(
                f"the camera of '{robot.name}' hangs on {joint.name}, a joint of its chain: "
                "expected a link that stands still, such as the head"
            )
        pose = pose @ joint.origin
        if joint.movable:
            pose = pose @ joint_motion(joint, posture.get(joint.name, 0.0))
    pose = pose @ _offset(camera.position, camera.rotation)
    return Pinhole.from_view(pose, camera.field_of_view, camera.width, camera.height)


def take_picture(
    client: Any, camera: Pinhole, config: EyeConfig, mask: bool = False
) -> tuple[Image, NDArray[np.int32] | None]:
    """Render what a camera sees, by the software renderer.

    Args:
        client: PyBullet client.
        camera: Where it is and its lens.
        config: Light and background.
        mask: Whether to return the body of each pixel as well.

    Returns:
        Red, green, blue (height, width, 3), and PyBullet's number of body and link at each pixel
        (height, width), see `body_and_link`; None if not requested.
    """
    flags = pybullet.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX if mask else 0
    _, _, colours, depth, bodies = client.getCameraImage(
        camera.width,
        camera.height,
        camera.view_matrix(),
        camera.projection_matrix(config.near, config.far),
        lightDirection=list(config.light),
        lightAmbientCoeff=config.ambient,
        lightDiffuseCoeff=config.diffuse,
        lightSpecularCoeff=config.specular,
        shadow=int(config.shadow),
        renderer=pybullet.ER_TINY_RENDERER,
        flags=flags or pybullet.ER_NO_SEGMENTATION_MASK,
    )
    shape = (camera.height, camera.width)
    image = np.reshape(np.asarray(colours, dtype=np.uint8), (*shape, 4))[:, :, :3].copy()
    image[np.reshape(np.asarray(depth), shape) >= 1.0] = config.background
    if not mask:
        return image, None
    return image, np.reshape(np.asarray(bodies, dtype=np.int32), shape)


def body_and_link(numbers: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Take the numbers of a mask apart: the body, -1 where there is none, and its link.

    PyBullet writes body + (link + 1) * 2^24 (its quickstart guide, getCameraImage).
    """
    seen = numbers >= 0
    bodies = np.where(seen, numbers & ((1 << 24) - 1), -1).astype(np.int32)
    return bodies, np.where(seen, (numbers >> 24) - 1, -2).astype(np.int32)


def dimmed(config: EyeConfig, lighting: float) -> EyeConfig:
    """Turn the light about the vertical by 180 deg and halve it, or a share of that."""
    turn, x, y = np.pi * lighting, config.light[0], config.light[1]
    light = [
        float(np.cos(turn) * x - np.sin(turn) * y),
        float(np.sin(turn) * x + np.cos(turn) * y),
        config.light[2],
    ]
    left = 1.0 - 0.5 * lighting
    return replace(
        config, light=light, ambient=left * config.ambient, diffuse=left * config.diffuse
    )


def _offset(position: ArrayLike, rotation: ArrayLike) -> Array:
    """Homogeneous transform (4, 4) of a position [m] and roll, pitch, yaw [deg]."""
    pose = np.eye(4)
    pose[:3, 3] = np.asarray(position, dtype=np.float64)
    pose[:3, :3] = matrix_from_rpy(np.deg2rad(np.asarray(rotation, dtype=np.float64)))
    return pose
