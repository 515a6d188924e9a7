"""How well a solver does: errors, success, time and the statistics of all three.

`runner.evaluate_solver` gives raw rows, `metrics` the errors in them, `statistics` what can be said
of them.
"""
