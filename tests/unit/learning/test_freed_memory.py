"""Gradients of a large network: their pages are asked of the kernel once, not at every step."""

from __future__ import annotations

import resource
import subprocess
import sys

import pytest

from pipeline.learning.memory import keep_freed_memory

# In a process of its own: what a process has freed before shapes what it gets.
PROGRAM = """
import resource, sys, torch
from pipeline.learning.memory import keep_freed_memory
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


def faults(how: str) -> int:
    command = [sys.executable, "-c", PROGRAM, how]
    return int(subprocess.run(command, capture_output=True, check=True, text=True).stdout)


@pytest.mark.skipif(not keep_freed_memory(), reason="the C library is not glibc")
def test_freed_tensors_are_used_again() -> None:
    pages = 5 * 12 * 1500 * 1500 * 4 // resource.getpagesize()
    assert faults("kept") < 0.02 * pages < 0.5 * pages < faults("as ever")
