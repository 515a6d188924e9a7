"""Where this code lies: a checkout with `conf/` beside the packages, or an installed package."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1]  # of the packages
MARKS = ("pyproject.toml", "conf")  # what a checkout has beside them
INSTALLED_CONF = Path("pipeline", "conf")  # where a wheel has conf/


def checkout() -> Path | None:
    """Return the folder of the checkout that this code is run from, None for a wheel's."""
    return FOLDER if all((FOLDER / mark).exists() for mark in MARKS) else None


def conf_dir() -> Path:
    """Return the folder of the configuration: the checkout's or that of the installed package."""
    return FOLDER / ("conf" if checkout() else INSTALLED_CONF)


def home() -> Path:
    """Return the folder below which `results/` lies where no other is named.

    That is the checkout; of an installed package it is the folder where the user stands.
    """
    return checkout() or Path.cwd()
