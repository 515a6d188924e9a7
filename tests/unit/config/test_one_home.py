"""Every key of every YAML acts where it stands, and says what it is.

Each value under conf/ is replaced by a text that names its file and key. A run must then have
just these texts, each at the key that its file speaks of: whatever is set twice, or by a file that
is not read, is found.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import pytest
import yaml
from omegaconf import OmegaConf

from baselines import registry
from pipeline.config import (
    OWNERS,
    Source,
    bench_lists,
    compose,
    group_choices,
    sources,
    to_yaml,
    values,
)
from pipeline.key_comments import key_comments
from pipeline.locations import CONF_DIR
from pipeline.settings import Config
from tests.groups import runs

HEADER = "# @package _global_\n"
STRUCTURE = ("defaults", registry.TARGET)  # they say what is composed; they are no values


@cache
def files_of(*run: str) -> tuple[Source, ...]:
    return tuple(sources(run))


def leaves(node: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Keys and values of a document; a list is one value unless it holds mappings."""
    nested = isinstance(node, list) and any(isinstance(item, dict) for item in node)
    if isinstance(node, dict) and (node or not path):
        for key, value in node.items():
            if path or key not in STRUCTURE:
                yield from leaves(value, f"{path}.{key}" if path else str(key))
    elif nested and all(node):
        for number, item in enumerate(node):
            yield from leaves(item, f"{path}.{number}")
    else:
        yield path, node


def mark(path: Path, key: str) -> str:
    return f"{path.parent.name}/{path.stem} {key}"


def marked(node: Any, path: Path, key: str = "") -> Any:
    """The document with every value replaced by its mark."""
    if key and key in dict(leaves(node, key)):
        return mark(path, key)
    if isinstance(node, dict):
        return {
            name: value
            if not key and name in STRUCTURE
            else marked(value, path, f"{key}.{name}" if key else str(name))
            for name, value in node.items()
        }
    return [marked(item, path, f"{key}.{number}") for number, item in enumerate(node)]


