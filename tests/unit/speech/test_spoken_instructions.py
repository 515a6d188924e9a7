"""Instructions as speech in a file, recognised and understood; nine of ten come out right."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from pipeline.agent import seen_at
from pipeline.agent.loading import load_agent
from pipeline.config import compose
from pipeline.speech import load_recogniser, load_synthesiser
from pipeline.speech.grammar_recogniser import RATE
from pipeline.speech.sound import write_sound

pytest.importorskip("pocketsphinx", reason="the extra 'speech' is not installed")
if shutil.which("flite") is None:
    pytest.skip("the program flite is not installed", allow_module_level=True)

NAMES = ("soup_can", "baseball", "banana", "pear", "orange")
ROBOTS = ("nico", "nicol")
PHRASINGS = {
    "grasp the banana": "grasp banana",
    "please pick up the soup can": "grasp soup_can",
    "could you push the ball": "push baseball",
    "point at the orange": "point orange",
    "look left": "look left",
    "grasp the banana, then point at the orange": "grasp banana, point orange",
    "hand me the pear please": "grasp pear",
    "show me the leftmost object": "point soup_can",
    "take the banana and the orange": "grasp banana, grasp orange",
    "do not grasp the banana": "",
}
OTHER = (
    "what is the weather like in hamburg today",
    "one two three four five six",
    "we need to buy some milk and bread",
)


@pytest.fixture(scope="module")
def config():
    return compose(["agent=policy"])


@pytest.fixture(scope="module")
def recogniser(config):
    return load_recogniser(config.speech, config.agent.vocabulary, NAMES, ROBOTS)


@pytest.fixture(scope="module")
def synthesiser(config):
    return load_synthesiser(config.speech)


def test_nine_of_ten_phrasings_start_the_right_action(config, recogniser, synthesiser, tmp_path):
    scene = [seen_at(name, 0.5, 0.3 - 0.15 * i, 0.9) for i, name in enumerate(NAMES)]
    wrong = {}
    for phrasing, wanted in PHRASINGS.items():
        synthesiser.speak(phrasing, tmp_path / "said.wav")
        heard = recogniser.recognise(tmp_path / "said.wav")
        turn = load_agent(config.agent, "nicol").instruct(heard, scene)
        actions = [each for each in turn.actions if each.kind not in ("speak", "done")]
        if ", ".join(f"{each.kind} {each.target}" for each in actions) != wanted:
            wrong[phrasing] = heard
    assert len(wrong) <= 1, wrong


def test_other_speech_starts_nothing(recogniser, synthesiser, tmp_path):
    for sentence in OTHER:
        synthesiser.speak(sentence, tmp_path / "said.wav")
        assert recogniser.recognise(tmp_path / "said.wav") == "", sentence


@pytest.mark.parametrize("sound", ["silence", "noise", "tone", "nothing"])
def test_no_speech_is_no_instruction(recogniser, tmp_path, sound):
    samples = {
        "silence": np.zeros(RATE),
        "noise": np.random.default_rng(0).normal(0, 0.1, 2 * RATE),
        "tone": 0.3 * np.sin(np.arange(RATE) * 2 * np.pi * 300 / RATE),
        "nothing": np.zeros(0),
    }[sound]
    write_sound(tmp_path / "sound.wav", samples, RATE)
    assert recogniser.recognise(tmp_path / "sound.wav") == ""


def test_objects_may_have_names_that_the_dictionary_lacks(config, recogniser):
    odd = load_recogniser(config.speech, config.agent.vocabulary, ["banana", "qwxzt_gizmo"], ROBOTS)
    assert odd.grammar.accepts("grasp the banana")
    assert not odd.grammar.accepts("grasp the qwxzt gizmo")
