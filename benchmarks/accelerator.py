"""Table I on an accelerator that is at hand for a quarter of an hour: one command, no network.

    python benchmarks/accelerator.py data  --data /tmp/poses     # pose sets, on the processor
    python benchmarks/accelerator.py probe --data /tmp/poses     # ms a step, alone and together
    python benchmarks/accelerator.py train --data /tmp/poses --out DIR --seconds 450

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
import json
import multiprocessing
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.torch import save_file
from torch import Tensor

from pipeline.config import compose
from pipeline.data.dataset import split_seed
from pipeline.evaluation.metrics import pose_errors
from pipeline.learning.fleet import CHUNK, FleetJob, FleetRun, build, run_fleet
from pipeline.learning.fused import FusedCycleLoss
from pipeline.learning.networks import parameter_count
from pipeline.learning.rotation import quaternion_from_matrix
from pipeline.seeding import derive_seed
from pipeline.settings import Config, TrainConfig
from robots import Robot, load_robot
from robots.sampling import ChunkExecutor, Samples, sample_configurations

ROBOTS = ("nicol", "fetch", "panda", "valkyrie", "nico")  # the longest training first
SPLITS = ("train", "validation", "test")
HELD_OUT = 10_000  # validation poses of a curve
STABILITY_DRAWS, STABILITY_STEPS = 8, 1500
SATURATED = 0.99  # of a joint's half range: where tanh is flat
RATIOS = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)  # position weight per rotation weight
LOSSES, LOSS_ROBOTS, LOSS_SEEDS = ("smooth", "former"), ("nico", "panda"), (0, 1, 2)
DRAWS = 40
BATCHES = (1, 100, 1000)
GROUPS = ("table", "published", "nico", "stability", "search", "losses", "seeds")


class Data:
    """The pose sets of the robots, made once on the processor."""

    def __init__(self, folder: Path, toy: bool) -> None:
        self.folder, self.toy = folder, toy
        self.configs = {name: self._config(name) for name in ROBOTS}
        self.robots = {name: load_robot(name) for name in ROBOTS}

    def make(self, workers: int, verdicts: Path | None) -> None:
        """Draw what is missing; the samples of `python -m pipeline dataset profile=paper`."""
        self.folder.mkdir(parents=True, exist_ok=True)
        with multiprocessing.get_context("spawn").Pool(workers) as pool:
            for name in ROBOTS:
                started = time.perf_counter()
                counts = {split: self._make(name, split, pool, verdicts) for split in SPLITS}
                print(f"data {name} {counts} {time.perf_counter() - started:.1f} s", flush=True)

    def load(self, name: str, split: str) -> NDArray[np.float64]:
        """Poses (N, 7) of a split."""
        return np.load(self.folder / f"{name}_{split}.npy")

    def _make(self, name: str, split: str, pool: Any, verdicts: Path | None) -> int:
        config, robot = self.configs[name], _robot(name, verdicts)
        path, count = self.folder / f"{name}_{split}.npy", getattr(config.dataset, split)
        if path.exists():
            return 0

        def draw(one: Any, numbers: Sequence[int]) -> Iterable[Samples]:
            chunk = partial(_drawn, name, one.func, one.keywords, verdicts)
            return pool.imap(chunk, numbers, chunksize=4)

        samples = sample_configurations(
            robot,
            count,
            seed=split_seed(config.seed, name, split),
            workspace_filter=config.robot.workspace_filter,
            executor=ChunkExecutor(draw, 0.0),
        )
        np.save(path, robot.forward_kinematics(samples.joints))
        return len(samples.joints)

    def _config(self, name: str) -> Config:
        config = compose([f"robot={name}", "profile=paper"])
        if not self.toy:
            return config
        sizes = replace(config.dataset, train=3000, validation=200, test=400)
        model = replace(config.model, hidden=[32, 32])
        return replace(config, dataset=sizes, model=model)


@cache
def _robot(name: str, verdicts: Path | None) -> Robot:
    """A robot, once a process; without coal where a file of verdicts takes its place."""
    robot = load_robot(name)
    if verdicts is not None:
        robot.collision.__dict__["exact"] = _Lookup(json.loads(verdicts.read_text()))
    return robot


def _drawn(
    name: str,
    draw: Callable[..., Samples],
    keywords: dict[str, Any],
    verdicts: Path | None,
    number: int,
) -> Samples:
    """A chunk of samples, drawn in another process."""
    return draw(_robot(name, verdicts), number, **keywords)


class _Lookup:
    """In the place of coal: which of the few undecided samples touch, from a file."""

    def __init__(self, touching: dict[str, bool]) -> None:
        self.touching = touching

    def answers(self, joints: NDArray[np.float64], pairs: Iterable[int]) -> Iterator[bool]:
        yield self.touching.get(np.asarray(joints, dtype=np.float64).tobytes().hex(), True)


class Plan:
    """Which trainings, in which order; jobs that depend on results wait for them."""

    def __init__(self, data: Data, device: torch.device, options: argparse.Namespace) -> None:
        self.data, self.device, self.options = data, device, options
        self.results: dict[str, dict[str, Any]] = {}
        self._poses: dict[tuple[str, str], Tensor] = {}

    def jobs(self) -> Iterator[FleetJob | None]:
        """Jobs of the groups, in the order that the options name them."""
        makers: dict[str, Callable[[], Iterator[FleetJob | None]]] = {
            "table": lambda: (self._table(name, 0) for name in ROBOTS),
            "published": lambda: iter([self._table("nico", 0, published=True)]),
            "nico": lambda: (self._table("nico", seed) for seed in (1, 2)),
            "seeds": lambda: (
                self._table(name, seed) for seed in (1, 2) for name in ROBOTS if name != "nico"
            ),
            "stability": self._stability,
            "search": self._search,
            "losses": self._losses,
        }
        for group in self.options.groups:
            yield from makers[group]()

    def poses(self, name: str, split: str) -> Tensor:
        """A split on the device, float32."""
        if (name, split) not in self._poses:
            values = self.data.load(name, split)
            values = values[:HELD_OUT] if split == "validation" else values
            self._poses[name, split] = torch.as_tensor(values, dtype=torch.float32).to(self.device)
        return self._poses[name, split]

    def _job(
        self,
        label: str,
        name: str,
        train: TrainConfig,
        seed: int,
        **more: Any,
    ) -> FleetJob:
        config = self.data.configs[name]
        poses = self.poses(name, "train")
        poses = poses[: train.poses] if train.poses else poses
        train = replace(train, precision=self.options.precision)
        more.setdefault("rounded_until", self.options.rounded_until)
        more.setdefault("model", config.model)
        return FleetJob(
            label=label,
            robot=self.data.robots[name],
            train=train,
            seed=derive_seed(config.seed, "train", name, "paper", seed),
            poses=poses,
            held_out=self.poses(name, "validation"),
            **more,
        )

    def _table(self, name: str, seed: int, published: bool = False) -> FleetJob:
        train = self.data.configs[name].train
        if published:
            label, train = f"published/{name}/{seed}", _as_published(train)
        else:
            label = f"table/{name}/{seed}"
        return self._job(label, name, train, seed, urgent=seed == 0)

    def _stability(self) -> Iterator[FleetJob]:
        for name in ROBOTS:
            train = self.data.configs[name].train
            recipes = {
                "published": _as_published(train),
                "warm_up": replace(train, gradient_clip=None),
                "clipped": replace(train, warm_up_steps=0),
                "stable": train,
            }
            steps = 20 if self.data.toy else STABILITY_STEPS
            for recipe in self.options.recipes:
                for seed in range(STABILITY_DRAWS):
                    label = f"stability/{name}/{recipe}/{seed}"
                    yield self._job(label, name, recipes[recipe], seed, steps=steps, validations=3)

    def _search(self) -> Iterator[FleetJob]:
        name, config = "nico", self.data.configs["nico"]
        train = replace(config.train, epochs=1, poses=self.options.search_poses)
        yield self._job("search/table_one", name, train, 0)
        generator = np.random.default_rng(derive_seed(config.seed, "search", name))
        for number in range(DRAWS):
            layers = int(generator.integers(5, 10))
            widths = [int(10 * generator.integers(50, 351)) for _ in range(layers)]
            tanh_layers = int(generator.integers(1, 4))
            drawn = replace(
                train,
                batch_size=int(50 * generator.integers(2, 13)),
                learning_rate=float(1e-5 * generator.integers(1, 101)),
                position_weight=float(generator.integers(1, 21)),
                rotation_weight=float(generator.integers(1, 21)),
            )
            widths = [32] * layers if self.data.toy else widths
            model = replace(config.model, hidden=widths, tanh_layers=tanh_layers)
            yield self._job(f"search/{number}", name, drawn, 0, model=model)

    def _losses(self) -> Iterator[FleetJob | None]:
        cells = [(name, loss) for name in LOSS_ROBOTS for loss in LOSSES]
        for name, loss in cells:
            for ratio in RATIOS:
                yield self._loss_job(f"losses/ratio/{name}/{loss}/{ratio}", name, loss, ratio, 10)
        wanted = {
            cell: [f"losses/ratio/{cell[0]}/{cell[1]}/{ratio}" for ratio in RATIOS]
            for cell in cells
        }
        while not all(label in self.results for labels in wanted.values() for label in labels):
            yield None
        best = {
            cell: RATIOS[int(np.argmin([self.results[label]["score"] for label in labels]))]
            for cell, labels in wanted.items()
        }
        for name in LOSS_ROBOTS:
            for seed in LOSS_SEEDS:
                for loss, epochs in (("former", 100), ("former", 10), ("smooth", 10)):
                    label = f"losses/final/{name}/{loss}/{epochs}/{seed}"
                    yield self._loss_job(label, name, loss, best[name, loss], epochs, seed)

    def _loss_job(
        self, label: str, name: str, loss: str, ratio: float, epochs: int, seed: int = 0
    ) -> FleetJob:
        train = replace(
            self.data.configs[name].train,
            loss=loss,
            position_weight=ratio,
            rotation_weight=1.0,
            epochs=epochs,
            poses=self.options.loss_poses,
        )
        return self._job(label, name, train, seed)


def _as_published(train: TrainConfig) -> TrainConfig:
    return replace(train, warm_up_steps=0, gradient_clip=None)


class Recorder:
    """Writes what a finished run is worth."""

    def __init__(self, plan: Plan, out: Path, weights: Path | None, started: float) -> None:
        self.plan, self.out, self.weights, self.started = plan, out, weights, started
        self.networks: dict[str, FleetRun] = {}

    def __call__(self, run: FleetRun) -> None:
        """Record one run."""
        job, curve = run.job, run.finish()
        loss, learned, skipped = run.sums.tolist()
        row: dict[str, Any] = {
            "label": job.label,
            "robot": job.robot.name,
            "seed": job.seed,
            "parameters": parameter_count(run.network),
            "hidden": list(job.model.hidden),
            "tanh_layers": job.model.tanh_layers,
            "batch_size": job.train.batch_size,
            "learning_rate": job.train.learning_rate,
            "loss": job.train.loss,
            "position_weight": job.train.position_weight,
            "rotation_weight": job.train.rotation_weight,
            "warm_up_steps": job.train.warm_up_steps,
            "gradient_clip": job.train.gradient_clip,
            "precision": job.train.precision,
            "rounded_until": job.rounded_until,
            "epochs": job.train.epochs,
            "poses": len(job.poses),
            "steps": run.step,
            "steps_learned": learned,
            "steps_skipped": skipped,
            "mean_loss": loss / max(learned, 1.0),
            "curve": curve,
            "score": curve[-1]["position_error_mm"] / 10 + curve[-1]["rotation_error_deg"] / 20,
            "seconds": time.perf_counter() - run.started,
            "at_s": time.perf_counter() - self.started,
            "device": _device_name(self.plan.device),
            "torch": torch.__version__,
            **self._saturation(run),
        }
        kind = job.label.split("/")[0]
        if kind in ("table", "published"):
            row["test"] = self._test(run)
        self.plan.results[job.label] = row
        _append(self.out / "runs.jsonl", row)
        print(f"{row['at_s']:7.1f} s  {job.label}  {curve[-1]}", flush=True)
        if kind == "table" and job.label.endswith("/0"):
            self.networks[job.robot.name] = run

    def _saturation(self, run: FleetRun) -> dict[str, float]:
        """How many outputs lie where tanh is flat, and how much answers differ between poses."""
        answers = run.answers(run.job.held_out)
        network = run.network
        output = (answers - network.joint_centre) / network.joint_scale
        return {
            "outputs_saturated": float((output.abs() > SATURATED).float().mean()),
            "outputs_spread": float(output.std(dim=0).mean()),
        }

    def _test(self, run: FleetRun) -> dict[str, Any]:
        """Errors on the whole test set in both families, recomputed in float64."""
        name = run.job.robot.name
        poses = self.plan.data.load(name, "test")
        inputs = torch.as_tensor(poses, dtype=torch.float32).to(run.device)
        answers = run.answers(inputs)
        test = {"float32": _summary(run, poses, answers)}
        if run.job.label == f"table/{name}/0":
            np.save(self.out / f"answers_{name}.npy", answers.cpu().numpy())
            if self.weights is not None:
                self.weights.mkdir(parents=True, exist_ok=True)
                state = {key: value.half() for key, value in run.network.state_dict().items()}
                save_file(
                    {key: value.contiguous().cpu() for key, value in state.items()},
                    self.weights / f"{name}.safetensors",
                )
            test["float16_weights"] = self._half(run, poses, inputs)
        return test

    def _half(self, run: FleetRun, poses: NDArray[np.float64], inputs: Tensor) -> dict[str, Any]:
        """The same with weights rounded to float16."""
        kept = [parameter.detach().clone() for parameter in run.network.parameters()]
        with torch.no_grad():
            for parameter in run.network.parameters():
                parameter.copy_(parameter.half().float())
            answers = run.answers(inputs)
            for parameter, before in zip(run.network.parameters(), kept, strict=True):
                parameter.copy_(before)
        return _summary(run, poses, answers)

    def latency(self, repetitions: int) -> None:
        """Time calls from a host array to a host array, the device otherwise idle."""
        for name, run in self.networks.items():
            poses = self.plan.data.load(name, "test")
            for size in BATCHES:
                times = []
                for turn in range(repetitions + 20):
                    first = (turn * size) % max(len(poses) - size, 1)
                    part = np.ascontiguousarray(poses[first : first + size], dtype=np.float32)
                    began = time.perf_counter()
                    run.answers(torch.from_numpy(part).to(run.device)).cpu()
                    times.append(time.perf_counter() - began)
                kept = np.array(times[20:]) * 1e3
                row = {
                    "robot": name,
                    "poses_per_call": size,
                    "calls": repetitions,
                    "median_ms": float(np.median(kept)),
                    "mean_ms": float(kept.mean()),
                    "p99_ms": float(np.quantile(kept, 0.99)),
                    "device": _device_name(run.device),
                }
                _append(self.out / "latency.jsonl", row)
                print(row, flush=True)


def _summary(run: FleetRun, poses: NDArray[np.float64], answers: Tensor) -> dict[str, Any]:
    """Errors of answers (N, dof), their kinematics recomputed in float64."""
    robot, device = run.job.robot, run.device
    lower, upper = (torch.as_tensor(limit, device=device) for limit in (robot.lower, robot.upper))
    joints = torch.minimum(torch.maximum(answers.double(), lower), upper)
    exact = FusedCycleLoss(robot.chain, run.job.train, device, torch.float64)
    tips = [exact.frames(part)[1] for part in joints.split(CHUNK)]
    tip = torch.cat(tips)
    quaternion = quaternion_from_matrix(tip[:, :3, :3].contiguous())
    reached = torch.cat((tip[:, :3, 3], quaternion), dim=1).cpu().numpy()
    errors = pose_errors(poses, reached)
    paper = (errors.paper_position_mm < 10) & (errors.paper_rotation_deg < 20)
    near = (errors.position_mm < 10) & (errors.rotation_deg < 20)
    summary: dict[str, Any] = {"poses": len(poses)}
    for key, values in vars(errors).items():
        summary[f"{key}_mean"], summary[f"{key}_sd"] = float(values.mean()), float(values.std())
        summary[f"{key}_median"] = float(np.median(values))
    return {
        **summary,
        "paper_success": float(paper.mean()),
        "success_10mm_20deg": float(near.mean()),
    }


def _append(path: Path, row: dict[str, Any]) -> None:
    with path.open("a") as file:
        file.write(json.dumps(row) + "\n")


def _device_name(device: torch.device) -> str:
    return torch.cuda.get_device_name(device) if device.type == "cuda" else "cpu"


def probe(plan: Plan, seconds: float) -> None:
    """Milliseconds a step, by precision and with other runs beside."""
    for precision in ("float32", "bfloat16_backward"):
        plan.options.precision = precision
        runs = []
        for name in ROBOTS:
            job = plan._table(name, 0)
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
