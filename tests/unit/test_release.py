"""The version stands in several files, and is one."""

from __future__ import annotations

import json
import re
import tomllib

import pytest
import yaml

from robots.locations import FOLDER


@pytest.fixture(scope="module")
def version() -> str:
    with (FOLDER / "pyproject.toml").open("rb") as stream:
        return str(tomllib.load(stream)["project"]["version"])


def test_citation_archive_and_changelog_have_the_version_of_the_package(version: str) -> None:
    citation = yaml.safe_load((FOLDER / "CITATION.cff").read_text(encoding="utf-8"))
    archive = json.loads((FOLDER / ".zenodo.json").read_text(encoding="utf-8"))
    changes = re.findall(r"^## (\S+)(?: \((.*)\))?$", read("CHANGELOG.md"), re.MULTILINE)
    assert {citation["version"], archive["version"], changes[0][0]} == {version}
    assert str(citation["date-released"]) == archive["publication_date"] == changes[0][1]
    assert citation["license"] == archive["license"]


def test_users_are_told_what_is_new_what_moved_and_how_to_upgrade() -> None:
    newest = read("CHANGELOG.md").split("\n## ")[1]
    for title in ("### New", "### Moved", "### Upgrading"):
        assert f"\n{title}\n" in newest


def read(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")
