"""What a finished training is worth: its row, its answers, its weights and its latency."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.torch import save_file
from torch import Tensor

from benchmarks.accelerator.plan import Plan
from pipeline.evaluation.metrics import pose_errors
from pipeline.learning.fleet import CHUNK, FleetRun
from pipeline.learning.fused import FusedCycleLoss
from pipeline.learning.networks import parameter_count
from pipeline.learning.rotation import quaternion_from_matrix

SATURATED = 0.99  # of a joint's half range: where tanh is flat
BATCHES = (1, 100, 1000)


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
