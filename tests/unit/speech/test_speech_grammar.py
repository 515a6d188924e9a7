"""The grammar holds what the policy understands, and what it holds the policy understands."""

from __future__ import annotations

import random

import pytest

from pipeline.agent import Agent, seen_at
from pipeline.agent.policy import Policy
from pipeline.config import compose
from pipeline.speech.grammar import EPSILON, FINAL, START, Graph, instruction_graph

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
def graph(config) -> Graph:
    return instruction_graph(config.vocabulary, NAMES, ["nicol"])


@pytest.mark.parametrize("sentence", SENTENCES)
def test_instructions_are_in_the_grammar(graph, sentence):
    assert graph.accepts(sentence)


@pytest.mark.parametrize(
    "sentence", ["", "banana", "grasp", "grasp the", "grasp the unicorn", "the grasp banana"]
)
def test_other_sentences_are_not(graph, sentence):
    assert not graph.accepts(sentence)


def test_phrases_with_unknown_words_are_left_out(config):
    graph = instruction_graph(config.vocabulary, NAMES, known=lambda word: word != "banana")
    assert graph.accepts("grasp the pear")
    assert not graph.accepts("grasp the banana")


def test_probabilities_of_a_state_sum_to_one(graph):
    leaving: dict[int, float] = {}
    for source, _, probability, *_ in graph.weighted():
        leaving[source] = leaving.get(source, 0.0) + probability
    assert all(abs(total - 1) < 1e-9 for total in leaving.values())
    assert FINAL not in leaving


def test_the_policy_knows_what_to_do_with_whatever_is_recognised(graph, config):
    """Random walks through the grammar: no problem, and no 'I do not understand'."""
    scene = [seen_at(name, 0.5, 0.1 * i, 0.9) for i, name in enumerate(NAMES)]
    draw = random.Random(3)
    for _ in range(300):
        sentence = _walk(graph, draw)
        turn = Agent(Policy(config.vocabulary), "nicol", config).instruct(sentence, scene)
        assert turn.reason in ("", "loop", "too_many_actions"), (sentence, turn.problem)
        assert (
            "I do not understand" not in turn.reply or "never" in sentence or "not" in sentence
        ), (
            sentence,
            turn.reply,
        )


def _walk(graph: Graph, draw: random.Random) -> str:
    at, words = START, []
    while at != FINAL:
        arc = draw.choice([arc for arc in graph.arcs if arc.source == at])
        if arc.word != EPSILON:
            words.append(arc.word)
        at = arc.target
    return " ".join(words)
