"""Small suites with the values of conf/suite, and the checksums that they are known by."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pipeline.data.files import read_yaml
from pipeline.locations import CONF_DIR
from pipeline.suites.config import CLASSES, SuiteConfig

POSES, TRAJECTORIES = 40, 2
CHECKSUMS = Path(__file__).parent / "data" / "suite_checksums.csv"


def config_of(suite: str) -> SuiteConfig:
    """A suite of 40 poses or 2 trajectories."""
    values = read_yaml(CONF_DIR / "suite" / f"{suite}.yaml")
    return CLASSES[values["generator"]](**values, poses=POSES, trajectories=TRAJECTORIES)


def known_checksums(robot: str, suite: str, version: int) -> list[str]:
    """The checksum that a version of such a suite with root seed 0 is known by."""
    known = pd.read_csv(CHECKSUMS)
    line = known[(known.robot == robot) & (known.suite == suite) & (known.version == version)]
    return [str(value) for value in line.checksum]
