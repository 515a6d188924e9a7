"""The embedded policy: what it understands, in order, and that it says so where it does not."""

from __future__ import annotations

from dataclasses import asdict, replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.agent import Agent, seen_at
from pipeline.agent.loading import load_agent
from pipeline.agent.policy import NOT_UNDERSTOOD

PAPER = (
    "NICOL, please grasp all the objects on the table, one after another. "
    "Choose the order of the objects yourself."
)
FROM_THE_RIGHT = "grasp orange, grasp pear, grasp banana, grasp baseball, grasp soup_can"


def acts(agent: Agent, instruction: str, scene) -> str:
    """The actions but for words and the end, as text."""
    turn = agent.instruct(instruction, scene)
    assert not turn.problem, turn.problem
    assert turn.finished
    silent = [each for each in turn.actions if each.kind not in ("speak", "done")]
    return ", ".join(f"{each.kind} {each.target}" for each in silent)


UNDERSTOOD = {
    PAPER: FROM_THE_RIGHT,
    "grasp the banana": "grasp banana",
    "Please, hand me the pear!": "grasp pear",
    "could you pick up the banana and the orange": "grasp banana, grasp orange",
    "pick the can up": "grasp soup_can",
    "can you push the can": "push soup_can",
    "would you mind grasping the tin of soup?": "grasp soup_can",
    "I'd like the ball": "grasp baseball",
    "can I have the pear please": "grasp pear",
    "grab the tomato soup can": "grasp soup_can",
    "put the banana into the bin": "grasp banana",
    "grasp the banana on the table": "grasp banana",
    "clear the table": FROM_THE_RIGHT,
    "grasp everything": FROM_THE_RIGHT,
    "grasp all objects from left to right": "grasp soup_can, grasp baseball, grasp banana, "
    "grasp pear, grasp orange",
    "grasp all the objects, starting with the banana": "grasp banana, grasp orange, grasp pear, "
    "grasp baseball, grasp soup_can",
    "take everything except the ball and the pear": "grasp orange, grasp banana, grasp soup_can",
    "remove all the fruit": "grasp orange, grasp pear, grasp banana",
    "point at the orange": "point orange",
    "show me the yellow fruit": "point banana",
    "nudge the ball and shove the can": "push baseball, push soup_can",
    "grasp the leftmost object": "grasp soup_can",
    "throw away the leftmost fruit": "grasp banana",
    "pick up the thing on the right": "grasp orange",
    "grab the nearest one": "grasp pear",
    "hand me the one in the middle": "grasp banana",
    "grab the orange ball": "grasp baseball",
    "look left": "look left",
    "turn your head to the right": "look right",
    "look at me": "look user",
    "look at the ceiling": "look up",
    "look at the banana and the pear": "look banana, look pear",
    "smile": "face happiness",
    "make a sad face": "face sadness",
    "look happy": "face happiness",
    "grasp the banana, then point at the orange": "grasp banana, point orange",
    "first look at the can, after that push it, and finally smile": "look soup_can, "
    "push soup_can, face happiness",
    "point at the pear and grasp it": "point pear, grasp pear",
    "Do you see the banana? Grasp it.": "look banana, grasp banana",
    "where is the pear?": "look pear",
    "say hello and then grasp the pear": "grasp pear",
    "before you grasp the pear, take the ball": "grasp baseball, grasp pear",
}


@pytest.mark.parametrize("instruction", UNDERSTOOD)
def test_what_is_understood(config, scene, instruction):
    assert acts(load_agent(config, "nicol"), instruction, scene) == UNDERSTOOD[instruction]


@pytest.mark.parametrize(
    ("instruction", "said"),
    [
        ("asdkj alksjd", NOT_UNDERSTOOD),
        ("", "<done/>"),
        ("(go on)", NOT_UNDERSTOOD),
        ("do not smile", "All right."),
        ("wave at me", NOT_UNDERSTOOD),
        ("grasp", "What shall I grasp?"),
        ("grasp the apple", "I do not see an apple."),
        ("take the tomato", "I do not see a tomato."),
        ("grasp it", "I do not know which object you mean."),
        ("do not grasp the banana", "I leave the banana."),
        ("don't touch the banana", "I leave the banana."),
        ("never push the can", "I leave the soup can."),
        ("put the banana next to the orange", "I do not know places beside other objects."),
        ("if you grasp the pear, take the ball", "I do not follow conditions."),
        ("what do you see?", "I see a soup can, a baseball, a banana, a pear and an orange."),
        ("which fruit do you see?", "I see a banana, a pear and an orange."),
        ("Hello", "Hello, what shall I do?"),
        ("stop", "All right."),
    ],
)
def test_what_moves_no_arm(config, scene, instruction, said):
    turn = load_agent(config, "nicol").instruct(instruction, scene)
    assert said in turn.reply
    assert not any(action.is_physical for action in turn.actions)


def test_negation_holds_for_one_verb(config, scene):
    agent = load_agent(config, "nicol")
    assert acts(agent, "do not grasp the banana, but push the orange", scene) == "push orange"
    assert acts(agent, "point at the pear, but do not grasp it", scene) == "point pear"
    assert acts(agent, "grasp the pear, not the banana", scene) == "grasp pear"


def test_it_is_the_object_of_the_turn_before(config, scene):
    agent = load_agent(config, "nicol")
    assert acts(agent, "the banana", scene) == "look banana"
    assert acts(agent, "grasp it", scene) == "grasp banana"


