"""Decide claims of the paper by small experiments.

    python -m benchmarks.claims domain labels signs epochs
    python -m benchmarks.claims batches [--networks results/paper/train]
    python -m benchmarks.claims misses --rows results/quick/evaluate results/paper/evaluate

Each prints its rule, its rows and its verdict, and writes them to results/studies/claim_NAME.*;
results/claims.yaml takes the verdicts from there. Seconds for the first two, 45 minutes
of a core for `epochs`, one to twenty for the others.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import shlex
from pathlib import Path

from benchmarks.studies import write_study

EXPERIMENTS = ("batches", "domain", "labels", "signs", "epochs", "misses")


def main() -> None:
    """Run what is named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("experiments", nargs="+", choices=EXPERIMENTS)
    parser.add_argument("--networks", type=Path, help="results/paper/train with Table I's networks")
    parser.add_argument("--rows", nargs="+", type=Path, help="folders results/<profile>/evaluate")
    options = parser.parse_args()
    for name in options.experiments:
        module = importlib.import_module(f"benchmarks.claims.{name}")
        wanted = inspect.signature(module.run).parameters
        table, verdict = module.run(**{key: getattr(options, key) for key in wanted})
        rule = " ".join((module.__doc__ or "").split())
        text = f"{rule}\n\n{table.to_markdown(index=False, floatfmt='.4g')}\n\n{verdict}"
        print(text, flush=True)
        given = [word for key in wanted for word in _option(key, getattr(options, key))]
        command = shlex.join(["python", "-m", "benchmarks.claims", name, *given])
        write_study(module.NAME, table, text, command, module.SEEDS)


def _option(name: str, value: Path | list[Path] | None) -> list[str]:
    """Words of the command line that give an option a value; none without one."""
    values = value if isinstance(value, list) else [value]
    return [f"--{name}", *map(str, values)] if value else []


if __name__ == "__main__":
    main()
