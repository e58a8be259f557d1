"""The control socket of a run, which answers the verbs about it."""

from __future__ import annotations

import os

from launcher.control.logs import Logs
from launcher.control.server import Server
from launcher.control.service import Service
from launcher.posix import socket_directory
from launcher.posix.socket_directory import ControlError
from launcher.run.output.screen_filters import ScreenFilters
from launcher.run.part import Part, When

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.process import Process
    from launcher.run.run import Run


class ControlSocket(Part):
    """Opened when the first processes have been started."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._filters = ScreenFilters(run.all_processes.values(), run.log)
        self._logs = Logs(run)
        self._server: Server | None = None

    def begin(self) -> None:
        """Open it, then the parts that are clients of it; warns if there is no place for it."""
        run = self.run
        service = Service(run, self._filters, self._logs)
        try:
            self._server = Server(
                run.reactor,
                lambda: socket_directory.prepare(run.id, os.environ, os.getuid()),
                hello=service.hello,
                serve=service.serve,
                warn=run.log.warn,
            )
        except ControlError as error:
            run.log.warn(f"cannot open the control socket: {error.message}")
            return
        run.socket = str(self._server.path)
        run.parts.begin(When.SERVED)

    def adding(self, process: Process) -> None:
        self._filters.adopt(process)
        self._logs.subscribe()

    def close(self) -> None:
        if self._server is not None:
            self._server.close()
