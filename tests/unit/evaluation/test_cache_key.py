"""What rows say of themselves, and what makes others of them: seeds, cores, settings, weights."""

import json
import os
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scripted import OneByOne, Scripted, task

import baselines
from baselines import Solution, Solver
from pipeline.evaluation.cache import cache_key, solver_identity
from pipeline.evaluation.config import row_name, solver_of_rows
from pipeline.evaluation.runner import evaluate_solver, plan_chunks
from robots import load_robot

ROOT = Path(__file__).parents[3]


class Seeder(Solver):
    """Answers with joints that depend on the pose, so that a mix-up would show."""

    name = "seeder"

    def _solve_batch(self, poses, initial, budget):
        solution = Solution.empty(len(poses), self.robot.dof)
        joints = np.repeat(poses[:, :1], self.robot.dof, axis=1)
        return replace(solution, joints=joints, reason=("not a solution",) * len(poses))


@pytest.mark.parametrize("batch_size", [1, 4])
def test_each_pose_starts_from_the_seed_of_that_pose(robot, config, batch_size):
    given = replace(task(robot, OneByOne(robot)), seeder=Seeder(robot))
    rows = evaluate_solver(given, replace(config, batch_sizes=[batch_size]))
    inside = np.clip(rows.target_x_m, robot.lower[0], robot.upper[0])
    np.testing.assert_array_equal(rows.q0, inside)
    assert (rows.seeded_by == "seeder").all()
    assert (rows.seed_time_us > 0).all()
    assert cache_key(given, config)["seeder_identity"]["class"].endswith("Seeder")
    home = evaluate_solver(replace(given, seeder=None), config)
    assert (home.seeded_by == "home").all()
    assert (home.seed_time_us == 0).all()


def test_rows_say_whether_they_were_pinned_and_to_how_many_cores(robot, config):
    given = task(robot, Scripted(robot, robot.home))
    cores = len(os.sched_getaffinity(0))
    rows = evaluate_solver(given, config)
    assert rows.pinned.all()
    assert (rows.threads == 1).all()
    free = evaluate_solver(given, replace(config, pinned=False))
    assert not free.pinned.any()
    assert (free.threads == cores).all()
    assert len(os.sched_getaffinity(0)) == cores
    assert row_name("trac_ik", pinned=False) != row_name("trac_ik", pinned=True) == "trac_ik"
    assert solver_of_rows(row_name("trac_ik", pinned=False)) == "trac_ik"


def test_solvers_of_single_poses_are_not_timed_in_batches(robot, config):
    config = replace(config, batch_sizes=[1, 4])
    chunks = list(plan_chunks(task(robot, OneByOne(robot, iterations=1)), config))
    assert chunks == [(1, 0, 5), (1, 5, 10), (1, 10, 12)]


def test_the_question_is_json_and_names_poses_and_machine(robot, config):
    import json

    key = cache_key(task(robot, Scripted(robot, robot.home)), config)
    assert json.loads(json.dumps(key))["poses"] == 12
    assert len(key["poses_checksum"]) == 64
    assert key["machine"]["threads"] == 1


def test_other_weights_or_settings_are_another_question(robot, config):
    import torch

    torch.manual_seed(0)
    solver = Scripted(robot, robot.home)
    solver.network = torch.nn.Linear(7, 2)
    given = task(robot, solver)
    first = cache_key(given, config)
    assert cache_key(given, config) == first
    with torch.no_grad():
        solver.network.weight[0, 0] += 1e-6
    assert cache_key(given, config) != first
    other = task(robot, Scripted(robot, robot.home, found=False))
    assert cache_key(other, config) != cache_key(task(robot, Scripted(robot, robot.home)), config)


def test_an_edited_setting_is_another_question_but_a_moved_folder_of_weights_is_not(robot):
    first, again = (solver_identity(baselines.load("lm", robot)) for _ in range(2))
    assert first == again
    assert solver_identity(baselines.load("lm", robot, damping_gain=0.5)) != first
    outer = Scripted(robot, robot.home)
    outer.settings = {"weights": "here"}
    outer.kernel = baselines.load("lm", robot)
    before = solver_identity(outer)
    outer.settings = {"weights": "there"}
    assert solver_identity(outer) == before
    outer.kernel = baselines.load("lm", robot, patience=7)
    assert solver_identity(outer) != before


def test_the_budget_that_was_used_is_told(robot, config):
    given = task(robot, baselines.load("lm", robot, iterations=50))
    assert cache_key(given, config)["solver_budget"] == {"time_s": None, "iterations": 50}
    timed = cache_key(given, replace(config, time_s=1e-3))
    assert timed["solver_budget"] == {"time_s": 1e-3, "iterations": None}
    more = replace(config, time_s=1e-3, time_factor={given.solver.name: 4.0, "other": 9.0})
    assert cache_key(given, more)["solver_budget"] == {"time_s": 4e-3, "iterations": None}


def test_rows_of_other_code_answer_another_question(robot, config):
    given = replace(task(robot, Scripted(robot, robot.home)), code="before")
    assert cache_key(given, config) == cache_key(given, config)
    assert cache_key(replace(given, code="after"), config) != cache_key(given, config)


@pytest.mark.parametrize("name", ["lm", "pinocchio", "placo", "bio_ik"])
def test_a_solver_made_in_another_process_is_the_same_one(name):
    """Kept rows of a killed run would otherwise never be found again."""
    program = (
        "import baselines, json; from robots import load_robot; "
        "from pipeline.evaluation.cache import solver_identity; "
        f"print(json.dumps(solver_identity(baselines.load('{name}', load_robot('panda')))))"
    )
    made = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    here: list[dict] = []
    thread = threading.Thread(
        target=lambda: here.append(solver_identity(baselines.load(name, load_robot("panda"))))
    )
    thread.start()
    thread.join()
    assert json.loads(made.stdout) == json.loads(json.dumps(here[0]))
