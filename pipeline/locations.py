"""Where files are: the configuration, the paper's numbers, and the results of the user's runs."""

from __future__ import annotations

from pathlib import Path

from pipeline.errors import PipelineError
from robots.locations import FOLDER, checkout, conf_dir, home

CONF_DIR = conf_dir()
PUBLISHED_FILE = "published_results.csv"
RATES_FILE = "rates.csv"


def results() -> Path:
    """Return the folder of the results of all profiles: the checkout's, else the user's."""
    return home() / "results"


def published_results() -> Path:
    """Return the file of the paper's numbers."""
    return _shipped(PUBLISHED_FILE)


def rates_file() -> Path:
    """Return the file of what tasks cost, in core seconds a unit."""
    return _shipped(RATES_FILE)


def _shipped(name: str) -> Path:
    """A file of the checkout's results/ that an installed package has too."""
    return FOLDER / ("results" if checkout() else "pipeline/published") / name


def need_checkout(what: str) -> Path:
    """Return the folder of the checkout.

    Args:
        what: Is to be written there.

    Raises:
        PipelineError: The code is run from an installed package.
    """
    folder = checkout()
    if folder is None:
        raise PipelineError(
            f"{what} belongs to a checkout of the project, and this is an installed package in "
            f"{FOLDER}: run the command in a checkout"
        )
    return folder
