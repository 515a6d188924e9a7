"""What is shown while a target is dragged, joints are slid and motions play; no viser here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.planning.benchmark import Pair, plan_by_rule
from pipeline.planning.config import PlanConfig
from pipeline.viewing.clip import Clip, Player, clip_of_motion, clip_of_path
from pipeline.viewing.comparison import Answer, Comparison, colliding_links
from pipeline.viewing.errors import ViewError
from pipeline.viewing.null_space import self_motion

if TYPE_CHECKING:
    from baselines import Solver

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Snapshot:
    """What is to be seen now.

    Attributes:
        target: Pose of the tip that is wanted, base frame [m, quaternion w x y z], shape (7,).
        joints: Of the solid robot [rad or m], shape (dof,).
        colliding: Links of the solid robot that touch others that they should not.
        answers: What each solver says to the target, by its name.
        ghosts: Whether the other solvers' answers are to be seen.
        path: Places of the tip on the motion that plays, base frame [m], shape (S, 3).
        clip: Name of what plays; empty where nothing does.
        message: A sentence for the user.
    """

    target: Array
    joints: Array
    colliding: frozenset[str]
    answers: Mapping[str, Answer]
    ghosts: bool
    path: Array
    clip: str
    message: str


class Session:
    """A robot, solvers that answer a target, and motions that play.

    Attributes:
        robot: The robot.
        comparison: The solvers.
        main: Name of the solver whose answer the solid robot shows.
        player: Where in the motion we are.
        snapshot: What is to be seen now.
        start: Joints from which the next motion is planned [rad or m], shape (dof,).
        show: Called with every new snapshot.
    """

    def __init__(
        self, comparison: Comparison, main: str, plan: PlanConfig, self_motion_step: float
    ) -> None:
        """Begin at home.

        Args:
            comparison: The solvers.
            main: Name of one of them.
            plan: Rule and timing of motions.
            self_motion_step: Length of a step through the null space [rad or m].
        """
        self.comparison, self.robot, self.main = comparison, comparison.robot, main
        self.show: Callable[[Snapshot], object] = lambda snapshot: None
        self.player = Player(self._play)
        self.start: Array = self.robot.home.copy()
        self._plan, self._step = plan, self_motion_step
        self._clip: Clip | None = None
        self._seed = 0
        self.snapshot = self._at_rest(self.robot.home, "")

    @property
    def solver(self) -> Solver:
        """The solver of the solid robot."""
        return self.comparison.solvers[self.main]

    def move_target(self, pose: Array) -> None:
        """Let all solvers answer another target (7,), base frame; the solid robot follows one."""
        self._end_clip()
        answers = self.comparison.answers(pose)
        main = answers[self.main]
        self._shown(
            replace(
                self.snapshot,
                target=pose,
                joints=main.joints,
                colliding=main.colliding,
                answers=answers,
                ghosts=True,
                message="",
            )
        )

    def move_joints(self, joints: Array) -> None:
        """Put the solid robot at joints (dof,); the target moves with its tip."""
        self._end_clip()
        self._shown(self._at_rest(joints, ""))

    def home(self) -> None:
        """Go to the idle configuration; every solver starts from there again."""
        self.comparison.restart(self.robot.home)
        self.move_joints(self.robot.home)

    def guide(self, wanted: bool) -> None:
        """Let solvers start from their last answers, or without a guess; all answer again."""
        self.comparison.guided = wanted
        self.move_target(self.snapshot.target)

    def random_target(self, workspace_filter: bool) -> None:
        """Take the pose of a random collision-free configuration; another one every time.

        Args:
            workspace_filter: Whether it lies in the box that networks are trained for.
        """
        self._seed += 1
        joints = self.robot.sample(1, seed=self._seed, workspace_filter=workspace_filter)
        self.move_target(self.robot.forward_kinematics(joints)[0])

    def take_start(self) -> None:
        """Remember where the solid robot stands as the start of the next motion."""
        self.start = self.snapshot.joints.copy()
        self.say("The start is taken: move the target, then plan.")

    def plan_to_target(self) -> None:
        """Plan from the start to the target with the solid robot's solver, and play it."""
        self.plan_pair(Pair(self.start, self.snapshot.target), f"motion by {self.main}")

    def plan_pair(self, pair: Pair, name: str) -> None:
        """Plan a motion with the rule of conf/plan, and play it.

        Args:
            pair: Start and target.
            name: What it is called.
        """
        motion = plan_by_rule(self.robot, self.solver, pair, self._plan.motion, None)
        timing = self._plan.timing
        self.play(clip_of_motion(name, motion, self.robot.velocity_limit, timing), ghosts=False)

    def play_null_space(self) -> None:
        """Move the solid robot through other configurations with the same pose, and back."""
        self._seed += 1
        joints = self.snapshot.joints
        path = self_motion(self.robot, joints, self._step, self._seed)
        if len(path) < 2:
            raise ViewError("every direction of the null space leads beyond a joint limit here")
        moved = np.abs(path - joints).max()
        note = f"same pose, joints move by up to {moved:.2f} rad or m"
        clip = clip_of_path("null space", note, path, self.robot.velocity_limit, self._plan.timing)
        self.play(clip, ghosts=False)

    def play(self, clip: Clip, ghosts: bool) -> None:
        """Play a clip over and over until something else is wanted.

        Args:
            clip: What to play.
            ghosts: Whether the other solvers' answers stay.
        """
        self._clip = clip
        self.snapshot = replace(
            self.snapshot, ghosts=ghosts, path=clip.path, clip=clip.name, message=clip.note
        )
        self.player.load(clip.duration)

    def say(self, sentence: str) -> None:
        """Show a sentence; all else stays."""
        self._shown(replace(self.snapshot, message=sentence))

    def _play(self) -> None:
        if self._clip is None:
            return
        joints = self._clip.at(self.player.time)
        colliding = colliding_links(self.robot, joints)
        self._shown(replace(self.snapshot, joints=joints, colliding=colliding))

    def _end_clip(self) -> None:
        self._clip = None
        self.player.stop()

    def _at_rest(self, joints: Array, message: str) -> Snapshot:
        """The solid robot at joints, the target at its tip, and what the solvers say to that."""
        target = self.robot.forward_kinematics(joints)[0]
        return Snapshot(
            target=target,
            joints=joints,
            colliding=colliding_links(self.robot, joints),
            answers=self.comparison.answers(target),
            ghosts=True,
            path=np.empty((0, 3)),
            clip="",
            message=message,
        )

    def _shown(self, snapshot: Snapshot) -> None:
        if self._clip is None:
            snapshot = replace(snapshot, clip="", path=np.empty((0, 3)))
        self.snapshot = snapshot
        self.show(snapshot)
