"""How robots, solvers, models and outcomes are called, and in which order they are shown."""

from __future__ import annotations

from collections.abc import Iterable

ROBOTS = {
    "nicol": "NICOL",
    "nico": "NICO",
    "valkyrie": "Valkyrie",
    "panda": "Panda",
    "fetch": "Fetch",
}
SOLVERS = {
    "cycleik": "CycleIK",
    "cycleik_refined": "CycleIK refined",
    "null_space": "CycleIK null space",
    "flow": "flow",
    "ikflow": "IKFlow",
    "eem": "EEM",
    "bio_ik": "BioIK",
    "trac_ik": "TRAC-IK",
    "lm": "LM, compiled",
    "pinocchio": "Pinocchio DLS",
    "placo": "placo",
    "pytorch_kinematics": "PyTorch Kinematics",
    "optik": "OptIK",
    "pink": "Pink",
    "mink": "mink",
    "roboticstoolbox": "Robotics Toolbox",
    "ssik": "ssik",
    "frankik": "frankik",
}
OUTCOMES = {
    "success": "Success",
    "slipped": "Slipped",
    "not_grasped": "Not Grasped",
    "detection": "Detection",
    "llm": "LLM",
}


def robot_title(name: str) -> str:
    """Return how a robot is written."""
    return ROBOTS.get(name, name)


def solver_title(name: str) -> str:
    """Return how a solver is written."""
    return SOLVERS.get(name, name)


def ordered_robots(names: Iterable[str]) -> list[str]:
    """Put robots in the paper's order, others behind."""
    return _ordered(names, list(ROBOTS))


def ordered_solvers(names: Iterable[str]) -> list[str]:
    """Put solvers in one order everywhere: neural first, then the paper's, then others."""
    return _ordered(names, list(SOLVERS))


def outcome_key(name: str) -> str:
    """Return the key of a class of grasp outcomes: ``Not Grasped`` is ``not_grasped``."""
    return str(name).strip().lower().replace(" ", "_").replace("-", "_")


def _ordered(names: Iterable[str], known: list[str]) -> list[str]:
    unique = sorted(set(names))
    return sorted(unique, key=lambda name: known.index(name) if name in known else len(known))
