"""The panel of a session beside the picture: table, sliders and buttons, by viser."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.planning.benchmark import Pair
from pipeline.presentation.naming import ordered_solvers, solver_title
from pipeline.viewing.inbox import Inbox
from pipeline.viewing.playback import SLIDING_S, Playback
from pipeline.viewing.scene import SessionScene
from pipeline.viewing.session import Session, Snapshot
from pipeline.viewing.table import answers_html, sentence_html

Array = NDArray[np.float64]
SLIDER_STEP = 0.001  # rad or m


class Panel:
    """What a session says in numbers, and what a user may want of it."""

    def __init__(
        self,
        server: Any,
        session: Session,
        scene: SessionScene,
        inbox: Inbox,
        pairs: list[Pair],
        workspace_filter: bool,
    ) -> None:
        """Make the panel.

        Args:
            server: `viser.ViserServer`.
            session: What is shown.
            scene: Its picture, some of which can be hidden.
            inbox: Receives what the user wants.
            pairs: Starts and targets of the planner benchmark.
            workspace_filter: Whether random targets lie in the box that networks are trained for.
        """
        self._session, self._scene, self._inbox = session, scene, inbox
        self._workspace_filter = workspace_filter
        self._slid = 0.0
        gui = server.gui
        self._table = gui.add_html("")
        self._sentence = gui.add_html(sentence_html(""))
        self._add_target(gui)
        self._add_shown(gui)
        self._add_motions(gui, pairs)
        self._add_joints(gui)

    def show(self, snapshot: Snapshot) -> None:
        """Write what is to be seen now."""
        self._table.content = answers_html(snapshot.answers, self._session.main)
        self._sentence.content = sentence_html(snapshot.message)
        self._playback.show()
        if time.monotonic() - self._slid > SLIDING_S:
            for slider, value in zip(self._sliders, snapshot.joints, strict=True):
                inside = float(np.clip(value, slider.min, slider.max))
                if abs(slider.value - inside) > SLIDER_STEP / 2:
                    slider.value = inside

    def _button(self, gui: Any, label: str, action: Callable[[], object], hint: str) -> None:
        def pressed(event: Any) -> None:
            self._inbox.post(label, action)

        gui.add_button(label, hint=hint).on_click(pressed)

    def _add_target(self, gui: Any) -> None:
        session = self._session
        with gui.add_folder("Target"):
            wanted = {
                "Home": session.home,
                "Random": lambda: session.random_target(self._workspace_filter),
            }
            buttons = gui.add_button_group(
                "Go to", tuple(wanted), hint="or drag the arrows and arcs in the picture"
            )
            guided = gui.add_checkbox(
                "From last answer", True, hint="where solvers start; without, they get no guess"
            )

            def chosen(event: Any) -> None:
                self._inbox.post("target", wanted[buttons.value])

            buttons.on_click(chosen)

            def toggled(event: Any) -> None:
                self._inbox.post("guided", lambda: session.guide(guided.value))

            guided.on_update(toggled)

    def _add_shown(self, gui: Any) -> None:
        session, scene = self._session, self._scene
        with gui.add_folder("Shown", expand_by_default=False):
            for name in ordered_solvers(scene.wanted):
                if name != session.main:
                    self._add_ghost(gui, name)
            shapes = gui.add_checkbox("Collision shapes", False)

            def changed(event: Any) -> None:
                self._inbox.post("shapes", lambda: self._show_collisions(shapes.value))

            shapes.on_update(changed)

    def _add_ghost(self, gui: Any, name: str) -> None:
        box = gui.add_checkbox(solver_title(name), True)

        def change() -> None:
            self._scene.wanted[name] = box.value
            self._scene.show(self._session.snapshot)

        def clicked(event: Any) -> None:
            self._inbox.post(f"ghost {name}", change)

        box.on_update(clicked)

    def _show_collisions(self, wanted: bool) -> None:
        self._scene.show_collisions(wanted)
        self._scene.show(self._session.snapshot)

    def _add_motions(self, gui: Any, pairs: list[Pair]) -> None:
        session = self._session
        with gui.add_folder("Motions"):
            self._button(
                gui,
                "Play the null space",
                session.play_null_space,
                "other configurations with the same pose; again takes another direction",
            )
            self._button(gui, "Start here", session.take_start, "of the motion that is planned")
            self._button(
                gui,
                "Plan to the target",
                session.plan_to_target,
                "from that start, by the solid robot",
            )
            if pairs:
                self._add_pairs(gui, pairs)
            self._playback = Playback(gui, session.player, self._inbox)

    def _add_pairs(self, gui: Any, pairs: list[Pair]) -> None:
        session = self._session
        number = gui.add_number("Pair", 0, min=0, max=len(pairs) - 1, step=1)
        self._button(
            gui,
            "Plan the pair",
            lambda: session.plan_pair(
                pairs[int(number.value)], f"pair {int(number.value)} by {session.main}"
            ),
            "of the planner benchmark: python -m pipeline plan",
        )

    def _ends(self) -> list[tuple[float, float]]:
        """Joint limits rounded inwards to the sliders' step."""
        robot = self._session.robot
        low = np.ceil(robot.lower / SLIDER_STEP) * SLIDER_STEP
        high = np.floor(robot.upper / SLIDER_STEP) * SLIDER_STEP
        return [
            (round(a, 3), round(b, 3)) for a, b in zip(low.tolist(), high.tolist(), strict=True)
        ]

    def _add_joints(self, gui: Any) -> None:
        session, robot = self._session, self._session.robot
        with gui.add_folder("Joints"):
            self._sliders = [
                gui.add_slider(name, low, high, SLIDER_STEP, float(np.clip(at, low, high)))
                for name, (low, high), at in zip(
                    robot.joint_names, self._ends(), robot.home, strict=True
                )
            ]

        def move() -> None:
            session.move_joints(np.array([slider.value for slider in self._sliders]))

        def slid(event: Any) -> None:
            if event.client is not None:  # not one of our own
                self._slid = time.monotonic()
                self._inbox.post("target", move)

        for slider in self._sliders:
            slider.on_update(slid)
