"""Evaluations in turns and side by side: the order, the cores, and jobs that fail."""

import pytest

from pipeline.commands.benchmark import benchmark
from pipeline.config import compose
from pipeline.engine.cores import usable_cores
from pipeline.evaluation.side_by_side import EvaluationJob, jobs_in_turns, run_jobs


def test_robots_begin_with_other_solvers_and_unpinned_jobs_come_last():
    jobs = jobs_in_turns(["a", "b", "c"], ["x", "y"], ["y"])
    names = [str(job) for job in jobs]
    assert names[:6] == ["a x", "a y", "b y", "b x", "c x", "c y"]
    assert names[6:] == ["a y unpinned", "b y unpinned", "c y unpinned"]
    assert len({job.file_name for job in jobs}) == len(jobs)


def test_every_job_runs_once_and_a_failure_stops_no_other(tmp_path):
    seen = []
    jobs = jobs_in_turns(["a", "b"], ["x", "y"], ["y"])
    engine = compose(["engine.workers=2"]).engine

    def command(job, beside):
        seen.append((job, beside))
        return ["help"] if job != EvaluationJob("a", "y") else ["no-such-command"]

    failed = run_jobs(jobs, command, engine, tmp_path / "logs")
    assert failed == [EvaluationJob("a", "y")]
    assert sorted(str(job) for job, _ in seen) == sorted(str(job) for job in jobs)
    assert {beside for job, beside in seen if not job.pinned} == {1}
    assert {beside for job, beside in seen if job.pinned} == {min(2, usable_cores())}
    assert "error:" in (tmp_path / "logs" / EvaluationJob("a", "y").file_name).read_text()


@pytest.mark.parametrize(
    ("argument", "words"),
    [
        ("robot=panda", "takes robots="),
        ("--fast", "no option '--fast'"),
        ("processes=0", "whole number from 1"),
        ("numerical=[placco]", "did you mean 'placo'"),
        ("robots=[pandaa]", "did you mean 'panda'"),
    ],
)
def test_what_cannot_run_is_refused_before_the_first_job(argument, words):
    with pytest.raises(ValueError, match=words):
        benchmark([argument, "profile=smoke"])
