"""Runs a short command beside the run, without waiting for it."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Sequence

from launcher.base.model.record import Record
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import execute, reap


class Completed(Record):
    """How it ended; `returncode` is None if it had to be killed at its time limit."""

    returncode: int | None
    output: bytes
    errors: bytes


class ShortCommand:
    """Starts `words`, and calls `done` when they have ended; OSError if they cannot be started.

    Its output goes to memory, so that it never waits for a reader.
    """

    def __init__(
        self,
        reactor: Reactor,
        words: Sequence[str],
        done: Callable[[Completed], None],
        *,
        timeout_s: float,
    ) -> None:
        self._reactor = reactor
        self._done = done
        self._is_late = False
        null = os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
        self._files = null, os.memfd_create("output"), os.memfd_create("errors")
        try:
            self._pid = execute(words, env=os.environ, streams=self._files)
        except OSError:
            self._close_files()
            raise
        self._pidfd = os.pidfd_open(self._pid)
        reactor.add_reader(self._pidfd, self._exited)
        self._timer = reactor.call_later(timeout_s, self._kill)

    def _kill(self) -> None:
        self._is_late = True
        os.kill(self._pid, signal.SIGKILL)

    def _exited(self) -> None:
        returncode, _ = self._reap()
        _, output, errors = (os.pread(fd, os.fstat(fd).st_size, 0) for fd in self._files)
        self._close_files()
        self._done(Completed(None if self._is_late else returncode, output, errors))

    def _reap(self) -> tuple[int, bool]:
        self._timer.cancel()
        self._reactor.remove(self._pidfd)
        end = reap(self._pidfd)
        os.close(self._pidfd)
        return end

    def _close_files(self) -> None:
        for fd in self._files:
            os.close(fd)

    def close(self) -> None:
        """Kill it; `done` is not called any more. Only before it has ended."""
        os.kill(self._pid, signal.SIGKILL)
        self._reap()
        self._close_files()
