"""The detectors: detections in held-out images, and their position error."""

from __future__ import annotations

from pipeline.evaluation.detections import summary
from pipeline.presentation.columns import ROBOT, count, number, plain, share, text, under
from pipeline.presentation.naming import ordered_robots
from pipeline.presentation.table import Table
from pipeline.reporting.data import Topic
from pipeline.reporting.results import Results

COLUMNS = (
    ROBOT,
    text("object", "object", convert=plain),
    count("objects", "in images"),
    share("map50", "mAP50 [%]", lambda line: line.get("map50", line.get("ap50"))),
    share("precision", "precision [%]"),
    share("recall", "recall [%]"),
    *under(
        "position error [mm]",
        number("mean_mm", "mean", "position_error_mm"),
        number("p95_mm", "95 %", "position_error_p95_mm"),
        number("worst_mm", "largest", "position_error_max_mm"),
    ),
)


def detectors(results: Results) -> Table:
    """One line for each class of each robot, and one for all of its classes."""
    lines = []
    for robot in ordered_robots(results.detector):
        found = summary(*results.detector[robot])
        for name, figures in {"all": found, **found["classes"]}.items():
            lines.append({"robot": robot, "object": name, **figures})
    return Table.of(
        lines,
        COLUMNS,
        name="detector",
        title="Detector on held-out images",
        caption="The embedded detector on renderings whose light, camera pose and surroundings are "
        "drawn from ranges that training never saw: mean average precision at an overlap of 0.5, "
        "precision and recall at the threshold in use, and the position error on the table, "
        "with a calibrated camera. A detector that comes with the project was trained before; one "
        "of this run was trained in it (`networks` in conf/bench.yaml).",
    )


TOPIC = Topic(tables=(lambda data: detectors(data.results),), stages=("detector",))
