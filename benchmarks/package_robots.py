"""Robots of the leaderboard that are taken out of packages: nothing of theirs lies in git.

    python -m benchmarks.package_robots [ur5 iiwa]

Adds those that are not there yet, as `python -m pipeline robot add` does, under robots/ and
conf/robot; `python -m pipeline train robot=ur5` and all else then work as for any other robot. What
is made is the same as long as the package's version is: the checksums of suites say so.
"""

from __future__ import annotations

import argparse
import sysconfig
from dataclasses import dataclass
from pathlib import Path

from robots import available_robots
from robots.add import add_robot


@dataclass(frozen=True)
class PackageRobot:
    """A chain of a URDF of a package, by its path below the folder of libraries."""

    urdf: str
    base: str
    tip: str


ROBOTS = {
    "ur5": PackageRobot(  # example-robot-data, of the extra `test`
        "cmeel.prefix/share/example-robot-data/robots/ur_description/urdf/ur5_robot.urdf",
        "base_link",
        "tool0",
    ),
    "iiwa": PackageRobot(  # pybullet
        "pybullet_data/kuka_iiwa/model.urdf", "lbr_iiwa_link_0", "lbr_iiwa_link_7"
    ),
}


def main() -> None:
    """Add the robots that are named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("robots", nargs="*", default=list(ROBOTS), metavar="ROBOT")
    wanted = parser.parse_args().robots
    if unknown := [name for name in wanted if name not in ROBOTS]:
        parser.error(f"no robot {unknown[0]!r} here, expected some of {', '.join(ROBOTS)}")
    for name in wanted:
        ensure(name)


def ensure(name: str) -> None:
    """Add a robot of `ROBOTS` where it is not there yet; others are left alone."""
    if name not in ROBOTS or name in available_robots():
        return
    robot = ROBOTS[name]
    print(add_robot(urdf_of(name), robot.base, robot.tip, name), flush=True)


def urdf_of(name: str) -> Path:
    """Return the URDF of a robot of `ROBOTS`, whether it is there or not."""
    return Path(sysconfig.get_path("purelib")) / ROBOTS[name].urdf


if __name__ == "__main__":
    main()
