"""Mutated URDFs and odd arguments: each is taken or refused in a sentence, and soon."""

from __future__ import annotations

import random
import re
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import baselines
from baselines import Budget, Solver
from robots import Robot, available_robots, load_robot
from robots.description import FOLDER, find_description

LONGEST_S = 10.0  # of the processor, which others may use as well
LONGEST_IDLE_S = 60.0
OURS = ("robots", "baselines", "pipeline")
WORDS = (
    *("", "0", "-1", "1e400", "nan", "inf", "-inf", "1e-320", "2_5", "0x10", "a", "é", "\x7f"),
    *("0 0 0", "1 2", "0 0 0 0", "revolute", "continuous", "prismatic", "fixed", "floating"),
    *("planar", "base", "${x}", "$(find a)", "package://a/b.stl", "&amp;", "&lt;", "&#0;"),
    *("&undefined;", "true", "null"),
)
VALUES: tuple[Any, ...] = (
    *(None, True, 0, -1, 1, 1.5, 10**30, float("nan"), float("inf"), 1e300, 1j, range(7)),
    *("", "a", "0.1", b"x", [], {}, (), set(), object(), [1.0] * 7, [[0, 0, 0, 1, 0, 0, 0]]),
    *([[0.1] * 7], [None] * 7, [[1.0] * 7, [1.0]], np.zeros(7), np.zeros((2, 7)), np.eye(4)),
    *(np.full((1, 7), np.nan), np.zeros((1, 7), "f4"), np.float32(0.01), np.int64(3)),
    *(np.zeros((1, 7), complex), np.array("x"), np.zeros((0, 7)), np.datetime64("2020")),
    np.ma.masked_all(7),
)


def fuzz_urdfs(count: int, chance: random.Random) -> dict[str, Any]:
    """Mutate the project's own URDFs and load them; return a row of counts."""
    descriptions = [find_description(name) for name in available_robots()]
    chains = [(robot.urdf.read_text(), robot.base, robot.tip) for robot in descriptions]
    fixtures = FOLDER.parent / "tests" / "fixtures"
    chains += [((fixtures / "two_link.urdf").read_text(), "base", "tip")] * 2
    chains += [((fixtures / "mixed.urdf").read_text(), "bench", "tool")] * 3
    ends = Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.urdf"
        for number in range(count):
            text, base, tip = chance.choice(chains)
            data = mutated(text, chance)
            path.write_bytes(data)
            ends[_outcome(partial(_use, path, base, tip), f"URDF {number}", data[:200])] += 1
    return _row("mutated URDFs", count, ends)


def mutated(text: str, chance: random.Random) -> bytes:
    """Change a URDF in one to four places."""
    for _ in range(chance.randint(1, 4)):
        kind = chance.randrange(6)
        values = list(re.finditer(r'="([^"]*)"', text))
        elements = list(re.finditer(r"<[a-z]+[^<>]*/>", text))
        if kind <= 2 and values:
            place = chance.choice(values)
            text = text[: place.start(1)] + chance.choice(WORDS) + text[place.end(1) :]
        elif kind == 3 and elements:
            place = chance.choice(elements)
            text = text[: place.start()] + place[0] * chance.choice((0, 2)) + text[place.end() :]
        elif kind == 4:
            at = chance.randrange(len(text) + 1)
            text = text[:at] + chance.choice('<>/"& \0é') + text[at + chance.randint(0, 3) :]
        elif chance.random() < 0.2:
            text = text[: chance.randrange(len(text) + 1)]
    return text.encode(chance.choice(("utf-8",) * 8 + ("utf-16", "latin-1")), "replace")


def _use(path: Path, base: str, tip: str) -> None:
    robot = load_robot(urdf=path, base=base, tip=tip)
    joints = robot.sample(3, collision_free=False)
    assert np.isfinite(robot.forward_kinematics(joints)).all(), "poses that are not finite"


def fuzz_arguments(count: int, chance: random.Random) -> dict[str, Any]:
    """Hand odd values to every entry of the library; return a row of counts."""
    robot = load_robot("panda")
    solvers = {name: baselines.load(name, robot) for name in ("lm", "bio_ik", "pinocchio")}
    for solver in solvers.values():  # kernels are compiled at their first call
        solver.solve(robot.forward_kinematics(robot.sample(1)), budget=Budget(iterations=1))
    settings = {name: list(solver.settings) for name, solver in solvers.items()}
    ends = Counter[str]()
    for _ in range(count):
        one, two = chance.choice(VALUES), chance.choice(VALUES)
        name = chance.choice(list(solvers))
        key = chance.choice(settings[name])
        calls = _calls(robot, solvers[name], key, one, two)
        which = chance.randrange(len(calls))
        ends[_outcome(calls[which], f"call {which} of {name} {key}", (one, two))] += 1
    return _row("arguments", count, ends)


def _row(target: str, count: int, ends: Counter[str]) -> dict[str, Any]:
    """What happened as a row of the table."""
    kinds = {kind: ends[kind] for kind in ("taken", "refused", "bad")}
    return {"attack": "odd input", "target": target, "count": count, **kinds}


def _calls(
    robot: Robot, solver: Solver, key: str, one: Any, two: Any
) -> tuple[Callable[[], object], ...]:
    short = Budget(iterations=5)
    return (
        lambda: robot.forward_kinematics(one),
        lambda: robot.jacobian(one),
        lambda: robot.in_collision(one),
        lambda: robot.sample(1 if _is_large(one) else one, two, False),
        lambda: Budget(time_s=one, iterations=two),
        lambda: solver.solve(one, budget=short),
        lambda: solver.solve(one, initial=two, budget=short),
        lambda: solver.solve([[0.4, 0, 0.4, 0, 1, 0, 0]], initial=two, budget=short),
        lambda: baselines.load(solver.name, robot, **{key: one}),
        lambda: load_robot(one),
        lambda: load_robot(urdf=one, base=two),
    )


def _is_large(value: object) -> bool:
    return isinstance(value, int) and value > 1000


def _outcome(call: Callable[[], object], what: str, given: object) -> str:
    began = time.perf_counter(), time.process_time()
    try:
        call()
        end = "taken"
    except Exception as error:
        ours = type(error).__module__.split(".")[0] in OURS
        end = "refused" if ours and "\n" not in str(error) else "bad"
        if end == "bad":
            print(f"{what}: {type(error).__name__}: {str(error)[:200]!r} for {given!r}"[:600])
    wall_s, core_s = time.perf_counter() - began[0], time.process_time() - began[1]
    if core_s > LONGEST_S or wall_s - core_s > LONGEST_IDLE_S:
        print(f"{what}: took {core_s:.0f} of {wall_s:.0f} s for {given!r}"[:600])
        end = "bad"
    return end
