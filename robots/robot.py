"""A robot as the rest of the project sees it: kinematics, limits, collision, samples."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robots import kinematics
from robots.arguments import as_floats, shown
from robots.bodies import Bodies, build_bodies, link_poses
from robots.chain import Chain, Drive, build_chain, chain_joints, drives, followers
from robots.clearance import ClearanceChecker
from robots.collision import CollisionChecker, checked_pairs, find_allowed_pairs
from robots.description import Description, available_robots, find_description
from robots.errors import RobotError, UnknownRobotError
from robots.limits import (
    FARTHEST,
    check_names,
    choose_home,
    narrow,
    nearest_turns,
    search_range,
)
from robots.pinocchio_model import chain_model
from robots.sampling import sample_configurations
from robots.threads import forked
from robots.urdf import Urdf
from robots.urdf_reader import read_urdf

if TYPE_CHECKING:
    import torch

Array = NDArray[np.float64]

# Random configurations behind what is found out rather than given: allowed pairs, reach.
PAIR_SAMPLES = 300
REACH_SAMPLES = 20_000


class Robot:
    """A kinematic chain from a base to a tip, on a body that stands still.

    Joint arrays are (N, dof) or (dof,), base to tip, in rad (m for a sliding joint).

    Attributes:
        description: What `robot.yaml` says.
        urdf: The checked URDF.
        name: Name of the robot.
        base: Link whose frame poses are given in.
        tip: Link whose pose is meant by "the pose".
        joint_names: Independent joints of the chain.
        dof: Number of independent joints.
        lower: (dof,) joint limits, rad or m; of a joint that turns for ever, one full turn.
        upper: (dof,) joint limits, rad or m.
        endless: (dof,) which joints turn for ever.
        velocity_limit: (dof,) rad/s or m/s, infinite where unknown.
        home: (dof,) idle configuration.
        chain: The chain as plain arrays for compiled code.
    """

    def __init__(self, description: Description, urdf: Urdf | None = None) -> None:
        """Read and check the URDF and what the description adds to it.

        Args:
            description: From `robot.yaml` or made by `load_robot`.
            urdf: Its URDF, where it was read already.

        Raises:
            UrdfError: If the URDF cannot be used.
            DescriptionError: If the description contradicts the URDF.
        """
        self.description = description
        self.name = description.name
        self.base, self.tip = description.base, description.tip
        self.urdf: Urdf = read_urdf(description.urdf) if urdf is None else urdf
        joints = chain_joints(self.urdf, self.base, self.tip)
        joints = [joint for joint in joints if joint.name not in description.posture]
        self.joint_names = tuple(joint.name for joint in joints)
        self.dof = len(joints)
        check_names(description, self.urdf, self.joint_names)
        self.lower = np.array([joint.lower for joint in joints])
        self.upper = np.array([joint.upper for joint in joints])
        self.velocity_limit = np.array([joint.velocity for joint in joints])
        self.endless = narrow(description, joints, self.lower, self.upper)
        self.home = choose_home(description, self.lower, self.upper)
        self._drives: dict[str, Drive] = drives(
            self.urdf, list(self.joint_names), description.posture
        )
        self._range = search_range(self.lower, self.upper, self.endless)
        self.chain: Chain = self.chain_to(self.tip)

    def __reduce__(self) -> tuple[type[Robot], tuple[Description, Urdf]]:
        """Pickle what was read: no file is needed again, and C++ objects are made anew."""
        return (Robot, (self.description, self.urdf))

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, dof={self.dof}, {self.base} to {self.tip})"

    def chain_to(self, link: str) -> Chain:
        """The chain from the base to another link; an UrdfError if none is below the base."""
        return build_chain(self.urdf, self.base, link, *self._range, self._drives)

    def followers(self) -> list[str]:
        """What becomes of the coupled joints between base and tip, one sentence each."""
        return followers(self.urdf, self.base, self.tip, self._drives)

    @property
    def urdf_path(self) -> Path:
        """The URDF file."""
        return self.urdf.path

    @property
    def urdf_checksum(self) -> str:
        """The sha256 of the URDF file, hexadecimal."""
        return self.urdf.checksum

    @cached_property
    def workspace(self) -> Array:
        """(2, 3) lower and upper corner of the tip's box in the base frame, m.

        The description's, else the reach of uniform samples (collisions not considered).
        """
        if self.description.workspace is not None:
            return self.description.workspace
        samples = self.sample(REACH_SAMPLES, collision_free=False)
        position = self.forward_kinematics(samples)[:, :3]
        return np.stack([position.min(axis=0), position.max(axis=0)])

    @cached_property
    def sliding(self) -> NDArray[np.bool_]:
        """(dof,) which joints slide."""
        found = np.zeros(self.dof, dtype=bool)
        found[self.chain.variable[self.chain.prismatic]] = True
        return found

    def link_poses(self, joints: ArrayLike) -> dict[str, Array]:
        """Pose (4, 4) of every link in the root's frame for one configuration (dof,), m."""
        return link_poses(self.urdf, self.positions(joints))

    @cached_property
    def bodies(self) -> Bodies:
        """All links and the driven joints they hang on."""
        return build_bodies(self.urdf, self._drives)

    def positions(self, joints: ArrayLike) -> dict[str, float]:
        """Position of every joint of the robot for one configuration, coupled ones included.

        Args:
            joints: (dof,) rad or m.

        Returns:
            Joint name to position, rad or m.
        """
        q = self.as_joints(joints)[0]
        return {
            name: float(drive.multiplier * q[drive.variable] + drive.offset)
            for name, drive in self._drives.items()
        }

    def within_limits(self, joints: ArrayLike, slack: float = 0.0) -> NDArray[np.bool_]:
        """Whether configurations keep every joint within its limits, (N,).

        Args:
            joints: (N, dof) or (dof,); a joint that turns for ever may be anywhere.
            slack: How far beyond a limit is still taken for rounding, rad or m.
        """
        q = self.as_joints(joints)
        inside = (q >= self.lower - slack) & (q <= self.upper + slack)
        return np.asarray((inside | self.endless).all(axis=1))

    def nearest_turns(self, joints: Array, near: Array | None = None) -> Array:
        """Turn joints that turn for ever by full turns, nearest to a reference.

        Args:
            joints: (N, dof), rad or m.
            near: (dof,) or (N, dof) reference; the middle of the limits if not given, so that the
                result is within them.
        """
        if not self.endless.any():
            if near is not None:
                return joints
            return np.minimum(np.maximum(joints, self.lower), self.upper)
        middle = (self.lower + self.upper) / 2
        reference = middle if near is None else near
        turned = nearest_turns(joints, reference, self.endless, self.lower, self.upper)
        return turned if near is not None else np.clip(turned, self.lower, self.upper)

    @cached_property
    def collision(self) -> CollisionChecker:
        """Collision checker over the pairs that are not allowed to touch.

        Raises:
            UrdfError: A collision shape cannot be used.
        """
        self.urdf.require_shapes("collision")
        allowed = self.description.allowed_collisions
        if allowed is None:
            allowed = tuple(self.find_allowed_collisions())
        pairs = checked_pairs(self.urdf, self.bodies, allowed)
        return CollisionChecker(self.urdf, self.bodies, self._drives, pairs)

    @cached_property
    def clearance(self) -> ClearanceChecker:
        """Distances of the links that move from obstacles."""
        return ClearanceChecker(self)

    def find_allowed_collisions(self) -> list[tuple[str, str, str]]:
        """Find the pairs that are adjacent or always touch: what `robot.yaml` may list."""
        self.urdf.require_shapes("collision")
        samples = self.sample(PAIR_SAMPLES, collision_free=False)
        return find_allowed_pairs(self.urdf, self.bodies, self._drives, samples)

    def forward_kinematics(self, joints: ArrayLike, parallel: bool = False) -> Array:
        """Poses of the tip in the base frame.

        Args:
            joints: (N, dof) or (dof,).
            parallel: Use all threads of numba; the result is the same.

        Returns:
            (N, 7) x y z in m, then the unit quaternion qw qx qy qz with qw >= 0.
        """
        threads = parallel and not forked()
        return kinematics.forward_kinematics(self.chain, self.as_joints(joints), threads)

    def jacobian(self, joints: ArrayLike) -> Array:
        """Geometric Jacobians at the tip, in axes of the base, linear rows first.

        Args:
            joints: (N, dof) or (dof,).

        Returns:
            (N, 6, dof) in m or m/rad, and rad/m or 1.
        """
        return kinematics.poses_and_jacobians(self.chain, self.as_joints(joints))[1]

    def in_collision(self, joints: ArrayLike) -> NDArray[np.bool_]:
        """Whether any pair of links that is not allowed to touch does, (N,)."""
        return self.collision.in_collision(self.as_joints(joints))

    def sample(
        self, n: int, seed: int = 0, collision_free: bool = True, workspace_filter: bool = False
    ) -> Array:
        """Uniform configurations within the limits, (n, dof).

        Args:
            n: How many.
            seed: Any non-negative integer.
            collision_free: Drop configurations in collision.
            workspace_filter: Drop those whose tip is outside `workspace`.
        """
        return sample_configurations(self, n, seed, collision_free, workspace_filter).joints

    def pinocchio(self) -> tuple[Any, int]:
        """Pinocchio model of the chain, joints in our order, and the id of the tip's frame."""
        return chain_model(self.urdf, self._drives, self.base, self.tip)

    def torch_chain(self, dtype: torch.dtype | None = None, device: str = "cpu") -> Any:
        """Build the chain for pytorch-kinematics; `forward_kinematics` takes (N, dof) tensors.

        Args:
            dtype: Floating-point type, float32 if not given.
            device: Torch device.
        """
        import torch

        from robots.torch_chain import build_torch_chain

        return build_torch_chain(self, dtype or torch.float32, device)

    def as_joints(self, joints: ArrayLike) -> Array:
        """Check and convert joints to a contiguous float64 array (N, dof).

        Raises:
            RobotError: If they are no finite numbers within `limits.FARTHEST`, the last axis is
                not dof long, or the array has other than 1 or 2 axes.
        """
        array = as_floats(joints, f"joints of '{self.name}'", RobotError)
        if array.ndim == 1 and array.size:
            array = array[None, :]
        if array.ndim != 2 or array.shape[1] != self.dof:
            raise RobotError(
                f"'{self.name}' expects joints of the shape (N, {self.dof}), got {array.shape}"
            )
        if not (np.abs(array) <= FARTHEST).all():
            row = int(np.argmin((np.abs(array) <= FARTHEST).all(axis=1)))
            raise RobotError(
                f"'{self.name}' expects finite joints within {FARTHEST:g} rad or m, got "
                f"{array[row].tolist()} in row {row}"
            )
        return array


