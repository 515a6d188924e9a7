"""What a description adds to a URDF, checked against it: joint names, limits, home."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robots.description import Description
from robots.errors import DescriptionError
from robots.urdf import Urdf

Array = NDArray[np.float64]


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


def narrow(description: Description, names: tuple[str, ...], lower: Array, upper: Array) -> None:
    """Apply the description's limits in place; they may only be narrower.

    Args:
        description: The robot's.
        names: Joints of the chain.
        lower: (dof,) limits of the URDF, rad or m.
        upper: (dof,) limits of the URDF, rad or m.

    Raises:
        DescriptionError: If they are wider, not as many as joints, or leave no room.
    """
    for key, limit, wanted in (
        ("lower", lower, description.lower),
        ("upper", upper, description.upper),
    ):
        if wanted is None:
            continue
        if wanted.shape != limit.shape:
            raise DescriptionError(
                f"robot '{description.name}': {key} has {len(wanted)} numbers, expected one for "
                f"each of {list(names)}"
            )
        wider = wanted < limit - 1e-9 if key == "lower" else wanted > limit + 1e-9
        if wider.any():
            k = int(np.argmax(wider))
            raise DescriptionError(
                f"robot '{description.name}': {key} limit {wanted[k]:g} of '{names[k]}' is wider "
                f"than the URDF's {limit[k]:g}"
            )
        limit[:] = wanted
    if (lower >= upper).any():
        name = names[int(np.argmax(lower >= upper))]
        raise DescriptionError(
            f"robot '{description.name}': the lower limit of '{name}' is not below the upper"
        )


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
