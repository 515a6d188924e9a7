"""Let Panda pick an object of one's own from the table and drop it in a bin, in simulation."""

from pathlib import Path

import pandas as pd

from pipeline import run_command

# Primitives with size [m], place [m] and rotation [deg] in the object's frame; mass [kg].
PARTS = """[
  {shape: cylinder, size: [0.02, 0.09], position: [0, 0, 0], rotation: [0, 0, 0],
   colour: [0.9, 0.4, 0.1, 1]}]"""
BOTTLE = f"""{{mass: 0.15, friction: 1.0, rolling_friction: 1.0e-4, spinning_friction: 1.0e-3,
  height: 0.09, parts: {PARTS}}}"""
RESULTS = "results/example"

run_command(
    "grasp",
    [
        "robot=panda",
        "experiment=refined_grasp",
        "grasp.solver=lm",
        f"+grasp.objects.bottle={' '.join(BOTTLE.split())}",
        "grasp.scenes.panda.objects=[bottle]",
        "grasp.trials=2",
        f"results_dir={RESULTS}",
    ],
)
folder = Path(RESULTS) / "grasp/panda"
rows = pd.read_parquet(folder / "trials.parquet")
print(rows[["trial", "object", "x_m", "y_m", "class", "reason"]].to_string(index=False))
print("film:", *folder.glob("*.mp4"))
