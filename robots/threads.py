"""Whether compiled kernels may use threads in this process.

The threads of numba and of OpenMP, which torch stands on, do not survive a fork: a child that
starts a parallel kernel waits for workers that its parent has. So a forked process stays on one
thread, with the same results; whoever wants threads in workers starts them by spawn.
"""

from __future__ import annotations

import os
import sys

_state = {"forked": False}


def forked() -> bool:
    """Whether this process is a fork of one that had loaded this package."""
    return _state["forked"]


def _note_fork() -> None:
    _state["forked"] = True
    torch = sys.modules.get("torch")
    if torch is not None and hasattr(torch, "set_num_threads"):
        torch.set_num_threads(1)  # as torch does in the workers of its own data loaders


os.register_at_fork(after_in_child=_note_fork)
