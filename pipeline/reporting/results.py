"""What the stages left in a results folder; what is missing or unreadable is noted, not fatal."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd

from pipeline.artifacts import SIGNATURE
from pipeline.data.files import check_listed, read_json, read_sealed_yaml
from pipeline.data.tables import read_metadata, read_table
from pipeline.reporting.sweeps import SweptRun, read_sweeps

Content = TypeVar("Content")
Key = TypeVar("Key")
ProtocolKey = tuple[str, str, str, int]
PICTURES = (".png", ".gif")
VIDEOS = (".mp4",)
EVIDENCE = "evidence"  # folder of transcripts and pictures that trials are judged by: not for show
SMOKE = "smoke"  # the profile whose networks see a few hundred steps
SEEDED = "seeded_by_"  # folders of rows that started from another solver's answers
LEFT_OUT = "left_out.json"  # written by `python -m pipeline paper`
JOINT = re.compile(r"q\d+")
STAGES = ("dataset", "tune", "train", "evaluate", "plan", "grasp")
# Made on demand: nothing is missing where they did not run.
EXPERIMENTS = (
    "sample",
    "grasp_study",
    "grasp_agent",
    "compare_tuned",
    "detector",
    "evaluate_suite",
    "evaluate_protocol",
    "judge",
)


@dataclass
class Results:
    """Everything that a report can show, by robot, and what is not there.

    Attributes:
        folder: The results folder.
        dataset: Card of the pose sets, by robot.
        tune: Trials and best configuration, by robot.
        train: Card and curve, by (robot, model).
        evaluate: Raw rows, by (robot, solver).
        evaluated: Provenance of those rows, by (robot, solver).
        seeded: Raw rows from a neural seed and their provenance, by (robot, solver, its seeder).
        suites: Raw rows on suites of hard poses, by (robot, suite, solver).
        protocols: Raw rows by other groups' protocols and their provenance, by (robot, protocol,
            solver, batch size).
        sample: Raw rows of many solutions of one pose, by (robot, solver).
        swept: Trainings of sweeps below this folder.
        plan: Raw rows of the planner benchmark, by robot.
        grasp: Trials, by robot.
        grasp_studies: Trials of the studies of grasps, by (robot, study).
        grasp_agents: Trials with a camera or an agent, by (robot, setting).
        compare_tuned: Trainings of the best of a search and its rivals, by robot.
        detector: Raw rows on held-out pictures and the least score in use, by robot.
        media: Pictures and videos of a stage, by (stage, robot).
        left_out: What a whole run did not run, with the hours of one core that it would take.
        cards: Provenance of each file of rows, by stage.
        notes: What is missing or could not be read, one sentence each.
    """

    folder: Path
    dataset: dict[str, dict[str, Any]] = field(default_factory=dict)
    tune: dict[str, tuple[pd.DataFrame, dict[str, Any]]] = field(default_factory=dict)
    train: dict[tuple[str, str], tuple[dict[str, Any], pd.DataFrame]] = field(default_factory=dict)
    evaluate: dict[tuple[str, str], pd.DataFrame] = field(default_factory=dict)
    evaluated: dict[tuple[str, str], dict[str, Any]] = field(default_factory=dict)
    seeded: dict[tuple[str, str, str], tuple[pd.DataFrame, dict[str, Any]]] = field(
        default_factory=dict
    )
    suites: dict[tuple[str, str, str], pd.DataFrame] = field(default_factory=dict)
    protocols: dict[ProtocolKey, tuple[pd.DataFrame, dict[str, Any]]] = field(default_factory=dict)
    sample: dict[tuple[str, str], pd.DataFrame] = field(default_factory=dict)
    swept: list[SweptRun] = field(default_factory=list)
    plan: dict[str, pd.DataFrame] = field(default_factory=dict)
    grasp: dict[str, pd.DataFrame] = field(default_factory=dict)
    grasp_studies: dict[tuple[str, str], pd.DataFrame] = field(default_factory=dict)
    grasp_agents: dict[tuple[str, str], pd.DataFrame] = field(default_factory=dict)
    compare_tuned: dict[str, pd.DataFrame] = field(default_factory=dict)
    detector: dict[str, tuple[pd.DataFrame, float]] = field(default_factory=dict)
    media: dict[tuple[str, str], list[Path]] = field(default_factory=dict)
    left_out: list[dict[str, Any]] = field(default_factory=list)
    cards: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def keep_card(self, path: Path) -> dict[str, Any]:
        """Keep the provenance of a file of rows under its stage, and return it."""
        facts = read_metadata(path)
        self.cards.setdefault(path.relative_to(self.folder).parts[0], []).append(facts)
        return facts

    @property
    def robots(self) -> list[str]:
        """Robots that any stage has results of, sorted."""
        keyed = [*self.train, *self.evaluate]
        plain = [*self.dataset, *self.tune, *self.plan, *self.grasp]
        return sorted({*plain, *(robot for robot, _ in keyed)})

    def solvers(self, robot: str) -> list[str]:
        """Solvers that were evaluated on a robot, sorted."""
        return sorted(solver for name, solver in self.evaluate if name == robot)

    @property
    def empty(self) -> bool:
        """Whether no stage has left anything, not even a file that cannot be read."""
        stages = (*STAGES, *EXPERIMENTS, "sweep")
        return not any(_folders(self.folder / stage) for stage in stages)


def read_results(folder: Path, profile: str = "") -> Results:
    """Read what is in a results folder; it may be empty.

    Args:
        folder: Results folder of a profile or of a run.
        profile: Profile of the run that asks; what the rows themselves say counts as well.
    """
    results = Results(folder)
    results.swept, unread = read_sweeps(folder)
    results.cards["sweep"] = [run.card for run in results.swept]
    results.notes += unread
    for stage in (*STAGES, *EXPERIMENTS):
        robots = _folders(folder / stage)
        if not robots and stage in STAGES:
            results.notes.append(f"The {stage} stage has left nothing in {folder.name}/{stage}.")
        for place in robots:
            READERS[stage](results, place)
            media = [p for p in _files(place, "**/*") if p.suffix in PICTURES + VIDEOS]
            media = [p for p in media if EVIDENCE not in p.relative_to(place).parts]
            media = [p for p in media if p.suffix != ".gif" or p.with_suffix(".mp4") not in media]
            if media:
                results.media[stage, place.name] = media
    if (folder / LEFT_OUT).exists():
        written: dict[str, Any] = _try(results, folder / LEFT_OUT, read_json) or {}
        results.left_out = list(written.pop("left_out", []))
        results.cards[LEFT_OUT] = [written]
    profiles = {profile, folder.name, *(f.get("profile") for f in results.evaluated.values())}
    if SMOKE in profiles:
        results.notes.insert(
            0, "This profile shows that everything runs; its numbers mean nothing."
        )
    return results


def _read_dataset(results: Results, place: Path) -> None:
    card = _try(results, place / "card.json", read_json)
    if card is not None:
        results.dataset[place.name] = card


def _read_tune(results: Results, place: Path) -> None:
    card = _try(results, place / "card.json", read_json) if _has_card(place) else None
    trials = _try(results, place / "trials.csv", partial(_read_csv, card or {}))
    best = _try(results, place / "best.yaml", read_sealed_yaml)
    if trials is not None:
        results.tune[place.name] = (trials, best or {})
        results.cards.setdefault("tune", []).append(_signature(results, place))


def _read_train(results: Results, place: Path) -> None:
    for model in _folders(place):
        card = _try(results, model / "card.json", read_json)
        curve = _try(results, model / "curve.csv", partial(_read_csv, card or {}))
        if card is not None:
            empty = pd.DataFrame()
            results.train[place.name, model.name] = (card, empty if curve is None else curve)
            results.cards.setdefault("train", []).append({**card, **_signature(results, model)})


def _read_evaluate(results: Results, place: Path) -> None:
    for path in _files(place, "*.parquet"):
        rows = _raw_rows(results, path)
        if rows is not None:
            results.evaluate[place.name, path.stem] = rows
            results.evaluated[place.name, path.stem] = results.keep_card(path)
    for path in _files(place, f"{SEEDED}*/*.parquet"):
        rows = _raw_rows(results, path)
        if rows is not None:
            seeder = path.parent.name.removeprefix(SEEDED)
            results.seeded[place.name, path.stem, seeder] = (rows, results.keep_card(path))


def _raw_rows(results: Results, path: Path) -> pd.DataFrame | None:
    """Rows without the joints: a report does not need them, and they are half of the memory."""
    rows = _try(results, path, read_table)
    if rows is not None and rows.empty:
        results.notes.append(f"{_short(results, path)} holds no rows.")
        return None
    return None if rows is None else rows.drop(columns=[c for c in rows if JOINT.fullmatch(str(c))])


def _read_suites(results: Results, place: Path) -> None:
    for path in _files(place, "*/*.parquet"):
        rows = _raw_rows(results, path)
        if rows is not None and _of_present_suite(results, path):
            results.suites[place.name, path.parent.name, str(rows.solver.iloc[0])] = rows
            results.keep_card(path)


def _of_present_suite(results: Results, path: Path) -> bool:
    """Whether rows are of the suite that lies there; without one nobody knows, and they count."""
    robot, suite = path.parts[-3:-1]
    present = results.folder / "suite" / robot / f"{suite}.parquet"
    facts = _try(results, present, read_metadata) if present.exists() else None
    same = facts is None or facts["suite_checksum"] == read_metadata(path)["suite_checksum"]
    if not same:
        results.notes.append(f"{_short(results, path)} is of another version or size of the suite.")
    return same


def _read_protocols(results: Results, place: Path) -> None:
    for path in _files(place, "*/*/*.parquet"):
        rows = _raw_rows(results, path)
        if rows is not None:
            key = (place.name, path.parts[-3], path.parts[-2], int(rows.batch_size.iloc[0]))
            results.protocols[key] = (rows, results.keep_card(path))


def _read_plan(results: Results, place: Path) -> None:
    wanted = []
    for path in _files(place, "*.parquet"):
        frame = _try(results, path, read_table)
        if frame is not None and "pair" in frame.columns:
            wanted.append(frame)
            results.keep_card(path)
    if wanted:
        results.plan[place.name] = pd.concat(wanted, ignore_index=True)


def _read_detector(results: Results, place: Path) -> None:
    rows = _try(results, place / "errors.parquet", read_table)
    if rows is not None and len(rows):
        threshold = results.keep_card(place / "errors.parquet")["threshold"]
        results.detector[place.name] = (rows, float(threshold))


def _keep(results: Results, found: dict[Key, pd.DataFrame], key: Key, path: Path) -> None:
    """Keep the rows of a table under a key, if it has any."""
    rows = _try(results, path, read_table)
    if rows is not None and len(rows):
        found[key] = rows
        results.keep_card(path)


def _keep_each(
    results: Results, found: dict[tuple[str, str], pd.DataFrame], robot: str, named: dict[str, Path]
) -> None:
    """Keep the rows of tables by the robot and their own name."""
    for name, path in named.items():
        _keep(results, found, (robot, name), path)


def _tables(place: Path) -> dict[str, Path]:
    return {path.stem: path for path in _files(place, "*.parquet")}


READERS: dict[str, Callable[[Results, Path], None]] = {
    "dataset": _read_dataset,
    "tune": _read_tune,
    "train": _read_train,
    "evaluate": _read_evaluate,
    "sample": lambda r, p: _keep_each(r, r.sample, p.name, _tables(p)),
    "plan": _read_plan,
    "grasp": lambda r, p: _keep(r, r.grasp, p.name, p / "trials.parquet"),
    "grasp_study": lambda r, p: _keep_each(r, r.grasp_studies, p.name, _tables(p)),
    "grasp_agent": lambda r, p: _keep_each(
        r, r.grasp_agents, p.name, {f.name: f / "trials.parquet" for f in _folders(p)}
    ),
    "compare_tuned": lambda r, p: _keep(r, r.compare_tuned, p.name, p / "trainings.parquet"),
    "detector": _read_detector,
    "evaluate_suite": _read_suites,
    "evaluate_protocol": _read_protocols,
    "judge": _read_suites,
}


def _signature(results: Results, place: Path) -> dict[str, Any]:
    """When and at which commit a folder was made; empty where it is older than that."""
    return (
        _try(results, place / SIGNATURE, read_json) if (place / SIGNATURE).exists() else {}
    ) or {}


def _try(results: Results, path: Path, reader: Callable[[Path], Content]) -> Content | None:
    """Read a file, or note why not: a report of what is there is worth more than none."""
    if not path.exists():
        results.notes.append(f"There is no {_short(results, path)}.")
        return None
    try:
        return reader(path)
    except (ValueError, OSError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        results.notes.append(f"{_short(results, path)} could not be read: {reason}.")
        return None


def _short(results: Results, path: Path) -> str:
    return str(path.relative_to(results.folder.parent))


def _folders(place: Path) -> list[Path]:
    if not place.is_dir():
        return []
    return sorted(p for p in place.iterdir() if p.is_dir() and not p.name.startswith("."))


def _files(place: Path, pattern: str) -> list[Path]:
    """Files without those that begin with a dot: a killed run leaves half-written ones."""
    return sorted(p for p in place.glob(pattern) if not p.name.startswith("."))


def _read_csv(card: Mapping[str, Any], path: Path) -> pd.DataFrame:
    """Read a table that a card may have the checksum of."""
    check_listed(path, card)
    return pd.read_csv(path)


def _has_card(place: Path) -> bool:
    """Whether a search ended: its trials are written before that as well."""
    return (place / "card.json").exists()
