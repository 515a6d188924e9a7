"""The grammar holds what the policy understands, and what it holds the policy understands."""

from __future__ import annotations

import random

import pytest

from pipeline.agent import Agent, seen_at
from pipeline.agent.policy import Policy
from pipeline.config import compose
from pipeline.speech.grammar import START, SpokenGrammar

NAMES = ("soup_can", "baseball", "banana", "pear", "orange")
SENTENCES = (
    "grasp the banana",
    "please pick up the soup can",
    "could you push the ball",
    "point at the orange",
    "look left",
    "grasp the banana then point at the orange",
    "clear the table",
    "hand me the pear please",
    "show me the leftmost object",
    "give me the object on the right",
    "take everything except the banana",
    "do not grasp the banana",
    "grasp the banana and the pear and smile",
    "where is the pear",
    "nicol please grasp all the objects on the table one after another "
    "choose the order of the objects yourself",
)


@pytest.fixture(scope="module")
def config():
    return compose(["agent=policy"]).agent


@pytest.fixture(scope="module")
def graph(config) -> SpokenGrammar:
    return SpokenGrammar(config.vocabulary, NAMES, ["nicol"])


@pytest.mark.parametrize("sentence", SENTENCES)
def test_instructions_are_in_the_grammar(graph, sentence):
    assert graph.accepts(sentence)


@pytest.mark.parametrize(
    "sentence", ["", "banana", "grasp", "grasp the", "grasp the unicorn", "the grasp banana"]
)
def test_other_sentences_are_not(graph, sentence):
    assert not graph.accepts(sentence)


def test_phrases_with_unknown_words_are_left_out(config):
    graph = SpokenGrammar(config.vocabulary, NAMES, known=lambda word: word != "banana")
    assert graph.accepts("grasp the pear")
    assert not graph.accepts("grasp the banana")


def test_the_recogniser_has_the_same_sentences(graph, tmp_path):
    """Its own reading of the JSGF takes what the parser takes, and refuses what it refuses."""
    package = pytest.importorskip("pocketsphinx", reason="the extra 'speech' is not installed")
    (tmp_path / "instruction.gram").write_text(graph.jsgf())
    jsgf = package.Jsgf(str(tmp_path / "instruction.gram"))
    sentences = jsgf.build_fsg(jsgf.get_rule("instruction.spoken"), package.LogMath(), 1.0)
    for sentence in (*SENTENCES, "banana", "grasp", "grasp the", "the grasp banana"):
        assert bool(sentences.accept(sentence)) == graph.accepts(sentence), sentence


def test_the_policy_knows_what_to_do_with_whatever_is_recognised(graph, config):
    """Random walks through the grammar: no problem, and no 'I do not understand'."""
    scene = [seen_at(name, 0.5, 0.1 * i, 0.9) for i, name in enumerate(NAMES)]
    draw = random.Random(3)
    for _ in range(60):
        sentence = " ".join(_walk(graph, START, draw))
        if len(sentence) > config.max_instruction_chars:
            continue
        turn = Agent(Policy(config.vocabulary), "nicol", config).instruct(sentence, scene)
        assert turn.reason in ("", "loop", "too_many_actions"), (sentence, turn.problem)
        assert "I do not understand" not in turn.reply, sentence


def _walk(graph: SpokenGrammar, name: str, draw: random.Random) -> list[str]:
    """Words of a random sentence of a rule, or of a terminal."""
    if name in graph.phrases:
        return draw.choice(sorted(graph.phrases[name])).split()
    rules = [rule for rule in graph.parser.rules if rule.origin.name == name]
    return [w for each in draw.choice(rules).expansion for w in _walk(graph, each.name, draw)]
