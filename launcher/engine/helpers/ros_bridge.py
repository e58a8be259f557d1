"""BridgeProcess: our end of the bridge, the process that shows the run to ROS (graph/bridge.py).

It is no process of the run: it has no part in the exit code, and does not keep the run alive.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from launcher.engine.cleanup.sweep import RUN_ID_VARIABLE
from launcher.engine.monitor.housekeeping import Housekeeper
from launcher.engine.posix.reactor import Reactor, Timer

MOST = 3  # how often it is started before the run goes on without one
REST_S = 1.0
GOODBYE_S = 4.0  # a bridge that does not end with the run is killed after this


class BridgeProcess:
    """Keeps the bridge of the run with this socket at work; `warn` says what goes wrong.

    The caretaker frees the shared memory of one that is killed.
    """

    def __init__(
        self,
        reactor: Reactor,
        socket_path: Path,
        env: Mapping[str, str],
        warn: Callable[[str], None],
        caretaker: Housekeeper,
    ) -> None:
        self._reactor = reactor
        self._socket_path = socket_path
        # Not what the run has to clean up: it ends by itself when we do.
        self._env = {name: value for name, value in env.items() if name != RUN_ID_VARIABLE}
        self._warn = warn
        self._caretaker = caretaker
        self._started = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._pidfd = self._errors = -1
        self._timer: Timer | None = None

    @property
    def pid(self) -> int | None:
        """The bridge's pid, while it is at work."""
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start it."""
        self._timer = None
        self._started += 1
        self._errors = os.memfd_create("bridge-errors", os.MFD_CLOEXEC)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "launcher.graph.bridge", str(self._socket_path)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=self._errors,
                env=self._env,
                start_new_session=True,
            )
        except OSError as error:
            os.close(self._errors)
            self._warn(f"ROS does not see this run, its bridge cannot start: {error.strerror}")
            return
        self._caretaker.attend(self._process.pid)
        self._pidfd = os.pidfd_open(self._process.pid)
        self._reactor.add_reader(self._pidfd, self._died)

    def _died(self) -> None:
        assert self._process is not None
        code = self._process.wait()
        if code < 0:
            self._caretaker.died_by_signal()
        reason = f": {self._last_words()}" if self._last_words() else ""
        self._let_go()
        starts_anew = self._started < MOST
        what = "it is started again" if starts_anew else "the run goes on without it"
        how = f"exit code {code}" if code >= 0 else f"signal {-code}"
        self._warn(f"the ROS bridge died ({how}){reason}; {what}")
        if starts_anew:
            self._timer = self._reactor.call_later(REST_S, self.start)

    def _last_words(self) -> str:
        size = os.fstat(self._errors).st_size
        text = os.pread(self._errors, 1000, max(0, size - 1000)).decode(errors="replace")
        lines = text.strip().splitlines()
        return lines[-1] if lines else ""

    def close(self) -> None:
        """Let it tell the end of the run, and wait for its own."""
        if self._timer is not None:
            self._timer.cancel()
        if self._process is None:
            return
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(GOODBYE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._let_go()

    def _let_go(self) -> None:
        assert self._process is not None and self._process.stdin is not None
        self._reactor.remove(self._pidfd)
        self._process.stdin.close()
        os.close(self._pidfd)
        os.close(self._errors)
        self._pidfd = self._errors = -1
        self._process = None
