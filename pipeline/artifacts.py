"""Where each stage's artifact lies under a results folder, and how a missing one is named."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock, Timeout

from pipeline.errors import MissingArtifactError
from pipeline.progress import LOGGER

SIGNATURE = "signature.json"  # beside results whose card later stages depend on
SPLITS = ("train", "validation", "test")


@dataclass(frozen=True)
class Artifacts:
    """Paths under one results folder; ``base`` is searched for inputs that are not there.

    A sweep's run writes into a folder of its own and reads what it did not change from the folder
    of its profile.

    Attributes:
        root: Folder that is written to.
        base: Folder that inputs may come from as well.
    """

    root: Path
    base: Path | None = None

    def dataset(self, robot: str) -> Path:
        """Folder of the pose sets of a robot."""
        return self.root / "dataset" / robot

    def tune(self, robot: str) -> Path:
        """Folder of the hyperparameter search of a robot."""
        return self.root / "tune" / robot

    def compare_tuned(self, robot: str) -> Path:
        """Trainings of the best of a robot's search and of its rivals, at one budget."""
        return self.root / "compare_tuned" / robot / "trainings.parquet"

    def train(self, robot: str, model: str) -> Path:
        """Folder of the trained weights of a model for a robot."""
        return self.root / "train" / robot / model

    def evaluate(self, robot: str, solver: str, seeded_by: str = "") -> Path:
        """Raw rows of a solver on the test poses of a robot, apart where another seeded it."""
        folder = self.root / "evaluate" / robot
        return (folder / f"seeded_by_{seeded_by}" if seeded_by else folder) / f"{solver}.parquet"

    def suite(self, robot: str, suite: str) -> Path:
        """Problems of a suite of hard poses of a robot."""
        return self.root / "suite" / robot / f"{suite}.parquet"

    def evaluate_suite(self, robot: str, suite: str, solver: str) -> Path:
        """Raw rows of a solver on a suite."""
        return self.root / "evaluate_suite" / robot / suite / f"{solver}.parquet"

    def evaluate_protocol(self, robot: str, protocol: str, solver: str) -> Path:
        """Folder of the raw rows of a solver by a protocol, a table for each batch size."""
        return self.root / "evaluate_protocol" / robot / protocol / solver

    def protocols(self, robot: str) -> Path:
        """Folder of the tables and the figure of all protocols of a robot."""
        return self.root / "protocols" / robot

    def tracker(self) -> Path:
        """Folder of what a tracker is told of trainings and trials."""
        return self.root / "tracker"

    def judge(self, robot: str, suite: str, name: str) -> Path:
        """Raw rows of answers to a suite that came from elsewhere."""
        return self.root / "judge" / robot / suite / f"{name}.parquet"

    def sample(self, robot: str, solver: str) -> Path:
        """Many solutions of each of some test poses, by a solver that draws."""
        return self.root / "sample" / robot / f"{solver}.parquet"

    def reach(self, robot: str) -> Path:
        """Folder of the reachability map of a robot."""
        return self.root / "reach" / robot

    def plan(self, robot: str) -> Path:
        """Folder of the planner benchmark of a robot."""
        return self.root / "plan" / robot

    def detector(self, robot: str) -> Path:
        """Folder of the trained detector of a robot's objects."""
        return self.root / "detector" / robot

    def grasp(self, robot: str) -> Path:
        """Folder of the grasp trials of a robot."""
        return self.root / "grasp" / robot

    def grasp_agent(self, robot: str, setting: str) -> Path:
        """Folder of the trials of a robot with a camera or an agent, such as camera-policy."""
        return self.root / "grasp_agent" / robot / setting

    def chat(self, robot: str) -> Path:
        """Folder of the conversations with a robot."""
        return self.root / "chat" / robot

    def instructions(self, agent: str) -> Path:
        """Folder of the plans of an agent for the suite of instructions, and their tables."""
        return self.root / "instructions" / agent

    def grasp_study(self, robot: str) -> Path:
        """Folder of the studies of a robot's grasps, one table a study."""
        return self.root / "grasp_study" / robot

    def checkpoint(self, robot: str, model: str) -> Path:
        """State of a training that has not ended; outside the artifact, so it outlives a rerun."""
        return self.root / "checkpoint" / f"{robot}-{model}.safetensors"

    def find(self, relative: Path) -> Path | None:
        """Return where ``relative`` (a path below ``root``) is: here, in ``base``, or nowhere."""
        for folder in (self.root, self.base):
            if folder is not None and (folder / relative).exists():
                return folder / relative
        return None

    def need(self, path: Path, command: str) -> Path:
        """Return where the artifact ``path`` is.

        Args:
            path: A path that one of the methods above gave.
            command: What a user runs to make it.

        Raises:
            MissingArtifactError: It is nowhere.
        """
        found = self.find(path.relative_to(self.root))
        if found is None:
            raise MissingArtifactError(f"there is no {path}; make it with: {command}")
        return found


@contextmanager
def exclusive(path: Path) -> Iterator[bool]:
    """Hold a lock on an artifact while it is made, so that two runs never write it together.

    A killed `dvc repro` can leave its stage running; the next call then waits for that stage
    instead of racing it. The operating system releases the lock with its process.

    Args:
        path: The artifact.

    Yields:
        Whether another process held the lock first.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    lock = FileLock(path.parent / f".{path.name}.lock")
    waited = False
    try:
        lock.acquire(blocking=False)
    except Timeout:
        LOGGER.info("another process is making %s: waiting for it", path)
        lock.acquire()
        waited = True
    try:
        yield waited
    finally:
        lock.release()
