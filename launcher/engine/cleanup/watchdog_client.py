"""Our end of the watchdog, which ends all processes of the run if the launcher is killed."""

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
MOST_STARTS = 3  # then the run continues without one


class WatchdogProcess:
    """Starts the watchdog for a run. `pidfd` becomes readable if it is killed."""

    def __init__(self, run_id: str) -> None:
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "watchdog.py")
        theirs, self._line = os.pipe()
        nowhere = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
        try:
            self.pid = execute(
                (sys.executable, "-I", "-S", script, run_id),
                # No run id in its own environment: it must not find itself.
                env={k: v for k, v in os.environ.items() if k == "LD_LIBRARY_PATH"},
                streams=(theirs, nowhere, nowhere),
            )
            self.pidfd = os.pidfd_open(self.pid)
        except OSError:
            os.close(self._line)
            raise
        finally:
            os.close(nowhere)
            os.close(theirs)

    def close(self) -> None:
        """End it without killing anything, since the run has ended in order."""
        from launcher.engine.cleanup.watchdog import GOODBYE

        with contextlib.suppress(BrokenPipeError):  # it has been killed
            os.write(self._line, GOODBYE)
        os.close(self._line)
        if not _ends(self.pidfd, GOODBYE_S):  # it has been suspended
            os.kill(self.pid, signal.SIGKILL)
        reap(self.pidfd)
        os.close(self.pidfd)


def _ends(pidfd: int, patience_s: float) -> bool:
    poll = select.poll()
    poll.register(pidfd, select.POLLIN)
    return bool(poll.poll(patience_s * 1000))


class WatchdogClient:
    """Starts the watchdog of a run, and another one if it is killed."""

    def __init__(self, reactor: Reactor, run_id: str, log: RunLog) -> None:
        self._reactor = reactor
        self._run_id = run_id
        self._log = log
        self._process: WatchdogProcess | None = None
        self._started = 0

    @property
    def pids(self) -> frozenset[int]:
        """The running watchdog, if there is one."""
        return frozenset() if self._process is None else frozenset({self._process.pid})

    def ensure(self) -> None:
        """Start it, before the first process; it notices our death even while it starts."""
        if not self._started:
            self._start()

    def _start(self) -> None:
        self._started += 1
        try:
            self._process = WatchdogProcess(self._run_id)
        except OSError as error:
            self._log.warn(f"cannot start the watchdog: {error.strerror}")
            return
        self._reactor.add_reader(self._process.pidfd, self._died)

    def _died(self) -> None:
        self.close()
        is_restarted = self._started < MOST_STARTS
        if is_restarted:
            self._start()
        what = "restarting it" if is_restarted else "the run continues without one"
        self._log.warn(f"the watchdog was killed; {what}")

    def close(self) -> None:
        if self._process is not None:
            self._reactor.remove(self._process.pidfd)
            self._process.close()
            self._process = None
