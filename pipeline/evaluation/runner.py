"""Runs a solver on poses and writes down everything about every one of them: raw rows."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from baselines import Budget, QuerySolver, Solution, Solver, SolverError
from pipeline.errors import PipelineError
from pipeline.evaluation.cache import ChunkCache, cache_key
from pipeline.evaluation.config import EvaluateConfig
from pipeline.evaluation.machine import (
    allowed_threads,
    fingerprint_hash,
    machine_fingerprint,
    pinned,
)
from pipeline.evaluation.rows import raw_rows
from pipeline.evaluation.task import EvaluationTask, accepted_budget

Array = NDArray[np.float64]
NS_PER_US = 1e3


class EvaluationError(PipelineError):
    """An evaluation that cannot be run, or a solver that breaks its protocol."""


def evaluate_solver(
    task: EvaluationTask,
    config: EvaluateConfig,
    cache_folder: Path | None = None,
    progress: Callable[[int], object] | None = None,
) -> pd.DataFrame:
    """Solve every pose and record joints, true errors, claims and time, one row a pose and batch.

    One batch size answers all poses: the first of ``config.batch_sizes``, or the solver's in
    ``config.error_batch_size``. The others are for time: they answer ``config.latency_poses``
    (at least one batch, a small test set again from its start) and only where the solver answers
    whole batches. A solver that fails on a call gives rows with ``found = false``, its home
    configuration and the reason; nothing is dropped.

    Args:
        task: Solver, robot and poses.
        config: Budget, batch sizes, warm-up, threads.
        cache_folder: Where finished chunks are kept, so that a second call continues; None keeps
            none. Call `pipeline.evaluation.cache.clear_chunks` when the
            rows are safely written.
        progress: Called with the number of poses finished, also for chunks found on disk.

    Returns:
        Raw rows; `pipeline.evaluation.rows.COLUMNS` says what each column means.

    Raises:
        EvaluationError: No poses, or a solver that answers with the wrong shape.
    """
    if len(task.poses) == 0:
        raise EvaluationError("expected at least one pose to evaluate, got none")
    threads = allowed_threads(config.threads, config.pinned)
    machine = fingerprint_hash(machine_fingerprint(threads))
    cache = ChunkCache(cache_folder, cache_key(task, config))
    with pinned(config.threads, cores=config.pinned, first=config.first_core):
        _warm_up(task, config)
        frames = []
        for batch_size, start, stop in plan_chunks(task, config):
            name = f"batch{batch_size}_{start:08d}"
            rows = cache.get(name)
            if rows is None:
                part = task.part(start, stop)
                rows = _solve_chunk(part, config, batch_size, start, len(task.poses))
                rows["threads"], rows["pinned"] = threads, config.pinned
                rows["machine"] = machine
                cache.put(name, rows)
            frames.append(rows)
            if progress is not None:
                progress(stop - start)
    return pd.concat(frames, ignore_index=True)


def count_poses(task: EvaluationTask, config: EvaluateConfig) -> int:
    """Return how many poses `evaluate_solver` will answer, all batch sizes together."""
    return sum(stop - start for _, start, stop in plan_chunks(task, config))


def plan_chunks(task: EvaluationTask, config: EvaluateConfig) -> Iterator[tuple[int, int, int]]:
    """Yield batch size, first and last-but-one pose of every chunk, in the order of work."""
    total = len(task.poses)
    sizes = batch_sizes(task.solver, config) if task.follows is None else [1]
    for rank, batch_size in enumerate(sizes):
        end = total
        if rank > 0:
            if isinstance(task.solver, QuerySolver):
                continue
            end = max(config.latency_poses // batch_size, 1) * batch_size
        length = max(config.chunk // batch_size, 1) * batch_size
        starts = _starts(task, end, length)
        for start, stop in zip(starts, [*starts[1:], end], strict=True):
            yield batch_size, start, stop


def _starts(task: EvaluationTask, end: int, length: int) -> list[int]:
    """First poses of chunks; none begins at a pose that follows the one before."""
    starts = list(range(0, end, length))
    if task.follows is None:
        return starts
    free = np.flatnonzero(~task.follows)
    later = free[np.minimum(np.searchsorted(free, starts), len(free) - 1)]
    return sorted({0, *(int(start) for start in later)})


def batch_sizes(solver: Solver, config: EvaluateConfig) -> list[int]:
    """Return the batch sizes of a solver, that of the errors first."""
    first = config.error_batch_size.get(solver.name, config.batch_sizes[0])
    return [first, *(size for size in config.batch_sizes if size != first)]


def _warm_up(task: EvaluationTask, config: EvaluateConfig) -> None:
    """Let caches fill and compilers run, at every batch size, before anything is timed."""
    budget = accepted_budget(task.solver, config)
    for batch_size in sorted({size for size, _, _ in plan_chunks(task, config)}):
        count = max(config.warm_up, batch_size) if config.warm_up else 0
        for start in range(0, count, batch_size):
            _call(task.part(start, min(start + batch_size, count)).seeded(), budget)


def _solve_chunk(
    task: EvaluationTask, config: EvaluateConfig, batch_size: int, first: int, total: int
) -> pd.DataFrame:
    budget = accepted_budget(task.solver, config)
    answers: list[Solution] = []
    times, seed_times = [], []
    for start in range(0, len(task.poses), batch_size):
        part = task.part(start, min(start + batch_size, len(task.poses)))
        if answers and part.follows is not None and part.follows[0]:
            part = replace(part, initial=answers[-1].joints)
        requested = time.perf_counter_ns()
        seeded = part.seeded()
        begin = time.perf_counter_ns()
        solution = _call(seeded, budget)
        end = time.perf_counter_ns()
        answers.append(solution)
        count = len(solution)
        times.append(np.full(count, (end - begin) / count / NS_PER_US))
        seeding = begin - requested if task.seeder is not None else 0
        seed_times.append(np.full(count, seeding / count / NS_PER_US))
    judged = config, task.solver.always_answers, task.freedoms
    rows = raw_rows(task.robot, task.poses, answers, np.concatenate(times), *judged)
    rows.insert(0, "robot", task.robot.name)
    rows.insert(1, "solver", task.label)
    rows.insert(2, "seed", task.seed)
    rows.insert(3, "pose", np.arange(first, first + len(rows)) % total)
    rows.insert(4, "batch_size", batch_size)
    rows["seeded_by"], rows["seed_time_us"] = task.seeded_by, np.concatenate(seed_times)
    return rows


def _call(task: EvaluationTask, budget: Budget | None) -> Solution:
    """One query; a solver that fails gives its home configuration and the reason."""
    robot, count = task.robot, len(task.poses)
    further = {"avoid": task.avoid} if task.asks_to_avoid else {}
    try:
        if task.in_part and task.freedoms is not None:
            solution = task.solver.solve_partial(task.poses, task.freedoms, task.initial, budget)
        elif task.asks_to_follow and task.initial is not None:
            solution = task.solver.follow(task.poses, task.initial, budget)
        else:
            solution = task.solver.solve(task.poses, initial=task.initial, budget=budget, **further)
    except (SolverError, ArithmeticError, RuntimeError, np.linalg.LinAlgError) as error:
        failed = Solution.empty(count, robot.dof)
        reason = f"{type(error).__name__}: {error}"
        return replace(failed, joints=np.tile(robot.home, (count, 1)), reason=(reason,) * count)
    if solution.joints.shape != (count, robot.dof):
        raise EvaluationError(
            f"solver '{task.label}' must return joints of shape ({count}, {robot.dof}), got "
            f"{solution.joints.shape}"
        )
    finite = np.asarray(np.isfinite(solution.joints).all(axis=1))
    if finite.all():
        return solution
    reasons = np.where(finite, list(solution.reason), "joints were not finite")
    return replace(
        solution,
        joints=np.where(finite[:, None], solution.joints, robot.home),
        found=solution.found & finite,
        reason=tuple(str(reason) for reason in reasons),
    )
