"""A generated header, compiled and called with whole batches: what checks and timings stand on."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import PipelineError
from pipeline.exporting.c_header import driver_text
from pipeline.exporting.source import Source

Array = NDArray[np.float64]

COMPILERS = ("cc", "gcc", "clang")
FLAGS = ("-std=c99", "-O2")


def find_compiler() -> str | None:
    """Return a compiler of C, that of the variable CC first; None where there is none."""
    named = os.environ.get("CC")
    wanted = (named,) if named else COMPILERS
    return next((found for name in wanted if (found := shutil.which(name))), None)


class CompiledHeader:
    """The functions of a header for arrays.

    Args:
        source: What the header was made of.
        path: The header.
        flags: Options of the compiler.

    Raises:
        PipelineError: There is no compiler, or the header does not compile.
    """

    def __init__(self, source: Source, path: Path, flags: Sequence[str] = FLAGS) -> None:
        self._dof = source.robot.dof
        with tempfile.TemporaryDirectory() as folder:
            program, library = Path(folder) / "driver.c", Path(folder) / "driver.so"
            program.write_text(driver_text(source, path.absolute()), encoding="utf-8")
            compile_c([*flags, "-shared", "-fPIC", str(program), "-o", str(library), "-lm"])
            self._library = ctypes.CDLL(str(library))

    def forward_kinematics(self, joints: Array) -> Array:
        """Poses (N, 7) of joints (N, dof)."""
        given, poses = _doubles(joints), np.empty((len(joints), 7))
        self._library.batch_fk(_pointer(given), len(given), _pointer(poses))
        return poses

    def network(self, poses: Array) -> tuple[Array, NDArray[np.intc]]:
        """The network's joints (N, dof) for poses (N, 7), and which heads (N,) they are of."""
        given, joints = _doubles(poses), np.empty((len(poses), self._dof))
        heads = np.empty(len(poses), dtype=np.intc)
        self._library.batch_network(_pointer(given), len(given), _pointer(joints), _pointer(heads))
        return joints, heads

    def solve(self, poses: Array, initial: Array | None = None) -> tuple[Array, NDArray[np.bool_]]:
        """Joints (N, dof) for poses (N, 7), and which are found; `initial` (N, dof) or None."""
        given, joints = _doubles(poses), np.empty((len(poses), self._dof))
        found = np.empty(len(poses), dtype=np.intc)
        guess = None if initial is None else _doubles(initial)
        start = None if guess is None else _pointer(guess)
        self._library.batch_solve(
            _pointer(given), len(given), start, _pointer(joints), _pointer(found)
        )
        return joints, found == 1


def compile_c(arguments: Sequence[str]) -> None:
    """Run the compiler.

    Raises:
        PipelineError: There is none, or it refuses.
    """
    compiler = find_compiler()
    if compiler is None:
        raise PipelineError(f"there is no compiler of C: expected one of {', '.join(COMPILERS)}")
    done = subprocess.run([compiler, *arguments], capture_output=True, text=True)
    if done.returncode:
        raise PipelineError(f"{compiler} refuses the file: {' '.join(done.stderr.split())}")


def _doubles(array: Array) -> Array:
    return np.ascontiguousarray(array, dtype=np.float64)


def _pointer(array: NDArray[np.float64] | NDArray[np.intc]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
