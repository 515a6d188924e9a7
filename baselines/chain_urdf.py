"""The URDF of the chain alone (`robots.serial_urdf`) for solvers that read URDF files."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from baselines.errors import SolverError
from robots.errors import RobotError
from robots.serial_urdf import serial_urdf

if TYPE_CHECKING:
    from robots import Robot


def chain_urdf(robot: Robot) -> str:
    """URDF text of the serial chain from `robot.base` (its root) to `robot.tip`.

    Raises:
        SolverError: A joint of the chain mimics another one, which these libraries cannot express.
    """
    try:
        return serial_urdf(robot)
    except RobotError as error:
        raise SolverError(str(error)) from error


@contextmanager
def chain_urdf_file(robot: Robot) -> Iterator[Path]:
    """The text of `chain_urdf` as a file that is removed afterwards."""
    with tempfile.TemporaryDirectory(prefix="chain_urdf_") as folder:
        path = Path(folder) / "chain.urdf"
        path.write_text(chain_urdf(robot))
        yield path
