"""Tables of the study: how likely the published counts are, and which errors would make them so."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import chi2, chi2_contingency

from benchmarks.hardware.chances import CLASSES
from benchmarks.hardware.errors import ERRORS, Error
from benchmarks.hardware.explanation import Alone, Explanation, deviance
from pipeline.presentation.columns import ROBOT, count, number, p_value, share, text, under
from pipeline.presentation.table import Table

Array = NDArray[np.float64]
NONE_RUN, LAST_RUN = "no error, run", "errors of the last round, run"
LIKELIHOOD = "log-likelihood"  # the test's statistic, of Cressie and Read's family


@dataclass(frozen=True)
class Robot:
    """What was found for a robot.

    Attributes:
        robot: Its name.
        found: The explanation.
        trials: How many trials the chances are fitted to.
        runs: Outcomes of trials that all had the same errors, places in `CLASSES`, by their name.
    """

    robot: str
    found: Explanation
    trials: int
    runs: Mapping[str, NDArray[np.int64]]

    @property
    def best(self) -> str:
        """What the best errors are called."""
        return "likely errors" if self.found.likely else "nearest errors"


@dataclass(frozen=True)
class Setting:
    """Outcomes of a robot under one choice of errors."""

    robot: str
    name: str
    chances: Array
    counts: Array  # published, which these chances are to explain
    ended: Array | None = None  # counts of the trials that the chances were counted in

    @property
    def trials(self) -> int | None:
        """How many trials the chances were counted in; None for those of the model."""
        return None if self.ended is None else int(self.ended.sum())

    @property
    def p_value(self) -> float:
        """Of published counts farther off; where chances were counted, of both counts at once."""
        if self.ended is None:
            return float(chi2.sf(deviance(self.chances[None], self.counts)[0], len(CLASSES) - 1))
        both = np.array([self.counts, self.ended])
        return float(chi2_contingency(both[:, both.any(axis=0)], lambda_=LIKELIHOOD).pvalue)


@dataclass(frozen=True)
class Line:
    """One error of a robot."""

    robot: str
    error: Error
    found: Explanation
    which: int

    @property
    def alone(self) -> Alone:
        """The error without the others."""
        return self.found.alone[self.which]

    def said(self, shares: Array) -> float:
        """Value of this error in shares of all [its unit]."""
        return self.error.said(float(shares[self.which]))


def settings(robots: Sequence[Robot]) -> list[Setting]:
    """What the paper counted, and the chances with no error, the smallest and the best ones."""
    lines = []
    for each in robots:
        found = each.found
        none = np.zeros(len(ERRORS))
        choices = [("no error", none), ("smallest errors", found.smallest)]
        choices.append((each.best, found.best))
        published = found.counts / found.counts.sum()
        lines.append(Setting(each.robot, "published", published, found.counts, found.counts))
        lines += [
            Setting(each.robot, name, found.chances.of(shares[None])[0], found.counts)
            for name, shares in choices
            if not np.isnan(shares).any()
        ]
        for name, ended in each.runs.items():
            counts = np.bincount(ended, minlength=len(CLASSES)).astype(np.float64)
            lines.append(Setting(each.robot, name, counts / counts.sum(), found.counts, counts))
    return lines


def tables(robots: Sequence[Robot]) -> Iterator[Table]:
    """Yield the tables of the study."""
    yield Table.of(
        settings(robots),
        (
            ROBOT,
            text("errors", "errors", "name"),
            count("trials", "trials"),
            *under(
                "chance of [%]",
                *(
                    share(name.lower().replace(" ", "_"), name, lambda line, k=k: line.chances[k])
                    for k, name in enumerate(CLASSES)
                ),
            ),
            p_value("p", "p_value"),
        ),
        name="hardware_settings",
        title="How likely the published counts are",
        caption="Of the published trials those that neither detection nor language model lost. "
        "Chances by the model, and shares of trials that were run with none and with the errors "
        "that were likely, or the nearest, before the last round's trials were fitted too. p: of "
        "the published counts under the model's chances (likelihood ratio), or that they and the "
        "run's were drawn alike.",
    )
    yield Table.of(
        [
            Line(each.robot, error, each.found, which)
            for each in robots
            for which, error in enumerate(ERRORS)
        ],
        (
            ROBOT,
            text("error", "error", lambda line: line.error.title),
            number("worst", "largest tried", lambda line: line.error.said(1.0)),
            *under(
                "smallest together",
                number("smallest", "value", lambda line: line.said(line.found.smallest)),
                number("smallest_low", "from", lambda line: line.said(line.found.spread[0])),
                number("smallest_high", "to", lambda line: line.said(line.found.spread[1])),
            ),
            number("best", "likely or nearest", lambda line: line.said(line.found.best)),
            *under(
                "not contradicted",
                number("range_low", "from", lambda line: line.said(line.found.ranges[0])),
                number("range_high", "to", lambda line: line.said(line.found.ranges[1])),
            ),
            *under(
                "alone",
                number("alone", "smallest", lambda line: line.error.said(line.alone.share)),
                number("alone_deviance", "least deviance", lambda line: line.alone.deviance),
            ),
        ),
        name="hardware_errors",
        title="What explains them",
        caption="The smallest errors, in the sum of squared shares of the ranges tried, that the "
        "published counts do not contradict (95 %); from and to: 90 % of refits to other draws of "
        "the placements, of those that explain the counts. Likely: the smallest with which half of "
        "all draws of the counts would be farther off; where there are none, those nearest to it. "
        "Not contradicted: whatever the other errors are. Alone: the others zero; a dash where no "
        "size of it will do.",
    )
    yield Table.of(
        [
            (each.robot, error, each.found.sensitivity(each.found.best)[which])
            for each in robots
            for which, error in enumerate(ERRORS)
        ],
        (
            text("robot", "Robot", lambda line: ROBOT.cell({"robot": line[0]})),
            text("error", "error", lambda line: line[1].title),
            *(
                share(
                    f"change_{k}",
                    f"{name} [points]",
                    lambda line, k=k: line[2][k],
                    signed=True,
                )
                for k, name in enumerate(CLASSES)
            ),
        ),
        name="hardware_sensitivity",
        title="Which class an error feeds",
        caption="Change of the chances, in points of a hundred, where an error grows by a tenth of "
        "its range from the likely or nearest errors.",
    )


def outcomes(rows: pd.DataFrame) -> NDArray[np.int64]:
    """How trials ended, places in `CLASSES`."""
    return rows["class"].map({name: k for k, name in enumerate(CLASSES)}).to_numpy(np.int64)
