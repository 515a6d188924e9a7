"""Networks that answer inverse kinematics, trained through differentiable forward kinematics."""

import os

# PyTorch reads it at its first tensor, and then requests huge pages from the kernel where a tensor
# fills one: a step of a large network otherwise spends a tenth of its time on finding small ones.
os.environ.setdefault("THP_MEM_ALLOC_ENABLE", "1")
