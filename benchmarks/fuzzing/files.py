"""Each kind of file that the project writes and reads again, cut off and with flipped bytes.

What is damaged is refused in one sentence that names the file, or made anew; it never gives other
numbers. MP4, pictures and tables of a report are written and never read. YAML that people write
(conf/, robot.yaml) has no checksum: cut at the end of a line it says less, and a flipped digit is
another digit.
"""

from __future__ import annotations

import random
import shutil
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import optuna
import pandas as pd
import torch

from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.data.dataset import read_split, write_card, write_split
from pipeline.data.files import read_json, sha256, write_json, write_sealed_json, write_sealed_yaml
from pipeline.data.rows import RowCheckpoint
from pipeline.data.tables import read_metadata, read_table, write_table
from pipeline.learning.card import chain_facts
from pipeline.learning.checkpoint import Progress, restore, save
from pipeline.learning.factory import build_network
from pipeline.learning.weights import load_network, save_weights
from pipeline.perception.config import NetworkConfig
from pipeline.perception.network import CentreNetwork
from pipeline.perception.pictures import is_rendered, labels_path
from pipeline.perception.weights import load_centre_network, save_detector
from pipeline.reporting.results import read_results
from pipeline.tuning.best import read_best
from pipeline.tuning.journal import JournalStore
from robots import Robot, load_robot
from robots.checksums import sampling_checksum
from robots.description import FOLDER, find_description

LONGEST_S = 10.0
OURS = ("robots", "baselines", "pipeline")
ROBOT, OVERRIDES = "nico", ["robot=nico", "profile=smoke"]
ANEW = None  # what a reader gives for a file that is made again
Made = Callable[[Path], Path]
Read = Callable[[Path], Any]


@dataclass(frozen=True)
class Kind:
    """A kind of file.

    Attributes:
        make: Writes one into a folder, with what belongs to it, and returns its path.
        read: What the project reads from it, as a text that says all; `ANEW` if it is made again.
        prefix: Whether a part of the content from its beginning is right as well: lines that are
            kept, when those that are lost are made again.
        sealed: Whether a changed byte is noticed as well.
    """

    make: Made
    read: Read
    prefix: bool = False
    sealed: bool = True


def damage_files(
    root: Path, count: int, chance: random.Random, names: Sequence[str] = ()
) -> Iterator[dict[str, Any]]:
    """Damage each kind of file and yield a row about it.

    Args:
        root: An empty folder to work in.
        count: Places at which a file is cut off, and as many files in which a byte is flipped.
        chance: Draws places and bits.
        names: Kinds; all where left out.
    """
    for name in names or KINDS:
        folder = root / name.replace(" ", "_")
        ends = Counter[str]()
        for sentence in attack(KINDS[name], folder, count, chance, ends):
            print(f"{name}: WRONG: {sentence}", flush=True)
        kinds = {kind: ends[kind] for kind in ("taken", "refused", "anew", "bad")}
        yield {"attack": "damaged file", "target": name, "count": sum(ends.values()), **kinds}


def attack(
    kind: Kind, folder: Path, count: int, chance: random.Random, ends: Counter[str]
) -> Iterator[str]:
    """Damage one kind of file and yield what went wrong, a sentence each.

    Args:
        kind: Of file.
        folder: Is made; holds the file.
        count: Of cuts, and of flipped bytes.
        chance: Draws places and bits.
        ends: Counts how each ended.
    """
    folder.mkdir(parents=True)
    path = kind.make(folder)
    content, right = path.read_bytes(), kind.read(path)
    aside = folder.with_name(f"{folder.name}-whole")
    shutil.copytree(folder, aside)
    for damaged, what in _damages(content, count if kind.sealed else 0, count, chance):
        shutil.rmtree(folder)
        shutil.copytree(aside, folder)
        path.write_bytes(damaged)
        end, sentence = _outcome(kind, path, right)
        ends[end] += 1
        if end == "bad":
            yield f"{what}: {sentence}"


def _damages(
    content: bytes, flips: int, cuts: int, chance: random.Random
) -> Iterator[tuple[bytes, str]]:
    size = len(content)
    places = [0, size - 1, *(chance.randrange(size) for _ in range(max(0, cuts - 2)))]
    for place in places[:cuts]:
        yield content[:place], f"cut at {place} of {size}"
    for _ in range(flips):
        place, bit = chance.randrange(size), 1 << chance.randrange(8)
        changed = bytearray(content)
        changed[place] ^= bit
        yield bytes(changed), f"bit {bit} of byte {place} of {size} flipped"


