"""A conversation carried out: actions of the agent are executed and their outcomes reported."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from pipeline.agent import Action, Agent, Turn
from pipeline.embodiment.body import Body
from pipeline.embodiment.perception import Perception, View
from pipeline.embodiment.scene_objects import Array, SceneObject, SceneObjects
from pipeline.grasping.outcome import ActionResult, GraspReport
from pipeline.perception.detection import Sighting


@dataclass(frozen=True)
class Event:
    """One action and its result.

    Attributes:
        time_s: Simulated time when it began [s].
        action: What the agent requested.
        result: Its result.
        sighting: Where its target was seen; None for what needs none.
        view: The look that it was seen in.
        obj: What really lay there; None if nothing did.
        offset: How far from its target's sighting the nearest object lay [m].
        report: Of a grasp, what happened.
        lasted_s: How long it took [s].
        places: Where all objects really lay when it began, base frame [m], shape (N, 3).
    """

    time_s: float
    action: Action
    result: ActionResult
    sighting: Sighting | None = None
    view: View | None = None
    obj: SceneObject | None = None
    offset: float = float("nan")
    report: GraspReport | None = None
    lasted_s: float = 0.0
    places: Array | None = None


@dataclass
class Episode:
    """How one instruction went.

    Attributes:
        view: The look that the agent received first.
        events: Actions in order.
        turns: Replies of the agent.
    """

    view: View
    events: list[Event] = field(default_factory=list)
    turns: list[Turn] = field(default_factory=list)

    @property
    def problem(self) -> str:
        """Reason code and sentence of the turn that ended it, or nothing."""
        return self.turns[-1].problem if self.turns else ""


class Session:
    """An agent in a body at a table.

    Attributes:
        heard: Called with every event as it happens.
    """

    def __init__(
        self,
        agent: Agent,
        body: Body,
        perception: Perception,
        objects: SceneObjects,
        located: float,
        refuse: Callable[[Action, SceneObject | None], str] = lambda action, obj: "",
        heard: Callable[[Event], object] = lambda event: None,
    ) -> None:
        """Bring them together.

        Args:
            agent: Says what to do.
            body: Does it.
            perception: See the table before each turn and each motion.
            objects: What really lies there, to judge outcomes by.
            located: Distance within which what is seen is the object that lies there [m].
            refuse: Says why an action is not carried out; nothing if it is.
            heard: Called with every event.
        """
        self.agent, self.body, self.perception, self.objects = agent, body, perception, objects
        self._located, self._refuse, self.heard = located, refuse, heard

    def look(self) -> View:
        """Look at the table; the arm is at idle and out of the way."""
        return self.perception.look(self.body.scene, self.objects)

    def instruct(self, words: str) -> Episode:
        """Carry out an instruction until the agent says that it is done, or fails to answer."""
        episode = Episode(self.look())
        turn = self.agent.instruct(words, episode.view.seen())
        known = episode.view
        while True:
            episode.turns.append(turn)
            episode.events += self.do(turn.actions, known)
            if turn.finished:
                return episode
            known = self.look()
            turn = self.agent.proceed(known.seen())

    def do(self, actions: Iterable[Action], known: View) -> list[Event]:
        """Carry out actions in order, and tell the agent what became of them.

        Args:
            actions: What to do.
            known: The look that they were chosen by.

        Returns:
            An event for each but the word that it is done.
        """
        events = []
        for action in actions:
            event = self._act(action, known)
            if action.kind != "done":
                events.append(event)
                self.heard(event)
        return events

    def insist(self, words: str, most: int) -> Episode:
        """Say an instruction again while something is seen on the table, so often at most.

        The agent has been told what became of its actions. A turn that failed ends it.
        """
        episode = self.instruct(words)
        for _ in range(most - 1):
            if episode.problem or not self.look().sightings:
                break
            again = self.instruct(words)
            episode.events += again.events
            episode.turns += again.turns
        return episode

    def _act(self, action: Action, known: View) -> Event:
        """Do one action; targets that are out of sight now are where they were seen before."""
        now = self.body.scene.time_s
        if not action.is_physical:
            return Event(now, action, ActionResult(True, ""))
        view = self.look()
        sighting = view.find(action.target)
        if sighting is None:
            view, sighting = known, known.find(action.target)
        if sighting is None:
            return self._reported(
                Event(now, action, ActionResult(False, "it is out of sight"), view=view)
            )
        places = self.objects.positions()
        nearest, offset = self.objects.nearest(sighting.position)
        obj = nearest if offset <= self._located else None
        if reason := self._refuse(action, obj):
            result, report = ActionResult(False, reason), None
        else:
            judged = obj or self.objects.named(action.target) or nearest
            place, name = sighting.position.copy(), sighting.name
            result = self.body.act(action.kind, place, name, judged.body)
            report = self.body.report if action.kind == "grasp" else None
        lasted = self.body.scene.time_s - now
        return self._reported(
            Event(now, action, result, sighting, view, obj, offset, report, lasted, places)
        )

    def _reported(self, event: Event) -> Event:
        """Report the result of an action to the agent."""
        action, result = event.action, event.result
        how = "done" if result.done else "failed"
        self.agent.report(f"{action.kind} {action.target}: {how}, {result.words}")
        return event
