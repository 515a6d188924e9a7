"""The page of a session: server, picture and panel together."""

from __future__ import annotations

from typing import Any

from pipeline.planning.benchmark import Pair
from pipeline.presentation.naming import robot_title
from pipeline.viewing.config import ViewConfig
from pipeline.viewing.inbox import Inbox
from pipeline.viewing.loop import run_until_interrupted
from pipeline.viewing.panel import Panel
from pipeline.viewing.scene import SessionScene
from pipeline.viewing.server import announce, serve, stop
from pipeline.viewing.session import Session, Snapshot


class Page:
    """A session in a browser.

    Attributes:
        server: `viser.ViserServer`.
        inbox: What the user wants done.
    """

    def __init__(
        self, session: Session, config: ViewConfig, pairs: list[Pair], workspace_filter: bool
    ) -> None:
        """Serve a session.

        Args:
            session: What is shown.
            config: Where, and how.
            pairs: Starts and targets of the planner benchmark.
            workspace_filter: Whether random targets lie in the box that networks are trained for.

        Raises:
            ViewError: viser is missing, or the port is taken.
            UrdfError: A shape of the robot cannot be used.
        """
        self._session, self._config = session, config
        self.inbox = Inbox()
        self.server: Any = serve(config, robot_title(session.robot.name))
        try:
            self._scene = SessionScene(self.server, session, self.inbox, config.opacity)
            self._panel = Panel(
                self.server, session, self._scene, self.inbox, pairs, workspace_filter
            )
        except BaseException:
            self.close()
            raise
        session.show = self.show
        self.show(session.snapshot)

    def show(self, snapshot: Snapshot) -> None:
        """Draw and write what is to be seen now."""
        with self.server.atomic():
            self._scene.show(snapshot)
            self._panel.show(snapshot)

    def run(self) -> None:
        """Say where the page is, and go on until Ctrl-C."""
        announce(self.server, self._config)
        session, rate = self._session, self._config.rate
        run_until_interrupted(self.inbox, session.player, rate, session.say)

    def close(self) -> None:
        """Stop serving."""
        stop(self.server)
