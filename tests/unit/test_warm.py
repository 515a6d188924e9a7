"""`warm` compiles once for a state of the sources."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pipeline.commands import warm
from robots import compiled_cache


class Pool:
    """Runs tasks in place of worker processes."""

    compiled: list[str]

    def __init__(self, *setting: Any) -> None:
        pass

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *problem: object) -> None:
        pass

    def submit(self, function: Any, name: str) -> Any:
        Pool.compiled.append(name)
        return _Done()


class _Done:
    def result(self) -> None:
        pass


def test_it_compiles_again_when_a_source_has_changed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    Pool.compiled = []
    monkeypatch.setattr(warm, "STAMP", tmp_path / "kernels")
    monkeypatch.setattr(warm, "ProcessPoolExecutor", Pool)
    monkeypatch.setattr(warm, "as_completed", list)
    for _ in range(2):
        assert warm.warm([]) == 0
    assert sorted(Pool.compiled) == sorted(warm.KERNELS)
    monkeypatch.setattr(warm, "source_digest", lambda *folders: "another")
    warm.warm([])
    assert len(Pool.compiled) == 2 * len(warm.KERNELS)


def test_its_stamp_knows_every_folder_with_compiled_functions() -> None:
    root = compiled_cache.ROOT
    folders = {
        path.parent.relative_to(root).as_posix()
        for package in ("robots", "baselines", "pipeline")
        for path in (root / package).rglob("*.py")
        if "@njit" in path.read_text(encoding="utf-8")
    }
    assert folders <= set(warm.COMPILED)
