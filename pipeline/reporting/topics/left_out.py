"""What a whole run did not run on its machine, with the hours that it would take."""

from __future__ import annotations

from pipeline.presentation.columns import ROBOT, SOLVER, number, text
from pipeline.presentation.table import Table
from pipeline.reporting.data import Topic
from pipeline.reporting.results import LEFT_OUT, Results

COLUMNS = (
    text("step", "step"),
    ROBOT,
    SOLVER,
    number("hours", "core hours", digits=3),
    text("why", "why"),
)


def left_out(results: Results) -> Table:
    """What was left out, one line a task.

    Args:
        results: Everything on disk.
    """
    return Table.of(
        [{"robot": None, "solver": None, **line} for line in results.left_out],
        COLUMNS,
        name="left_out",
        title="Not run here",
        caption="Tasks that this machine did not run, with the hours of one core that they would "
        "take by the rates in results/rates.csv.",
    )


TOPIC = Topic(tables=(lambda data: left_out(data.results),), stages=(LEFT_OUT,))