def test_only_what_is_in_view(config):
    toys = [seen_at(name, 0.3, y, 0.9) for name, y in (("tomato", -0.1), ("lemon_half", -0.2))]
    agent = load_agent(config, "nico")
    assert acts(agent, "grasp the tomato and the half lemon", toys) == (
        "grasp tomato, grasp lemon_half"
    )
    assert acts(agent, "grasp the grapes, then the tomato", toys) == "grasp tomato"
    assert acts(agent, PAPER.replace("NICOL", "NICO"), []) == ""


def test_objects_that_the_vocabulary_does_not_know(config):
    scene = [seen_at("coffee_mug", 0.5, 0.1, 0.9), seen_at("glue-stick 2", 0.5, -0.1, 0.9)]
    agent = load_agent(config, "nicol")
    assert acts(agent, "grasp the mug and point at the glue stick 2", scene) == (
        "grasp coffee_mug, point glue-stick 2"
    )


@pytest.mark.parametrize("name", ["NICOL", "PANDA", "MY ARM 2"])
def test_the_reply_to_the_papers_sentence_is_that_of_the_committed_trials(config, scene, name):
    said = load_agent(config, "nicol").instruct(PAPER.replace("NICOL", name), scene).reply
    assert said == (
        "I grasp the orange. <grasp>orange</grasp> I grasp the pear. <grasp>pear</grasp> "
        "I grasp the banana. <grasp>banana</grasp> I grasp the baseball. <grasp>baseball</grasp> "
        "I grasp the soup can. <grasp>soup_can</grasp> <done/>"
    )


UNDERSTOOD_SINCE = {
    "grasp the neighbour of the banana": "grasp baseball",
    "grasp exactly one piece of fruit": "grasp orange",
    "grasp the orange after the baseball": "grasp baseball, grasp orange",
    "after grasping the pear, point at the can": "grasp pear, point soup_can",
    "take all but the pear": "grasp orange, grasp banana, grasp baseball, grasp soup_can",
    "take at most two fruits": "grasp orange, grasp pear",
    "grasp everything that is not round": "grasp pear, grasp banana, grasp soup_can",
    "take all the round ones and push the rest": "grasp orange, grasp baseball, push pear, "
    "push banana, push soup_can",
    "grasp the second object from the right": "grasp pear",
    "leave the pear alone and take all fruits": "grasp orange, grasp banana",
    "take the object between the ball and the pear": "grasp banana",
}


@pytest.mark.parametrize("instruction", UNDERSTOOD_SINCE)
def test_count_order_place_and_negation(config, scene, instruction):
    assert acts(load_agent(config, "nicol"), instruction, scene) == UNDERSTOOD_SINCE[instruction]


@pytest.mark.parametrize(
    ("instruction", "said"),
    [
        ("grasp the neighbour of the pear", "Which one: the orange, the banana"),
        ("push the round thing", "Which one: the orange or the baseball?"),
        ("take the banana or the can", "Which one: the banana or the soup can?"),
        ("take four fruits", "I see only 3 of that kind."),
        ("fetch the green ball", "I see nothing of that kind."),
        ("grasp the banana and peel it", "I do not know the word 'peel'."),
        ("take the object next to the apple", "I do not see an apple."),
    ],
)
def test_what_is_unclear_or_impossible_is_said_and_not_done(config, scene, instruction, said):
    turn = load_agent(config, "nicol").instruct(instruction, scene)
    assert said in turn.reply
    assert {action.kind for action in turn.actions} == {"speak", "done"}


def test_the_same_words_give_the_same_reply(config, scene):
    replies = {load_agent(config, "nicol").instruct(PAPER, scene).reply for _ in range(3)}
    assert len(replies) == 1


def test_the_longest_phrase_counts(config):
    scene = [seen_at("soup_can", 0.5, 0.1, 0.9), seen_at("tomato", 0.5, -0.1, 0.9)]
    agent = load_agent(config, "nicol")
    assert acts(agent, "can you take the tomato soup can", scene) == "grasp soup_can"
    assert acts(agent, "can you take the tomato", scene) == "grasp tomato"


@pytest.mark.parametrize("words", ["say ,", "say .", "then say , ?"])
def test_nothing_to_say_is_asked_for(composed, words):
    turn = load_agent(composed, "nicol").instruct(words, [])
    assert turn.reason == "", turn.problem
    assert "What shall I say?" in turn.reply


@pytest.fixture(scope="module")
def vocabulary_words(composed) -> list[str]:
    words = [",", ".", "then", "?", "mug", "<grasp>", "not", "starting with", "say", "fruit"]
    for phrases in asdict(composed.vocabulary).values():
        for listed in phrases.values() if isinstance(phrases, dict) else [phrases]:
            words += listed
    return words


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_no_words_break_it(composed, vocabulary_words, data):
    """Any order of its own words gives a reply in its own language."""
    word = st.one_of(st.sampled_from(vocabulary_words), st.text(max_size=5))
    words = data.draw(st.lists(word, max_size=14))
    scene = [seen_at(n, 0.5, y, 0.9) for n, y in (("banana", 0.1), ("soup_can", -0.2))]
    for view in (scene, []):
        turn = load_agent(composed, "nicol").instruct(" ".join(words), view)
        assert turn.reason in ("", "loop", "too_long", "too_many_actions"), turn.problem


@pytest.mark.parametrize("key", ["verbs", "selectors", "orders", "faces", "places"])
def test_words_for_what_the_policy_cannot_do_are_refused(composed, key):
    known = getattr(composed.vocabulary, key)
    with pytest.raises(ValueError, match=rf"agent\.vocabulary\.{key} must be one of .*'done'"):
        replace(composed.vocabulary, **{key: {**known, "done": ["finish"]}})
