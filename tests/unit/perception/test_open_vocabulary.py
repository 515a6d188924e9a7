"""An OWL-ViT-class model from a local folder: a tiny one with random weights, made here."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.config import compose
from pipeline.errors import PerceptionError
from pipeline.perception.loading import load_detector
from robots import load_robot

CONFIG = replace(compose(["perception=camera"]).perception, detector="open_vocabulary")
NAMES = ("banana", "soup_can")
PIXELS, LENGTH = 32, 16  # side of the model's picture, length of a text


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model as `save_pretrained` leaves it; single letters are all of its vocabulary."""
    transformers = pytest.importorskip("transformers", reason="the extra `perception` is missing")
    path = tmp_path_factory.mktemp("owl")
    letters = [chr(code) for code in range(ord("a"), ord("z") + 1)]
    words = [*letters, *(f"{letter}</w>" for letter in letters)]
    words += ["<|startoftext|>", "<|endoftext|>"]
    vocabulary = {word: number for number, word in enumerate(words)}
    (path / "vocab.json").write_text(json.dumps(vocabulary))
    (path / "merges.txt").write_text("#version: 0.2\n")
    tokenizer = transformers.CLIPTokenizer(
        str(path / "vocab.json"), str(path / "merges.txt"), model_max_length=LENGTH
    )
    layers = {"hidden_size": 16, "intermediate_size": 16, "num_hidden_layers": 1}
    layers |= {"num_attention_heads": 2}
    config = transformers.OwlViTConfig(
        text_config={
            **layers,
            "vocab_size": len(words),
            "max_position_embeddings": LENGTH,
            "bos_token_id": vocabulary["<|startoftext|>"],
            "eos_token_id": vocabulary["<|endoftext|>"],
            "pad_token_id": 0,
        },
        vision_config={**layers, "image_size": PIXELS, "patch_size": 8},
        projection_dim=16,
    )
    images = transformers.OwlViTImageProcessor(size={"height": PIXELS, "width": PIXELS})
    transformers.OwlViTProcessor(image_processor=images, tokenizer=tokenizer).save_pretrained(path)
    transformers.OwlViTForObjectDetection(config).save_pretrained(path)
    return path


def test_texts_go_in_and_named_boxes_come_out(folder: Path) -> None:
    vocabulary = replace(CONFIG.vocabulary, model=str(folder))
    config = replace(CONFIG, vocabulary=vocabulary, threshold=0.0)
    detector = load_detector(config, load_robot("nicol"), NAMES)
    assert detector.names == NAMES
    image = np.random.default_rng(0).integers(0, 255, (48, 64, 3), dtype=np.uint8)
    found = detector.detect(image)
    assert found and {each.name for each in found} <= set(NAMES)
    scores = [each.score for each in found]
    assert scores == sorted(scores, reverse=True) and max(scores) <= 1.0
    for each in found:
        x0, y0, x1, y1 = each.box
        assert each.centroid == pytest.approx(((x0 + x1) / 2, (y0 + y1) / 2))
    none = load_detector(replace(config, threshold=1.0), load_robot("nicol"), NAMES)
    assert none.detect(image) == []
    with pytest.raises(PerceptionError, match="8-bit"):
        detector.detect(image[:, :, 0])


def test_a_folder_without_a_model_is_refused(tmp_path: Path) -> None:
    config = replace(CONFIG, vocabulary=replace(CONFIG.vocabulary, model=str(tmp_path)))
    with pytest.raises(PerceptionError, match="there is no model in"):
        load_detector(config, load_robot("nicol"), NAMES)
    with pytest.raises(PerceptionError, match=r"needs perception\.vocabulary\.model"):
        load_detector(CONFIG, load_robot("nicol"), NAMES)
    with pytest.raises(PerceptionError, match="needs the names"):
        load_detector(CONFIG, load_robot("nicol"))


def test_something_else_in_the_folder_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("transformers", reason="the extra `perception` is missing")
    (tmp_path / "config.json").write_text('{"model_type": "no such model"}')
    config = replace(CONFIG, vocabulary=replace(CONFIG.vocabulary, model=str(tmp_path)))
    with pytest.raises(PerceptionError, match="cannot be loaded"):
        load_detector(config, load_robot("nicol"), NAMES)


def test_a_missing_package_is_said_in_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "config.json").write_text("{}")
    monkeypatch.setitem(sys.modules, "transformers", None)
    config = replace(CONFIG, vocabulary=replace(CONFIG.vocabulary, model=str(tmp_path)))
    with pytest.raises(PerceptionError, match=r"pip install 'cycleik-bench\[perception\]'"):
        load_detector(config, load_robot("nicol"), NAMES)
