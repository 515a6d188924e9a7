"""A conversation acted out: what the agent says is done, and the agent is told what came of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from pipeline.agent import Action, Agent, Turn
from pipeline.embodiment.body import Body
from pipeline.embodiment.senses import Senses, View
from pipeline.embodiment.things import Array, Thing, Things
from pipeline.grasping.outcome import Deed, Report
from pipeline.perception.detection import Sighting


@dataclass(frozen=True)
class Event:
    """One action and what became of it.

    Attributes:
        time_s: Simulated time when it began [s].
        action: What the agent asked for.
        deed: What it came to.
        sighting: Where its target was seen; None for what needs none.
        view: The look that it was seen in.
        thing: What really lay there; None if nothing did.
        offset: How far from its target's sighting the nearest thing lay [m].
        report: Of a grasp, what happened.
        lasted_s: How long it took [s].
        places: Where all things really lay when it began, base frame [m], shape (N, 3).
    """

    time_s: float
    action: Action
    deed: Deed
    sighting: Sighting | None = None
    view: View | None = None
    thing: Thing | None = None
    offset: float = float("nan")
    report: Report | None = None
    lasted_s: float = 0.0
    places: Array | None = None


@dataclass
class Course:
    """How one instruction went.

    Attributes:
        view: The look that the agent was told of first.
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
        senses: Senses,
        things: Things,
        located: float,
        refuse: Callable[[Action, Thing | None], str] = lambda action, thing: "",
        heard: Callable[[Event], object] = lambda event: None,
    ) -> None:
        """Bring them together.

        Args:
            agent: Says what to do.
            body: Does it.
            senses: See the table before each turn and each motion.
            things: What really lies there, to judge outcomes by.
            located: Distance within which what is seen is the thing that lies there [m].
            refuse: Says why an action is not carried out; nothing if it is.
            heard: Called with every event.
        """
        self.agent, self.body, self.senses, self.things = agent, body, senses, things
        self._located, self._refuse, self.heard = located, refuse, heard

    def look(self) -> View:
        """Look at the table; the arm is at idle and out of the way."""
        return self.senses.look(self.body.scene, self.things)

    def instruct(self, words: str) -> Course:
        """Carry out an instruction until the agent says that it is done, or fails to answer."""
        course = Course(self.look())
        turn = self.agent.instruct(words, course.view.seen())
        known = course.view
        while True:
            course.turns.append(turn)
            for action in turn.actions:
                event = self._act(action, known)
                if action.kind != "done":
                    course.events.append(event)
                    self.heard(event)
            if turn.finished:
                return course
            known = self.look()
            turn = self.agent.proceed(known.seen())

    def _act(self, action: Action, known: View) -> Event:
        """Do one action; targets that are out of sight now are where they were seen before."""
        now = self.body.scene.time_s
        if not action.is_physical:
            return Event(now, action, Deed(True, ""))
        view = self.look()
        sighting = view.find(action.target)
        if sighting is None:
            view, sighting = known, known.find(action.target)
        if sighting is None:
            return self._told(Event(now, action, Deed(False, "it is out of sight"), view=view))
        places = self.things.positions()
        nearest, offset = self.things.nearest(sighting.position)
        thing = nearest if offset <= self._located else None
        if reason := self._refuse(action, thing):
            deed, report = Deed(False, reason), None
        else:
            judged = thing or self.things.named(action.target) or nearest
            place, name = sighting.position.copy(), sighting.name
            deed = self.body.act(action.kind, place, name, judged.body)
            report = self.body.report if action.kind == "grasp" else None
        lasted = self.body.scene.time_s - now
        return self._told(
            Event(now, action, deed, sighting, view, thing, offset, report, lasted, places)
        )

    def _told(self, event: Event) -> Event:
        """Tell the agent what an action came to."""
        action, deed = event.action, event.deed
        how = "done" if deed.done else "failed"
        self.agent.report(f"{action.kind} {action.target}: {how}, {deed.words}")
        return event
