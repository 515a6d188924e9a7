"""Table I on an accelerator that is at hand for a quarter of an hour: one command, no network.

    python -m benchmarks.accelerator data  --data /tmp/poses     # pose sets, on the processor
    python -m benchmarks.accelerator probe --data /tmp/poses     # ms a step, alone and together
    python -m benchmarks.accelerator train --data /tmp/poses --out DIR --seconds 450

Needs torch, numba, SciPy, pandas, Hydra and zuko, but neither Pinocchio nor pytorch-kinematics. A
run's row is written when it ends, so what was finished by the end of the time is kept:

- runs.jsonl: one line a training: settings, curve, errors on the whole test set, seconds, device;
- latency.jsonl: the trained networks on the device, at 1, 100 and 1000 poses a call;
- answers_<robot>.npy: joints (200000, dof) of Table I's network for the test poses, float32;
- --weights DIR: that network in float16.

Groups are begun in the order of ``--groups``. What the first measurement on an H200 says of it: a
step of NICOL's network takes 1.6 ms alone in float32, as long as one tile of a product takes for
its 2,000 to 3,500 terms, so that trainings beside each other add up to some 1,200 steps a second;
five networks of 433,000 steps do not fit in a quarter of an hour without tensor cores.

``--toy`` runs all of it in a minute on a processor, with numbers that mean nothing.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from pathlib import Path

import torch

from benchmarks.accelerator.data import ROBOTS, Data
from benchmarks.accelerator.plan import GROUPS, Plan
from benchmarks.accelerator.recorder import Recorder
from pipeline.learning.fleet import FleetRun, build, run_fleet


def probe(plan: Plan, seconds: float) -> None:
    """Milliseconds a step, by precision and with other runs beside."""
    for precision in ("float32", "bfloat16_backward"):
        plan.options.precision = precision
        runs = []
        for name in ROBOTS:
            job = plan.table(name, 0)
            run = FleetRun(job, build(job), plan.device)
            runs.append(run)
            print(f"{precision} {name}: {_pace([run], seconds):.3f} ms a step alone", flush=True)
        together = _pace(runs, 2 * seconds)
        print(f"{precision}: {together:.3f} ms a step of any, five beside", flush=True)
        more = [FleetRun(r.job, build(r.job), plan.device) for r in runs for _ in range(2)]
        print(
            f"{precision}: {_pace(runs + more, 2 * seconds):.3f} ms of any, 15 beside", flush=True
        )
        del runs, more


def _pace(runs: list[FleetRun], seconds: float) -> float:
    began, first = time.perf_counter(), sum(run.step for run in runs)
    while time.perf_counter() - began < seconds:
        for run in runs:
            if run.ready and not run.done:
                run.advance()
    for run in runs:
        run.finish()
    return 1e3 * (time.perf_counter() - began) / max(sum(run.step for run in runs) - first, 1)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one of the three commands."""
    started = time.perf_counter()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", choices=("data", "probe", "train"))
    parser.add_argument("--data", type=Path, required=True, help="folder of pose sets")
    parser.add_argument("--out", type=Path, default=Path("results/accelerator"))
    parser.add_argument("--weights", type=Path, help="folder for float16 weights")
    parser.add_argument("--verdicts", type=Path, help="JSON of samples too near contact to decide")
    parser.add_argument("--seconds", type=float, default=450.0, help="training stops after these")
    parser.add_argument("--beside", type=int, default=16, help="trainings at a time")
    parser.add_argument("--workers", type=int, default=16, help="processes that draw poses")
    parser.add_argument(
        "--precision",
        default="bfloat16_backward",
        choices=("float32", "bfloat16_backward"),
        help="train.precision; on CUDA the second means TF32 in the backward pass",
    )
    parser.add_argument(
        "--rounded-until",
        type=float,
        default=0.9,
        help="share of a schedule over which forward products are TF32 too; float32 ends it",
    )
    parser.add_argument("--groups", nargs="+", default=list(GROUPS), choices=GROUPS)
    parser.add_argument("--recipes", nargs="+", default=["published", "warm_up"])
    parser.add_argument("--search-poses", type=int, default=500_000)
    parser.add_argument("--loss-poses", type=int, default=50_000)
    parser.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    parser.add_argument("--toy", action="store_true", help="seconds, on any machine")
    options = parser.parse_args(arguments)
    os.environ.setdefault("CUDA_DEVICE_MAX_CONNECTIONS", "32")  # as many streams at a time
    device = torch.device(options.device)
    data = Data(options.data, options.toy)
    if options.command == "data":
        data.make(options.workers, options.verdicts)
        return
    plan = Plan(data, device, options)
    if options.command == "probe":
        probe(plan, 0.1 if options.toy else 1.0)
        return
    options.out.mkdir(parents=True, exist_ok=True)
    if options.toy:
        options.loss_poses = 500
    recorder = Recorder(plan, options.out, options.weights, started)
    dropped = run_fleet(plan.jobs(), device, options.beside, started + options.seconds, recorder)
    recorder.latency(20 if options.toy else 200)
    if dropped:
        print(f"not finished in {options.seconds:.0f} s: {', '.join(dropped)}", flush=True)


if __name__ == "__main__":
    main()
