"""A run of a fleet learns what a training by itself learns."""

import time
from dataclasses import replace

import numpy as np
import pytest
import torch

from pipeline.config import compose
from pipeline.data.dataset import PoseSet
from pipeline.learning.fleet import FleetJob, build, run_fleet
from pipeline.learning.trainer import Trainer, TrainingRun
from robots import load_robot

CPU = torch.device("cpu")
ROBOT = load_robot("panda")


def poses_of(count, seed):
    joints = ROBOT.sample(count, seed=seed, collision_free=False)
    return PoseSet(ROBOT.forward_kinematics(joints), joints)


def job(**changes):
    config = compose(["robot=panda", "model=tiny", "profile=smoke"])
    train = replace(config.train, batch_size=60, epochs=3, warm_up_steps=5, loss="smooth")
    data, held_out = (
        torch.as_tensor(poses_of(count, seed).poses, dtype=torch.float32)
        for count, seed in ((500, 1), (50, 2))
    )
    return FleetJob("tiny", ROBOT, config.model, train, 7, data, held_out, **changes)


def run(jobs, deadline_s=60.0, beside=2):
    kept = []
    dropped = run_fleet(jobs, CPU, beside, time.perf_counter() + deadline_s, kept.append)
    return kept, dropped


def test_a_run_ends_with_the_weights_of_the_trainer():
    own = job()
    (done,), dropped = run([own])
    assert not dropped
    trainer = Trainer(
        ROBOT, build(own), replace(own.train, device="cpu"), TrainingRun(7, "", "alone")
    )
    progress = trainer.fit(poses_of(500, 1), poses_of(50, 2))
    assert progress.step == done.step == 24
    first = build(own)
    for got, wanted, before in zip(
        done.network.parameters(),
        trainer.network.parameters(),
        first.parameters(),
        strict=True,
    ):
        moved = float((wanted - before).detach().abs().max())
        assert float((got - wanted).detach().abs().max()) < 0.02 * moved
    loss, steps, skipped = done.sums.tolist()
    assert (steps, skipped) == (24, 0)
    assert loss > 0
    row = done.finish()[-1]
    assert row["step"] == 24
    assert row["position_error_mm"] == pytest.approx(
        progress.curve[-1]["validation_position_error_mm"], rel=0.02
    )


def test_runs_beside_each_other_do_not_touch():
    alone, _ = run([job()])
    beside, _ = run([job(), replace(job(), seed=8, label="other")])
    same = next(r for r in beside if r.job.seed == 7)
    for got, wanted in zip(same.network.parameters(), alone[0].network.parameters(), strict=True):
        assert torch.equal(got, wanted)


def test_a_limit_of_steps_ends_a_run_early_and_learns_no_further():
    (short,), _ = run([job(steps=11)])
    assert short.step == 11
    assert short.sums[1] == 11


def test_time_that_is_over_drops_what_is_unfinished_by_name():
    kept, dropped = run([job(), replace(job(), label="later")], deadline_s=-1.0)
    assert not kept
    assert dropped == ["tiny", "later"]


def test_answers_lie_within_the_limits():
    (done,), _ = run([job(steps=3)])
    answers = done.answers(torch.as_tensor(poses_of(40, 3).poses, dtype=torch.float32)).numpy()
    assert answers.shape == (40, ROBOT.dof)
    assert np.all((answers >= ROBOT.lower - 1e-5) & (answers <= ROBOT.upper + 1e-5))