def _outcome(kind: Kind, path: Path, right: Any) -> tuple[str, str]:
    began = time.process_time()
    try:
        found = kind.read(path)
    except Exception as error:
        text = str(error)
        ours = type(error).__module__.split(".")[0] in OURS and "\n" not in text
        if not ours or path.name not in text:
            return "bad", f"{type(error).__name__}: {text[:300]!r}"
        found, end = right, "refused"
    else:
        end = "anew" if found is ANEW else "taken"
    if (took := time.process_time() - began) > LONGEST_S:
        return "bad", f"took {took:.0f} s of the processor"
    if found is ANEW or found == right:
        return end, ""
    if kind.prefix and right.startswith(found):
        return "anew", ""
    return "bad", f"another content: {str(found)[:200]!r}"


def _robot() -> Robot:
    return load_robot(ROBOT)


def _make_pose_set(folder: Path) -> Path:
    robot = _robot()
    write_split(folder / "train.parquet", robot, robot.sample(60), {"seed": 1})
    write_card(folder, {"checksum": sampling_checksum(robot)}, ["train"])
    return folder / "train.parquet"


def _read_pose_set(path: Path) -> str:
    found = read_split(path.parent, "train", _robot())
    return repr((found.poses.tobytes(), found.joints.tobytes()))


def _make_table(folder: Path) -> Path:
    path = folder / "rows.parquet"
    frame = pd.DataFrame({"x": np.linspace(0, 1, 400), "name": [f"a{k}" for k in range(400)]})
    write_table(path, frame, {"threshold": 0.5, "commit": "c" * 12})
    return path


def _read_table(path: Path) -> str:
    rows = read_table(path)
    return rows.to_csv() + repr(sorted(read_metadata(path).items()))


def _make_weights(folder: Path) -> Path:
    robot, config = _robot(), compose(OVERRIDES)
    torch.manual_seed(0)
    card = {**chain_facts(robot), "config": {"model": to_dict(config.model)}}
    save_weights(folder, build_network(robot, config.model), card)
    return folder / "weights.safetensors"


def _read_weights(path: Path) -> str:
    return _said(load_network(path.parent, _robot()).state_dict())


def _make_detector(folder: Path) -> Path:
    torch.manual_seed(0)
    network = CentreNetwork(("can", "cup"), NetworkConfig(64, 64, [4, 4, 4, 4]))
    config = {"detector": {"network": to_dict(network.config)}}
    save_detector(folder, network, {"robot": ROBOT, "names": ["can", "cup"], "config": config})
    return folder / "weights.safetensors"


def _read_detector(path: Path) -> str:
    return _said(load_centre_network(path.parent, ROBOT).state_dict())


def _training() -> tuple[torch.nn.Module, torch.optim.Optimizer]:
    torch.manual_seed(0)
    network = torch.nn.Linear(7, 30)
    return network, torch.optim.AdamW(network.parameters())


def _make_checkpoint(folder: Path) -> Path:
    network, optimizer = _training()
    network(torch.ones(2, 7)).sum().backward()
    optimizer.step()
    path = folder / "nico-tiny.safetensors"
    progress = Progress(step=12, curve=[{"loss": 0.1}], best_error=2.0)
    best = {name: value.clone() for name, value in network.state_dict().items()}
    save(path, "digest", progress, network, optimizer, best)
    return path


def _read_checkpoint(path: Path) -> str | None:
    network, optimizer = _training()
    found = restore(path, "digest", network, optimizer)
    if found is None:
        return ANEW
    moments = [
        value for state in optimizer.state_dict()["state"].values() for value in state.items()
    ]
    return _said(network.state_dict()) + _said(dict(moments)) + repr(found[0]) + _said(found[1])


def _said(tensors: dict[str, Any]) -> str:
    return repr([(name, t.dtype, t.numpy().tobytes()) for name, t in tensors.items()])


def _make_rows(folder: Path) -> Path:
    kept = RowCheckpoint(folder / "plan.jsonl", ["pair"])
    for pair in range(30):
        kept.put({"pair": pair, "solver": "lm", "plan_time_ms": 0.1 * pair, "found": True})
    return kept.path


def _read_rows(path: Path) -> str:
    """All rows: those that are lost are made again, here with their right values."""
    kept = RowCheckpoint(path, ["pair"])
    again = {
        pair: {"pair": pair, "solver": "lm", "plan_time_ms": 0.1 * pair, "found": True}
        for pair in range(30)
    }
    return repr([kept.get(pair) or again[pair] for pair in range(30)])


def _make_journal(folder: Path) -> Path:
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    store = JournalStore(folder / "tune.log")
    study = optuna.create_study(study_name="study", storage=store.storage)
    study.sampler = optuna.samplers.RandomSampler(seed=0)
    study.optimize(lambda trial: trial.suggest_float("rate", 0, 1) ** 2, n_trials=8)
    store.close()
    return store.path


