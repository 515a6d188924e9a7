"""The Croissant card of pose sets: its files and columns are those that lie beside it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from pipeline.data.croissant import CROISSANT, croissant
from pipeline.data.dataset import CARD, split_seed, write_card, write_split
from pipeline.data.files import read_json, sha256, write_json
from robots import load_robot

SPLITS = ("train", "test")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made, robot = tmp_path_factory.mktemp("sets"), load_robot("panda")
    facts: dict[str, Any] = {}
    for count, split in enumerate(SPLITS, start=3):
        facts[split] = {"poses": count, "seed": split_seed(0, "panda", split)}
        joints = robot.sample(count, seed=count, collision_free=False)
        write_split(made / f"{split}.parquet", robot, joints, facts[split])
    write_card(made, {"robot": "panda", "splits": facts}, SPLITS)
    write_json(made / CROISSANT, croissant(read_json(made / CARD), robot))
    return made


def test_every_file_is_there_with_its_checksum(folder: Path) -> None:
    described = json.loads((folder / CROISSANT).read_text(encoding="utf-8"))
    assert described["@type"] == "sc:Dataset"
    assert described["conformsTo"] == "http://mlcommons.org/croissant/1.0"
    assert {"name", "description", "license", "version", "citeAs"} <= set(described)
    files = {each["@id"]: each for each in described["distribution"]}
    assert set(files) == {path.name for path in folder.glob("*.parquet")}
    for name, each in files.items():
        assert each["contentUrl"] == name
        assert each["sha256"] == sha256(folder / name)
    assert "4 for test, 3 for train" in described["description"]


def test_every_column_is_described_with_its_unit(folder: Path) -> None:
    described = json.loads((folder / CROISSANT).read_text(encoding="utf-8"))
    for records in described["recordSet"]:
        sources = [field["source"] for field in records["field"]]
        assert {each["fileObject"]["@id"] for each in sources} == {f"{records['@id']}.parquet"}
        named = [each["extract"]["column"] for each in sources]
        assert named == pq.read_schema(folder / f"{records['@id']}.parquet").names
        texts = {field["@id"]: field["description"] for field in records["field"]}
        assert len(texts) == len(named)
        assert texts[f"{records['@id']}/q0"] == "joint panda_joint1 [rad]"
        assert texts[f"{records['@id']}/x"].endswith("in the frame of panda_link0, x [m]")


def test_the_reference_implementation_reads_the_poses(folder: Path) -> None:
    mlcroissant = pytest.importorskip("mlcroissant")
    loaded = mlcroissant.Dataset(str(folder / CROISSANT))
    rows = list(loaded.records("test"))
    assert len(rows) == 4
    poses = pq.read_table(folder / "test.parquet").to_pandas()
    assert rows[0]["test/x"] == pytest.approx(poses.x[0])
