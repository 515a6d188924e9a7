"""Solvers on a CUDA device in the protocols of others; see `__main__`."""