def _read_journal(path: Path) -> str:
    store = JournalStore(path)
    try:
        study = optuna.create_study(study_name="study", storage=store.storage, load_if_exists=True)
        trials = study.get_trials(states=(optuna.trial.TrialState.COMPLETE,))
        return "".join(repr((t.number, t.params, t.value)) for t in trials)
    finally:
        store.close()


def _make_best(folder: Path) -> Path:
    path = folder / "best.yaml"
    text = "# made by\ntrain:\n  batch_size: 100\n  learning_rate: 0.00123\nof:\n  robot: nico\n"
    write_sealed_yaml(path, text)
    return path


def _read_best(path: Path) -> str:
    return repr(read_best(path, compose(OVERRIDES)))


def _make_pictures(folder: Path) -> Path:
    path = folder / "training-000000.npy"
    np.save(path, np.random.default_rng(0).integers(0, 255, (2, 8, 8, 3), dtype=np.uint8))
    write_sealed_json(labels_path(path), {"pictures": [], "core_s": 1.0, "sha256": sha256(path)})
    return path


def _read_pictures(path: Path) -> str | None:
    return "whole" if is_rendered(path.with_suffix(".npy")) else ANEW


def _make_trials(folder: Path) -> Path:
    place = folder / "tune" / ROBOT
    place.mkdir(parents=True)
    path = place / "trials.csv"
    pd.DataFrame({"number": range(9), "objective": np.linspace(1, 2, 9)}).to_csv(path, index=False)
    write_sealed_yaml(place / "best.yaml", "train: {}\n")
    write_sealed_json(place / "card.json", {"files": {path.name: sha256(path)}})
    return path


def _make_curve(folder: Path) -> Path:
    place = folder / "train" / ROBOT / "tiny"
    place.mkdir(parents=True)
    path = place / "curve.csv"
    pd.DataFrame({"samples": range(9), "loss": np.linspace(1, 2, 9)}).to_csv(path, index=False)
    write_sealed_json(place / "card.json", {"robot": ROBOT, "files": {path.name: sha256(path)}})
    return path


def _read_report(path: Path) -> str | None:
    """What a report reads; the note that it has about a file which it cannot read."""
    root = path.parents[3] if "train" in path.parts[-4:] else path.parents[2]
    found = read_results(root)
    if any(path.name in note and "could not be read" in note for note in found.notes):
        return ANEW
    tables = [trials for trials, _ in found.tune.values()]
    tables += [curve for _, curve in found.train.values()]
    return "".join(table.to_csv() for table in tables)


def _make_metrics(folder: Path) -> Path:
    path = folder / "metrics.json"
    write_json(path, {"success": 0.97, "trials": 100})
    return path


def _make_robot(folder: Path, suffix: str) -> Path:
    shutil.copytree(FOLDER / ROBOT, folder / ROBOT)
    return folder / ROBOT / ("robot.yaml" if suffix == "yaml" else f"{ROBOT}.{suffix}")


def _read_robot(path: Path) -> str:
    robot = Robot(find_description(ROBOT, path.parents[1]))
    return repr(robot.forward_kinematics(robot.home[None]).tobytes())


def _beside(make: Made, name: str) -> Made:
    """Another file of the same artifact."""
    return lambda folder: make(folder).with_name(name)


def _content(path: Path) -> str:
    return repr(sorted(read_json(path).items()))


KINDS: dict[str, Kind] = {
    "pose set (Parquet)": Kind(_make_pose_set, _read_pose_set),
    "card of pose sets (JSON)": Kind(_beside(_make_pose_set, "card.json"), _read_pose_set),
    "raw rows (Parquet)": Kind(_make_table, _read_table),
    "weights (safetensors)": Kind(_make_weights, _read_weights),
    "card of weights (JSON)": Kind(_beside(_make_weights, "card.json"), _read_weights),
    "training checkpoint (safetensors)": Kind(_make_checkpoint, _read_checkpoint),
    "detector (safetensors)": Kind(_make_detector, _read_detector),
    "card of a detector (JSON)": Kind(_beside(_make_detector, "card.json"), _read_detector),
    "pictures (npy)": Kind(_make_pictures, _read_pictures),
    "labels (JSON)": Kind(_beside(_make_pictures, "training-000000.json"), _read_pictures),
    "kept rows (JSON lines)": Kind(_make_rows, _read_rows),
    "journal of a search (JSON lines)": Kind(_make_journal, _read_journal, prefix=True),
    "best of a search (YAML)": Kind(_make_best, _read_best),
    "trials (CSV)": Kind(_make_trials, _read_report),
    "training curve (CSV)": Kind(_make_curve, _read_report),
    "metrics (JSON)": Kind(_make_metrics, _content, sealed=False),
    "robot (URDF)": Kind(lambda folder: _make_robot(folder, "urdf"), _read_robot, sealed=False),
    "robot (YAML)": Kind(lambda folder: _make_robot(folder, "yaml"), _read_robot, sealed=False),
}
