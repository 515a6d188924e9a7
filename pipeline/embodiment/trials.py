"""Trials with an agent: an instruction a row, a class for each of the row's objects."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.agent import Action, Agent
from pipeline.embodiment.body import Body
from pipeline.embodiment.evidence import draw_view, save_picture, save_transcript
from pipeline.embodiment.perception import Perception
from pipeline.embodiment.row import row_setup
from pipeline.embodiment.scene_objects import Array, SceneObject, SceneObjects
from pipeline.embodiment.session import Episode, Event, Session
from pipeline.embodiment.verdict import Verdict, judge
from pipeline.grasping.hardware import Hardware
from pipeline.grasping.outcome import SUCCESS, GraspReport, measures
from pipeline.grasping.placements import Setup
from pipeline.grasping.scene import Scene
from pipeline.grasping.series import Series
from pipeline.grasping.trial import conditions, required_scene
from pipeline.perception.distractors import lay_distractors
from pipeline.seeding import derive_seed
from pipeline.speech.loop import Ear, Heard


@dataclass(frozen=True)
class Experiment:
    """What all rows share.

    Attributes:
        series: Configuration, robot, solvers and seed, as of trials without an agent.
        perception: How the table is seen.
        agent: Begins a conversation, one a row.
        facts: Columns of every raw row besides the trial: perception and agent.
        folder: Where evidence is kept; None keeps none.
        distractors: Objects of no class on the table, which only a camera sees.
        ear: Hears the sentence; None takes it as it is written.
    """

    series: Series
    perception: Perception
    agent: Callable[[], Agent]
    facts: dict[str, Any]
    folder: Path | None = None
    distractors: int = 0
    ear: Ear | None = None

    @property
    def per_row(self) -> int:
        """Trials of a row: one per object."""
        return len(required_scene(self.series.config, self.series.robot.name).objects)

    def row(
        self, number: int, watch: Callable[[Scene], object] | None = None
    ) -> list[dict[str, Any]]:
        """Run the row of a number, which with the seed fixes all of it but the agent's answers.

        Args:
            number: Number of the row, from 0.
            watch: Called with the scene once all objects lie in it, for cameras.

        Returns:
            One raw row for each of its trials, in the order of their numbers.
        """
        begin = time.perf_counter()
        config, robot = self.series.config, self.series.robot
        setups = row_setup(config, robot.name, number, self.series.seed)
        scene_config = required_scene(config, robot.name)
        hardware = Hardware.drawn(config.hardware, robot, self.series.seed, number)
        with Scene(robot, scene_config, config.physics, config.gui, hardware) as scene:
            objects = SceneObjects(scene, config, setups)
            self._distract(scene, setups, number)
            if watch is not None:
                watch(scene)
            scene.wait(config.physics.settle_s)
            at_first = {each.body: objects.position(each) for each in objects.all}
            agent = self.agent()
            body = Body(scene, config, self.series.solver, self.series.repair)
            protocol = config.protocol
            session = Session(
                *(agent, body, self.perception, objects, protocol.located),
                refuse=_so_often_each(protocol.attempts),
            )
            words = protocol.sentence.format(robot=robot.name.upper())
            heard = Heard(words, np.nan) if self.ear is None else self.ear.hear(words, number)
            episode = session.insist(heard.words, protocol.attempts)
        shared = {
            "heard": "" if self.ear is None else heard.words,
            "word_error_rate": heard.error_rate,
            "turns": len(episode.turns),
            "problem": episode.turns[-1].reason,
            "wall_s": (time.perf_counter() - begin) / len(setups),
        }
        located, once = config.protocol.located, config.protocol.attempts == 1
        verdicts = [
            judge(each, at_first[each.body], episode, located, once) for each in objects.all
        ]
        kept = self._keep(number, objects, at_first, verdicts, episode, agent)
        return [
            self._raw_row(obj, verdict) | files | shared
            for obj, verdict, files in zip(objects.all, verdicts, kept, strict=True)
        ]

    def _distract(self, scene: Scene, setups: list[Setup], number: int) -> None:
        """Lay what is of no class, where it hides nothing; another place in every row."""
        draw = np.random.default_rng(
            derive_seed(self.series.seed, "grasp", self.series.robot.name, "distractors", number)
        )
        places = [each.place for each in setups]
        lay_distractors(scene.client, scene.config, self.distractors, draw, places)

    def _raw_row(self, obj: SceneObject, verdict: Verdict) -> dict[str, Any]:
        """What was laid where, the class and its reason, what was seen, errors, contacts."""
        each, setup, attempt = self.series, obj.setup, verdict.attempt
        report = attempt.report if attempt is not None else None
        return {
            **conditions(each.config, setup, each.robot, each.solver, each.seed),
            **self.facts,
            "class": verdict.outcome,
            "reason": verdict.reason,
            "seen_as": verdict.seen_as,
            "attempts": verdict.attempts,
            "score": float(verdict.score),
            "sighting_error_mm": 1e3 * float(verdict.sighting_error),
            "order": verdict.order,
            "began_s": attempt.time_s if attempt is not None else float("nan"),
            "simulated_s": attempt.lasted_s if attempt is not None else 0.0,
            **measures(report or GraspReport()),
        }

    def _keep(
        self,
        number: int,
        objects: SceneObjects,
        at_first: dict[int, Array],
        verdicts: list[Verdict],
        episode: Episode,
        agent: Agent,
    ) -> list[dict[str, Any]]:
        """Write transcript and pictures of a row; names of the files, for each of its trials."""
        if self.folder is None:
            return [{"transcript": "", "picture": ""} for _ in verdicts]
        path = self.folder / f"row{number:03d}.jsonl"
        transcript = save_transcript(path, agent.transcript, episode)
        kept = []
        for obj, verdict in zip(objects.all, verdicts, strict=True):
            picture = ""
            wanted = self.series.config.protocol.evidence
            if wanted == "all" or (wanted == "failures" and verdict.outcome != SUCCESS):
                picture = self._picture(obj, verdict, np.array([*at_first.values()]), episode)
            kept.append({"transcript": transcript, "picture": picture})
        return kept

    def _picture(self, obj: SceneObject, verdict: Verdict, true: Array, episode: Episode) -> str:
        """The look that a trial was judged by, what was seen drawn into it."""
        assert self.folder is not None
        event: Event | None = verdict.attempt
        view = episode.view
        if event is not None and event.view is not None and event.places is not None:
            view, true = event.view, event.places
        drawn = draw_view(view, self.perception, [obj.name, verdict.seen_as], true)
        outcome = verdict.outcome.lower().replace(" ", "_")
        return save_picture(drawn, self.folder / f"trial{obj.setup.number:03d}_{outcome}.png")


def _so_often_each(most: int) -> Callable[[Action, SceneObject | None], str]:
    """A rule of the protocol: each object is grasped so often at most, whatever the outcome."""
    tried: Counter[int] = Counter()

    def refuse(action: Action, obj: SceneObject | None) -> str:
        if action.kind != "grasp" or obj is None:
            return ""
        if tried[obj.body] == most:
            return "it has been tried already"
        tried[obj.body] += 1
        return ""

    return refuse
