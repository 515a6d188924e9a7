"""The table of measurements, and the device they come from."""

from __future__ import annotations

import csv
import platform
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FIELDS = [
    *("device", "robot", "protocol", "solver", "tolerance_m", "batch", "poses", "collision_free"),
    *("third_ms", "device_ms", "host_ms", "us_a_pose"),
    *("success_5mm_0.05rad", "success_1mm_1deg", "within_tolerance", "found"),
    *("p98_mm", "p98_rad", "mean_mm", "iterations", "first_s", "note"),
]


class Rows:
    """The table, written row by row, and the time that is left for it."""

    def __init__(self, path: Path, budget_s: float) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path, self.end = path, time.perf_counter() + budget_s
        with path.open("w", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, FIELDS).writeheader()

    @property
    def open(self) -> bool:
        """Whether another row may begin."""
        return time.perf_counter() < self.end

    def add(self, **values: Any) -> None:
        """Write a row."""
        rounded = {k: f"{v:.6g}" if isinstance(v, float) else v for k, v in values.items()}
        with self.path.open("a", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, FIELDS).writerow(rounded)
        shown = ("robot", "protocol", "solver", "tolerance_m", "batch", "device_ms", "host_ms")
        more = ("success_1mm_1deg", "within_tolerance", "p98_mm", "note")
        print(*(f"{key}={rounded.get(key)}" for key in (*shown, *more)), flush=True)


def device_name() -> str:
    from numba import cuda

    device = getattr(cuda, "get_current_device", object)()
    name = getattr(device, "name", "simulator")
    return name.decode() if isinstance(name, bytes) else str(name)


def processor() -> str:
    """Name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
