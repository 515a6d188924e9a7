"""Pinocchio models of a robot, the reference that the compiled code is tested against."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.chain import Drive
from robots.errors import RobotError, UrdfError
from robots.urdf import Urdf
from robots.urdf_writer import write_urdf

Array = NDArray[np.float64]


def reduced_model(
    urdf: Urdf, driven: dict[str, Drive], root: str | None = None, shapes: bool = False
) -> tuple[Any, Any]:
    """Pinocchio model in which only those joints move that a variable moves.

    The others are written as fixed where they stand, rather than locked in a larger model:
    Pinocchio looks them up by name, and a link may have the same one.

    Args:
        urdf: The robot.
        driven: What moves each joint (`robots.chain.drives`).
        root: Link to be the root, the URDF's own if not given.
        shapes: Whether to build the collision geometry as well.

    Returns:
        The model and the geometry model (None without shapes).

    Raises:
        UrdfError: If a collision shape cannot be used.
    """
    import pinocchio  # takes a while, and kinematics can do without

    if shapes:
        urdf.require_shapes("collision")
    still = {name: drive.offset for name, drive in driven.items() if drive.variable < 0}
    xml = write_urdf(urdf, root, shapes=shapes, still=still)
    model = pinocchio.buildModelFromXML(xml)
    if not shapes:
        return model, None
    try:
        geometry = pinocchio.buildGeomFromUrdfString(model, xml, pinocchio.GeometryType.COLLISION)
    except (ValueError, RuntimeError) as error:
        problem = " ".join(str(error).split())
        raise UrdfError(f"{urdf.path}: a collision mesh cannot be read: {problem}") from None
    return model, geometry


def chain_model(urdf: Urdf, driven: dict[str, Drive], base: str, tip: str) -> tuple[Any, int]:
    """Pinocchio model from base to tip, its universe being the base.

    Joints beside the path stand still in it, coupled ones included.

    Args:
        urdf: The robot.
        driven: What moves each joint.
        base: Link to be the root.
        tip: Link whose frame is wanted.

    Returns:
        The model, with one position per variable in the order of q, and the id of the tip's frame.

    Raises:
        RobotError: If a joint of the path is coupled to another one, which a plain model cannot
            express.
    """
    import pinocchio

    path = {joint.name for joint in urdf.path_between(base, tip)}
    coupled = [n for n in path if driven[n].variable >= 0 and urdf.joints[n].mimic]
    if coupled:
        raise RobotError(
            f"{urdf.path}: joints {coupled} mimic joints of the chain; a plain Pinocchio model has "
            f"no couplings, use the robot's own kinematics"
        )
    on_path = {n: d if n in path else Drive(-1, 0.0, d.offset) for n, d in driven.items()}
    model, _ = reduced_model(urdf, on_path, base)
    # A joint may have the name of the tip, too.
    return model, model.getFrameId(tip, pinocchio.FrameType.BODY)


def expand(model: Any, driven: dict[str, Drive], joints: Array) -> Array:
    """Positions of a reduced model with couplings, for a batch of variables.

    Args:
        model: From `reduced_model`.
        driven: What moves each joint.
        joints: (N, dof), rad or m.

    Returns:
        (N, model.nq).
    """
    positions = np.zeros((len(joints), model.nq))
    for index, name in enumerate(model.names):
        if index:
            variable, multiplier, offset = driven[name]
            column = model.joints[index].idx_q
            positions[:, column] = multiplier * joints[:, variable] + offset
    return positions
