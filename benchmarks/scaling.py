"""What a stage takes on any number of machines: a model in a few parts, and what they stand for.

    T(n) = start + serial F + parallel share(n) + bytes F / bandwidth + waiting(n)

`serial` and `parallel` are seconds of a unit (a pose, a pose of each solver, a trial) that one
process has to spend and that any worker can spend; `start` is what workers need at size 0. The
serial part is measured as such: the processor time of the process that hands out the work and
gathers it, with more than one worker, at two sizes. What a unit takes with one worker beyond that
is parallel. (The slope of the wall time with two workers would tell the same on machines of their
own; on one they share caches, memory and clock, which would pass for a serial part.) F are the
units of the published scale and share(n) those of the machine that gets most, since tasks are not
cut. A study has one more part: its journal lets one worker at a time begin a trial, so F trials
take F times that at least, however many workers there are.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf

# What is assumed and not measured: a file server on 10 Gbit/s, machines of one worker each, and the
# slowest of the numerical solvers, which takes this many times the mean of all.
BANDWIDTH = 1.25e9  # byte/s
SLOWEST = 4.0
POSES = ("dataset.validation=500", "dataset.test=500")
Times = dict[tuple[int, int], float]  # seconds by workers and units


@dataclass(frozen=True)
class Work:
    """A kind of work that fans out.

    Attributes:
        title: What it is called.
        stage: The stage that does it.
        overrides: Of the smaller size; ``{}`` stands for the number of units.
        units: Of the smaller size.
        prepared: Overrides of the pose sets that it needs first; none makes none.
        published: Units of the published scale, five robots together.
        tasks: Pieces that those units are cut into; no piece is shared by two machines.
        unit_bytes: Bytes that a unit moves over the network.
        trial: Whether a unit is a trial that has to be begun in a journal.
    """

    title: str
    stage: str
    overrides: tuple[str, ...]
    units: int
    prepared: tuple[str, ...]
    published: int
    tasks: int
    unit_bytes: float
    trial: bool = False


WORKS = (
    Work(
        "pose set",
        "dataset",
        ("robot=panda", "dataset.train={}", *POSES),
        600_000,
        (),
        5 * 1_300_000,
        tasks=5 * 1_300_000 // 2048,
        unit_bytes=8 * 7,  # joints come back, poses are computed where they are written
    ),
    Work(
        "evaluation",
        "evaluate",
        (
            "robot=panda",
            "dataset.train=500",
            "dataset.validation=500",
            "dataset.test=8000",
            "evaluate.solvers=[lm,pinocchio,pinocchio_dls,placo]",
            "evaluate.batch_sizes=[1]",
            "evaluate.poses={}",
        ),
        2_000,
        ("robot=panda", "dataset.train=500", "dataset.validation=500", "dataset.test=8000"),
        5 * 8 * 200_000 // 4,  # five robots and eight solvers; a unit is one pose of four solvers
        tasks=5 * 8,
        unit_bytes=4 * 8 * (7 + 7 + 12),  # targets in; joints, errors and times out
    ),
    Work(
        "study",
        "tune",
        (
            "robot=nico",
            "dataset.train=20000",
            *POSES,
            "model=compact",
            "tune.epochs=2",
            "tune.pruner.kind=none",
            "tune.startup=1000",  # drawn at random, so that all workers train the same trials
            "tune.trials={}",
        ),
        4,
        ("robot=nico", "dataset.train=20000", *POSES),
        5 * 200,
        tasks=5 * 200,
        unit_bytes=8 * 13 * 20_000,  # every trial reads the training set, or its machine's cache
        trial=True,
    ),
    Work(
        "grasps",
        "grasp",
        ("robot=nico", "grasp.video=none", "grasp.trials={}"),
        4,
        (),
        3 * 100,
        tasks=3 * 100,
        unit_bytes=2_000,
    ),
)


@dataclass(frozen=True)
class Model:
    """Seconds of a kind of work on any number of machines; see the head of this file."""

    work: Work
    start: float
    serial: float
    parallel: float
    begin: float  # s for which a study lets no other worker begin a trial

    def seconds(self, machines: int) -> float:
        """Wall time of the published scale."""
        return sum(self.parts(machines).values())

    def parts(self, machines: int) -> dict[str, float]:
        """Wall time of the published scale by what takes it."""
        units, work = self.work.published, self.work
        rounds = ceil(work.tasks / machines)
        share = units / work.tasks * rounds
        if work.stage == "evaluate":  # the slowest solver is one task
            share = max(share, SLOWEST * units / work.tasks)
        return {
            "start": self.start if machines > 1 else 0.0,
            "one process": self.serial * units,
            "workers": self.parallel * share,
            "network": work.unit_bytes * units / BANDWIDTH if machines > 1 else 0.0,
            "journal": self.waiting(machines),
        }

    def waiting(self, machines: int) -> float:
        """Seconds that workers queue to begin a trial, beyond those in which they work."""
        if not self.begin or machines == 1:
            return 0.0
        return max(self.work.published * (self.begin - self.parallel / machines), 0.0)

    def crowded_at(self) -> float:
        """Machines beyond which the journal, not the training, sets the pace."""
        return self.parallel / self.begin if self.begin else inf


def fitted(work: Work, times: Times, busy: dict[int, float], begin: float) -> Model:
    """The model of a kind of work.

    Args:
        work: The work.
        times: Wall times by workers and units.
        busy: Processor seconds of the process that hands it out, by units, with most workers.
        begin: Seconds to begin a trial.
    """
    few, many = min(w for w, _ in times), max(w for w, _ in times)
    small, large = min(busy), max(busy)

    def slope(first: float, last: float) -> float:
        return max(last - first, 0.0) / (large - small)

    whole = few * slope(times[few, small], times[few, large])
    serial = min(slope(busy[small], busy[large]), whole)
    parallel = whole - serial
    start = max(times[many, small] - (serial + parallel / many) * small, 0.0)
    return Model(work, start, serial, parallel, begin if work.trial else 0.0)
