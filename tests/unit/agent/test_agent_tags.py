"""The tag language: what is in it, what is not, and that no string gets anything else through."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.agent.action import FACES, KINDS, PLACES, Action
from pipeline.agent.errors import Reason, TagError
from pipeline.agent.tags import parse_reply

NAMES = ("banana", "soup_can", "orange")


def test_text_and_tags_come_out_in_order():
    reply = "I take it. <grasp>banana</grasp> There:\n<point>orange</point>"
    reply += " <face>happiness</face> <done/>"
    assert parse_reply(reply, NAMES) == [
        Action("speak", text="I take it."),
        Action("grasp", "banana"),
        Action("speak", text="There:"),
        Action("point", "orange"),
        Action("face", "happiness"),
        Action("done"),
    ]


@pytest.mark.parametrize(
    ("reply", "action"),
    [
        ("<push>Soup Can</push>", Action("push", "soup_can")),
        ("<grasp> soup-can\n</grasp>", Action("grasp", "soup_can")),
        ("<look>left</look>", Action("look", "left")),
        ("<look>BANANA</look>", Action("look", "banana")),
        ("<speak>so it is</speak>", Action("speak", text="so it is")),
        ("<done></done>", Action("done")),
        ("...<done/>", Action("done")),
    ],
)
def test_one_action(reply, action):
    assert parse_reply(reply, NAMES) == [action]


@pytest.mark.parametrize(
    ("reply", "reason"),
    [
        ("", Reason.NO_ACTION),
        ("I would rather not.", Reason.NO_ACTION),
        ("<grasp>banana", Reason.HALF_TAG),
        ("<grasp>banana</grasp", Reason.HALF_TAG),
        ("<grasp>banana</push>", Reason.HALF_TAG),
        ("grasp>banana</grasp>", Reason.HALF_TAG),
        ("banana</grasp>", Reason.HALF_TAG),
        ("<grasp><push>banana</push></grasp>", Reason.HALF_TAG),
        ("<done/> if 2 < 3", Reason.HALF_TAG),
        ("<>banana</>", Reason.UNKNOWN_ACTION),
        ("<run>ls</run>", Reason.UNKNOWN_ACTION),
        ("<GRASP>banana</GRASP>", Reason.UNKNOWN_ACTION),
        ("< grasp>banana</ grasp>", Reason.UNKNOWN_ACTION),
        ('<grasp name="banana"/>', Reason.UNKNOWN_ACTION),
        ("<grasp>unicorn</grasp>", Reason.NOT_IN_VIEW),
        ("<grasp>left</grasp>", Reason.NOT_IN_VIEW),
        ("<look>behind</look>", Reason.NOT_IN_VIEW),
        ("<grasp>../banana</grasp>", Reason.NOT_IN_VIEW),
        ("<grasp></grasp>", Reason.BAD_TARGET),
        ("<grasp/>", Reason.BAD_TARGET),
        ("<face>banana</face>", Reason.BAD_TARGET),
        ("<speak>!</speak>", Reason.BAD_TARGET),
        ("<done>banana</done>", Reason.BAD_TARGET),
        ("<done/>" + "x" * 5000, Reason.TOO_LONG),
        ("<look>left</look><look>right</look>" * 3 + "<look>up</look>" * 4, Reason.LOOP),
        ("<grasp>banana</grasp>" * 30, Reason.LOOP),
    ],
)
def test_what_is_not_in_the_language_is_refused_as_a_whole(reply, reason):
    with pytest.raises(TagError) as caught:
        parse_reply(reply, NAMES)
    assert caught.value.reason is reason
    assert str(caught.value).startswith(f"{reason}: ")
    assert "\n" not in str(caught.value)


def test_a_broken_end_takes_the_whole_reply_with_it():
    with pytest.raises(TagError):
        parse_reply("<grasp>banana</grasp> <point>oran", NAMES)


def test_more_actions_than_a_reply_may_have():
    reply = "".join(f"<look>{place}</look>" for place in PLACES)
    assert len(parse_reply(reply, NAMES, most=len(PLACES))) == len(PLACES)
    with pytest.raises(TagError) as caught:
        parse_reply(reply, NAMES, most=len(PLACES) - 1)
    assert caught.value.reason is Reason.TOO_MANY_ACTIONS


def test_an_action_can_be_forbidden():
    with pytest.raises(TagError) as caught:
        parse_reply("<push>banana</push>", NAMES, kinds=("grasp", "done"))
    assert caught.value.reason is Reason.UNKNOWN_ACTION
    silent = parse_reply("I take it. <grasp>banana</grasp>", NAMES, kinds=("grasp", "done"))
    assert silent == [Action("grasp", "banana")]


def test_names_that_differ_only_in_spelling_must_be_spelt_out():
    names = ("soup_can", "soup can")
    assert parse_reply("<grasp>soup can</grasp>", names) == [Action("grasp", "soup can")]
    with pytest.raises(TagError):
        parse_reply("<grasp>Soup-Can</grasp>", names)


def _holds(reply: str, names: tuple[str, ...]) -> None:
    """Whatever the string: actions of the whitelist on names in view, or a `TagError`."""
    try:
        actions = parse_reply(reply, names)
    except TagError as error:
        assert isinstance(error.reason, Reason)
        assert error.sentence
        return
    assert actions
    for action in actions:
        assert action.kind in KINDS
        assert "<" not in action.text and ">" not in action.text
        if action.kind in ("grasp", "push", "point"):
            assert action.target in names
        elif action.kind == "look":
            assert action.target in (*names, *PLACES)
        elif action.kind == "face":
            assert action.target in FACES
        else:
            assert action.target == ""


PIECES = [
    *[f"<{kind}>" for kind in KINDS],
    *[f"</{kind}>" for kind in KINDS],
    *NAMES,
    *FACES[:2],
    *PLACES[:2],
    *(
        "<done/>",
        "<",
        ">",
        "/",
        "</",
        "/>",
        "<<",
        "<!--",
        "-->",
        "<![CDATA[",
        "]]>",
        "&lt;grasp&gt;",
    ),
    *(
        "\x00",
        "\n",
        "\u202e",
        "\u200b",
        "\ud800",
        "＜grasp＞",
        "ﬁ",
        "İ",
        "ß",
        " ",
        "\t",
        "$(id)",
        "`id`",
    ),
    *(
        "; rm -rf /",
        "../..",
        "%s",
        "{0}",
        "__import__('os')",
        '"',
        "'",
        "\\",
        "grasp",
        "GRASP",
        "é",
    ),
]


@settings(max_examples=1500, deadline=None)
@given(st.lists(st.one_of(st.sampled_from(PIECES), st.text(max_size=8)), max_size=12))
def test_no_string_gets_anything_else_through(pieces):
    _holds("".join(pieces), NAMES)


@settings(max_examples=500, deadline=None)
@given(st.text(max_size=200), st.lists(st.text(max_size=20), max_size=4))
def test_nor_does_any_name(reply, names):
    _holds(reply, tuple(names))
    for name in names:
        _holds(f"<grasp>{name}</grasp>", tuple(names))


def test_ten_thousand_adversarial_strings():
    """Seeded, so that a failure comes again: pieces of tags, and whole replies with a bite."""
    draw = random.Random(7)
    whole = "Sure. <grasp>banana</grasp> and <point>soup_can</point> <speak>so</speak> <done/>"
    through = 0
    for number in range(10_000):
        if number % 2:
            reply = "".join(draw.choice(PIECES) for _ in range(draw.randrange(12)))
        else:
            at, length = draw.randrange(len(whole)), draw.randrange(4)
            reply = whole[:at] + draw.choice(PIECES) * draw.randrange(2) + whole[at + length :]
        _holds(reply, NAMES)
        try:
            through += bool(parse_reply(reply, NAMES))
        except TagError:
            continue
    assert 300 < through < 9_700  # neither everything nor nothing: the strings are near the border


def test_time_grows_with_the_length_only():
    """Strings that drive a backtracking parser to a standstill."""
    for reply in (
        "<grasp>" * 10**5,
        "<" * 10**6,
        "<grasp>" + "a" * 10**6,
        ("<" + "a" * 40) * 10**4,
    ):
        _holds(reply, NAMES)
        with pytest.raises(TagError):
            parse_reply(reply, NAMES, longest=10**7)
