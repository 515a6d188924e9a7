"""Ssik: analytical inverse kinematics, found by the chain's structure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.analytical import AnalyticalSolver
from baselines.transforms import pose_matrix

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

# It solves arms of six or seven turning joints; more have no closed form.
JOINTS = (6, 7)
# Two transforms are the same if no entry differs by more.
SAME = 1e-6


class Ssik(AnalyticalSolver):
    """`ssik.Manipulator`, the library's own for a known arm or made for the bare chain.

    Args:
        robot: The robot to solve for.
        solutions: Solutions asked of the library for each pose.
        prebuilt: Name of an arm that the library ships, taken where its kinematics are those of
            the robot but for the tool; many times as fast as one made for the chain.
        **checks: Tolerances, see `AnalyticalSolver`.
    """

    requires: ClassVar[tuple[str, ...]] = ("ssik",)

    def __init__(
        self, robot: Robot, *, solutions: int, prebuilt: str | None, **checks: Any
    ) -> None:
        super().__init__(robot, **checks)
        self.solutions = solutions
        known = _prebuilt(robot, prebuilt) if prebuilt else None
        self._arm, self._from_tip = known or (_manipulator(robot), np.eye(4))

    @classmethod
    def skip(cls, robot: Robot | None = None) -> str | None:
        """Skip chains of other than six or seven turning joints."""
        if robot is not None and (
            len(robot.chain.variable) != robot.dof
            or robot.dof not in JOINTS
            or robot.chain.prismatic.any()
        ):
            return f"ssik solves six or seven turning joints, {robot.name} is another chain"
        return super().skip(robot)

    def _candidates(self, target: Array, initial: Array) -> Array:
        flange = target @ self._from_tip
        found = self._arm.solve(flange, max_solutions=self.solutions, q_seed=initial)
        return np.array([solution.q for solution in found]).reshape(-1, self.robot.dof)


def _prebuilt(robot: Robot, name: str) -> tuple[Any, Array] | None:
    """A shipped arm and the transform from our tip to its end; None if it is not this robot."""
    import ssik

    arm = ssik.Manipulator.from_prebuilt(name)
    if arm.dof != robot.dof:
        return None
    share = np.linspace(0.4, 0.6, robot.dof)[None]
    joints = robot.lower + np.concatenate([share, share[:, ::-1]]) * (robot.upper - robot.lower)
    offsets = [
        np.linalg.inv(pose_matrix(pose)) @ arm.fk(q)
        for q, pose in zip(joints, robot.forward_kinematics(joints), strict=True)
    ]
    return (arm, offsets[0]) if np.allclose(offsets[0], offsets[1], atol=SAME) else None


def _manipulator(robot: Robot) -> Any:
    """The chain as ssik's description of an arm."""
    import ssik
    from ssik.internals import JointSpec, build_kinbody

    chain = robot.chain
    frames = np.tile(np.eye(4), (robot.dof + 1, 1, 1))
    frames[:, :3, :3], frames[:, :3, 3] = chain.rotations, chain.translations
    last = robot.dof - 1
    joints = [
        JointSpec(
            parent_link_T=frames[k],
            axis=np.array([0.0, 0.0, 1.0]),
            joint_type="revolute",
            child_link_T=frames[robot.dof] if k == last else None,
            name=robot.joint_names[k],
            limits=(float(robot.lower[k]), float(robot.upper[k])),
        )
        for k in range(robot.dof)
    ]
    return ssik.Manipulator(
        build_kinbody(joints, base_link_name=robot.base, ee_link_name=robot.tip)
    )
