"""What the eyes see of a calibrated and of a perturbed scene, and how long a look takes.

    python benchmarks/perception.py [nico nicol] [pictures]

Random layouts under the light of the trials: share of the objects that are found, and the error of
their place on the table, for each named perturbation of `conf/perception`. Times are processor time
of one thread. The limits of a calibrated scene: 8 mm on average, 20 mm for 95 %.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import torch

from pipeline.config import compose
from pipeline.perception.camera import EyeCamera
from pipeline.perception.config import PerturbationConfig
from pipeline.perception.distractors import lay_distractors
from pipeline.perception.layout import lay_out
from pipeline.perception.loading import load_detector, see
from pipeline.perception.studio import Studio
from robots import load_robot

CONFIG = compose(["perception=camera"])
VARIANTS = {
    "none": {},
    "pitch 0.25 deg": {"tilt": [0.0, 0.25, 0.0]},
    "pitch 1 deg": {"tilt": [0.0, 1.0, 0.0]},
    "yaw 1 deg": {"tilt": [0.0, 0.0, 1.0]},
    "10 mm to the left": {"shift": [0.0, 0.01, 0.0]},
    "10 mm ahead": {"shift": [0.01, 0.0, 0.0]},
    "lighting 1": {"lighting": 1.0},
    "5 distractors": {"distractors": 5},
}
LIMITS_MM = (8.0, 20.0)
PICTURES = 25


def main() -> None:
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    robots = [word for word in sys.argv[1:] if not word.isdigit()] or ["nico", "nicol"]
    torch.set_num_threads(1)
    print(f"{'robot':6} {'perturbation':18} {'found':>7} {'false':>6} {'mean':>6} {'95 %':>6} mm")
    for robot in robots:
        for line in measured(robot, numbers[0] if numbers else PICTURES):
            print(line)


def measured(name: str, pictures: int) -> Iterator[str]:
    robot, scene = load_robot(name), CONFIG.grasp.scenes[name]
    detector = load_detector(CONFIG.perception, robot, scene.objects)
    heights = {
        each: scene.table.height + 0.5 * CONFIG.grasp.objects[each].height for each in scene.objects
    }
    looking, detecting = [], []
    with Studio(robot, CONFIG.grasp, CONFIG.perception.eye, CONFIG.detector.visible) as studio:
        for variant, values in VARIANTS.items():
            wrong: PerturbationConfig = replace(CONFIG.perception.perturbation, **values)
            camera = EyeCamera(robot, CONFIG.perception.eye, wrong)
            objects, false, errors = 0, 0, []
            for number in range(pictures):
                draw = np.random.default_rng(number)
                laid = lay_out(draw, CONFIG.detector.training, scene, CONFIG.grasp.objects)
                places = {each.name: np.array(each.place) for each in laid}
                lay_distractors(
                    studio.scene.client, scene, wrong.distractors, draw, list(places.values())
                )
                begin = time.thread_time()
                image = studio.photograph(laid, camera.actual, camera.config).image
                looked = time.thread_time()
                seen = see(image, detector, camera, heights)
                looking.append(looked - begin)
                detecting.append(time.thread_time() - looked)
                objects += len(laid)
                for each in seen:
                    if each.name in places:
                        there = places.pop(each.name)
                        errors.append(1e3 * np.hypot(*(each.position[:2] - there)))
                    else:
                        false += 1
            mean, most = np.mean(errors), np.percentile(errors, 95)
            yield (
                f"{name:6} {variant:18} {len(errors):>3}/{objects:<3} {false:>6} {mean:6.1f} "
                f"{most:6.1f}" + limit(variant, mean, most)
            )
    yield (
        f"{name:6} a look: {1e3 * np.median(looking):.0f} ms to render 640 x 480, "
        f"{1e3 * np.median(detecting):.0f} ms to detect"
    )


def limit(variant: str, mean: float, most: float) -> str:
    if variant != "none":
        return ""
    kept = mean <= LIMITS_MM[0] and most <= LIMITS_MM[1]
    return f"  (at most {LIMITS_MM[0]:g}, {LIMITS_MM[1]:g}: {'kept' if kept else 'NOT KEPT'})"


if __name__ == "__main__":
    main()