def load_robot(
    name: str | None = None,
    *,
    urdf: str | Path | None = None,
    base: str | None = None,
    tip: str | None = None,
) -> Robot:
    """Load one of the robots under `robots/` by name, or any other from its URDF.

    Args:
        name: One of `available_robots()`.
        urdf: A URDF file, instead of a name.
        base: With `urdf`: link whose frame poses are given in; the root if not given.
        tip: With `urdf`: link whose pose is wanted; may be left out if the tree has one end.

    Raises:
        UnknownRobotError: If there is no such robot.
        UrdfError: If the URDF cannot be used.
        RobotError: If neither or both of name and URDF are given.
    """
    if (name is None) == (urdf is None):
        raise RobotError("give either the name of a robot or urdf=, base= and tip=")
    if name is not None:
        if not isinstance(name, str):
            raise UnknownRobotError(f"expected the name of a robot, got {shown(name)}")
        if base is not None or tip is not None:
            raise RobotError(
                f"base and tip of '{name}' stand in its robot.yaml; give urdf= instead"
            )
        return Robot(find_description(name))
    assert urdf is not None
    parsed = read_urdf(urdf)
    for role, link in (("base", base), ("tip", tip)):
        if not isinstance(link, str | None):
            raise RobotError(f"expected {role}= to be the name of a link, got {shown(link)}")
    tip = tip or _only_end(parsed)
    title = parsed.name.replace("_", " ")
    path = Path(urdf).absolute()  # the robot may go to a process that runs elsewhere
    name = parsed.name
    while name in available_robots():
        name += "_from_urdf"  # weights and results go by name, and those are of another robot
    description = Description(name, title, path, base or parsed.root, tip)
    return Robot(description, replace(parsed, path=path))


def _only_end(urdf: Urdf) -> str:
    parents = {joint.parent for joint in urdf.joints.values()}
    ends = [link for link in urdf.links if link not in parents]
    if len(ends) != 1:
        raise RobotError(f"{urdf.path}: give tip=, one of the links; ends are {', '.join(ends)}")
    return ends[0]
