"""One header of C99: kinematics, descent and, where there is one, the network of a robot."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from numpy.typing import NDArray

from baselines.registry import file_settings, load, settings
from pipeline.errors import PipelineError
from pipeline.exporting.c_network import network_values
from pipeline.exporting.source import Source
from robots import Robot
from robots.limits import FARTHEST
from robots.rotations import UNIT_TOLERANCE

HEADER, EXAMPLE, DRIVER = "header.h.jinja", "example.c.jinja", "driver.c.jinja"
WIDE = 100  # characters of a line of numbers
DOUBLE_BYTES, INT_BYTES = 8, 4
DESCENT = (  # settings of `lm` that the header has
    "position_tolerance_m",
    "rotation_tolerance_rad",
    "damping",
    "damping_gain",
    "patience",
    "max_active_set_passes",
    "iterations",
)


def identifier(name: str) -> str:
    """Return a robot's name as functions of C begin with it."""
    plain = re.sub(r"[^0-9A-Za-z]+", "_", name).strip("_").lower()
    if not plain:
        return "robot"
    return f"robot_{plain}" if plain[0].isdigit() else plain


def descent_settings(robot: Robot) -> dict[str, Any]:
    """Return those settings of the run's `lm` that are in `DESCENT`.

    Raises:
        PipelineError: The run changes another one, or takes away the limit of iterations.
        SolverError: Settings that `lm` refuses.
    """
    of_run, plain = settings("lm"), file_settings("lm")
    for name, value in of_run.items():
        if name not in DESCENT and value != plain[name]:
            raise PipelineError(
                f"the descent in C knows no solver.lm.{name}; it has {', '.join(DESCENT)}"
            )
    if of_run["iterations"] is None:
        raise PipelineError(
            "the descent in C reads no clock: solver.lm.iterations must be a number"
        )
    load("lm", robot)
    return {name: of_run[name] for name in DESCENT}


def header_text(source: Source, card: Mapping[str, str], file: str) -> str:
    """Return the header.

    Args:
        source: The robot and its network, if any.
        card: What the file says of itself.
        file: Its name, for the sentence on how to include it.
    """
    robot, chain = source.robot, source.robot.chain
    network = None if source.solver is None else network_values(source.network, source.ranking)
    frames = np.hstack((chain.rotations.reshape(-1, 9), chain.translations))
    lines = [comment(f"{key}: {value}") for key, value in card.items()]
    own = DOUBLE_BYTES * (frames.size + 2 * len(chain.variable) + 3 * robot.dof)
    own += INT_BYTES * (2 * len(chain.variable) + robot.dof)
    return _rendered(
        HEADER,
        source,
        file=comment(file),
        card={key: comment(value) for key, value in card.items()},
        card_lines=lines,
        constant_bytes=own + (network["bytes"] if network else 0),
        joint_names=[comment(name) for name in robot.joint_names],
        endless=robot.endless.tolist(),
        driven=len(chain.variable),
        frames=[numbers(frame) for frame in frames],
        prismatic=numbers(chain.prismatic.astype(int)),
        variable=numbers(chain.variable),
        multiplier=numbers(chain.multiplier),
        offset=numbers(chain.offset),
        home=numbers(robot.home),
        endless_flags=numbers(robot.endless.astype(int)),
        options=descent_settings(robot),
        farthest=FARTHEST,
        unit_tolerance=UNIT_TOLERANCE,
        network=network,
    )


def example_text(source: Source, file: str, example: str) -> str:
    """Return a program that times and checks a header.

    Args:
        source: As of the header.
        file: Name of the header.
        example: Name of the program.
    """
    return _rendered(EXAMPLE, source, file=file, example=example, network=source.solver is not None)


def driver_text(source: Source, path: Path) -> str:
    """Return a program that gives batches to the functions of a header at a path."""
    return _rendered(DRIVER, source, file=path.as_posix(), network=source.solver is not None)


def _rendered(template: str, source: Source, **values: Any) -> str:
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    robot, name = source.robot, identifier(source.robot.name)
    every = {
        "p": name,
        "P": name.upper(),
        "dof": robot.dof,
        "lower": robot.lower.tolist(),
        "upper": robot.upper.tolist(),
        "lower_limits": numbers(robot.lower),
        "upper_limits": numbers(robot.upper),
    }
    return environment.get_template(template).render(**every, **values)


def numbers(values: Iterable[Any] | NDArray[Any]) -> str:
    """Return numbers as C reads them, each exactly."""
    return ", ".join(repr(value) for value in np.asarray(values).tolist())


def comment(text: str) -> str:
    """Return a text that can stand in a comment of C: names of robots and joints may be any."""
    plain = " ".join(text.split())
    for mark, harmless in (("*/", "* /"), ("/*", "/ *"), ("??", "? ?")):
        plain = plain.replace(mark, harmless)
    return plain
