"""Model cards: what lies in a folder of shipped weights, for readers, from the card beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.data.files import read_json, write_text

CARD, TEXT = "card.json", "README.md"
HEAD = """\
---
license: mit
library_name: cycleik-bench
tags: [{tags}]
---
<!-- made from card.json by: python -m pipeline export-weights {words} -->
"""


def network_text(card: Mapping[str, Any]) -> str:
    """Return the model card of a network for inverse kinematics, in Markdown.

    Args:
        card: That lies beside its weights.
    """
    robot, test, train = card["robot"], card["test"], card["config"]["train"]
    return f"""{HEAD.format(tags="robotics, inverse-kinematics", words=f"robot={robot}")}
# Inverse kinematics of {robot}, model `{card["config"]["model"]["name"]}`

- **In**: a pose of `{card["tip"]}` in the frame of `{card["base"]}` (x y z [m], qw qx qy qz).
  **Out**: {len(card["joint_names"])} joints, base to tip: {", ".join(card["joint_names"])}.
- **Size**: {card["parameters"]:,} parameters, kept in {card["stored"]}.
- **Trained** on reachable poses that are free of self-collision, {train["epochs"]} epochs of
  batches of {train["batch_size"]:,}, loss `{train["loss"]}`, weighed {train["position_weight"]:g}
  for position and {train["rotation_weight"]:g} for rotation, seed {card["config"]["seed"]}, on a
  {card["device"]}; poses came from `python -m pipeline dataset robot={robot}`.
- **On {test["poses"]:,} test poses**, its best hypothesis, not refined: mean errors
  {test["position_error_mm"]:.2f} mm and {test["rotation_error_deg"]:.2f} deg (Euclidean, geodesic);
  {100 * test["success_10mm_20deg"]:.2f} % within 10 mm and 20 deg.
- **Use**: `load_solver("cycleik", robot)`, or `cycleik_refined` where millimetres are not enough.
- **Limits**: holds for this description of the robot alone (checksum in the card; another one is
  refused) and for poses of the distribution that it was trained on. No obstacles, no dynamics;
  an answer may be in self-collision. Nothing here was tried on a real robot.
- SHA-256 of the weights: `{card["weights_sha256"]}`.
"""


def detector_text(card: Mapping[str, Any]) -> str:
    """Return the model card of a detector of objects, in Markdown.

    Args:
        card: That lies beside its weights.
    """
    robot, held_out = card["robot"], card["held_out"]
    config = card["config"]["detector"]
    words = f"detector robot={robot}"
    return f"""{HEAD.format(tags="robotics, object-detection", words=words)}
# Detector of the objects on {robot}'s table

- **In**: a picture of the robot's camera. **Out**: centres and classes of
  {", ".join(card["names"])}.
- **Trained** on renderings of the simulated scene with random light, colours and distractors,
  {config["epochs"]} epochs of batches of {config["batch_size"]};
  `python -m pipeline detector robot={robot}` does it.
- **On {held_out["pictures"]} held-out renderings**: mAP50 {held_out["map50"]:.3f}, position error
  {held_out["position_error_mm"]:.1f} mm.
- **Limits**: it has seen no photograph, and no other camera, table or object than these.
- SHA-256 of the weights: `{card["weights_sha256"]}`.
"""


def write_model_card(folder: Path) -> None:
    """Write the model card of a folder of shipped weights beside its card."""
    card = read_json(folder / CARD)
    text = detector_text(card) if "held_out" in card else network_text(card)
    write_text(folder / TEXT, text)
