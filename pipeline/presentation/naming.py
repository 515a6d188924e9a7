"""How robots, solvers, models and outcomes are called, and in which order they are shown."""

from __future__ import annotations

from collections.abc import Iterable

from pipeline.evaluation.config import row_name, solver_of_rows

ROBOTS = {
    "nicol": "NICOL",
    "nico": "NICO",
    "valkyrie": "Valkyrie",
    "panda": "Panda",
    "fetch": "Fetch",
    "ur5": "UR5",
    "iiwa": "iiwa",
}
SOLVERS = {
    "cycleik": "CycleIK",
    "cycleik_refined": "CycleIK refined",
    "null_space": "CycleIK null space",
    "null_space_refined": "CycleIK null space refined",
    "flow": "flow",
    "flow_refined": "flow refined",
    "iknet": "IKNet (ours)",
    "iknet_refined": "IKNet (ours) refined",
    "gan": "constrained GAN (ours)",
    "gan_refined": "constrained GAN (ours) refined",
    "node_ik": "NODE IK (ours)",
    "node_ik_refined": "NODE IK (ours) refined",
    "ikflow": "IKFlow",
    "eem": "EEM",
    "eem_refined": "EEM (ours) refined",
    "bio_ik": "BioIK",
    "trac_ik": "TRAC-IK",
    "lm": "LM, compiled",
    "lookup": "LM from a lookup",
    "pinocchio": "Pinocchio LM",
    "pinocchio_dls": "Pinocchio DLS",
    "placo": "placo",
    "placo_once": "placo, no restarts",
    "pytorch_kinematics": "PyTorch Kinematics",
    "optik": "OptIK",
    "pink": "Pink",
    "mink": "mink",
    "roboticstoolbox": "Robotics Toolbox",
    "ssik": "ssik",
    "frankik": "frankik",
    "eaik": "EAIK",
}
NEURAL = (
    "cycleik",
    "cycleik_refined",
    "null_space",
    "null_space_refined",
    "flow",
    "flow_refined",
    "iknet",
    "iknet_refined",
    "gan",
    "gan_refined",
    "node_ik",
    "node_ik_refined",
    "ikflow",
    "eem",
    "eem_refined",
)
MODELS = {"null_space_paper": "generator of the paper's authors"}  # where it is not the usual one
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
    solver, _, model = solver_of_rows(name).partition("@")
    if model:
        return f"{SOLVERS.get(solver, solver)}, {MODELS.get(model, model)}"
    return SOLVERS.get(solver, solver) + (", unpinned" if solver != name else "")


def ordered_robots(names: Iterable[str]) -> list[str]:
    """Put robots in the paper's order, others behind."""
    return _ordered(names, list(ROBOTS))


def ordered_solvers(names: Iterable[str]) -> list[str]:
    """Put solvers in one order everywhere: neural first, then the paper's, then others.

    One that was not pinned follows itself.
    """
    order = [name for solver in SOLVERS for name in (solver, row_name(solver, pinned=False))]
    return _ordered(names, order)


def outcome_key(name: str) -> str:
    """Return the key of a class of grasp outcomes: ``Not Grasped`` is ``not_grasped``."""
    return str(name).strip().lower().replace(" ", "_").replace("-", "_")


def _ordered(names: Iterable[str], known: list[str]) -> list[str]:
    unique = sorted(set(names))
    return sorted(unique, key=lambda name: known.index(name) if name in known else len(known))
