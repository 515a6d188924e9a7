"""Every folder of shipped weights has a model card, which says what its card says."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.commands.model_card import write_model_card
from robots.locations import FOLDER

FOLDERS = sorted(path.parent for path in (FOLDER / "robots").glob("*/*/card.json"))


def test_five_networks_and_two_detectors_ship() -> None:
    assert len(FOLDERS) == 7


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda each: f"{each.parent.name}-{each.name}")
def test_a_model_card_is_that_of_its_weights(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "card.json").write_bytes((folder / "card.json").read_bytes())
    write_model_card(tmp_path)
    made = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert (folder / "README.md").read_text(encoding="utf-8") == made
    assert f"{folder.parent.name}" in made
