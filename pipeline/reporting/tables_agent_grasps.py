"""Tables of the trials with a camera or an agent: the paper's five classes, and every failure."""

from __future__ import annotations

import pandas as pd

from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import OUTCOMES, ordered_robots, robot_title
from pipeline.reporting.published import Published
from pipeline.reporting.results import Results
from pipeline.reporting.table import Cell, Column, Table
from pipeline.reporting.tables_trials import OUTCOME_COLUMNS, outcome_cells

EVIDENCE = "evidence"  # folder beside the rows: transcripts and pictures
SETTINGS = {"perfect": "places told", "camera": "camera"}
AGENTS = {"none": "no agent", "policy": "embedded policy", "endpoint": "chat endpoint"}


def setting_title(setting: str) -> str:
    """How a folder of trials such as `camera-policy` is called."""
    perception, _, agent = setting.partition("-")
    return f"{SETTINGS.get(perception, perception)}, {AGENTS.get(agent, agent)}"


def agent_grasping(results: Results, published: Published, config: ReportConfig) -> Table:
    """Figure 5 with what it takes: a camera, a detector and an agent, the paper beside."""
    table = Table(
        name="figure5_human_in_the_loop",
        title="Figure 5 with the human in the loop",
        caption="All objects of the set stand on a row, and the agent is given the paper's "
        "sentence for every row; each object of a row is a trial. Shares by outcome with "
        f"{config.confidence * 100:g} % Wilson intervals. Ours in simulation with a rendered "
        "camera; the paper's 100 trials a robot on hardware with ViLD and GPT-3.5.",
        columns=[
            Column("robot", "Robot"),
            Column("setting", "sees by, told by"),
            Column("outcome", "Outcome"),
            *OUTCOME_COLUMNS,
        ],
        notes=[
            "Detection: not seen where it lay, or taken for another object, and not grasped. LLM: "
            "seen, but the agent did not have it grasped.",
        ],
    )
    for robot, setting in _ordered(results):
        trials = results.grasp_agents[robot, setting]
        for key, title in OUTCOMES.items():
            table.add(
                robot=robot_title(robot),
                setting=setting_title(setting),
                outcome=title,
                **outcome_cells(trials, published, config, robot, key),
            )
    return table


def agent_sight(results: Results) -> Table:
    """How well objects were seen in those trials, by object."""
    table = Table(
        name="human_in_the_loop_sight",
        title="What was seen in these trials",
        caption="Objects of the rows: how many were seen under their own name within reach of "
        "where they lay, how far off, and what became of them.",
        columns=[
            Column("robot", "Robot"),
            Column("setting", "sees by, told by"),
            Column("object", "object"),
            Column("trials", "trials"),
            Column("seen", "seen", percent=0),
            Column("error_mean_mm", "mean", "error of the place [mm]", 3),
            Column("error_p95_mm", "p95", "error of the place [mm]", 3),
            Column("success", "success [%]", percent=0),
        ],
    )
    for robot, setting in _ordered(results):
        for name, part in results.grasp_agents[robot, setting].groupby("object", sort=True):
            errors = part["sighting_error_mm"].dropna()
            table.add(
                robot=robot_title(robot),
                setting=setting_title(setting),
                object=str(name).replace("_", " "),
                trials=len(part),
                seen=float((part["seen_as"] == part["object"]).mean()),
                error_mean_mm=float(errors.mean()) if len(errors) else None,
                error_p95_mm=float(errors.quantile(0.95)) if len(errors) else None,
                success=float((part["class"] == OUTCOMES["success"]).mean()),
            )
    return table


def agent_failures(results: Results) -> Table:
    """Every trial that failed, with its picture and its transcript."""
    table = Table(
        name="human_in_the_loop_failures",
        title="Failures of these trials",
        caption="Each failed trial with its reason. The picture has what was seen drawn into it "
        "(red: what the trial was about; green crosses: where the objects really lay); the "
        "transcript has every message of its row and every action.",
        columns=[
            Column("robot", "Robot"),
            Column("setting", "sees by, told by"),
            Column("trial", "trial"),
            Column("object", "object"),
            Column("outcome", "Outcome"),
            Column("reason", "reason"),
            Column("seen_as", "seen as"),
            Column("error_mm", "error [mm]", digits=2),
            Column("picture", "picture", link=True),
            Column("transcript", "transcript", link=True),
        ],
    )
    for robot, setting in _ordered(results):
        trials = results.grasp_agents[robot, setting]
        for row in trials[trials["class"] != OUTCOMES["success"]].to_dict("records"):
            table.add(
                robot=robot_title(robot),
                setting=setting_title(setting),
                trial=int(row["trial"]),
                object=str(row["object"]).replace("_", " "),
                outcome=row["class"],
                reason=row["reason"],
                seen_as=str(row["seen_as"]).replace("_", " ") or None,
                error_mm=float(row["sighting_error_mm"]),
                picture=_link(robot, setting, row["picture"]),
                transcript=_link(robot, setting, row["transcript"]),
            )
    return table


def agent_trials(results: Results) -> dict[str, dict[str, pd.DataFrame]]:
    """Trials by robot and by how the setting is called; perfect localisation first."""
    found: dict[str, dict[str, pd.DataFrame]] = {}
    for robot, setting in _ordered(results):
        found.setdefault(robot, {})[setting_title(setting)] = results.grasp_agents[robot, setting]
    return found


def _ordered(results: Results) -> list[tuple[str, str]]:
    robots = ordered_robots(robot for robot, _ in results.grasp_agents)
    return [
        (robot, setting)
        for robot in robots
        for name, setting in sorted(results.grasp_agents)
        if name == robot
    ]


def _link(robot: str, setting: str, name: object) -> Cell:
    """Path of a file of evidence from the report, or nothing."""
    return f"grasp_agent/{robot}/{setting}/{EVIDENCE}/{name}" if name else None
