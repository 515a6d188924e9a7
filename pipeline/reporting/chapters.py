"""The chapters of the report: which topics are shown where, in which order."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.reporting.data import Topic
from pipeline.reporting.topics import (
    agent,
    calibration,
    detector,
    experiments,
    grasps,
    learned,
    left_out,
    losses,
    outcomes,
    pairs,
    paper,
    planner,
    precision,
    protocols,
    sampling,
    seeding,
    suites,
    timing,
    training,
    tuning,
)


@dataclass(frozen=True)
class Chapter:
    """A chapter of the report; it is left out where it has nothing to show.

    Attributes:
        anchor: Link to it on the page.
        title: Heading.
        lead: One sentence below it.
        topics: What it is about, in order.
        media: Stages whose pictures and videos belong there.
        wall: Whether every grasp trial is shown there as a thumbnail.
    """

    anchor: str
    title: str
    lead: str
    topics: tuple[Topic, ...]
    media: tuple[str, ...] = ()
    wall: bool = False


CHAPTERS = (
    Chapter(
        "paper",
        "Against the paper",
        "The paper's tables with this run beside them, in the paper's own metric.",
        (paper.TOPIC, calibration.TOPIC, learned.TOPIC, left_out.TOPIC),
    ),
    Chapter(
        "solvers",
        "Precision and time",
        "The same poses for every solver; errors recomputed from the joints by Pinocchio.",
        (precision.TOPIC, timing.TOPIC, seeding.TOPIC, pairs.TOPIC),
    ),
    Chapter(
        "training",
        "Data, training and search",
        "Pose sets, training runs and hyperparameters of the networks.",
        (training.TOPIC, tuning.TOPIC),
        ("tune", "train"),
    ),
    Chapter(
        "experiments",
        "Experiments",
        "Runs on demand: losses at equal steps, secondary goals, many solutions of one pose.",
        (losses.TOPIC, experiments.TOPIC, sampling.TOPIC),
        ("sample",),
    ),
    Chapter(
        "suites",
        "Hard poses",
        "Where solvers differ: at limits, near singularities, at and beyond the edge of reach.",
        (suites.TOPIC,),
    ),
    Chapter(
        "protocols",
        "By everyone's protocol",
        "The same solvers as six groups measure them: who leads depends on who measures.",
        (protocols.TOPIC,),
    ),
    Chapter(
        "planning",
        "Motion planning",
        "Bezier curves in position, spherical interpolation in rotation, one batched query.",
        (planner.TOPIC,),
        ("plan",),
    ),
    Chapter(
        "grasping",
        "Grasping",
        "Pick, lift and drop in a physics simulation; held by contact and friction alone.",
        (outcomes.TOPIC, grasps.TOPIC),
        ("grasp", "grasp_study"),
    ),
    Chapter(
        "human_in_the_loop",
        "Human in the loop",
        "The robot perceives its table, receives an instruction and acts, on camera images.",
        (agent.TOPIC, detector.TOPIC),
        ("grasp_agent", "detector"),
        wall=True,
    ),
)
TOPICS = tuple(topic for chapter in CHAPTERS for topic in chapter.topics)
