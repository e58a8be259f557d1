"""Starts the watchdog, which kills all processes of the run if the launcher is killed."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys

from launcher.engine.logs.run_log import RunLog
from launcher.engine.posix.reactor import Reactor
from launcher.engine.posix.spawn import execute, reap

GOODBYE_S = 1.0  # a watchdog that does not end within this time is killed
MAX_STARTS = 3  # then the run continues without one


class WatchdogClient:
    """Starts the watchdog of a run, and another one if it is killed."""

    def __init__(self, reactor: Reactor, run_id: str, log: RunLog) -> None:
        self._reactor = reactor
        self._run_id = run_id
        self._log = log
        self._started = 0
        self._pid = self._pidfd = self._pipe = -1

    @property
    def pids(self) -> frozenset[int]:
        """The running watchdog, if there is one."""
        return frozenset({self._pid}) if self._pid > 0 else frozenset()

    def ensure(self) -> None:
        """Start it before the first process; it works even if we are killed while it starts."""
        if not self._started:
            self._start()

    def _start(self) -> None:
        self._started += 1
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "watchdog.py")
        theirs, self._pipe = os.pipe()
        null = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
        try:
            self._pid = execute(
                (sys.executable, "-I", "-S", script, self._run_id),
                # No run id in its own environment: it must not find itself.
                env={k: v for k, v in os.environ.items() if k == "LD_LIBRARY_PATH"},
                streams=(theirs, null, null),
            )
            self._pidfd = os.pidfd_open(self._pid)
            self._reactor.add_reader(self._pidfd, self._exited)
        except OSError as error:
            os.close(self._pipe)
            self._pid = -1
            self._log.warn(f"cannot start the watchdog: {error.strerror}")
        finally:
            os.close(null)
            os.close(theirs)

    def _exited(self) -> None:
        self.close()
        is_restarted = self._started < MAX_STARTS
        if is_restarted:
            self._start()
        what = "restarting it" if is_restarted else "the run continues without one"
        self._log.warn(f"the watchdog was killed; {what}")

    def close(self) -> None:
        """Stop it in an orderly way, so that it kills nothing."""
        if self._pid < 0:
            return
        from launcher.engine.cleanup.watchdog import GOODBYE

        self._reactor.remove(self._pidfd)
        with contextlib.suppress(BrokenPipeError):  # it has been killed
            os.write(self._pipe, GOODBYE)
        os.close(self._pipe)
        poll = select.poll()
        poll.register(self._pidfd, select.POLLIN)
        if not poll.poll(GOODBYE_S * 1000):  # it has been suspended
            os.kill(self._pid, signal.SIGKILL)
        reap(self._pidfd)
        os.close(self._pidfd)
        self._pid = -1
