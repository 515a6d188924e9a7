"""The one graph of stages: what each makes, of what, by which keys, and what it fans out over.

Two tables. `STAGES` are the commands; what they read says what is made first where it is missing,
and which groups of conf/ they heed. `STEPS` are the stages as a whole run takes them, each over the
robots and solvers of lists in conf/bench.yaml. `python -m pipeline all` goes through the steps, and
dvc.yaml is generated from them (`python -m pipeline dvc`); nothing else lists stages.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.artifacts import SIGNATURE, Artifacts

if TYPE_CHECKING:
    from pipeline.settings import Config

NETWORKS = "networks"  # key of conf/bench.yaml: where networks come from that the project has
PUBLISHED = "results/published_results.csv"  # the paper's numbers, below the checkout


def _no_solvers(config: Config) -> dict[str, list[str]]:
    return {}


@dataclass(frozen=True)
class Stage:
    """A command that makes one kind of artifact.

    Attributes:
        name: As it is typed.
        summary: What it makes, in one line.
        inputs: Stages whose artifacts it reads.
        groups: Groups of conf/ that it reads; ``grasp.physics`` is a part of one.
        solvers: Gives the names of the solvers that a run of it loads, by the key that names them.
        on_demand: Whether it is an experiment that no step takes.
    """

    name: str
    summary: str
    inputs: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    solvers: Callable[[Config], dict[str, list[str]]] = _no_solvers
    on_demand: bool = False

    def solver_names(self, config: Config) -> list[str]:
        """Return the names of the solvers that a run loads."""
        return [name for names in self.solvers(config).values() for name in names]

    @property
    def module(self) -> str:
        """Name of the module that runs it."""
        return f"pipeline.stages.{self.name.replace('-', '_')}"


STAGES = {
    stage.name: stage
    for stage in (
        Stage(
            "dataset",
            "collision-filtered poses for training, validation and test",
            groups=("robot", "dataset", "engine"),
        ),
        Stage(
            "tune",
            "hyperparameter search with Optuna",
            inputs=("dataset",),
            groups=("robot", "dataset", "model", "train", "tune", "tracker", "engine"),
        ),
        Stage(
            "compare-tuned",
            "the best of a search against Table I, at equal training budget",
            inputs=("dataset", "tune"),
            groups=("robot", "dataset", "model", "train", "tune"),
            on_demand=True,
        ),
        Stage(
            "train",
            "a network through differentiable forward kinematics",
            inputs=("dataset",),
            groups=("robot", "dataset", "model", "train", "tracker"),
        ),
        Stage(
            "evaluate",
            "solvers on the test poses, one raw row a pose",
            inputs=("dataset", "train"),
            groups=("robot", "dataset", "model", "evaluate", "solver", "engine"),
            solvers=lambda config: config.evaluate.solvers_by_key(),
        ),
        Stage(
            "suite",
            "hard poses of a robot: suite=at_limits, near_singular, unreachable, ...",
            groups=("robot", "suite"),
            on_demand=True,
        ),
        Stage(
            "evaluate-suite",
            "solvers on a suite of hard poses, one raw row a pose",
            inputs=("suite", "train"),
            groups=("robot", "suite", "model", "evaluate", "solver", "engine"),
            solvers=lambda config: config.evaluate.solvers_by_key(),
            on_demand=True,
        ),
        Stage(
            "evaluate-protocol",
            "solvers as another group measures them: protocol=trac_ik, ikflow, curobo, ...",
            inputs=("train",),
            groups=("robot", "protocol", "model", "evaluate", "solver", "engine"),
            solvers=lambda config: config.protocol.solvers_by_key(),
            on_demand=True,
        ),
        Stage(
            "sample",
            "many solutions of one pose, and how they spread",
            inputs=("dataset", "train"),
            groups=("robot", "dataset", "model", "sample", "evaluate.limit_slack", "solver"),
            solvers=lambda config: config.sample.solvers_by_key(),
            on_demand=True,
        ),
        Stage(
            "reach",
            "a map of the share of orientations that are reached over a grid of places",
            inputs=("train",),
            groups=("robot", "reach", "model", "report.dpi", "solver"),
            solvers=lambda config: config.reach.solvers_by_key(),
            on_demand=True,
        ),
        Stage(
            "plan",
            "Bezier motions between random poses",
            inputs=("train",),
            groups=("robot", "model", "plan", "solver"),
            solvers=lambda config: config.plan.solvers_by_key(),
        ),
        Stage(
            "detector",
            "a network that finds a robot's objects in the picture of its eye",
            groups=(
                "robot",
                "detector",
                "perception",
                "grasp.physics",
                "grasp.objects",
                "grasp.scenes",
                "engine",
            ),
        ),
        Stage(
            "grasp",
            "pick-and-drop trials in simulation",
            inputs=("train", "detector"),
            groups=("robot", "model", "grasp", "perception", "agent", "solver", "engine"),
            solvers=lambda config: config.grasp.solvers_by_key(),
        ),
        Stage(
            "report",
            "tables, figures and report.html from everything on disk",
            inputs=("dataset", "tune", "train", "evaluate", "plan", "detector", "grasp"),
            groups=("report",),
        ),
    )
}


@dataclass(frozen=True)
class Output:
    """A file or folder that a step writes, below the results folder.

    Attributes:
        path: With ``{robot}``, ``{solver}`` and ``{model}`` in it.
        read: Whether later steps read it; else only the report and people do.
        kind: out, metric, or plot.
        cached: Whether DVC keeps a copy.
        plot: How DVC plots it.
    """

    path: str
    read: bool = False
    kind: str = "out"
    cached: bool = True
    plot: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Step:
    """One stage as a whole run takes it.

    Attributes:
        name: Unique among the steps.
        stage: The command.
        over: List of conf/bench.yaml for each axis that the step fans out over.
        outputs: What it leaves.
        inputs: Steps whose outputs it reads.
        overrides: Of the command, with the axes' names in braces.
        model: Choice of conf/model that it trains or reads; empty for the run's own.
        choices: Choices of other groups than those of conf/config.yaml, by group.
        without: Groups that its stage reads in other runs, but not in this one; where `choices` has
            one of them, no user chooses otherwise.
        settings: Solvers whose settings count although the command does not name them.
        files: Further files that it reads, below the checkout.
    """

    name: str
    stage: str
    over: Mapping[str, str]
    outputs: tuple[Output, ...]
    inputs: tuple[str, ...] = ()
    overrides: tuple[str, ...] = ()
    model: str = ""
    choices: Mapping[str, str] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()
    files: tuple[str, ...] = ()

    def command(self, axes: Mapping[str, str]) -> list[str]:
        """Return the overrides of one run of the step, without profile and run's own model.

        Args:
            axes: Value of each axis; of `NETWORKS`, too, unless all are to be trained.
        """
        axes = {NETWORKS: "default", **axes}
        fixed = [f"{group}={choice}" for group, choice in self.choices.items()]
        model = [f"model={self.model}"] if self.model else []
        robot = [f"robot={axes['robot']}"] if "robot" in axes else []
        return [*robot, *model, *fixed, *(text.format(**axes) for text in self.overrides)]


_FOLDERS = Artifacts(Path())  # paths below a results folder
_EACH_ROBOT = {"robot": "robots"}
_TRAINED = ("weights.safetensors", "card.json")


def _path(path: Path, *more: str) -> str:
    return path.joinpath(*more).as_posix()


def _training(
    name: str, over: str, model: str, title: str, overrides: tuple[str, ...] = ()
) -> Step:
    folder = _FOLDERS.train("{robot}", model or "{model}")
    curve = {
        "x": "samples",
        "y": "validation_position_error_mm",
        "x_label": "poses seen",
        "y_label": "position error on the validation set, mm",
        "title": title,
    }
    return Step(
        name,
        "train",
        over={"robot": over},
        inputs=("dataset",),
        model=model,
        overrides=overrides,
        outputs=(
            *(Output(_path(folder, file), read=True) for file in _TRAINED),
            Output(_path(folder, "other.safetensors")),
            Output(_path(folder, SIGNATURE)),
            Output(_path(folder, "metrics.json"), kind="metric"),
            Output(_path(folder, "curve.csv"), kind="plot", plot=curve),
        ),
    )


def _evaluation(
    name: str,
    robots: str,
    solvers: str,
    inputs: tuple[str, ...],
    model: str = "",
    seeder: str = "",
    settings: tuple[str, ...] = (),
) -> Step:
    seeding = [f"evaluate.seeded_by={seeder}"] if seeder else []
    return Step(
        name,
        "evaluate",
        over={"robot": robots, "solver": solvers},
        inputs=inputs,
        model=model,
        overrides=("evaluate.solvers=[{solver}]", *seeding),
        settings=(*([seeder] if seeder else []), *settings),
        outputs=(Output(_path(_FOLDERS.evaluate("{robot}", "{solver}", seeder))),),
    )


_BEFORE_REPORT = (
    Step(
        "dataset",
        "dataset",
        over=_EACH_ROBOT,
        outputs=(Output(_path(_FOLDERS.dataset("{robot}")), read=True),),
    ),
    Step(
        "tune",
        "tune",
        over={"robot": "tune_robots"},
        inputs=("dataset",),
        outputs=(Output(_path(_FOLDERS.tune("{robot}"))),),
        files=(PUBLISHED,),
    ),
    _training("train", "robots", "", "Training", (f"train.from={{{NETWORKS}}}",)),
    _training("train_flow", "flow_robots", "flow", "Training of the flow"),
    _evaluation("evaluate_neural", "robots", "neural", ("dataset", "train"), settings=("lm",)),
    _evaluation(
        "evaluate_flow",
        "flow_robots",
        "flow",
        ("dataset", "train_flow"),
        model="flow",
        settings=("lm",),
    ),
    _evaluation("evaluate_numerical", "robots", "numerical", ("dataset",)),
    _evaluation("evaluate_seeded", "robots", "seeded", ("dataset", "train"), seeder="cycleik"),
    Step(
        "plan",
        "plan",
        over=_EACH_ROBOT,
        inputs=("train",),
        settings=("lm",),
        outputs=(Output(_path(_FOLDERS.plan("{robot}"))),),
    ),
    Step(
        "detector",
        "detector",
        over={"robot": "detector_robots"},
        overrides=(f"detector.from={{{NETWORKS}}}",),
        outputs=(
            *(Output(_path(_FOLDERS.detector("{robot}"), file), read=True) for file in _TRAINED),
            *(
                Output(_path(_FOLDERS.detector("{robot}"), file))
                for file in ("errors.parquet", "detections.png", "errors.png", "errors.pdf")
            ),
            Output(_path(_FOLDERS.detector("{robot}"), "metrics.json"), kind="metric"),
        ),
    ),
    Step(
        "grasp",
        "grasp",
        over={"robot": "grasp_robots"},
        inputs=("train",),
        choices={
            "perception": "perfect",
            "agent": "none",
        },  # the plain series, whatever the profile
        without=("perception", "agent"),
        settings=("lm",),
        outputs=(Output(_path(_FOLDERS.grasp("{robot}"))),),
    ),
    Step(
        "grasp_agent",
        "grasp",
        over={"robot": "detector_robots"},
        inputs=("train", "detector"),
        choices={"perception": "camera", "agent": "policy"},
        settings=("lm",),
        outputs=(Output(_path(_FOLDERS.grasp_agent("{robot}", "camera-policy"))),),
    ),
)

_REPORT = Step(
    "report",
    "report",
    over={},
    inputs=tuple(step.name for step in _BEFORE_REPORT),
    files=(PUBLISHED,),
    outputs=(
        Output("tables", cached=False),  # small: those of the published scale lie in git
        Output("figures"),
        Output("report.html"),
        Output("metrics.json", kind="metric"),
    ),
)

STEPS = {step.name: step for step in (*_BEFORE_REPORT, _REPORT)}


def runs(lists: Mapping[str, list[str]]) -> Iterator[tuple[Step, dict[str, str]]]:
    """Yield each step with the values of its axes, robot by robot, the report at the end.

    Args:
        lists: Lists of conf/bench.yaml and of the profile; robots that are not in ``robots`` are
            left out.
    """
    for robot in lists["robots"]:
        for step in STEPS.values():
            if "robot" in step.over and robot in lists[step.over["robot"]]:
                others = {axis: name for axis, name in step.over.items() if axis != "robot"}
                for values in product(*(lists[name] for name in others.values())):
                    yield step, {"robot": robot, **dict(zip(others, values, strict=True))}
    for step in STEPS.values():
        if not step.over:
            yield step, {}
