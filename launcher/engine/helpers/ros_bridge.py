"""Starts the process that publishes the state of the run in ROS (launcher.ros.bridge).

It is not a process of the run: it does not affect the exit code, and the run does not wait for it.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from launcher.engine.cleanup import RUN_ID_VARIABLE
from launcher.engine.helpers.popen import last_line, wait_or_kill
from launcher.engine.monitor.housekeeping import Housekeeper
from launcher.engine.posix.reactor import Reactor, Timer

MAX_STARTS = 3  # then the run continues without one
RESTART_DELAY_S = 1.0
GOODBYE_S = 4.0  # a bridge that does not exit with the run is killed after this


class BridgeProcess:
    """The bridge of the run with this socket, restarted if it exits.

    The housekeeper frees its shared memory if it is killed. `keep` lets it outlive a
    killed launcher, to exit by itself.
    """

    def __init__(
        self,
        reactor: Reactor,
        socket_path: Path,
        env: Mapping[str, str],
        warn: Callable[[str], None],
        housekeeper: Housekeeper,
        keep: Callable[[int], None],
    ) -> None:
        self._reactor = reactor
        self._socket_path = socket_path
        # Without the run id: it exits by itself when we do.
        self._env = {name: value for name, value in env.items() if name != RUN_ID_VARIABLE}
        self._warn = warn
        self._housekeeper = housekeeper
        self._keep = keep
        self._started = 0
        self._started_s = 0.0
        self._process: subprocess.Popen[bytes] | None = None
        self._pidfd = self._errors = -1
        self._timer: Timer | None = None

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        self._timer = None
        self._started += 1
        self._started_s = self._reactor.now()
        self._errors = os.memfd_create("bridge-errors", os.MFD_CLOEXEC)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "launcher.ros.bridge", str(self._socket_path)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=self._errors,
                env=self._env,
                start_new_session=True,
            )
        except OSError as error:
            os.close(self._errors)
            self._warn(f"this run is not visible in ROS: cannot start its bridge: {error.strerror}")
            return
        self._keep(self._process.pid)
        self._housekeeper.add_helper(self._process.pid)
        self._pidfd = os.pidfd_open(self._process.pid)
        self._reactor.add_reader(self._pidfd, self._exited)

    def _exited(self) -> None:
        assert self._process is not None
        code = self._process.wait()
        if code:
            self._housekeeper.died(code, self._reactor.now() - self._started_s)
        line = last_line(self._errors)
        reason = f": {line}" if line else ""
        self._release()
        is_restarted = self._started < MAX_STARTS
        what = "restarting it" if is_restarted else "the run continues without it"
        how = f"exit code {code}" if code >= 0 else f"signal {-code}"
        self._warn(f"the ROS bridge died ({how}){reason}; {what}")
        if is_restarted:
            self._timer = self._reactor.call_later(RESTART_DELAY_S, self.start)

    def close(self) -> None:
        """Let it publish the end of the run, and wait for its exit."""
        if self._timer is not None:
            self._timer.cancel()
        if self._process is None:
            return
        assert self._process.stdin is not None
        self._process.stdin.close()
        if wait_or_kill(self._process, GOODBYE_S) is None:
            self._housekeeper.died(-signal.SIGKILL, self._reactor.now() - self._started_s)
        self._release()

    def _release(self) -> None:
        assert self._process is not None and self._process.stdin is not None
        self._reactor.remove(self._pidfd)
        self._process.stdin.close()
        os.close(self._pidfd)
        os.close(self._errors)
        self._pidfd = self._errors = -1
        self._process = None
