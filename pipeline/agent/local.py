"""A language model on this machine, offline: a GGUF file, decoded greedily within the grammar.

The file is read by `transformers` and its weights are computed with in float32. At each step only
tokens that may follow in a reply of tags are considered (`TagGrammar`), so a model however weak
utters actions that exist, on objects that are in view; which ones is its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from pipeline.agent.config import AgentConfig
from pipeline.agent.errors import SetupError
from pipeline.agent.gguf_file import model_file
from pipeline.agent.model import Message
from pipeline.agent.scene_text import read_user_text
from pipeline.agent.tag_grammar import TagGrammar
from pipeline.packages import optional_package

SETTING = "agent=local"


class LocalModel:
    """A language model from a file.

    Attributes:
        name: Of the file, without suffix; it appears in rows and transcripts.
    """

    def __init__(self, config: AgentConfig) -> None:
        """Load the model, some seconds.

        Args:
            config: The file, and the bounds of a reply.

        Raises:
            SetupError: A package or the file is missing, or it is no model.
        """
        path = model_file(config.local.file)
        self.name, self._config = path.stem, config
        self._tokenizer, self._network = _load(path)
        vocabulary = [[token] for token in range(len(self._tokenizer))]
        self._words = Words(self._tokenizer.batch_decode(vocabulary))
        self._seen: list[int] = []  # tokens whose keys and values are kept
        self._cache: Any = None

    def reply(self, messages: Sequence[Message]) -> str:
        """Answer the last message; see `pipeline.agent.model.LanguageModel`."""
        _, seen = read_user_text(messages[-1].content)
        config, reply = self._config, ""
        bounds = config.max_actions, config.repeats, config.local.longest
        grammar = TagGrammar([each.name for each in seen], config.actions, *bounds)
        asked = [{"role": each.role, "content": each.content} for each in messages]
        text = self._tokenizer.apply_chat_template(
            asked, tokenize=False, add_generation_prompt=True
        )
        tokens = self._tokenizer(text, add_special_tokens=False).input_ids
        with torch.inference_mode():
            while not grammar.over:
                scores = self._scores(tokens).masked_fill(~self._words.allowed(grammar), -torch.inf)
                token = int(scores.argmax())
                grammar.follow(self._words.texts[token])
                reply += self._words.texts[token]
                tokens = [*tokens, token]
        return reply.strip()

    def _scores(self, tokens: list[int]) -> Tensor:
        """Scores (words,) of what may follow; what was computed for the same beginning is kept."""
        same = 0
        limit = min(len(self._seen), len(tokens) - 1)
        while same < limit and self._seen[same] == tokens[same]:
            same += 1
        if same == 0:
            self._cache = None
        elif same < len(self._seen):
            self._cache.crop(same - len(self._seen))
        answer = self._network(
            torch.tensor([tokens[same:]]),
            past_key_values=self._cache,
            use_cache=True,
            logits_to_keep=1,
        )
        self._cache, self._seen = answer.past_key_values, tokens
        scores: Tensor = answer.logits[
            0, -1, : len(self._words.texts)
        ]  # files pad their vocabulary
        return scores


class Words:
    """The texts of a vocabulary, and which of them may follow.

    Args:
        texts: Of each token, in order.
    """

    def __init__(self, texts: Sequence[str]) -> None:
        self.texts = texts
        self._tokens = {text: token for token, text in reversed([*enumerate(texts)])}
        self._plain = torch.tensor(
            [t != "" and t.isascii() and t.isprintable() and not set(t) & set("<>") for t in texts]
        )
        self._length = torch.tensor([len(text) for text in texts])

    def allowed(self, grammar: TagGrammar) -> Tensor:
        """Return the tokens (words,) that may follow, as truth values."""
        mask = self._plain & (self._length <= grammar.left_to_say())
        for text in grammar.continuations():
            beginnings = (text[:length] for length in range(1, len(text) + 1))
            mask[[self._tokens[part] for part in beginnings if part in self._tokens]] = True
        return mask


@cache
def _load(path: Path) -> tuple[Any, Any]:
    """Tokenizer and network of a file."""
    optional_package(SETTING, SetupError)  # without gguf, transformers would say so late
    import transformers

    transformers.utils.logging.disable_progress_bar()
    file = {"gguf_file": path.name, "local_files_only": True}
    try:
        tokenizer = transformers.AutoTokenizer.from_pretrained(path.parent, **file)
        network = transformers.AutoModelForCausalLM.from_pretrained(
            path.parent, dtype=torch.float32, **file
        )
    except (OSError, ValueError, KeyError, ImportError) as error:
        sentence = " ".join(str(error).split())
        raise SetupError(f"the model in {path} cannot be loaded: {sentence}") from error
    return tokenizer, network.eval()
