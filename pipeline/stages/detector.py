"""Stage detector: render, train and evaluate the embedded detector of a robot's objects."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.closure import source_tree
from pipeline.containers import to_dict
from pipeline.data.files import write_json
from pipeline.data.tables import write_table
from pipeline.evaluation.detections import summary
from pipeline.grasping.trial import required_scene
from pipeline.learning.networks import parameter_count
from pipeline.perception.camera import mounted
from pipeline.perception.embedded import EmbeddedDetector
from pipeline.perception.figures import draw_detections, draw_errors
from pipeline.perception.judging import judge
from pipeline.perception.network import CentreNetwork
from pipeline.perception.pictures import Chunk, Pictures, render_pictures
from pipeline.perception.training import DetectorTrainer
from pipeline.perception.weights import (
    CARD,
    halved,
    load_centre_network,
    read_detector_card,
    save_detector,
)
from pipeline.progress import bar
from pipeline.seeding import derive_seed
from pipeline.solvers import displayed_path
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.stages.shipped import SHIPPED, shipped_eyes
from robots import Robot

if TYPE_CHECKING:
    from pipeline.settings import Config

TIMES = ("render_core_s", "train_core_s")  # processor time that a training took [s]
ANY_SCORE = 0.01  # least score of the raw rows; precision and recall at any above follow from them


def run(config: Config) -> list[Path]:
    """Write weights.safetensors, card.json, errors.parquet, metrics.json and two figures.

    With `detector.from=shipped` the project's detector is judged, and none is trained.
    """
    robot = robot_of(config)
    names = tuple(required_scene(config.grasp, robot.name).objects)
    wanted, folders = config.detector, artifacts(config)
    folder = folders.detector(robot.name)
    seed = derive_seed(config.seed, "detector", robot.name)
    code = source_tree().digest(__name__)
    digest = provenance.digest([_facts(config, robot), provenance.versions(), seed])
    resumed = provenance.digest([digest, code])  # the card does not know the code: grasps read it
    work = folders.root / "checkpoint" / f"detector-{robot.name}-{resumed}"
    with exclusive(folder):
        network, training = _network(config, robot, work, seed, resumed)
        detector = EmbeddedDetector(
            halved(network), replace(config.perception, threshold=ANY_SCORE)
        )
        held_out = _pictures(config, robot, work, held_out=True)
        with bar(len(held_out), "picture", f"held out {robot.name}") as shown:
            rows = judge(detector, held_out, wanted.match_overlap, shown.update)
        metrics = summary(rows, config.perception.threshold)
        card = provenance.card(
            "detector",
            config=config,
            robot=robot.name,
            names=list(network.names),
            parameters=parameter_count(network),
            urdf_checksum=robot.urdf_checksum,
            run=digest,
            stored="float16",
            held_out=metrics,
            threshold=config.perception.threshold,
            **training,
        )
        write_table(
            folder / "errors.parquet", rows, {**card, **provenance.signature(config.profile)}
        )
        times = {name: training[name] for name in TIMES if name in training}
        write_json(
            folder / "metrics.json", metrics if SHIPPED in training else {**metrics, **times}
        )
        draw_errors(folder, rows, names)
        sure = EmbeddedDetector(network, config.perception)
        if wanted.figure_pictures:
            draw_detections(folder / "detections.png", sure, held_out, wanted.figure_pictures)
        save_detector(folder, network, card)
        _clear(work)
    return [folder, folder / CARD]


def _network(
    config: Config, robot: Robot, work: Path, seed: int, resumed: str
) -> tuple[CentreNetwork, dict[str, Any]]:
    """The detector that is judged, trained here or the project's, and how it was trained."""
    names = tuple(required_scene(config.grasp, robot.name).objects)
    if config.detector.source == SHIPPED and (shipped := shipped_eyes(config)) is not None:
        card = read_detector_card(shipped, robot.name)
        known = {name: card[name] for name in ("curve", *TIMES) if name in card}
        network = load_centre_network(shipped, robot.name, names)
        return network, {**known, SHIPPED: displayed_path(shipped)}
    pictures = _pictures(config, robot, work, held_out=False)
    trainer = DetectorTrainer(config.detector, pictures, names, seed)
    trained = trainer.fit(work / "state.safetensors", resumed, f"detector {robot.name}")
    spent = (pictures.core_s, sum(row["core_s"] for row in trained.curve))
    return trained.network, {"curve": trained.curve, **dict(zip(TIMES, spent, strict=True))}


def _facts(config: Config, robot: Robot) -> dict[str, Any]:
    """What pictures and training depend on."""
    scene = required_scene(config.grasp, robot.name)
    return {
        "detector": to_dict(config.detector),
        "eye": to_dict(config.perception.eye),
        "scene": [
            to_dict(scene.table),
            to_dict(scene.area),
            {k: to_dict(v) for k, v in scene.bins.items()},
        ],
        "names": list(scene.objects),  # their order is that of the classes
        "objects": {name: to_dict(config.grasp.objects[name]) for name in scene.objects},
        "posture": [robot.home.tolist(), dict(scene.hand.preshape)],
        "camera": [mounted(robot).pose.tolist(), mounted(robot).focal],
        "urdf": robot.urdf_checksum,
    }


def _pictures(config: Config, robot: Robot, work: Path, held_out: bool) -> Pictures:
    """Render a set: training as large as the network's input, held out as the eye's picture."""
    wanted, eye = config.detector, mounted(robot)
    kind = "held_out" if held_out else "training"
    count = wanted.held_out_pictures if held_out else wanted.pictures
    network = (wanted.network.width, wanted.network.height)
    chunks = [
        Chunk(
            robot=robot.name,
            grasp=config.grasp,
            eye=config.perception.eye,
            domain=wanted.held_out if held_out else wanted.training,
            visible=wanted.visible,
            size=(eye.width, eye.height) if held_out else network,
            first=first,
            count=min(wanted.chunk, count - first),
            seed=derive_seed(config.seed, "detector", robot.name, kind),
            path=work / f"{kind}-{first:06d}.npy",
        )
        for first in range(0, count, wanted.chunk)
    ]
    return render_pictures(chunks, config.engine, f"{kind.replace('_', ' ')} {robot.name}")


def _clear(work: Path) -> None:
    """Remove pictures and state of a finished run; hundreds of megabytes that can be made again."""
    for path in work.iterdir():
        path.unlink()
    work.rmdir()
