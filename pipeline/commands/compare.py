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
        flat.update(_flatten({k: v for k, v in whole.items() if k not in IGNORED}, "run: "))
    return flat


def _metrics(folder: Path) -> dict[str, Any]:
    """Flat metrics of every artifact in a folder, keys without the robot's and model's folders."""
    flat: dict[str, Any] = {}
    for path in sorted(folder.rglob("metrics.json")):
        parts = path.relative_to(folder).parts
        if parts[0] != "sweep":
            flat.update(_flatten(read_json(path), "/".join(parts[:-1]) + " "))
    return flat


def _flatten(node: Any, prefix: str) -> dict[str, Any]:
    if not isinstance(node, dict):
        return {prefix.rstrip("."): node}
    flat: dict[str, Any] = {}
    for key, value in node.items():
        flat.update(_flatten(value, f"{prefix}{key}." if isinstance(value, dict) else f"{prefix}{key}"))
    return flat


def _print_differences(title: str, first: dict[str, Any], second: dict[str, Any]) -> None:
    keys = [key for key in sorted({*first, *second}) if first.get(key) != second.get(key)]
    print(f"{title}: {len(keys)} of {len({*first, *second})} differ" if keys else f"{title}: the same")
    if not keys:
        print()
        return
    rows = [(key, _show(first.get(key)), _show(second.get(key)), _change(first.get(key), second.get(key))) for key in keys]
    widths = [max(len(row[column]) for row in [*rows, ("", "A", "B", "B - A")]) for column in range(4)]
    for row in [("", "A", "B", "B - A"), *rows]:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        print("  " + "  ".join(cells).rstrip())
    print()


def _show(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _change(first: Any, second: Any) -> str:
    numbers = (int, float)
    if isinstance(first, numbers) and isinstance(second, numbers) and not isinstance(first, bool):
        share = f" ({(second - first) / first:+.1%})" if first else ""
        return f"{second - first:+.6g}{share}"
    return ""
