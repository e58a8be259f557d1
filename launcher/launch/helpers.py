"""The control socket, the ROS bridge, the flight recorder, the page and the console of a run."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping

from launcher import __version__
from launcher.base.model.options import RunOptions
from launcher.control.server import Server
from launcher.control.service import Identity, open_control
from launcher.launch.target import LaunchRequest
from launcher.output.stdout import StdoutWriter
from launcher.posix.reactor import Reactor
from launcher.run.supervisor import Supervisor

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.helpers.client_process import ClientProcess
    from launcher.run.helpers.console import ConsoleProcess
    from launcher.run.helpers.flight_recorder import FlightRecorder
    from launcher.run.helpers.web_page import WebPage

BRIDGE_GOODBYE_S = 4.0  # a bridge that does not exit with the run is killed after this
CONSOLE_DELAY_S = 0.3  # leaves the processor to processes that are starting


class Helpers:
    """Opened when the first processes have been started, closed at the end of the run."""

    def __init__(
        self,
        supervisor: Supervisor,
        *,
        reactor: Reactor,
        screen: StdoutWriter,
        options: RunOptions,
        environment: Mapping[str, str],
    ) -> None:
        self._supervisor = supervisor
        self._reactor = reactor
        self._screen = screen
        self._options = options
        self._environment = environment
        log = supervisor.control.log.log
        self._warn = functools.partial(log, "WARNING", "launch")
        self._server: Server | None = None
        self._bridge: ClientProcess | None = None
        self._recorder: FlightRecorder | None = None
        self._page: WebPage | None = None
        self._console: ConsoleProcess | None = None

    def open(self, request: LaunchRequest, *, run_id: str, started: float) -> None:
        """Open the socket, then the bridge and the console if the options request them."""
        identity = Identity(
            run_id=run_id,
            launcher=__version__,
            target=str(request.path),
            arguments=tuple(f"{name}:={value}" for name, value in request.arguments),
            started=started,
            environment=self._environment,
        )
        self._server = open_control(self._supervisor.control, identity)
        if self._server is None:
            return
        if self._options.ros:
            self._open_bridge(self._server)
        if self._options.record is not None:
            self._open_recorder(self._server)
        self._supervisor.control.open_page = self._open_page
        if self._options.web:
            self._open_page()
        if self._options.console and self._screen.is_tty and os.isatty(0):
            self._reactor.call_later(CONSOLE_DELAY_S, self._open_console)

    def _open_bridge(self, server: Server) -> None:
        from launcher.run.helpers.client_process import ClientProcess

        control = self._supervisor.control
        self._bridge = ClientProcess(
            self._reactor,
            ("launcher.ros.helpers.bridge", str(server.path)),
            dict(self._environment),
            self._warn,
            control.housekeeper,
            control.keep,
            name="the ROS bridge",
            without="this run is not visible in ROS",
            goodbye_s=BRIDGE_GOODBYE_S,
        )
        self._bridge.start()

    def _open_recorder(self, server: Server) -> None:
        from launcher.launch.recording import settings_of
        from launcher.run.helpers.flight_recorder import FlightRecorder

        control = self._supervisor.control
        self._recorder = control.recorder = FlightRecorder(
            self._reactor,
            settings_of(self._options, control.log_dir, str(server.path)),
            dict(self._environment),
            control.log,
            control.housekeeper,
            control.keep,
        )
        self._recorder.start()

    def _open_page(self) -> WebPage:
        """The server of the page, started if it is not running; UsageError."""
        from launcher.run.helpers.web_page import WebPage
        from launcher.web.option import require_page, settings_of

        if self._page is not None and self._page.pid is not None:
            return self._page
        require_page("the page")
        assert self._server is not None
        control = self._supervisor.control
        self._page = WebPage(
            self._reactor,
            settings_of(self._options, str(self._server.path)),
            dict(self._environment),
            control.log,
            control.housekeeper,
            control.keep,
            show=lambda text: self._screen.log("INFO", "launch", text),
        )
        self._page.start()
        return self._page

    def _open_console(self) -> None:
        from launcher.run.helpers.console import ConsoleProcess

        keep = self._supervisor.control.keep
        self._console = ConsoleProcess(self._reactor, self._screen, self._warn, keep)
        self._console.start()

    def close(self) -> None:
        """Close the console first, so that it shows the end of the run."""
        if self._console is not None:
            self._console.close()
        if self._bridge is not None:
            self._bridge.close()
        if self._recorder is not None:
            self._recorder.close()
        if self._server is not None:
            self._server.close()
        if self._page is not None:  # its server has been told the last lines
            self._page.close()
        self._supervisor.control.housekeeper.release()
