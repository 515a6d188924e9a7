"""Trials with an agent from the configuration of a run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.agent.endpoint import resolved
from pipeline.agent.gguf_file import model_file
from pipeline.agent.loading import agent_factory, kind_of
from pipeline.containers import to_dict
from pipeline.data.files import sha256
from pipeline.embodiment.perception import CameraPerception, make_perception
from pipeline.embodiment.series import AgentSeries
from pipeline.embodiment.trials import Experiment
from pipeline.evaluation.cache import network_checksums
from pipeline.grasping.series import Series
from pipeline.perception.detection import Detector
from pipeline.speech.loop import load_ear

if TYPE_CHECKING:
    from pipeline.settings import Config

EVIDENCE = "evidence"  # folder of transcripts and pictures beside the rows


def is_embodied(config: Config) -> bool:
    """Whether a run's trials are those with a camera or an agent: all objects on a row."""
    return config.perception.source != "perfect" or config.agent.kind != "none"


def setting_name(config: Config) -> str:
    """Name of the folder of such trials, such as `camera-policy`."""
    return f"{config.perception.title}-{config.agent.kind}"


def load_agent_series(
    config: Config, series: Series, folder: Path, detector: Detector | None
) -> AgentSeries:
    """Give the trials of a series a camera and an agent.

    Args:
        config: Perception, agent, and the protocol of the trials.
        series: Robot, solvers and seed.
        folder: Where the raw rows go; evidence is kept beside them.
        detector: Finds objects in pictures; None where the simulator gives their places.

    Raises:
        PerceptionError: The robot has no camera.
        SetupError: The agent lacks a package, an address or a key.
        SpeechError: Somebody is to speak, and a program or a package is missing.
    """
    perception = make_perception(
        config.perception, series.config, series.robot, detector, series.seed
    )
    agents = agent_factory(config.agent, series.robot.name)
    experiment = Experiment(
        series=series,
        perception=perception,
        agent=agents,
        facts={
            "perception": config.perception.title,
            "agent": kind_of(config.agent, agents().model),
        },
        folder=folder / EVIDENCE,
        distractors=config.perception.perturbation.distractors,
        ear=load_ear(
            config.speech,
            config.agent.vocabulary,
            series.config.scenes[series.robot.name].objects,
            series.robot.name,
            series.seed,
        ),
    )
    return AgentSeries(experiment)


def embodied_facts(config: Config) -> dict[str, Any]:
    """Settings that the rows depend on beyond those of the grasps; of a file, what is in it."""
    agent = replace(config.agent, record=None)
    if agent.kind == "replay":
        agent = replace(agent, file=sha256(Path(str(agent.file))))
    if agent.kind == "endpoint":
        agent = replace(agent, endpoint=resolved(agent.endpoint))
    if agent.kind == "local":
        agent = replace(
            agent, local=replace(agent.local, file=sha256(model_file(agent.local.file)))
        )
    facts = {"perception": to_dict(config.perception), "agent": to_dict(agent)}
    spoken = {**to_dict(config.speech), "microphone": None}
    return facts | ({"speech": spoken} if config.speech.loop.voices else {})


def perception_identity(runner: AgentSeries) -> dict[str, Any]:
    """What sees, beyond its settings: the checksum of its networks."""
    perception = runner.experiment.perception
    if not isinstance(perception, CameraPerception):
        return {}
    return {
        "detector": type(perception.detector).__qualname__,
        **network_checksums(perception.detector),
    }
