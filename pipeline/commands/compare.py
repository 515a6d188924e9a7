"""Compare two results folders: what changed in configuration, and what it did to the figures."""

from __future__ import annotations

from argparse import ArgumentTypeError
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
from omegaconf import OmegaConf

from pipeline.commands.arguments import command_parser
from pipeline.config import compose
from pipeline.data.files import read_json
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.metrics_file import headline_metrics
from pipeline.reporting.results import STAGES, Results, read_results
from pipeline.reporting.summary import summarise

IGNORED = ("results_dir",)
EVALUATED = ("profile", "seed", "poses", "evaluate", "solver_budget")  # of the raw rows' provenance
COMPUTED = ("evaluate", "plan")  # stages that leave raw rows and no metrics.json


def compare(arguments: list[str]) -> int:
    """Print the configuration keys and the metrics in which folders A and B differ."""
    parser = command_parser("compare", "What two results folders differ in.")
    parser.add_argument("first", metavar="A", type=_folder, help="a results folder")
    parser.add_argument("second", metavar="B", type=_folder, help="another one")
    options = parser.parse(arguments)
    first, second = options.first, options.second
    print(f"A = {first}\nB = {second}\n")
    a, b = read_results(first), read_results(second)
    _print_differences("configuration", _configuration(a), _configuration(b))
    config = replace(compose().report, resamples=1)  # intervals are not shown
    _print_differences("metrics", _metrics(a, config), _metrics(b, config))
    return 0


def _folder(argument: str) -> Path:
    folder = Path(argument)
    if not folder.is_dir():
        raise ArgumentTypeError(f"there is no folder {argument}")
    return folder


def _configuration(results: Results) -> dict[str, Any]:
    """Flat configuration of every artifact: `<its folder>: <key>` and its value.

    Raw rows of the evaluate stage have no card; what made them lies in the file itself.
    """
    folder, flat = results.folder, dict[str, Any]()
    for path, place in _artifacts(folder, "card.json"):
        flat.update(_flatten(read_json(path).get("config") or {}, f"{place}: "))
    for (robot, solver), facts in results.evaluated.items():
        evaluated = {key: facts[key] for key in EVALUATED if facts.get(key) is not None}
        evaluated["solver"] = (facts.get("solver_identity") or {}).get("settings") or {}
        flat.update(_flatten(evaluated, f"evaluate/{robot}/{solver}: "))
    if (folder / "config.yaml").exists():
        whole = OmegaConf.to_container(OmegaConf.load(folder / "config.yaml"))
        assert isinstance(whole, dict)
        of_run = {str(key): value for key, value in whole.items() if key not in IGNORED}
        flat.update(_flatten(of_run, "run: "))
    return flat


def _metrics(results: Results, config: ReportConfig) -> dict[str, Any]:
    """Flat metrics of every artifact: what stages wrote, and the report's figures of raw rows."""
    flat: dict[str, Any] = {}
    for path, place in _artifacts(results.folder, "metrics.json"):
        flat.update(_flatten(read_json(path), f"{place} "))
    lines = [summarise(rows, config) for rows in results.evaluate.values()]
    summary = pd.concat(lines, ignore_index=True) if lines else pd.DataFrame()
    headline = headline_metrics(results, summary)
    for stage in COMPUTED:
        for robot, solvers in headline.get(stage, {}).items():
            for solver, numbers in solvers.items():
                flat.update(_flatten(numbers, f"{stage}/{robot}/{solver} "))
    return flat


def _artifacts(folder: Path, name: str) -> Iterator[tuple[Path, str]]:
    """Files called ``name`` of the stages, each with its folder relative to ``folder``.

    Those of a sweep's runs belong to other folders, and the report's are of the time it was made.
    """
    for stage in STAGES:
        for path in sorted((folder / stage).rglob(name)):
            yield path, path.parent.relative_to(folder).as_posix()


def _flatten(node: dict[str, Any], prefix: str) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in node.items():
        name = f"{prefix}{key}"
        flat.update(_flatten(value, f"{name}.") if isinstance(value, dict) else {name: value})
    return flat


def _print_differences(title: str, first: dict[str, Any], second: dict[str, Any]) -> None:
    every = sorted({*first, *second})
    keys = [key for key in every if first.get(key) != second.get(key)]
    if not keys:
        print(f"{title}: the same\n")
        return
    print(f"{title}: {len(keys)} of {len(every)} differ")
    rows = [("", "A", "B", "B - A")]
    for key in keys:
        a, b = first.get(key), second.get(key)
        rows.append((key, _show(a), _show(b), _change(a, b)))
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        print("  " + "  ".join(cells).rstrip())
    print()


def _show(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _change(first: Any, second: Any) -> str:
    if any(
        not isinstance(value, int | float) or isinstance(value, bool) for value in (first, second)
    ):
        return ""
    share = f" ({(second - first) / first:+.1%})" if first else ""
    return f"{second - first:+.6g}{share}"
