"""A person talks to a robot at its table: lines in, what happens out, all of it kept."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pipeline.agent.transcript import write_transcript
from pipeline.embodiment.evidence import described
from pipeline.embodiment.perception import View
from pipeline.embodiment.session import Event, Session
from pipeline.errors import SpeechError
from pipeline.speech.protocol import Recogniser, Synthesiser

QUIT = ("quit", "exit")
HELP = """\
Say what to do, for example: grasp the banana, then point at the orange. Or one of
  look           see the table again
  FILE.wav       a recorded instruction
  listen         an instruction from the microphone
  quit           end"""


class Chat:
    """One conversation, line by line.

    Attributes:
        transcript: Where it is kept; the file is renewed after every line.
    """

    def __init__(
        self,
        session: Session,
        name: str,
        transcript: Path,
        say: Callable[[str], object],
        recogniser: Callable[[], Recogniser],
        synthesiser: Callable[[], Synthesiser],
        record: Callable[[Path], bool],
    ) -> None:
        """Begin.

        Args:
            session: Agent, body and senses.
            name: How the robot is called in what is shown.
            transcript: The file to keep the conversation in.
            say: Shows a line to the person.
            recogniser: Loads what understands speech; called when the first is heard.
            synthesiser: Loads what speaks; called when an instruction by voice is answered.
            record: Records from the microphone to a WAV file; whether anybody spoke.
        """
        self.session, self.name, self.transcript, self._say = session, name, transcript, say
        self._load = {"recogniser": recogniser, "synthesiser": synthesiser}
        self._loaded: dict[str, Any] = {}
        self._record = record
        self._sounds = 0
        self._aloud = False
        self._events: list[dict[str, Any]] = []
        session.heard = self._show_event

    def show_table(self) -> None:
        """Show the person what the robot sees."""
        self._say(f"{self.name} sees{seen_text(self.session.look())}")

    def line(self, text: str) -> bool:
        """Answer one line; whether the conversation continues."""
        words = text.strip()
        self._aloud = False
        if words.lower() in QUIT:
            return False
        if words.lower() in ("", "help"):
            self._say(HELP)
        elif words.lower() == "look":
            self.show_table()
        else:
            self._instruct(words)
        return True

    def _instruct(self, words: str) -> None:
        if words.lower() == "listen" or words.lower().endswith(".wav"):
            try:
                words = self._heard(words)
            except (SpeechError, OSError) as error:
                self._say(f"not heard: {error}")
                return
            self._say(f"heard: {words}" if words else "not understood; say it again, or type it")
            if not words:
                return
            self._aloud = True
        begin = len(self._events)
        episode = self.session.instruct(words)
        if episode.problem:
            self._say(f"no answer that can be used: {episode.problem}")
        elif len(self._events) == begin:
            self._say(f"{self.name} has nothing to do.")
        self.keep()
        self.show_table()

    def keep(self) -> None:
        """Write the transcript: the conversation in order, then what was done."""
        write_transcript(self.transcript, [*self.session.agent.transcript, *self._events])

    def _heard(self, words: str) -> str:
        """The words of a WAV file, or of the microphone."""
        path = Path(words)
        if words.lower() == "listen":
            path = self._sound("heard")
            self._say("listening")
            if not self._record(path):
                return ""
        return str(self._speech("recogniser").recognise(path))

    def _show_event(self, event: Event) -> None:
        self._events.append(described(event))
        action, result = event.action, event.result
        if action.kind == "speak":
            self._say(f'{self.name}: "{action.text}"')
            self._speak(action.text)
        elif action.is_physical:
            how = "done" if result.done else "failed"
            self._say(f"{action.kind} {action.target}: {how}, {result.words}")
        else:
            self._say(f"{action.kind} {action.target}")

    def _speak(self, text: str) -> None:
        """Answer an instruction by voice aloud: as a sound beside the transcript."""
        if not self._aloud:
            return
        try:
            path = self._sound("said")
            self._speech("synthesiser").speak(text, path)
            self._say(f"  ({path})")
        except SpeechError as error:
            self._say(f"  (not said aloud: {error})")
            self._aloud = False

    def _speech(self, which: str) -> Any:
        if which not in self._loaded:
            self._loaded[which] = self._load[which]()
        return self._loaded[which]

    def _sound(self, kind: str) -> Path:
        self._sounds += 1
        return self.transcript.with_name(f"{self.transcript.stem}_{self._sounds:02d}_{kind}.wav")


def seen_text(view: View) -> str:
    """What is seen, one line per object, from the robot's left to its right."""
    ordered = sorted(view.sightings, key=lambda each: -each.position[1])
    if not ordered:
        return " nothing on its table."
    lines = [":"]
    for each in ordered:
        ahead, left = float(each.position[0]), float(each.position[1])
        side = "left" if left > 0 else "right"
        where = f"{100 * ahead:.0f} cm ahead, {100 * abs(left):.0f} cm to the {side}"
        lines.append(f"  {each.name.replace('_', ' '):<12} {where}  ({each.score:.2f})")
    return "\n".join(lines)
