"""Talk to NICOL at its table: the embedded policy answers, no language model and no network.

Without the lines below `python -m pipeline chat robot=nicol` asks for yours; with agent=endpoint
a language model answers.
"""

import io
import sys

from pipeline import run_command

LINES = """\
What do you see?
Grasp the banana, then point at the orange.
Grasp the elephant.
quit
"""

sys.stdin = io.StringIO(LINES)  # in place of a person who types
print(LINES)
run_command("chat", ["robot=nicol", "experiment=refined_grasp", "results_dir=results/example"])
