"""Table of the detectors: what is found in held-out pictures, and how far off its place is."""

from __future__ import annotations

from pipeline.evaluation.detections import summary
from pipeline.reporting.naming import ordered_robots, robot_title
from pipeline.reporting.results import Results
from pipeline.reporting.table import Column, Table

FIGURES = {
    "precision": "precision",
    "recall": "recall",
    "mean_mm": "position_error_mm",
    "p95_mm": "position_error_p95_mm",
    "worst_mm": "position_error_max_mm",
}


def detectors(results: Results) -> Table:
    """One line for each class of each robot, and one for all of its classes."""
    table = Table(
        name="detector",
        title="What the eyes find",
        caption="The embedded detector on renderings whose light, camera pose and surroundings are "
        "drawn from ranges that training never saw: mean average precision at an overlap of 0.5, "
        "precision and recall at the threshold in use, and the error of the place on the table, "
        "the camera being calibrated.",
        columns=[
            Column("robot", "Robot"),
            Column("object", "object"),
            Column("objects", "in pictures"),
            Column("map50", "mAP50 [%]", percent=1),
            Column("precision", "precision [%]", percent=1),
            Column("recall", "recall [%]", percent=1),
            Column("mean_mm", "mean", "position error [mm]", 3),
            Column("p95_mm", "95 %", "position error [mm]", 3),
            Column("worst_mm", "largest", "position error [mm]", 3),
        ],
    )
    for robot in ordered_robots(results.detector):
        rows, threshold = results.detector[robot]
        told = summary(rows, threshold)
        lines = {"all": told, **told["classes"]}
        for name, line in lines.items():
            table.add(
                robot=robot_title(robot),
                object=name.replace("_", " "),
                objects=line["objects"],
                map50=line.get("map50", line.get("ap50")),
                **{column: line[key] for column, key in FIGURES.items()},
            )
    return table
