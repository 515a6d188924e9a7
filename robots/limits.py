"""What a description adds to a URDF, checked against it: joint names, limits, home."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robots.description import Description
from robots.errors import DescriptionError, UrdfError
from robots.urdf import Joint, Urdf

Array = NDArray[np.float64]

FULL_TURN = 2.0 * np.pi
# Descriptions round pi: what lacks no more than this of a full turn is one [rad].
TURN_SLACK = 1e-3
# Beyond this, in rad or m, sines and full turns lose their digits.
FARTHEST = 1e6
LONGEST_M = 1e4


def check_names(description: Description, urdf: Urdf, names: tuple[str, ...]) -> None:
    """Check the joints and the posture of a description.

    Args:
        description: The robot's.
        urdf: Its URDF.
        names: Joints of the chain as the URDF has them.

    Raises:
        DescriptionError: If the description says otherwise or names joints that are not there.
    """
    if description.joints is not None and description.joints != names:
        raise DescriptionError(
            f"robot '{description.name}': joints in robot.yaml are {list(description.joints)}, but "
            f"from {description.base} to {description.tip} the URDF has {list(names)}"
        )
    still = {name for name, joint in urdf.joints.items() if joint.movable} - set(names)
    if unknown := sorted(description.posture.keys() - still):
        raise DescriptionError(
            f"robot '{description.name}': posture names {unknown}, which are no movable joints "
            f"outside the chain; those are {sorted(still)}"
        )


def narrow(
    description: Description, joints: Sequence[Joint], lower: Array, upper: Array
) -> NDArray[np.bool_]:
    """Apply the description's limits in place; they may only be narrower.

    Args:
        description: The robot's.
        joints: Independent joints of the chain.
        lower: (dof,) limits of the URDF, rad or m.
        upper: (dof,) limits of the URDF, rad or m.

    Returns:
        (dof,) which joints turn for ever: those that the URDF calls so and that the description
        leaves a full turn.

    Raises:
        DescriptionError: If they are wider, not as many as joints, or leave no room.
        UrdfError: If a joint slides further than a robot can.
    """
    names = [joint.name for joint in joints]
    endless = np.array([joint.endless for joint in joints], dtype=bool)
    for key, limit, wanted in (
        ("lower", lower, description.lower),
        ("upper", upper, description.upper),
    ):
        if wanted is None:
            continue
        if wanted.shape != limit.shape:
            raise DescriptionError(
                f"robot '{description.name}': {key} has {len(wanted)} numbers, expected one for "
                f"each of {names}"
            )
        wider = wanted < limit - 1e-9 if key == "lower" else wanted > limit + 1e-9
        wider &= ~endless
        if wider.any():
            k = int(np.argmax(wider))
            raise DescriptionError(
                f"robot '{description.name}': {key} limit {wanted[k]:g} of '{names[k]}' is wider "
                f"than the URDF's {limit[k]:g}"
            )
        limit[:] = np.where(endless, np.clip(wanted, -np.pi, np.pi), wanted)
    if (lower >= upper).any():
        name = names[int(np.argmax(lower >= upper))]
        raise DescriptionError(
            f"robot '{description.name}': the lower limit of '{name}' is not below the upper"
        )
    if (far := np.maximum(np.abs(lower), np.abs(upper)) > LONGEST_M).any():
        k = int(np.argmax(far))
        raise UrdfError(
            f"{description.urdf}: joint '{names[k]}' of the chain slides from {lower[k]:g} to "
            f"{upper[k]:g} m; expected limits within {LONGEST_M:g} m, such as those of the place "
            f"it works in"
        )
    return endless & (upper - lower >= FULL_TURN - TURN_SLACK)


def search_range(lower: Array, upper: Array, endless: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Limits at which a search stops: a joint that turns for ever has a turn more on either side.

    So every solver, whatever library it stands on, can cross the half turn; its answers are
    brought back by `nearest_turns`.

    Args:
        lower: (dof,) limits, rad or m.
        upper: (dof,) limits, rad or m.
        endless: (dof,) which joints turn for ever.
    """
    room = np.where(endless, FULL_TURN, 0.0)
    return lower - room, upper + room


def nearest_turns(
    joints: Array, near: Array, endless: NDArray[np.bool_], lower: Array, upper: Array
) -> Array:
    """Turn joints that turn for ever by full turns until they are nearest to a reference.

    Args:
        joints: (N, dof) rad or m.
        near: (dof,) or (N, dof) reference, rad or m; rows with a number beyond `FARTHEST` count
            as the middle of the limits, where full turns still differ.
        endless: (dof,) which joints turn for ever.
        lower: (dof,) limits, rad or m.
        upper: (dof,) limits, rad or m.

    Returns:
        (N, dof); other joints are as they were.
    """
    if not endless.any():
        return joints
    columns = np.flatnonzero(endless)
    wanted = near[..., columns]
    reference = np.where(np.abs(wanted) <= FARTHEST, wanted, ((lower + upper) / 2)[columns])
    turns = np.round((reference - joints[..., columns]) / FULL_TURN)
    if not turns.any():
        return joints
    turned = joints.copy()
    turned[..., columns] += FULL_TURN * turns
    return turned


def choose_home(description: Description, lower: Array, upper: Array) -> Array:
    """Idle configuration: the description's, else zero, or mid-range where zero is no choice.

    Args:
        description: The robot's.
        lower: (dof,) limits, rad or m.
        upper: (dof,) limits, rad or m.

    Raises:
        DescriptionError: If the description's home is not within the limits.
    """
    home = description.home
    if home is None:
        return np.where((lower <= 0.0) & (upper >= 0.0), 0.0, (lower + upper) / 2)
    if home.shape != lower.shape or (home < lower - 1e-9).any() or (home > upper + 1e-9).any():
        raise DescriptionError(
            f"robot '{description.name}': home {home.tolist()} does not fit the limits "
            f"{lower.tolist()} to {upper.tolist()}"
        )
    return np.clip(home, lower, upper)
