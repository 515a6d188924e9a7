"""The project under attack; each attack is a command of its own.

    python -m benchmarks.fuzzing urdfs --count 10000
    python -m benchmarks.fuzzing arguments --count 10000
    python -m benchmarks.fuzzing kills --count 20 --terminations 5 [--only train plan]
    python -m benchmarks.fuzzing files --count 20 [--only ...]
    python -m benchmarks.fuzzing disks --count 4 [--only train plan]

Prints what went wrong and puts the counts into results/studies/fuzzing.{csv,md}; status 1 if
anything went wrong. Hours of a machine: no test runs it.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.fuzzing.table import record

ATTACKS = ("urdfs", "arguments", "kills", "files", "disks")


def main() -> int:
    """Run one attack."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("attack", choices=ATTACKS)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--terminations", type=int, default=5)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="fuzzing-") as folder:
        rows = []
        for row in _rows(options, Path(folder)):
            print(row, flush=True)
            rows.append(row)
            record(row)
    return 1 if any(row["bad"] for row in rows) else 0


def _rows(options: argparse.Namespace, folder: Path) -> Iterator[dict[str, Any]]:
    chance = random.Random(options.seed)
    if options.attack == "kills":
        from benchmarks.fuzzing.kills import kill_stages

        yield from kill_stages(folder, options.count, options.terminations, chance, options.only)
    elif options.attack == "disks":
        from benchmarks.fuzzing.disks import attack_disks

        yield from attack_disks(folder, options.count, chance, options.only)
    elif options.attack == "files":
        from benchmarks.fuzzing.files import damage_files

        yield from damage_files(folder, options.count, chance, options.only)
    else:
        from benchmarks.fuzzing.inputs import fuzz_arguments, fuzz_urdfs

        yield (fuzz_urdfs if options.attack == "urdfs" else fuzz_arguments)(options.count, chance)


if __name__ == "__main__":
    sys.exit(main())
