"""Networks that answer inverse kinematics, trained through differentiable forward kinematics."""

import os

# PyTorch reads it at its first tensor, and then asks the kernel for huge pages where a tensor fills
# one: a step of a large network otherwise spends some tenth of its time on looking up small ones.
os.environ.setdefault("THP_MEM_ALLOC_ENABLE", "1")
