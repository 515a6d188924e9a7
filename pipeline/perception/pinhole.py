"""The pinhole model: points to pixels and pixels back to a plane.

Frames: the camera's frame has x along the line of sight, y to the left and z up in the picture, as
a link of a URDF would. Pixel u runs to the right and v down, from the picture's upper left corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import PerceptionError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pinhole:
    """A camera without distortion: square pixels, the principal point in the middle.

    Attributes:
        pose: (4, 4) of the camera's frame in the base frame, m.
        focal: Focal length [pixels].
        width: Of the picture [pixels].
        height: Of the picture [pixels].
    """

    pose: Array
    focal: float
    width: int
    height: int

    @classmethod
    def from_view(cls, pose: Array, field_of_view: float, width: int, height: int) -> Pinhole:
        """Make one from its vertical field of view [deg]."""
        focal = 0.5 * height / np.tan(0.5 * np.deg2rad(field_of_view))
        return cls(pose, float(focal), width, height)

    def pixels_of(self, points: ArrayLike) -> Array:
        """Project points to the picture.

        u = w/2 - f y/x, v = h/2 - f z/x with x, y, z in the camera's frame (Hartley and Zisserman,
        Multiple View Geometry, 2nd ed., section 6.1, in our axes).

        Args:
            points: (N, 3), base frame [m].

        Returns:
            (N, 2) u and v [pixels]; not a number for points that are not in front of the camera.
        """
        points = np.atleast_2d(np.asarray(points, dtype=np.float64))
        local = (points - self.pose[:3, 3]) @ self.pose[:3, :3]
        depth = np.where(local[:, 0] > 0.0, local[:, 0], np.nan)
        return np.stack(
            [
                0.5 * self.width - self.focal * local[:, 1] / depth,
                0.5 * self.height - self.focal * local[:, 2] / depth,
            ],
            axis=1,
        )

    def project(self, pixels: ArrayLike, height: ArrayLike) -> Array:
        """Project pixels back to a level plane.

        Args:
            pixels: (N, 2) u and v.
            height: z of the plane, base frame [m]: one for all, or (N,).

        Returns:
            (N, 3) points, base frame [m].

        Raises:
            PerceptionError: A pixel's ray does not meet the plane in front of the camera.
        """
        pixels = np.atleast_2d(np.asarray(pixels, dtype=np.float64))
        rays = np.stack(
            [
                np.full(len(pixels), self.focal),
                0.5 * self.width - pixels[:, 0],
                0.5 * self.height - pixels[:, 1],
            ],
            axis=1,
        )
        rays = rays @ self.pose[:3, :3].T
        eye = self.pose[:3, 3]
        drop = np.broadcast_to(np.asarray(height, dtype=np.float64), len(pixels)) - eye[2]
        with np.errstate(divide="ignore", invalid="ignore"):
            length = drop / rays[:, 2]
        if bad := np.flatnonzero(~(np.isfinite(length) & (length > 0.0))).tolist():
            (u, v), plane = pixels[bad[0]], drop[bad[0]] + eye[2]
            raise PerceptionError(
                f"pixel ({u:.1f}, {v:.1f}) does not look at the plane z = {plane:.3f} m from "
                f"{eye[2]:.3f} m: expected a pixel below the horizon and a plane below the eye"
            )
        points: Array = eye + length[:, None] * rays
        return points

    def view_matrix(self) -> list[float]:
        """The base frame seen from the camera in OpenGL's axes, column by column, (16,)."""
        axes = self.pose[:3, :3]
        rotation = np.stack([-axes[:, 1], axes[:, 2], -axes[:, 0]])  # right, up, backward
        view = np.eye(4)
        view[:3, :3] = rotation
        view[:3, 3] = -rotation @ self.pose[:3, 3]
        return [float(number) for number in view.T.reshape(-1)]

    def projection_matrix(self, near: float, far: float) -> list[float]:
        """OpenGL's perspective projection of this lens, column by column, (16,)."""
        matrix = np.zeros((4, 4))
        matrix[0, 0] = 2.0 * self.focal / self.width
        matrix[1, 1] = 2.0 * self.focal / self.height
        matrix[2, 2] = (near + far) / (near - far)
        matrix[2, 3] = 2.0 * near * far / (near - far)
        matrix[3, 2] = -1.0
        return [float(number) for number in matrix.T.reshape(-1)]
