"""Stage commands of README and docs/ run to their end, at smoke scale; others look around."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import pytest

from pipeline.__main__ import main
from pipeline.commands import LOOKING
from pipeline.stages.graph import STAGES
from tests.pages import commands

pytestmark = pytest.mark.slow

# Need a cluster, a model's server, or a model of the reader's.
ELSEWHERE = {"engine=slurm", "engine=ray", "agent=endpoint", "perception.detector=open_vocabulary"}
HERE = "engine.cluster=local"  # jobs of SLURM as processes of this machine
SMALL = {  # what profile=smoke does not make small, or an experiment makes large again
    "plan": ["plan.pairs=3"],
    "reach": ["reach.spacing_m=0.2", "reach.orientations=8"],
    "compare-tuned": ["tune.comparison.amount=1", "tune.comparison.replicates=2"],
}
FIRST = ("dataset", "tune")  # what others of these commands start from
OF_PIPELINE = [words[3:] for words in commands() if words[:3] == ["python", "-m", "pipeline"]]
STAGE_COMMANDS = sorted(
    (words for words in OF_PIPELINE if words and words[0] in STAGES and "--help" not in words),
    key=lambda words: words[:1] not in [[name] for name in FIRST],
)
RUNNABLE = [
    words
    for words in STAGE_COMMANDS
    if not set(words) & ELSEWHERE or (HERE in words and find_spec("submitit"))
]
LOOKS = [words for words in OF_PIPELINE if len(words) == 1 and words[0] in LOOKING]
WRITES = ("dvc", "readme", "deviations", "code")  # files of the checkout


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("results")


@pytest.mark.xdist_group("pages")
@pytest.mark.parametrize("words", RUNNABLE, ids=" ".join)
def test_a_command_of_a_stage_runs(words: list[str], folder: Path) -> None:
    kept = [item for item in words if not item.startswith(("profile=", "results_dir="))]
    small = ["profile=smoke", f"results_dir={folder}", *SMALL.get(words[0], [])]
    assert main([*kept, *small]) == 0
    assert any(folder.rglob("*"))


@pytest.mark.parametrize(
    "words", [words for words in LOOKS if words[0] not in WRITES], ids=" ".join
)
def test_a_command_that_looks_around_prints_something(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 0
    assert capsys.readouterr().out.strip()
