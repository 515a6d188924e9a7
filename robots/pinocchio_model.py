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
    """Pinocchio model with every joint locked that no variable moves.

    Args:
        urdf: The robot.
        driven: What moves each joint (`robots.chain.drives`).
        root: Link to be the root, the URDF's own if not given.
        shapes: Whether to build the collision geometry as well.

    Returns:
        The model and the geometry model (None without shapes).

    Raises:
        UrdfError: If a collision mesh is there but cannot be read.
    """
    import pinocchio  # takes a while, and kinematics can do without

    xml = write_urdf(urdf, root, shapes=shapes)
    model = pinocchio.buildModelFromXML(xml)
    locked, position = [], pinocchio.neutral(model)
    for index, name in enumerate(model.names):
        if index and driven[name].variable < 0:
            locked.append(index)
            position[model.joints[index].idx_q] = driven[name].offset
    if not shapes:
        return pinocchio.buildReducedModel(model, locked, position), None
    try:
        geometry = pinocchio.buildGeomFromUrdfString(model, xml, pinocchio.GeometryType.COLLISION)
    except (ValueError, RuntimeError) as error:
        problem = " ".join(str(error).split())
        raise UrdfError(f"{urdf.path}: a collision mesh cannot be read: {problem}") from None
    model, geometries = pinocchio.buildReducedModel(model, [geometry], locked, position)
    return model, geometries[0]


def chain_model(urdf: Urdf, driven: dict[str, Drive], base: str, tip: str) -> tuple[Any, int]:
    """Pinocchio model from base to tip, its universe being the base.

    Args:
        urdf: The robot.
        driven: What moves each joint.
        base: Link to be the root.
        tip: Link whose frame is wanted.

    Returns:
        The model, with one position per variable in the order of q, and the id of the tip's frame.

    Raises:
        RobotError: If a joint of the subtree is coupled to a variable, which a plain model cannot
            express.
    """
    coupled = [n for n, d in driven.items() if d.variable >= 0 and urdf.joints[n].mimic]
    if coupled:
        raise RobotError(
            f"{urdf.path}: joints {coupled} mimic joints of the chain; a plain Pinocchio model has "
            f"no couplings, use the robot's own kinematics"
        )
    model, _ = reduced_model(urdf, driven, base)
    return model, model.getFrameId(tip)


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
