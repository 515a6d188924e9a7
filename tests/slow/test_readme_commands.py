"""The commands of README run to their end, at the smoke scale and into a folder of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.__main__ import main
from pipeline.stages.graph import STAGES
from tests.readme import commands

pytestmark = pytest.mark.slow

ELSEWHERE = ("engine=slurm", "engine=ray", "agent=endpoint")  # need a cluster, or a model's server
SMALL = {  # what profile=smoke does not make small, or an experiment makes large again
    "plan": ["plan.pairs=3"],
    "compare-tuned": ["tune.comparison.amount=1", "tune.comparison.replicates=2"],
}
FIRST = ("dataset", "tune")  # what others of these commands start from
STAGE_COMMANDS = sorted(
    (words[3:] for words in commands() if words[:3] == ["python", "-m", "pipeline"]),
    key=lambda words: words[:1] not in [[name] for name in FIRST],
)
RUNNABLE = [
    words
    for words in STAGE_COMMANDS
    if words and words[0] in STAGES and not set(words) & {*ELSEWHERE}
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("results")


@pytest.mark.xdist_group("readme")
@pytest.mark.parametrize("words", RUNNABLE, ids=" ".join)
def test_a_command_of_readme_runs(words: list[str], folder: Path) -> None:
    kept = [item for item in words if not item.startswith(("profile=", "results_dir="))]
    small = ["profile=smoke", f"results_dir={folder}", *SMALL.get(words[0], [])]
    assert main([*kept, *small]) == 0
    assert any(folder.rglob("*"))
