"""Guard: our end of the watchdog. As long as it is open, a killed launcher leaves nothing."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys

from launcher.engine.logs.run_log import RunLog
from launcher.engine.posix.reactor import Reactor
from launcher.engine.posix.spawn import execute, reap

GOODBYE_S = 1.0  # a watchdog that does not go within this time is killed
MOST = 3  # how many watchdogs a run starts before it goes on without one


class WatchdogProcess:
    """Starts the watchdog for a run; `close()` says goodbye to it and waits for its end.

    `pidfd` becomes readable when somebody ends it; the run is not guarded any more then.
    """

    def __init__(self, run_id: str) -> None:
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "watchdog.py")
        theirs, self._line = os.pipe()
        nowhere = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
        try:
            self.pid = execute(
                (sys.executable, "-I", "-S", script, run_id),
                # No run id in its own environment: it must not find itself.
                env={k: v for k, v in os.environ.items() if k == "LD_LIBRARY_PATH"},
                stdin=theirs,
                stdout=nowhere,
                stderr=nowhere,
            )
            self.pidfd = os.pidfd_open(self.pid)
        except OSError:
            os.close(self._line)
            raise
        finally:
            os.close(nowhere)
            os.close(theirs)

    def close(self) -> None:
        """The run ended in order: nothing is to be killed."""
        from launcher.engine.cleanup.watchdog import GOODBYE

        # Somebody may have killed the watchdog; then there is nothing to say goodbye to.
        with contextlib.suppress(BrokenPipeError):
            os.write(self._line, GOODBYE)
        os.close(self._line)
        if not _ends(self.pidfd, GOODBYE_S):  # somebody has stopped it
            os.kill(self.pid, signal.SIGKILL)
        reap(self.pidfd)
        os.close(self.pidfd)


def _ends(pidfd: int, patience_s: float) -> bool:
    """Whether the process ends within so many seconds."""
    poll = select.poll()
    poll.register(pidfd, select.POLLIN)
    return bool(poll.poll(patience_s * 1000))


class WatchdogClient:
    """Keeps one watchdog at work, and starts another one where somebody ends it."""

    def __init__(self, reactor: Reactor, run_id: str, log: RunLog) -> None:
        self._reactor = reactor
        self._run_id = run_id
        self._log = log
        self._process: WatchdogProcess | None = None
        self._started = 0

    @property
    def pids(self) -> frozenset[int]:
        """The watchdog that is at work, if one is."""
        return frozenset() if self._process is None else frozenset({self._process.pid})

    def ensure(self) -> None:
        """Before the first process: if we die now, the watchdog finds that out when it is up."""
        if not self._started:
            self._start()

    def _start(self) -> None:
        self._started += 1
        try:
            self._process = WatchdogProcess(self._run_id)
        except OSError as error:
            self._log.warn(f"this run is not guarded, the watchdog cannot start: {error.strerror}")
            return
        self._reactor.add_reader(self._process.pidfd, self._died)

    def _died(self) -> None:
        self.close()
        starts_anew = self._started < MOST
        if starts_anew:
            self._start()
        what = "another one is started" if starts_anew else "this run goes on without one"
        self._log.warn(f"somebody ended the watchdog; {what}")

    def close(self) -> None:
        """Say goodbye to the watchdog."""
        if self._process is not None:
            self._reactor.remove(self._process.pidfd)
            self._process.close()
            self._process = None
