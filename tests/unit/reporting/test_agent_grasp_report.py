"""The chapter of trials with a camera and an agent: five classes, failures linked to evidence."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import pandas as pd
from PIL import Image
from synthetic import PUBLISHED, report_config

from pipeline.data.tables import write_table
from pipeline.presentation.published import read_published
from pipeline.reporting.report import make_report
from pipeline.reporting.results import EVIDENCE, read_results
from pipeline.reporting.topics.agent import agent_failures, agent_grasping, agent_trials
from pipeline.reporting.topics.outcomes import outcome_bars
from pipeline.reporting.wall import THUMBNAIL, walls

CLASSES = ["Success"] * 7 + ["Detection", "LLM", "Slipped"]


def write_trials(folder: Path, robot: str, setting: str) -> None:
    rows = [
        {
            "trial": number,
            "robot": robot,
            "object": ["pear", "orange"][number % 2],
            "class": outcome,
            "reason": "in the left bin" if outcome == "Success" else "<b>lost</b>",
            "seen_as": "" if outcome == "Detection" else ["pear", "orange"][number % 2],
            "sighting_error_mm": float("nan") if outcome == "Detection" else 3.0,
            "picture": "" if outcome == "Success" else f"trial{number:03d}.png",
            "transcript": f"row{number // 5:03d}.jsonl",
        }
        for number, outcome in enumerate(CLASSES)
    ]
    path = folder / "grasp_agent" / robot / setting / "trials.parquet"
    write_table(path, pd.DataFrame(rows), {})


def test_the_five_classes_stand_beside_the_papers(tmp_path: Path) -> None:
    write_trials(tmp_path, "nicol", "camera-policy")
    table = agent_grasping(read_results(tmp_path), read_published(PUBLISHED), report_config())
    names = [column.name for column in table.columns]
    rows = [dict(zip(names, row, strict=True)) for row in table.rows]
    counts = {row["outcome"]: (row["count"], row["share_paper"]) for row in rows}
    assert counts["Success"] == (7, 0.72)
    assert counts["Detection"] == (1, 0.04)
    assert counts["LLM"] == (1, 0.02)
    assert counts["Not Grasped"] == (0, 0.07)
    assert rows[0]["setting"] == "camera, embedded policy"


def test_every_failure_is_linked_to_its_picture_and_transcript(tmp_path: Path) -> None:
    write_trials(tmp_path, "nico", "camera-policy")
    table = agent_failures(read_results(tmp_path))
    assert len(table.rows) == 3
    shown = table.to_html()
    link = "grasp_agent/nico/camera-policy/evidence/trial008.png"
    assert f'<a href="{link}">trial008.png</a>' in shown
    assert "row001.jsonl</a>" in shown
    assert "<b>lost" not in shown


def test_a_wall_has_every_trial_in_the_colour_of_its_class_with_what_is_kept_of_it(
    tmp_path: Path,
) -> None:
    write_trials(tmp_path, "nico", "camera-policy")
    folder = tmp_path / "grasp_agent" / "nico" / "camera-policy"
    (folder / EVIDENCE).mkdir()
    Image.new("RGB", (640, 480), "red").save(folder / EVIDENCE / "trial008.png")
    (folder / EVIDENCE / "trial009.png").write_bytes(b"no picture")
    (folder / EVIDENCE / "row001.jsonl").write_text("{}")
    (folder / "trial009_slipped.mp4").write_bytes(b"")
    (wall,) = walls(read_results(tmp_path))
    assert [tile.trial for tile in wall.tiles] == [*range(10)]
    assert {name: count for name, (_, count) in wall.legend.items()} == {
        **{"Success": 7, "Slipped": 1, "Detection": 1, "LLM": 1}
    }
    red, damaged, plain = wall.tiles[8], wall.tiles[9], wall.tiles[0]
    content = base64.b64decode(red.thumbnail.partition(",")[2])
    with Image.open(io.BytesIO(content)) as thumbnail:
        assert thumbnail.size == THUMBNAIL
    base = "grasp_agent/nico/camera-policy"
    assert red.links["picture"] == f"{base}/evidence/trial008.png"
    assert damaged.links == {
        "picture": f"{base}/evidence/trial009.png",
        "transcript": f"{base}/evidence/row001.jsonl",
        "film": f"{base}/trial009_slipped.mp4",
    }
    assert (damaged.thumbnail, plain.thumbnail, plain.links) == ("", "", {})
    assert len({tile.colour for tile in wall.tiles}) == 4


def test_the_report_has_the_chapter(tmp_path: Path) -> None:
    for robot in ("nico", "nicol"):
        write_trials(tmp_path, robot, "camera-policy")
        write_trials(tmp_path, robot, "perfect-policy")
    trials = agent_trials(read_results(tmp_path))
    assert list(trials["nico"]) == ["camera, embedded policy", "ground truth, embedded policy"]
    figure = outcome_bars(trials, read_published(PUBLISHED), report_config())
    assert len(figure.axes) == 2
    paths = make_report(tmp_path, PUBLISHED, report_config())
    page = paths.html.read_text(encoding="utf-8")
    assert "Human in the loop" in page
    assert (paths.figures / "human_in_the_loop_outcomes.png").exists()
    assert "grasp_agent/nicol/camera-policy/evidence/trial007.png" in page
