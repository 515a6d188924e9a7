"""Which figures a report has, and what is said under each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from matplotlib.figure import Figure

from pipeline.reporting import figures_benchmark as benchmark
from pipeline.reporting import figures_comparison as comparison
from pipeline.reporting import figures_experiment as experiment
from pipeline.reporting import figures_grasps as grasps
from pipeline.reporting import figures_planner as plans
from pipeline.reporting.figures_agent_grasps import agent_outcomes
from pipeline.reporting.losses import compare_losses, losses_figure, verdict
from pipeline.reporting.page import Illustration
from pipeline.reporting.report_data import ReportData
from pipeline.reporting.style import save, styled
from pipeline.reporting.tables_agent_grasps import agent_trials
from pipeline.reporting.tables_grasps import with_places

MAPPED = "cycleik"  # the solver whose precision is shown over the workspace
Planned = Iterator[tuple[str, str, Callable[[], Figure]]]  # name, caption, how to draw it


def draw_figures(data: ReportData, folder: Path) -> list[Illustration]:
    """Draw every figure that there are rows for, and say under each how to read it."""
    illustrations = []
    with styled():
        for name, caption, draw in planned(data):
            png, _ = save(draw(), folder, name, data.config.dpi)
            illustrations.append(Illustration(name, caption, png))
    return illustrations


def planned(data: ReportData) -> Planned:
    """Yield name, caption and how to draw it for every figure that there are rows for."""
    yield from _of_solvers(data)
    yield from _of_trainings(data)
    yield from _of_plans(data)
    yield from _of_grasps(data)


def _of_solvers(data: ReportData) -> Planned:
    published, config = data.published, data.config
    rows, summary, pairs = data.results.evaluate, data.summary, data.pairs
    if rows:
        yield (
            "against_the_paper",
            "This run beside the paper's Table II, in the paper's metric.",
            lambda: comparison.against_the_paper(summary, published),
        )
        yield (
            "success_against_tolerance",
            "Share of test poses within a tolerance of x mm and x deg (Euclidean, geodesic, joint "
            "limits kept). The line at 1 is the strict success of the tables.",
            lambda: benchmark.success_against_tolerance(rows, config),
        )
        yield (
            "error_against_time",
            "Mean error in the paper's metric against time per pose; numbers at the points are "
            "batch sizes. Towards the lower left is better. Stars: the paper.",
            lambda: benchmark.error_against_time(summary, published),
        )
        yield (
            "error_distributions",
            "Median (marker), middle half (thick) and 1st to 99th percentile (thin) of the errors.",
            lambda: benchmark.error_distributions(rows, config),
        )
        if any(solver == MAPPED for _, solver in rows):
            yield (
                "workspace_map",
                "Median position error of CycleIK over the workspace: distance from the base's "
                "vertical axis, and height.",
                lambda: comparison.workspace_map(rows, MAPPED, config),
            )
    if len(pairs):
        yield (
            "win_matrix",
            "Share of poses [%] on which the solver of the row is nearer to the target than that "
            "of the column.",
            lambda: comparison.win_matrix(pairs),
        )


def _of_trainings(data: ReportData) -> Planned:
    results = data.results
    if any(len(curve) for _, curve in results.train.values()):
        yield (
            "training_curves",
            "Mean Euclidean and geodesic errors while training; batches smoothed by a moving "
            "median.",
            lambda: experiment.training_curves(results.train),
        )
    if compared := compare_losses(results.swept):
        yield (
            "losses",
            "Former and new losses at equal steps: mean of the runs, and from the smallest to the "
            f"largest. {verdict(compared)}",
            lambda: losses_figure(compared),
        )


def _of_plans(data: ReportData) -> Planned:
    results = data.results
    if results.plan:
        yield (
            "planner_flips",
            "Plans whose path stays in reach: without a branch flip on the path as asked, without "
            "one on another curve between the same ends, or neither. Diamonds: the batched query "
            "alone, before any repair.",
            lambda: plans.planner_flips(results.plan),
        )
        yield (
            "planner_times",
            "Time and largest tip error of every plan; the dashed line is the paper's 70 ms.",
            lambda: plans.planner_times(results.plan, data.published),
        )


def _of_grasps(data: ReportData) -> Planned:
    results, published, config = data.results, data.published, data.config
    if results.grasp:
        yield (
            "grasp_outcomes",
            "Figure 5 of the paper: outcomes of grasp trials, with Wilson intervals. The paper's "
            "trials ran on hardware, with detector and language model.",
            lambda: experiment.grasp_outcomes(results.grasp, published, config),
        )
    if placed := with_places(results.grasp):
        yield (
            "grasp_places",
            "Where the object of each trial lay, seen from above with the robot below, and what "
            "came of it; success by object with Wilson intervals.",
            lambda: grasps.grasp_places(placed, config),
        )
    if results.grasp_studies:
        yield (
            "grasp_studies",
            "The same trials with one or two settings varied: success with Wilson intervals, or "
            "in per cent on a map.",
            lambda: grasps.grasp_studies(results.grasp_studies, config),
        )
    if spoken := agent_trials(results):
        yield (
            "human_in_the_loop_outcomes",
            "Figure 5 of the paper with camera and agent: every object of a row is a trial. The "
            "paper's trials ran on hardware, with ViLD and GPT-3.5.",
            lambda: agent_outcomes(spoken, published, config),
        )
