"""The path to a SLURM cluster, its commands played by shell scripts that run an array in turn."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pipeline.config import compose
from pipeline.engine import submitit_jobs
from pipeline.engine.config import EngineConfig
from pipeline.engine.running import run_tasks, try_tasks
from pipeline.errors import EngineError
from tests import engine_tasks

pytest.importorskip("submitit", reason="submitit is not installed (extra cluster)")
SBATCH = """#!/bin/sh
cp "$1" "$PLAYED/submitted.sh"
last=$(sed -n 's/^#SBATCH --array=0-\\([0-9]*\\)%.*/\\1/p' "$1")
export SLURM_ARRAY_JOB_ID=$$ SLURM_NTASKS=1 SLURM_JOB_NUM_NODES=1
export SLURM_NODEID=0 SLURM_PROCID=0 SLURM_LOCALID=0
(for task in $(seq 0 $last); do
  SLURM_JOB_ID=$(($$ + task)) SLURM_ARRAY_TASK_ID=$task sh "$1"
  echo "$$_$task|COMPLETED" >> "$PLAYED/states"
done) > "$PLAYED/log" 2>&1 &
echo "Submitted batch job $$"
"""
SRUN = """#!/bin/sh
while [ "${1#-}" != "$1" ]; do
  case "$1" in --output|--error) shift;; esac
  shift
done
exec "$@"
"""
SACCT = """#!/bin/sh
echo "JobID|State"
cat "$PLAYED/states" 2> /dev/null || true
"""
SCANCEL = """#!/bin/sh
echo "$@" >> "$PLAYED/cancelled"
"""
COMMANDS = {"sbatch": SBATCH, "srun": SRUN, "sacct": SACCT, "scancel": SCANCEL}


@pytest.fixture
def cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> EngineConfig:
    for name, script in COMMANDS.items():
        (tmp_path / name).write_text(script, encoding="utf-8")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.setenv("PLAYED", str(tmp_path))
    monkeypatch.setattr(submitit_jobs, "CLUSTER_POLL_S", 0.1)
    overrides = [
        "engine=slurm",
        "engine.workers=3",
        "engine.cpus=2",
        "engine.memory_gb=1.5",
        "engine.minutes=7",
        "engine.partition=short",
        "engine.options={account: robotics}",
        "engine.setup=[module load python]",
        "engine.tasks_per_job=2",
        f"results_dir={tmp_path / 'results'}",
    ]
    return compose(overrides).engine


def test_tasks_become_one_array_of_jobs(cluster: EngineConfig, tmp_path: Path) -> None:
    assert run_tasks(cluster, engine_tasks.square, range(5), title="grasp") == [0, 1, 4, 9, 16]
    script = (tmp_path / "submitted.sh").read_text(encoding="utf-8").splitlines()
    wanted = ("array=0-2%3", "cpus-per-task=2", "job-name=grasp", "partition=short", "time=7")
    for line in (*wanted, "account=robotics"):
        assert f"#SBATCH --{line}" in script
    assert "module load python" in script
    assert not (tmp_path / "results").exists() or not list((tmp_path / "results").rglob("*.pkl"))


def test_a_job_that_dies_loses_its_own_tasks(
    cluster: EngineConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    import submitit

    monkeypatch.setattr(submitit.Job, "_results_timeout_s", 1)
    endings = dict(try_tasks(cluster, engine_tasks.die_at_one, range(4)))
    assert [number for number, outcome in sorted(endings.items()) if outcome.lost] == [0, 1]
    assert re.fullmatch(r"job \d+_0 died; its log is in .*/jobs/tasks-.*_0", endings[1].problem)


def test_a_scheduler_that_refuses_is_quoted(cluster: EngineConfig, tmp_path: Path) -> None:
    script = "#!/bin/sh\necho 'invalid partition specified: short' >&2\nexit 1\n"
    (tmp_path / "sbatch").write_text(script, encoding="utf-8")
    with pytest.raises(EngineError, match=r"took no jobs: .*invalid partition specified: short"):
        run_tasks(cluster, engine_tasks.square, range(2))
