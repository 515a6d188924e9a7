"""Compare two results folders: what changed in configuration, and what it did to the figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from omegaconf import OmegaConf

from pipeline.data.files import read_json
from pipeline.errors import PipelineError

IGNORED = ("results_dir",)


def compare(arguments: list[str]) -> int:
    """Print the configuration keys and the metrics in which folders A and B differ."""
    if arguments[:1] in (["-h"], ["--help"]) or len(arguments) != 2:
        if len(arguments) != 2 and "-h" not in arguments and "--help" not in arguments:
            raise PipelineError("usage: python -m pipeline compare A B, two results folders")
        print("python -m pipeline compare A B: two results folders, such as those of a sweep")
        return 0
    first, second = (_folder(argument) for argument in arguments)
    print(f"A = {first}\nB = {second}\n")
    _print_differences("configuration", _configuration(first), _configuration(second))
    _print_differences("metrics", _metrics(first), _metrics(second))
    return 0


def _folder(argument: str) -> Path:
    folder = Path(argument)
    if not folder.is_dir():
        raise PipelineError(f"there is no folder {argument}; compare takes two results folders")
    return folder


def _configuration(folder: Path) -> dict[str, Any]:
    """Flat configuration of every artifact in a folder: `<stage>.<key>` and its value."""
    flat: dict[str, Any] = {}
    for path in sorted(folder.rglob("card.json")):
        if "sweep" in path.relative_to(folder).parts[:1]:
            continue
        stage = path.relative_to(folder).parts[0]
        flat.update(_flatten(read_json(path).get("config", {}), f"{stage}: "))
    if (folder / "config.yaml").exists():
        whole = OmegaConf.to_container(OmegaConf.load(folder / "config.yaml"))
        assert isinstance(whole, dict)
        told = {str(key): value for key, value in whole.items() if key not in IGNORED}
        flat.update(_flatten(told, "run: "))
    return flat


def _metrics(folder: Path) -> dict[str, Any]:
    """Flat metrics of every artifact in a folder, keys without the robot's and model's folders."""
    flat: dict[str, Any] = {}
    for path in sorted(folder.rglob("metrics.json")):
        parts = path.relative_to(folder).parts
        if parts[0] != "sweep":
            flat.update(_flatten(read_json(path), "/".join(parts[:-1]) + " "))
    return flat


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
