"""Wall time against workers on this machine, and on paper what a hundred machines would make of it.

    python benchmarks/workers.py [--workers 1 2] [--engine engine=ray] [--only tune ...]
                                 [--size 1.0] [--figure FOLDER]

The project is to be installed (`pip install -e .`) and the machine to be left alone meanwhile. Four
kinds of work, each at two sizes and with each number of workers, in turns: a pose set, an
evaluation, a study and grasps. Beside them stands the processor time of the process that hands out
the work of most workers. The journal of a study is timed by itself: trials that cost nothing, one
after another. `benchmarks/scaling.py` has the model that these times are put into, and its
assumptions.

Prints the times, the published scale on one machine and on a hundred, and what limits them then;
draws one figure.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from matplotlib.axes import Axes
from scaling import WORKS, Model, Times, Work, fitted

from pipeline.config import compose
from pipeline.presentation.style import LOOKS, legend_below, logarithmic, panels, save, styled
from pipeline.stages.running import run_stage
from pipeline.tuning.space import draw
from pipeline.tuning.storage import open_store
from pipeline.tuning.study import open_study, run_trials

MACHINES = 100
JOURNAL_TRIALS = 200
DPI = 150
QUIET = ["profile=smoke", "engine.cpus=1", "engine.start_up_s=0"]


def timed(work: Work, units: int, workers: int, engine: list[str]) -> tuple[float, float]:
    """Seconds of a stage whose inputs are there: wall time, and processor time of this process."""
    with tempfile.TemporaryDirectory() as folder:
        common = [*engine, f"engine.workers={workers}", *QUIET, f"results_dir={folder}"]
        if work.prepared:
            run_stage("dataset", compose([*common, *work.prepared]))
        overrides = [item.format(units) for item in work.overrides]
        overrides += [f"dataset.workers={workers}"] if work.stage == "dataset" else []
        config = compose([*common, *overrides])
        began, busy = time.perf_counter(), time.process_time()
        run_stage(work.stage, config)
        return time.perf_counter() - began, time.process_time() - busy


def begin_s() -> float:
    """Seconds to begin and end a trial that costs nothing, the mean over a study of 200."""
    config = compose(["robot=nico", "profile=smoke", f"tune.trials={JOURNAL_TRIALS}"])
    with tempfile.TemporaryDirectory() as folder:
        store = open_store("journal", Path(folder) / "journal.log", config.tune.heartbeat_s)
        study = open_study(store, config)
        began = time.perf_counter()
        run_trials(store, study, lambda trial: draw(trial, config)[0].learning_rate, config)
        seconds = time.perf_counter() - began
        store.close()
    return seconds / JOURNAL_TRIALS


def figure(measured: dict[str, Times], models: list[Model], to: Path) -> None:
    """Wall time against workers: what was measured, and the model up to a hundred machines."""
    with styled():
        drawing, axes = panels(2, 4.5, 3.2)
        seen, paper = axes
        machines = sorted({round(10 ** (k / 10)) for k in range(21)})
        for model, look in zip(models, LOOKS, strict=False):
            times, title = measured[model.work.title], model.work.title
            large = max(units for _, units in times)
            points = sorted((w, seconds) for (w, units), seconds in times.items() if units == large)
            seen.plot(*zip(*points, strict=True), "o-", color=look.colour, label=title)
            whole = [model.seconds(n) / 60 for n in machines]
            paper.plot(machines, whole, color=look.colour, label=title)
            paper.plot(machines, [whole[0] / n for n in machines], ":", color=look.colour)
        seen.set(xlabel="workers", ylabel="wall time [s]", title="measured on this machine")
        seen.set_xticks(sorted({workers for times in measured.values() for workers, _ in times}))
        paper.set(xlabel="machines", ylabel="wall time [min]", title="published scale, on paper")
        _logarithmic(paper)
        seen.set_ylim(bottom=0)
        legend_below(drawing, axes)
        save(drawing, to, "workers", DPI)


def _logarithmic(axes: Axes) -> None:
    logarithmic(axes, "x")
    logarithmic(axes, "y")


def main() -> None:
    """Measure, fit, print and draw."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument(
        "--engine", nargs="+", default=["engine=local", "engine.cpus=1"], help="overrides"
    )
    parser.add_argument("--size", type=float, default=1.0, help="of the work, times the usual")
    parser.add_argument("--only", nargs="+", choices=[work.stage for work in WORKS])
    parser.add_argument("--figure", type=Path, help="folder that workers.png and .pdf go to")
    options = parser.parse_args()
    works = [work for work in WORKS if not options.only or work.stage in options.only]
    measured: dict[str, Times] = {}
    models = []
    begin = begin_s() if any(work.trial for work in works) else 0.0
    heads = " | ".join(f"{n} workers [s]" for n in options.workers)
    print(f"| work | units | {heads} | of it, handing out [s] |")
    print("|---" * (len(options.workers) + 3) + "|")
    for work in works:
        units = max(round(options.size * work.units), 2)
        timed(work, units, max(options.workers), options.engine)  # compiled code comes from disk
        sizes, most = (units, 2 * units), max(options.workers)
        both = {
            (n, size): timed(work, size, n, options.engine)
            for size in sizes
            for n in options.workers
        }
        times = {run: wall for run, (wall, _) in both.items()}
        busy = {size: both[most, size][1] for size in sizes}
        for size in sizes:
            cells = " | ".join(f"{times[n, size]:.1f}" for n in options.workers)
            print(f"| {work.title} | {size} | {cells} | {busy[size]:.2f} |", flush=True)
        measured[work.title] = times
        models.append(fitted(work, times, busy, begin))
    print(f"\nBegin a trial in a journal: {1e3 * begin:.1f} ms. Published scale, on paper:\n")
    print(
        f"| work | 1 machine [min] | {MACHINES} machines [min] | gain | what takes longest then |"
    )
    print("|---|---:|---:|---:|---|")
    for model in models:
        alone, together = model.seconds(1), model.seconds(MACHINES)
        parts = model.parts(MACHINES)
        limit = max(parts, key=lambda name: parts[name])
        shares = ", ".join(f"{name} {value:.1f} s" for name, value in parts.items() if value > 0.05)
        print(
            f"| {model.work.title} | {alone / 60:.1f} | {together / 60:.2f} | "
            f"{alone / together:.0f} | {limit} ({shares}) |"
        )
    for model in models:
        if model.work.trial:
            print(f"\nThe journal sets the pace beyond {model.crowded_at():.0f} machines.")
    if options.figure:
        figure(measured, models, options.figure)


if __name__ == "__main__":
    main()
