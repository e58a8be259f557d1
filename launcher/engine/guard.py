"""Guard: our end of the watchdog. As long as it is open, a killed launcher leaves nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from launcher.engine.reactor import Reactor
from launcher.engine.watchdog import GOODBYE

GOODBYE_S = 1.0  # a watchdog that does not go within this time is killed
MOST = 3  # how many watchdogs a run starts before it goes on without one


class Guard:
    """Starts the watchdog for a run; `close()` says goodbye to it and waits for its end.

    `pidfd` becomes readable when somebody ends it; the run is not guarded any more then.
    """

    def __init__(self, run_id: str) -> None:
        script = Path(__file__).with_name("watchdog.py")
        # No run id in its own environment: it must not find itself.
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", str(script), run_id],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={k: v for k, v in os.environ.items() if k == "LD_LIBRARY_PATH"},
            cwd="/",
            start_new_session=True,
            bufsize=0,
        )
        self.pidfd = os.pidfd_open(self._process.pid)

    @property
    def pid(self) -> int:
        """The watchdog's pid."""
        return self._process.pid

    def close(self) -> None:
        """The run ended in order: nothing is to be killed."""
        assert self._process.stdin is not None
        try:
            os.write(self._process.stdin.fileno(), GOODBYE)
        except BrokenPipeError:
            pass  # somebody killed the watchdog; there is nothing to say goodbye to
        finally:
            self._process.stdin.close()
        try:
            self._process.wait(GOODBYE_S)
        except subprocess.TimeoutExpired:  # somebody has stopped it
            self._process.kill()
            self._process.wait()
        os.close(self.pidfd)


class Guards:
    """Keeps one watchdog at work, and starts another one where somebody ends it."""

    def __init__(self, reactor: Reactor, run_id: str, warn: Callable[[str], None]) -> None:
        self._reactor = reactor
        self._run_id = run_id
        self._warn = warn
        self._guard: Guard | None = None
        self._started = 0

    @property
    def pids(self) -> frozenset[int]:
        """The watchdog that is at work, if one is."""
        return frozenset() if self._guard is None else frozenset({self._guard.pid})

    def ensure(self) -> None:
        """Before the first process: if we die now, the watchdog finds that out when it is up."""
        if not self._started:
            self._start()

    def _start(self) -> None:
        self._started += 1
        try:
            self._guard = Guard(self._run_id)
        except OSError as error:
            self._warn(f"this run is not guarded, the watchdog cannot start: {error.strerror}")
            return
        self._reactor.add_reader(self._guard.pidfd, self._died)

    def _died(self) -> None:
        self.close()
        starts_anew = self._started < MOST
        if starts_anew:
            self._start()
        what = "another one is started" if starts_anew else "this run goes on without one"
        self._warn(f"somebody ended the watchdog; {what}")

    def close(self) -> None:
        """Say goodbye to the watchdog."""
        if self._guard is not None:
            self._reactor.remove(self._guard.pidfd)
            self._guard.close()
            self._guard = None
