"""Raw rows that are reused: what they depend on, unfinished chunks, and whether a table is current.

Rows may be reused where everything that they depend on is the same: their `cache_key`. It stands in
the metadata of a finished table (`is_up_to_date`) and of the chunks of an unfinished one
(`ChunkCache`).
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch
from numpy.typing import NDArray

from baselines import Solver
from baselines.freedom import widths_of
from pipeline.data.tables import TableError, read_metadata, read_table, write_table
from pipeline.evaluation.config import HOME, EvaluateConfig
from pipeline.evaluation.machine import allowed_threads, machine_fingerprint
from pipeline.evaluation.task import EvaluationTask, accepted_budget

# Settings that rows do not depend on, beside the poses that are answered.
CACHE_KEY_EXCLUDES = ("solvers", "keep", "first_core", "trajectories")
SIMPLE = (bool, int, float, str)
TRANSIENT = ("_owner",)  # attributes that answers do not depend on: the thread that made a solver
PATHS = ("weights",)  # a folder may hold other weights tomorrow: networks go by checksum


def cache_key(task: EvaluationTask, config: EvaluateConfig) -> dict[str, Any]:
    """Return everything that the rows depend on, as provenance and as the key of chunks.

    Args:
        task: Solver, robot, poses and initial guesses.
        config: Budget, batch sizes, warm-up, threads.

    Returns:
        JSON-ready facts; two evaluations with the same ones give the same rows but for the times.
    """
    return {
        "code": task.code,
        **_robot_facts(task),
        **_solver_facts(task, config),
        **_pose_facts(task),
        "evaluate": {k: v for k, v in asdict(config).items() if k not in CACHE_KEY_EXCLUDES},
        "machine": machine_fingerprint(allowed_threads(config.threads, config.pinned)),
    }


def _robot_facts(task: EvaluationTask) -> dict[str, Any]:
    robot = task.robot
    return {
        "robot": robot.name,
        "urdf_checksum": robot.urdf_checksum,
        "base": robot.base,
        "tip": robot.tip,
    }


def _solver_facts(task: EvaluationTask, config: EvaluateConfig) -> dict[str, Any]:
    budget = accepted_budget(task.solver, config) or task.solver.budget
    return {
        "solver": task.label,
        "solver_identity": solver_identity(task.solver),
        "solver_budget": None if budget is None else asdict(budget),
        "seed": task.seed,
        "seeded_by": task.seeded_by,
        "seeder_identity": solver_identity(task.seeder) if task.seeder else None,
    }


def _pose_facts(task: EvaluationTask) -> dict[str, Any]:
    following = {}
    if task.freedoms is not None:
        following["freedoms"] = array_checksum(widths_of(task.freedoms, len(task.poses)))
    if task.follows is not None:
        following["follows"] = array_checksum(task.follows.astype(np.float64))
    if task.avoid is not None:
        said = "\n".join(each.to_json() for each in task.avoid)
        following["avoid"] = hashlib.sha256(said.encode()).hexdigest()
    return {
        **following,
        "initial": HOME if task.initial is None else array_checksum(task.initial),
        "poses": len(task.poses),
        "poses_checksum": array_checksum(task.poses),
    }


def is_up_to_date(path: Path, key: Mapping[str, Any]) -> bool:
    """Return whether a table holds the rows of a key.

    Args:
        path: Raw rows, or nothing yet.
        key: What the rows would depend on, from `cache_key`.

    Returns:
        False where the file is missing, damaged or has another key.
    """
    try:
        facts = read_metadata(path)
        read_table(path)
    except TableError:
        return False
    wanted = json.loads(json.dumps(dict(key), default=str))
    return all(name in facts and facts[name] == value for name, value in wanted.items())


class ChunkCache:
    """A folder of finished chunks of one table, so that a killed evaluation continues.

    Args:
        folder: Where the chunks lie; it is made when the first is put. None keeps nothing.
        key: What the rows depend on, from `cache_key`. Chunks of another key are not used.
    """

    def __init__(self, folder: Path | None, key: Mapping[str, Any]) -> None:
        self.folder = folder
        text = json.dumps(dict(key), sort_keys=True, default=str)
        self.key = hashlib.sha256(text.encode()).hexdigest()

    def get(self, name: str) -> pd.DataFrame | None:
        """Return the rows of a chunk, or None where it is missing, damaged or of another key."""
        if self.folder is None:
            return None
        path = self.folder / f"{name}.parquet"
        try:
            if read_metadata(path).get("key") != self.key:
                return None
            return read_table(path)
        except TableError:
            return None

    def put(self, name: str, rows: pd.DataFrame) -> None:
        """Keep the rows of a finished chunk."""
        if self.folder is not None:
            write_table(self.folder / f"{name}.parquet", rows, {"key": self.key})


def clear_chunks(folder: Path) -> None:
    """Remove the chunks of an evaluation whose table is written."""
    shutil.rmtree(folder, ignore_errors=True)


def solver_identity(solver: Solver) -> dict[str, Any]:
    """Describe a solver by its class, its settings and the checksum of its networks.

    Settings are those that the registry loaded it with, plus every plain attribute for solvers that
    were made by hand; a solver inside another one is described in the same way.

    Args:
        solver: As it was made, before it has solved anything.

    Returns:
        JSON-ready facts; solvers that may answer differently have different ones.
    """
    facts: dict[str, Any] = {"class": f"{type(solver).__module__}.{type(solver).__qualname__}"}
    facts["settings"] = {k: v for k, v in solver.settings.items() if k not in PATHS}
    for name, value in sorted(vars(solver).items()):
        if name in TRANSIENT:
            continue
        if value is None or isinstance(value, SIMPLE):
            facts[name] = value
        elif isinstance(value, Solver):
            facts[name] = solver_identity(value)
    return facts | network_checksums(solver)


def network_checksums(owner: object) -> dict[str, str]:
    """Return the checksum of each network that is an attribute of a solver or a detector."""
    values = sorted(vars(owner).items())
    return {name: network_checksum(v) for name, v in values if isinstance(v, torch.nn.Module)}


def network_checksum(network: torch.nn.Module) -> str:
    """Return the SHA-256 of a network's parameters and buffers, names included."""
    digest = hashlib.sha256()
    for name, tensor in network.state_dict().items():
        digest.update(f"{name}:{tensor.dtype}:{tuple(tensor.shape)}".encode())
        values = tensor.detach().cpu().contiguous().reshape(-1)
        digest.update(values.view(torch.uint8).numpy().tobytes())
    return digest.hexdigest()


def array_checksum(array: NDArray[np.float64]) -> str:
    """Return the SHA-256 of an array's shape and values."""
    digest = hashlib.sha256(str(array.shape).encode())
    digest.update(np.ascontiguousarray(array, dtype=np.float64).tobytes())
    return digest.hexdigest()
