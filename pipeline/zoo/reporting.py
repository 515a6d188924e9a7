"""The zoo as a table with a verdict, and as a figure."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd
from matplotlib.figure import Figure
from scipy import stats

from pipeline.presentation.columns import count, number, share, text, under
from pipeline.presentation.style import LOOKS, panels
from pipeline.presentation.table import Table
from pipeline.zoo.arms import ZooConfig

NAME = "zoo"
CAUSES = {  # what the gain is looked at against
    "joints": "joints",
    "range_rad": "mean range of the turning joints [rad]",
    "home_first_start": "share that lm solves from home without a restart",
}
GAINS = {"gain_iterations": "iterations", "gain_time": "time with the network"}
COLUMNS = (
    text("arm", "Arm"),
    count("joints", "joints"),
    number("range_rad", "range [rad]"),
    number("training_s", "training [s]"),
    *under("network alone", number("network_mm", "[mm]"), number("network_deg", "[deg]")),
    *under(
        "lm from home",
        number("home_iterations", "iterations"),
        share("home_first_start", "no restart [%]", decimals=1),
        share("home_found", "found [%]", decimals=2),
        number("home_time_us", "a pose [µs]"),
    ),
    *under(
        "from the network's best",
        number("seeded_iterations", "iterations"),
        share("seeded_first_start", "no restart [%]", decimals=1),
        share("seeded_found", "found [%]", decimals=2),
        number("seeded_time_us", "a pose [µs]"),
    ),
    *under(
        "gain", number("gain_iterations", "iterations"), number("gain_time", "time", decimals=2)
    ),
)


def table_of(rows: pd.DataFrame, zoo: ZooConfig, notes: Sequence[str]) -> Table:
    """Return the table of the zoo's rows, the fewest joints first.

    Args:
        rows: A row an arm, see `pipeline.zoo.study.row_of`.
        zoo: Sizes of the study.
        notes: What is to be said besides: arms that were left out.
    """
    return Table.of(
        rows.sort_values(["joints", "arm"]),
        COLUMNS,
        name=NAME,
        title="The zoo: where a neural seed pays",
        caption=f"A compact network for each arm, trained for {zoo.minutes:g} minutes of one core "
        f"(by results/rates.csv; *training*: processor time); {zoo.poses:,} free poses in one "
        "batch, one thread, times of the processor: the compiled Levenberg-Marquardt from home and "
        "from the network's best hypothesis. *range*: mean of the turning joints, endless ones "
        "count as a full turn. *gain*: home over network; time includes the network's.",
        notes=[*verdict(rows), *notes],
    )


def verdict(rows: pd.DataFrame) -> list[str]:
    """Return in sentences what the gain goes with and where a seed pays."""
    if len(rows) < 3:
        return []
    pays = rows[rows.gain_time > 1]
    names = ", ".join(pays.sort_values("gain_time", ascending=False).arm)
    fewer = int((rows.gain_iterations > 1).sum())
    found = [
        f"The network's seed saves iterations on {fewer} of {len(rows)} arms (median gain "
        f"{rows.gain_iterations.median():.2f}), and time, the network counted, on {len(pays)}"
        f"{': ' + names if len(pays) else ''} (median gain {rows.gain_time.median():.2f})."
    ]
    parts = []
    for cause, title in CAUSES.items():
        rank = stats.spearmanr(rows[cause], rows.gain_iterations).statistic
        parts.append(f"{rank:+.2f} with {title.partition(' [')[0]}")
    found.append(f"Rank correlation of the gain in iterations: {'; '.join(parts)}.")
    return found


def figure_of(rows: pd.DataFrame) -> Figure:
    """Return the gain in iterations and in time against what may cause it, a mark an arm."""
    figure, axes = panels(len(CAUSES), 3.6, 3.4)
    for axis, (cause, title) in zip(axes, CAUSES.items(), strict=True):
        axis.axhline(1.0, color="0.6", linewidth=0.8, zorder=0)
        for (gain, what), look in zip(GAINS.items(), LOOKS, strict=False):
            axis.plot(
                rows[cause],
                rows[gain],
                linestyle="",
                marker=look.marker,
                color=look.colour,
                label=what,
            )
        for row in rows.itertuples():
            axis.annotate(
                str(row.arm),
                (getattr(row, cause), row.gain_iterations),
                xytext=(3, 3),
                textcoords="offset points",
                fontsize=5,
                color="0.35",
            )
        axis.set_xlabel(title)
    axes[0].set_ylabel("gain over home, by")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(GAINS))
    return figure
