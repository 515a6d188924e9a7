"""A live view in the browser: answers of solvers to a target that is dragged, and grasp trials.

What is shown (`comparison`, `session`, `null_space`, `clip`, `recording`) knows nothing of viser,
the library by which `server`, `scene`, `panel` and `replay` draw it.
"""
