"""Trials with a camera or an agent: the paper's five classes, and every failure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import pandas as pd

from pipeline.presentation.columns import ROBOT, Cell, count, number, plain, share, text, under
from pipeline.presentation.naming import OUTCOMES, ordered_robots
from pipeline.presentation.published import Published
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.results import EVIDENCE, Results
from pipeline.reporting.topics.outcomes import OUTCOME_COLUMNS, Counted, outcome_bars

SETTINGS = {
    "perfect": "ground truth",
    "camera": "camera",
    "miscalibrated": "camera with calibration error",
}
AGENTS = {
    "none": "no agent",
    "policy": "embedded policy",
    "endpoint": "chat endpoint",
    "local": "language model offline",
    "replay": "recorded replies",
}
SUCCESS = OUTCOMES["success"]


def setting_title(setting: str) -> str:
    """How a folder of trials such as `camera-policy` is called."""
    perception, _, agent = setting.partition("-")
    return f"{SETTINGS.get(perception, perception)}, {AGENTS.get(agent, agent)}"


@dataclass(frozen=True)
class Seen:
    """Trials with one object in one setting."""

    robot: str
    setting: str
    object: str
    rows: pd.DataFrame

    @property
    def errors(self) -> pd.Series:
        """How far off the object was seen [mm], where it was."""
        return self.rows["sighting_error_mm"].dropna()


SETTING = text("setting", "perception / agent", convert=setting_title)
SIGHT = (
    ROBOT,
    SETTING,
    text("object", "object", convert=plain),
    count("trials", "trials", lambda line: len(line.rows)),
    share("seen", "detected", lambda line: (line.rows["seen_as"] == line.object).mean(), 0),
    *under(
        "position error [mm]",
        number("error_mean_mm", "mean", lambda line: line.errors.mean()),
        number("error_p95_mm", "p95", lambda line: line.errors.quantile(0.95)),
    ),
    share("success", "success [%]", lambda line: (line.rows["class"] == SUCCESS).mean(), 0),
)
FAILURES = (
    ROBOT,
    SETTING,
    count("trial", "trial"),
    text("object", "object", convert=plain),
    text("outcome", "Outcome", "class"),
    text("reason", "reason"),
    text("seen_as", "detected as", lambda row: plain(row["seen_as"]) or None),
    number("error_mm", "error [mm]", "sighting_error_mm", 2),
    text("picture", "picture", lambda row: _link(row, "picture"), link=True),
    text("transcript", "transcript", lambda row: _link(row, "transcript"), link=True),
)


def agent_grasping(results: Results, published: Published, config: ReportConfig) -> Table:
    """Figure 5 with camera, detector and agent, beside the paper."""
    return Table.of(
        [
            Counted(robot, key, trials, config.confidence, published, of=setting)
            for robot, setting, trials in _trials(results)
            for key in OUTCOMES
        ],
        (
            ROBOT,
            replace(SETTING, source="of"),
            *OUTCOME_COLUMNS,
        ),
        name="figure5_human_in_the_loop",
        title="Figure 5 with the human in the loop",
        caption="All objects of the set stand on a row, and the agent is given the paper's "
        "sentence for every row; each object of a row is a trial. Shares by outcome with "
        f"{config.confidence * 100:g} % Wilson intervals. Ours in simulation with a rendered "
        "camera; the paper's 100 trials a robot on hardware with ViLD and GPT-3.5.",
        notes=[
            "Detection: not detected at its position, or as another object, and not grasped. LLM: "
            "detected, but the agent did not request its grasp.",
        ],
    )


def agent_sight(results: Results) -> Table:
    """How well objects were detected in those trials, by object."""
    return Table.of(
        [
            Seen(robot, setting, str(name), part)
            for robot, setting, trials in _trials(results)
            for name, part in trials.groupby("object", sort=True)
        ],
        SIGHT,
        name="human_in_the_loop_sight",
        title="Perception in these trials",
        caption="Objects of the rows: the share that was detected with the right class near the "
        "true position, the position error, and the success.",
    )


def agent_failures(results: Results) -> Table:
    """Every trial that failed, with its picture and its transcript."""
    return Table.of(
        [
            {**row, "robot": robot, "setting": setting}
            for robot, setting, trials in _trials(results)
            for row in trials[trials["class"] != SUCCESS].to_dict("records")
        ],
        FAILURES,
        name="human_in_the_loop_failures",
        title="Failures of these trials",
        caption="Each failed trial with its reason. The picture shows the detections (red: the "
        "object of the trial; green crosses: true positions); the transcript has every message of "
        "its row and every action.",
    )


def agent_trials(results: Results) -> dict[str, dict[str, pd.DataFrame]]:
    """Trials by robot and by how the setting is called; perfect localisation first."""
    found: dict[str, dict[str, pd.DataFrame]] = {}
    for robot, setting, trials in _trials(results):
        found.setdefault(robot, {})[setting_title(setting)] = trials
    return found


def _trials(results: Results) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Yield robot, setting and raw rows, robots in the order of all tables."""
    for robot in ordered_robots(robot for robot, _ in results.grasp_agents):
        for name, setting in sorted(results.grasp_agents):
            if name == robot:
                yield robot, setting, results.grasp_agents[robot, setting]


def _link(row: dict[str, Cell], name: str) -> Cell:
    """Path of a file of evidence from the report, or nothing."""
    if not row[name]:
        return None
    return f"grasp_agent/{row['robot']}/{row['setting']}/{EVIDENCE}/{row[name]}"


TOPIC = Topic(
    stages=("grasp_agent",),
    tables=(
        lambda data: agent_grasping(data.results, data.published, data.config),
        lambda data: agent_sight(data.results),
        lambda data: agent_failures(data.results),
    ),
    plots=(
        Plot(
            "human_in_the_loop_outcomes",
            "Figure 5 of the paper with camera and agent: every object of a row is a trial. The "
            "paper's trials ran on hardware, with ViLD and GPT-3.5.",
            lambda data: data.results.grasp_agents,
            lambda data: outcome_bars(agent_trials(data.results), data.published, data.config),
        ),
    ),
)
