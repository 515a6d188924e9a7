"""Every learned method, trained for the same time, beside the published numbers.

The rows are those of a study that is committed (`python -m benchmarks.table_three`): a run of a
profile trains none of these networks but the flow.
"""

from __future__ import annotations

import pandas as pd

from pipeline.presentation.columns import ROBOT, SOLVER, count, number, text, under
from pipeline.presentation.table import Table
from pipeline.reporting.committed import committed
from pipeline.reporting.data import Topic

NAME = "table_three"
COLUMNS = (
    ROBOT,
    SOLVER,
    text("source", "Source"),
    text("of", "errors of"),
    *under(
        "Euclidean, geodesic",
        number("position_mm", "position [mm]"),
        number("rotation_deg", "rotation [deg]"),
    ),
    *under(
        "means over axes",
        number("paper_position_mm", "position [mm]"),
        number("paper_rotation_deg", "rotation [deg]"),
    ),
    number("call_ms", "time of 100 [ms]"),
    count("parameters", "parameters"),
    *under(
        "training",
        count("poses", "poses seen"),
        number("seconds", "processor time [s]", decimals=0),
        text("device", "device"),
    ),
)


def learned_methods(rows: pd.DataFrame) -> Table:
    """Return the table of rows with the columns' names."""
    return Table.of(
        rows,
        COLUMNS,
        name=NAME,
        title="Table III with every learned method, trained for the same time",
        caption="The published numbers beside networks of ours. *draws*: every draw counts with "
        "its own error, as IKFlow reports; *best*: the draw that forward kinematics finds nearest, "
        "which is what the solver answers. The published errors of CycleIK are means over axes, "
        "those of IKFlow and EEM Euclidean and geodesic; ours stand in both columns. Our time is "
        "the median processor time of a call of 100 poses on one thread, published times are of "
        "graphics processors.",
        notes=[
            "Networks other than CycleIK's are reduced re-implementations, trained for minutes "
            "where their authors train for hours or days: what stands here is what minutes give, "
            "not what the methods can reach."
        ],
    )


TOPIC = Topic(
    tables=(lambda data: committed(data.results, NAME, learned_methods),),
    stages=(),
)
