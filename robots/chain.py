"""The kinematic chain from base to tip as plain arrays, ready for compiled code.

Every frame is turned so that its joint axis is z, which leaves forward kinematics exact and
makes each joint a rotation about z or a shift along z:

    T(q) = F[0] Z(q_0) F[1] Z(q_1) ... F[m-1] Z(q_m-1) F[m]

where `F[i]` is constant and folds the joint's origin, all fixed joints before it, and the turns
of both axes onto z.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.errors import UrdfError
from robots.urdf import Joint, Urdf
from robots.urdf_writer import joint_motion

Array = NDArray[np.float64]


class Chain(NamedTuple):
    """A serial chain; m driven joints, dof <= m independent variables.

    m exceeds dof only if a joint of the chain mimics another one of it.

    Attributes:
        rotations: (m + 1, 3, 3) of the constant transforms F.
        translations: (m + 1, 3) of the constant transforms F, in m.
        prismatic: (m,) whether a joint slides along its z axis instead of turning about it.
        variable: (m,) index into q of the variable that drives a joint.
        multiplier: (m,) and
        offset: (m,) give the joint position, multiplier x q + offset, in rad or m.
        lower: (dof,) where a search stops, rad or m: the limits of the variables, but for those
            that turn for ever, which have a full turn more on either side (`robots.limits`).
        upper: (dof,) the same above.
    """

    rotations: Array
    translations: Array
    prismatic: NDArray[np.bool_]
    variable: NDArray[np.int64]
    multiplier: Array
    offset: Array
    lower: Array
    upper: Array


class Drive(NamedTuple):
    """What moves a joint: position = multiplier x q[variable] + offset; variable -1 is frozen."""

    variable: int
    multiplier: float
    offset: float


def chain_joints(urdf: Urdf, base: str, tip: str) -> list[Joint]:
    """Name the independent joints between base and tip, base first.

    Raises:
        UrdfError: If there is none, one has more than one degree of freedom, or there is no path.
    """
    path = urdf.path_between(base, tip)
    for joint in path:
        if joint.kind in ("floating", "planar"):
            raise UrdfError(
                f"{urdf.path}: joint '{joint.name}' between '{base}' and '{tip}' is {joint.kind}; "
                f"only joints with one degree of freedom can be in the chain"
            )
        if joint.name in urdf.broken_mimics:
            raise UrdfError(f"{urdf.path}: {urdf.broken_mimics[joint.name]}")
    independent = [joint for joint in path if joint.movable and joint.mimic is None]
    if not independent:
        coupled = [f"'{j.name}' mimics '{j.mimic.joint}'" for j in path if j.mimic]
        why = f"; {', '.join(coupled)}, which is not between them" if coupled else ""
        raise UrdfError(f"{urdf.path}: no joint moves between '{base}' and '{tip}'{why}")
    return independent


def followers(urdf: Urdf, base: str, tip: str, driven: dict[str, Drive]) -> list[str]:
    """Say of every coupled joint between base and tip what becomes of it, one sentence each."""
    sentences = []
    for joint in urdf.path_between(base, tip):
        drive = driven[joint.name]
        if joint.mimic is None or not joint.movable:
            continue
        master = f"'{joint.name}' mimics '{joint.mimic.joint}'"
        if drive.variable >= 0:
            sentences.append(f"{master}: coupled within the chain, which not every solver can do")
        else:
            sentences.append(
                f"{master}, which the chain does not move: it stands still at {drive.offset:g}"
            )
    return sentences


def drives(urdf: Urdf, variables: list[str], posture: dict[str, float]) -> dict[str, Drive]:
    """Find out what moves every joint of a robot.

    Args:
        urdf: The robot.
        variables: Names of the independent joints, in the order of q.
        posture: Positions of joints that stand still, rad or m; the others stand at zero, or at
            their nearer limit where zero is out of limits.
    """
    return {name: _drive(urdf, name, variables, posture) for name in urdf.joints}


def _drive(urdf: Urdf, name: str, variables: list[str], posture: dict[str, float]) -> Drive:
    joint = urdf.joints[name]
    if name in variables:
        return Drive(variables.index(name), 1.0, 0.0)
    if name in posture:
        return Drive(-1, 0.0, posture[name])
    if joint.mimic is not None and joint.movable:
        master = _drive(urdf, joint.mimic.joint, variables, posture)
        factor, shift = joint.mimic.multiplier, joint.mimic.offset
        return Drive(master.variable, factor * master.multiplier, factor * master.offset + shift)
    return Drive(-1, 0.0, min(max(0.0, joint.lower), joint.upper))


class DrivenJoints(NamedTuple):
    """How m joints follow the variables, as plain arrays for compiled code.

    Attributes:
        prismatic: (m,) whether a joint slides along its z axis instead of turning about it.
        variable: (m,) index into q of the variable that drives a joint.
        multiplier: (m,) and
        offset: (m,) give the joint position, multiplier x q + offset, in rad or m.
    """

    prismatic: NDArray[np.bool_]
    variable: NDArray[np.int64]
    multiplier: Array
    offset: Array


def driven_joints(joints: list[Joint], driven: dict[str, Drive]) -> DrivenJoints:
    """Collect what moves some joints into arrays.

    Args:
        joints: m joints that move.
        driven: What moves each joint (`drives`).
    """
    chosen = [driven[joint.name] for joint in joints]
    return DrivenJoints(
        prismatic=np.array([joint.kind == "prismatic" for joint in joints]),
        variable=np.array([drive.variable for drive in chosen], dtype=np.int64),
        multiplier=np.array([drive.multiplier for drive in chosen]),
        offset=np.array([drive.offset for drive in chosen]),
    )


def build_chain(
    urdf: Urdf,
    base: str,
    tip: str,
    lower: Array,
    upper: Array,
    driven: dict[str, Drive],
) -> Chain:
    """Fold a path of a URDF into a `Chain`.

    Args:
        urdf: The robot.
        base: Link whose frame poses are given in.
        tip: Link whose pose is wanted.
        lower: (dof,) limits of the independent joints as a search has them, rad or m.
        upper: (dof,) limits of the independent joints as a search has them, rad or m.
        driven: What moves each joint (`drives`).
    """
    constants: list[Array] = []
    moving: list[Joint] = []
    pending = np.eye(4)
    for joint in urdf.path_between(base, tip):
        pending = pending @ joint.origin
        drive = driven[joint.name]
        if drive.variable < 0:
            pending = pending @ joint_motion(joint, drive.offset)
            continue
        turn = turn_to_z(joint.axis)
        constants.append(pending @ turn)
        moving.append(joint)
        pending = turn.T.copy()
    constants.append(pending)
    frames = np.stack(constants)
    return Chain(
        rotations=np.ascontiguousarray(frames[:, :3, :3]),
        translations=np.ascontiguousarray(frames[:, :3, 3]),
        **driven_joints(moving, driven)._asdict(),
        lower=lower.copy(),
        upper=upper.copy(),
    )


def turn_to_z(axis: Array) -> Array:
    """Return a (4, 4) rotation A with A z = axis, exact for axes along x, y and z.

    Args:
        axis: (3,) unit vector.
    """
    turn = np.eye(4)
    # The helper is the coordinate axis furthest from the joint axis.
    helper = np.zeros(3)
    helper[(int(np.argmax(np.abs(axis))) + 1) % 3] = 1.0
    x = helper - axis * (axis @ helper)
    x /= np.linalg.norm(x)
    turn[:3, 0], turn[:3, 1], turn[:3, 2] = x, np.cross(axis, x), axis
    return turn
