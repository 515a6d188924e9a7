"""Arguments of commands: options between overrides, and bad ones as one sentence."""

from __future__ import annotations

import pytest

from pipeline.commands.arguments import (
    CommandParser,
    command_parser,
    split_keys,
    with_defaults,
)
from pipeline.commands.chat import DEFAULTS
from pipeline.errors import PipelineError


def parser() -> CommandParser:
    made = command_parser("walk", "Walks.")
    made.add_argument("-m", "--many", action="store_true")
    made.add_argument("gait", choices=("trot", "gallop"))
    return made.takes_overrides()


@pytest.mark.parametrize(
    "arguments", ["trot a=1 b=[2,3] -m", "-m trot a=1 b=[2,3]", "trot a=1 --many b=[2,3]"]
)
def test_options_stand_anywhere_and_overrides_keep_their_order(arguments: str) -> None:
    given = parser().parse(arguments.split())
    assert given.many
    assert given.gait == "trot"
    assert given.overrides == ["a=1", "b=[2,3]"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("", "required: gait.*; usage: python -m pipeline walk"),
        ("trott", "no gait 'trott'; did you mean 'trot'"),
        ("trot --man", "no option '--man'; did you mean '--many'"),
        ("trot a=1 -x", "no option '-x'"),
    ],
)
def test_bad_arguments_are_one_sentence(arguments: str, words: str) -> None:
    with pytest.raises(PipelineError, match=words) as caught:
        parser().parse(arguments.split())
    assert "\n" not in str(caught.value)


def test_keys_of_a_command_are_split_from_overrides() -> None:
    assert split_keys(["to=c", "a=1", "out=b=c.h"], ("to", "out")) == (
        {"to": "c", "out": "b=c.h"},
        ["a=1"],
    )


@pytest.mark.parametrize("argument", ["to", "to="])
def test_a_key_without_a_value_is_refused(argument: str) -> None:
    with pytest.raises(PipelineError, match="to has no value; expected to="):
        split_keys(["a=1", argument], ("to", "out"))


def test_a_camera_and_the_policy_unless_something_else_is_chosen() -> None:
    assert with_defaults([], DEFAULTS) == ["perception=camera", "agent=policy", "robot=nicol"]
    chosen = ["agent=endpoint", "perception=perfect", "robot=nico"]
    assert with_defaults(chosen, DEFAULTS) == chosen
