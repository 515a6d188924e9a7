"""Tables of what the trainings of this package wrote: which first draws learn, and Table I.

    python -m benchmarks.accelerator.tables results/studies/accelerator/runs.jsonl

Writes stability.{csv,md} and table_one.{csv,md} beside the file.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.evaluation.statistics import wilson_interval
from pipeline.presentation.origin import Origin
from pipeline.presentation.table import write_origin

SATURATED = 0.5  # share of outputs where tanh is flat, above which a network is lost
PUBLISHED = Path(__file__).parents[2] / "results" / "published_results.csv"


def read_rows(path: Path) -> pd.DataFrame:
    """One line a training, its label split into group, robot, recipe and draw."""
    rows: list[dict[str, Any]] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        row = json.loads(line)
        last = row["curve"][-1]
        flat = {f"{key}": value for key, value in row.get("test", {}).get("float32", {}).items()}
        rows.append({**row, **flat, **{f"validation_{k}": v for k, v in last.items()}})
    return pd.DataFrame(rows)


def stability(rows: pd.DataFrame) -> pd.DataFrame:
    """Draws of first weights that are lost after 1,500 steps, by robot and recipe."""
    kept = rows[rows.label.str.startswith("stability/")].copy()
    kept["recipe"] = kept.label.str.split("/").str[2]
    lost = kept.outputs_saturated > SATURATED
    table = (
        kept.assign(lost=lost, alive_mm=kept.validation_position_error_mm.where(~lost))
        .groupby(["robot", "recipe"])
        .agg(draws=("label", "size"), saturated=("lost", "sum"), position_mm=("alive_mm", "median"))
        .reset_index()
    )
    total = table.groupby("recipe")[["draws", "saturated"]].sum().reset_index()
    total["robot"], total["position_mm"] = "all", float("nan")
    table = pd.concat([table, total], ignore_index=True)
    bounds = [wilson_interval(int(r.saturated), int(r.draws), 0.95) for r in table.itertuples()]
    table["low"] = [round(bound.low, 3) for bound in bounds]
    table["high"] = [round(bound.high, 3) for bound in bounds]
    return table.round({"position_mm": 1})


def table_one(rows: pd.DataFrame) -> pd.DataFrame:
    """Errors of the finished networks of Table I on the whole test set."""
    kept = rows[rows.label.str.match(r"(table|published)/")]
    columns = {
        "label": "training",
        "robot": "robot",
        "poses": "test_poses",
        "paper_position_mm_mean": "paper_position_mm",
        "paper_rotation_deg_mean": "paper_rotation_deg",
        "paper_success": "paper_success",
        "position_mm_mean": "position_mm",
        "rotation_deg_mean": "rotation_deg",
        "success_10mm_20deg": "success_10mm_20deg",
        "outputs_saturated": "outputs_saturated",
        "seconds": "training_s",
        "device": "device",
        "date": "date",
    }
    return kept[list(columns)].rename(columns=columns).round(4)


def origin(rows: pd.DataFrame, command: str) -> Origin:
    """What made the rows: a training says its device, seed and day; the commit is not in it."""
    found = {
        name: ", ".join(sorted({str(value) for value in rows.get(column, []) if value == value}))
        for name, column in (("date", "date"), ("processor", "device"))
    }
    said = {name: value for name, value in found.items() if value}
    return Origin(command, **said, seeds="of each row of runs.jsonl", profile="paper")


def write(table: pd.DataFrame, path: Path, title: str, made_by: Origin) -> None:
    """CSV, the same as Markdown, and its origin in both."""
    table.to_csv(path.with_suffix(".csv"), index=False)
    head = "| " + " | ".join(table.columns) + " |\n" + "|---" * len(table.columns) + "|\n"
    body = "".join(
        "| " + " | ".join(map(str, row)) + " |\n" for row in table.itertuples(index=False)
    )
    text = f"{title}\n\n{head}{body}\n{made_by.sentence()}\n"
    path.with_suffix(".md").write_text(text, encoding="utf-8")
    write_origin(path.parent, path.stem, made_by)


def main() -> None:
    """Write both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", type=Path, help="runs.jsonl")
    path = parser.parse_args().runs
    rows = read_rows(path)
    made_by = origin(rows, f"python -m benchmarks.accelerator.tables {path.as_posix()}")
    made = f"made by `python -m benchmarks.accelerator.tables {path.as_posix()}`"
    write(
        stability(rows),
        path.parent / "stability",
        f"<!-- {made} -->\n**First draws of Table I's weights after 1,500 steps**, the published "
        "recipe (no warm-up, no clipping) and the same with 500 steps of warm-up; a network is "
        f"lost where more than {SATURATED:.0%} of its outputs lie where tanh is flat. Median "
        "validation error of the others, Euclidean; Wilson interval of the share that is lost.",
        made_by,
    )
    write(
        table_one(rows),
        path.parent / "table_one",
        f"<!-- {made} -->\n**Networks of Table I trained on an accelerator**, whole test set; "
        "`published` trains without warm-up and clipping.",
        made_by,
    )


if __name__ == "__main__":
    main()
