"""Bits do not depend on which kernel was compiled first.

What a function leaves open (`fastmath`, `forceinline`), numba takes from the caller that needs it
first, and that version is kept and called by everybody else.
"""

import importlib
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from numba.core.registry import CPUDispatcher

ROOT = Path(__file__).parents[2]

BITS = """
import sys
import numpy as np
from numba import njit
from robots import load_robot
from robots.collision_kernel import ROOT, find_frames
from robots.kinematics import tip_frame

robot = load_robot("panda")
tree = robot.collision.tree
frames = np.zeros((len(tree.parent) + 1, 12))
frames[0] = ROOT
rotation, position = np.empty((3, 3)), np.empty(3)
joints = np.random.default_rng(0).uniform(robot.chain.lower, robot.chain.upper, (200, robot.dof))

@njit
def call(function, *arguments):
    # Functions that only compiled code calls have no entry from Python.
    function(*arguments)

def kinematics(q):
    call(tip_frame, robot.chain, q, rotation, position)
    return rotation.tobytes() + position.tobytes()

def collision(q):
    call(find_frames, tree, q, frames)
    return frames.tobytes()

kernels = {"kinematics": kinematics, "collision": collision}
bits = {name: b"".join(kernels[name](q) for q in joints) for name in sys.argv[1:]}
print(bits["kinematics"].hex(), bits["collision"].hex())
"""


def _bits(folder: Path, *order: str) -> str:
    """Frames of the kinematics and of the collision checks, compiled in some order."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder), "PYTHONPATH": str(ROOT)}
    ran = subprocess.run(
        [sys.executable, "-c", BITS, *order],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return ran.stdout


def test_two_orders_of_compilation_give_the_same_bits(tmp_path: Path) -> None:
    first = _bits(tmp_path / "first", "kinematics", "collision")
    assert len(first) > 200 * 12 * 16
    assert _bits(tmp_path / "second", "collision", "kinematics") == first


def _compiled() -> dict[str, CPUDispatcher]:
    """Every compiled function of the project by its full name."""
    found = {}
    for package in ("robots", "baselines", "pipeline"):
        for path in (ROOT / package).rglob("*.py"):
            if b"njit" not in path.read_bytes():
                continue
            name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for value in vars(importlib.import_module(name)).values():
                if isinstance(value, CPUDispatcher):
                    found[f"{value.py_func.__module__}.{value.py_func.__name__}"] = value
    return found


def _called(function: CPUDispatcher) -> list[CPUDispatcher]:
    """Compiled functions that one calls, those of functions inlined into it included."""
    code, scope = function.py_func.__code__, function.py_func.__globals__
    values = [scope[name] for name in code.co_names if name in scope]
    modules = [value for value in values if isinstance(value, ModuleType)]
    values += [vars(module)[n] for module in modules for n in code.co_names if n in vars(module)]
    called = []
    for value in values:
        if isinstance(value, CPUDispatcher):
            inlined = value.targetoptions.get("inline") == "always"
            called += _called(value) if inlined else [value]
    return called


@pytest.mark.parametrize("option", ["fastmath", "forceinline"])
def test_no_function_takes_an_option_from_a_caller(option: str) -> None:
    functions = _compiled()
    assert len(functions) > 60
    inherited = [
        f"{name} -> {called.py_func.__module__}.{called.py_func.__name__}"
        for name, function in functions.items()
        if function.targetoptions.get(option)
        for called in _called(function)
        if option not in called.targetoptions
    ]
    assert not inherited, f"state {option} on the callee, as robots/frames.py does"


ASKING = {"empty", "zeros", "ones", "full", "empty_like", "zeros_like", "array", "copy"}


def _without_memory(function: CPUDispatcher, way: tuple[str, ...]) -> list[str]:
    """Ways on which a function that may not ask for memory, or what it calls, does."""
    way = (*way, function.py_func.__name__)
    asks = ASKING & {*function.py_func.__code__.co_names}
    found = [f"{' -> '.join(way)}: {', '.join(sorted(asks))}"] if asks else []
    for called in _called(function):
        if called.targetoptions.get("_nrt") is None:
            found += _without_memory(called, way)
    return found


def test_what_asks_for_memory_says_so_where_a_caller_may_not() -> None:
    """`_nrt=False` is inherited, too, and then compiling fails, if the caller comes first."""
    bare = [f for f in _compiled().values() if f.targetoptions.get("_nrt") is False]
    assert len(bare) > 10
    assert not [way for function in bare for way in _without_memory(function, ())]
