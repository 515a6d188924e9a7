"""The outcome of one grasp trial: its report, the class that follows from it, and its numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pipeline.planning.motion import Motion

SUCCESS, SLIPPED, NOT_GRASPED = "Success", "Slipped", "Not Grasped"
DETECTION, LANGUAGE = "Detection", "LLM"  # classes of the paper that need perception and an agent
CLASSES = (SUCCESS, SLIPPED, NOT_GRASPED, DETECTION, LANGUAGE)

PUSHED_AWAY = (
    0.03  # m that an object moved before the fingers closed, to be the reason of a failure
)
FALLEN = 1.0  # m of such a way that only a fall from the table explains
NOT_CLOSED = 0.02  # share of a finger joint's range below which the hand did not close at all


@dataclass(frozen=True)
class ActionResult:
    """The result of an action.

    Attributes:
        done: Whether it succeeded.
        words: What happened, or why it failed.
    """

    done: bool
    words: str


@dataclass
class GraspReport:
    """What happened in one attempt, from the simulator's state.

    Attributes:
        motions: Planned motions by name, as they were followed.
        reach_error: Tip error of the best top grasp [m].
        pushed: Way the object moved before the fingers closed [m].
        tracking_error: Distance of the tip from where it was to be when it had arrived [m].
        touching: Links of the hand on the object after closing, after the lift, after the carry.
        closing_s: Time the fingers took to stall [s].
        closing_share: Way of the joint that closed farthest, as a share of its range.
        lifted: Whether the object was off the table and in the hand after the lift, or at some time
            of a motion that lifts and deposits in one.
        kept: Whether it was still in the hand over the bin.
        released: Whether the hand was opened over the bin.
        clinging: Whether it stuck to the open hand all the same.
        bin: Bin that it lies in at the end.
        swung: Motions whose path could not be followed: the joints moved straight.
        stopped: Why the attempt ended early; empty if it did not.
    """

    motions: dict[str, Motion] = field(default_factory=dict)
    reach_error: float = np.nan
    pushed: float = np.nan
    tracking_error: float = np.nan
    touching: list[int] = field(default_factory=list)
    closing_s: float = np.nan
    closing_share: float = np.nan
    lifted: bool = False
    kept: bool = False
    released: bool = False
    clinging: bool = False
    bin: str | None = None
    swung: list[str] = field(default_factory=list)
    stopped: str = ""


def classify(report: GraspReport) -> tuple[str, str]:
    """Class of the paper (section IV-C) and the reason in words.

    Returns:
        `Success`: lifted and in a bin. `Slipped`: lifted, but lost on the way. `Not Grasped`:
        not lifted.
    """
    if report.lifted:
        if report.bin is not None:
            return SUCCESS, f"in the {report.bin} bin"
        if report.stopped:
            return SLIPPED, report.stopped
        if report.clinging:
            return SLIPPED, "stuck to the open hand"
        return SLIPPED, "beside the bin" if report.kept else "lost on the way to the bin"
    if report.stopped:
        return NOT_GRASPED, report.stopped
    if report.closing_share < NOT_CLOSED:
        return NOT_GRASPED, "the hand did not close"
    if report.pushed > FALLEN:
        return NOT_GRASPED, "fell from the table before the fingers closed"
    if report.pushed > PUSHED_AWAY:
        return NOT_GRASPED, f"moved {1e3 * report.pushed:.0f} mm before the fingers closed"
    if report.touching and report.touching[0] == 0:
        return NOT_GRASPED, "the fingers closed on nothing"
    return NOT_GRASPED, "left behind by the lift"


def measures(report: GraspReport) -> dict[str, Any]:
    """Numbers of a report as columns; a motion that was not made has NaN."""
    touching = [*report.touching, 0, 0, 0][:3]
    columns: dict[str, Any] = {
        "lifted": report.lifted,
        "bin": report.bin or "",
        "swung": ",".join(report.swung),
        "reach_error_mm": 1e3 * report.reach_error,
        "pushed_mm": 1e3 * report.pushed,
        "tracking_error_mm": 1e3 * report.tracking_error,
        "closing_s": report.closing_s,
        "closing_share": report.closing_share,
        "contacts_closed": touching[0],
        "contacts_lifted": touching[1],
        "contacts_carried": touching[2],
    }
    for name in ("approach", "lift", "transfer", "deposit", "homeward"):
        motion = report.motions.get(name)
        columns[f"{name}_plan_ms"] = np.nan if motion is None else 1e3 * motion.time_s
        columns[f"{name}_tip_error_mm"] = (
            np.nan if motion is None else float(motion.tip_error_mm.max())
        )
        columns[f"{name}_flips"] = -1 if motion is None else motion.flips
    return columns