def read(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8")) or {}


@pytest.fixture(scope="module")
def marked_conf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("marked") / "conf"
    shutil.copytree(CONF_DIR, folder)
    for path in folder.rglob("*.yaml"):
        header = HEADER if path.read_text(encoding="utf-8").startswith(HEADER) else ""
        content = marked(read(path), path)
        path.write_text(header + yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return folder


@pytest.fixture
def composed_of_marks(marked_conf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pipeline.config.CONF_DIR", marked_conf)
    monkeypatch.setattr(registry, "FOLDER", marked_conf / "solver")


def at(node: Any, path: str) -> Any:
    for part in path.split("."):
        node = node[int(part)] if isinstance(node, list) else node[part]
    return node


def keys_of(source: Source) -> list[tuple[str, str]]:
    """Each key of a file, and where in the configuration it stands."""
    prefix = f"{source.package}." if source.package else ""
    return [(key, prefix + key) for key, _ in leaves(read(source.path))]


def is_owner(source: Source) -> bool:
    return source.path.parent.name in OWNERS


def sets(path: str, owned: set[str]) -> bool:
    return any(other == path or other.startswith(f"{path}.") for other in owned)


@pytest.mark.usefixtures("composed_of_marks")
@pytest.mark.parametrize("run", runs(), ids=" ".join)
def test_a_key_acts_where_it_stands(run: list[str]) -> None:
    got, files = values(run), sources(run)
    owned: set[str] = set()  # by profile and experiment, which come last
    astray = []
    for source in reversed(files):
        astray += [
            f"{source.path.parent.name}/{source.path.name}: {key}"
            for key, place in keys_of(source)
            if not sets(place, owned) and at(got, place) != mark(source.path, key)
        ]
        if is_owner(source):
            owned |= {place for _, place in keys_of(source)}
    assert not astray, "\n".join(astray)
    others = {place for file in files if not is_owner(file) for _, place in keys_of(file)}
    if "profile=quick" in run:
        assert not {place for place in others if sets(place, owned)}, "quick owns what no other has"


def test_every_file_is_selected_by_a_run() -> None:
    seen = {source.path for run in runs() for source in files_of(*run)}
    apart = {*CONF_DIR.glob("bench*.yaml")}
    assert {*CONF_DIR.rglob("*.yaml")} - seen == apart, "for what runs all the others"
    dvc = (CONF_DIR.parent / "dvc.yaml").read_text(encoding="utf-8")
    code = "".join(
        path.read_text(encoding="utf-8")
        for folder in ("commands", "stages")
        for path in (CONF_DIR.parent / "pipeline" / folder).glob("*.py")
    )
    for key in bench_lists():
        assert f"${{{key}}}" in dvc or f'"{key}"' in code, key


@pytest.mark.parametrize("run", [[], ["profile=smoke", "experiment=constraint"]], ids=" ".join)
def test_a_run_gets_what_is_composed(run: list[str]) -> None:
    got = yaml.safe_load(to_yaml(compose(run)))
    wanted = {key: value for key, value in leaves(values(run)) if key != "results_dir"}
    assert {key: at(got, key) for key in wanted} == wanted


@pytest.mark.parametrize("owner", OWNERS)
def test_what_is_set_for_another_group_is_said(owner: str) -> None:
    """Experiments list it in their header; a profile says at the key what it is in place of."""
    for name in group_choices(owner):
        path = CONF_DIR / owner / f"{name}.yaml"
        header = path.read_text(encoding="utf-8").split("defaults:")[0].replace("\n# ", " ")
        files = files_of(f"{owner}={name}")
        others = {p for file in files if file.path != path for _, p in keys_of(file)}
        for key, _ in leaves(read(path)):
            if owner == "profile" and sets(key, others):
                assert "in place of" in key_comments(path)[key], f"{path.name}: {key}"
            if owner == "experiment":
                group, setting = key.split(".")[:2]
                said = header.partition("Sets:")[2]
                assert group in said, f"{path.name}: {key}"
                assert setting in said, f"{path.name}: {key}"


def test_every_key_has_a_comment() -> None:
    """Nested ones too: meaning and unit stand beside the value, or beside the mapping of names."""
    named = {*names_of_data(Config)}
    documented = {
        place
        for run in runs()
        for source in files_of(*run)
        if source.path.parent.name != "experiment"
        for key, text in key_comments(source.path).items()
        if text
        for place in [f"{source.package}.{key}" if source.package else key]
    }
    bare = []
    for source in {source for run in runs() for source in files_of(*run)}:
        prefix = f"{source.package}." if source.package else ""
        found = key_comments(source.path)
        for key, text in found.items():
            above = [key.rsplit(".", count)[0] for count in range(1, key.count(".") + 1)]
            known = is_owner(source) and (
                key in CONF_GROUPS or any(prefix + name in documented for name in (key, *above))
            )
            data = any(prefix + name in named and found[name] for name in above)
            if not (text or known or data or key.split(".")[0] in STRUCTURE):
                bare.append(f"{source.path.relative_to(CONF_DIR)}: {key}")
    for path in CONF_DIR.glob("bench*.yaml"):
        bare += [f"{path.name}: {key}" for key, text in key_comments(path).items() if not text]
    assert not bare, "\n".join(sorted(bare))


CONF_GROUPS = {path.name for path in CONF_DIR.iterdir() if path.is_dir()}


def names_of_data(owner: type, path: str = "") -> Iterator[str]:
    """Keys whose children are words or robots with a text each, not settings."""
    hints = get_type_hints(owner)
    for item in fields(owner):
        place, hint = f"{path}{item.name}", hints[item.name]
        if is_dataclass(hint) and isinstance(hint, type):
            yield from names_of_data(hint, f"{place}.")
        elif get_origin(hint) is dict and get_args(hint)[1] in (str, list[str]):
            yield place


def test_an_edit_of_a_recipe_acts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`dvc exp run -S 'conf/train/compact.yaml:learning_rate=0.001'` of the docs edits the file."""
    folder = tmp_path / "conf"
    shutil.copytree(CONF_DIR, folder)
    path = folder / "train" / "compact.yaml"
    content = read(path)
    assert content["learning_rate"] != 0.001
    content["learning_rate"] = 0.001
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    monkeypatch.setattr("pipeline.config.CONF_DIR", folder)
    assert OmegaConf.create(values()).train.learning_rate == 0.001
    page = (CONF_DIR.parent / "docs" / "keys.md").read_text(encoding="utf-8")
    assert "dvc exp run -S 'conf/train/compact.yaml:learning_rate=0.001'" in page
    dvc = read(CONF_DIR.parent / "dvc.yaml")["stages"]["train"]["params"]
    assert {"conf/train/${model}.yaml": None} in dvc
