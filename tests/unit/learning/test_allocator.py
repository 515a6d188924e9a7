"""Pages of large tensors: requested once, not at every step, and huge where it can be."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.learning.allocator import keep_freed_memory

# In a process of its own: what a process has freed before shapes what it gets.
PROGRAM = """
import resource, sys, torch
from pipeline.learning.allocator import keep_freed_memory
if sys.argv[1] == "kept":
    assert keep_freed_memory()
def step():
    return [torch.ones(1500, 1500) for _ in range(12)]
step(); step()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(5):
    step()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""

HUGE = """
import pipeline.learning.trainer, torch
kept = torch.ones(16 * 2**20)
lines = open("/proc/self/smaps").read().splitlines()
print(sum(int(line.split()[1]) for line in lines if line.startswith("AnonHugePages")))
"""
HUGE_PAGES = "THP_MEM_ALLOC_ENABLE"
SWITCH = Path("/sys/kernel/mm/transparent_hugepage/enabled")


def faults(how: str) -> int:
    # Small pages only: a huge one is one fault, however it came. The threshold is glibc's first
    # one; left alone it moves with what a process happens to have freed.
    return printed(PROGRAM, how, **{HUGE_PAGES: "0", "MALLOC_MMAP_THRESHOLD_": str(128 * 1024)})


def printed(*program: str, **environment: str) -> int:
    command = [sys.executable, "-c", *program]
    inherited = {name: value for name, value in os.environ.items() if name != HUGE_PAGES}
    done = subprocess.run(
        command, capture_output=True, check=True, text=True, env=inherited | environment
    )
    return int(done.stdout)


@pytest.mark.skipif(not keep_freed_memory(), reason="the C library is not glibc")
def test_freed_tensors_are_used_again() -> None:
    pages = 5 * 12 * 1500 * 1500 * 4 // resource.getpagesize()
    # Three of the sixty tensors may still meet new pages, where the heap has holes (glibc 2.41).
    assert faults("kept") < 0.1 * pages < 0.5 * pages < faults("as ever")


@pytest.mark.skipif(
    not SWITCH.exists() or "[never]" in SWITCH.read_text(), reason="the kernel has no huge pages"
)
def test_large_tensors_lie_on_huge_pages() -> None:
    size_kib = 16 * 2**20 * 4 // 1024
    assert printed(HUGE) > 0.9 * size_kib
