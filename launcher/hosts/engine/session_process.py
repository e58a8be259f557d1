"""The process on this machine that leads to an agent: ssh, with its standard streams."""

from __future__ import annotations

import os
import select
import signal
from collections.abc import Callable, Mapping, Sequence

from launcher.hosts.engine.frame_channel import PIPE_BYTES
from launcher.posix import pipes, spawn
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.reactor import Reactor

_ERROR_BYTES = 16 * 1024  # of what it has written to standard error
_END_S = 1.0  # for an orderly end


class SessionProcess:
    """A running process; `stdin` and `stdout` are taken by the caller, who closes them.

    `ended(return code)` is called once, `line(text)` for each line on its standard error. OSError
    if it cannot be started.
    """

    def __init__(
        self,
        reactor: Reactor,
        words: Sequence[str],
        environment: Mapping[str, str],
        *,
        ended: Callable[[int], None],
        line: Callable[[str], None],
    ) -> None:
        self._reactor = reactor
        self._ended = ended
        self._line = line
        self._errors = b""
        theirs_in, self.stdin = os.pipe()
        self.stdout, theirs_out = os.pipe()
        self._stderr, theirs_err = os.pipe()
        pipes.widen(self.stdout, PIPE_BYTES)
        ours, theirs = (self.stdin, self.stdout, self._stderr), (theirs_in, theirs_out, theirs_err)
        # Not of the run: it ends by itself, and is not to be stopped as a leftover.
        env = {name: value for name, value in environment.items() if name != RUN_ID_VARIABLE}
        try:
            self.pid = spawn.execute(words, env=env, streams=theirs)
            self._pidfd = os.pidfd_open(self.pid)
        except OSError:
            for fd in ours:
                os.close(fd)
            raise
        finally:
            for fd in theirs:
                os.close(fd)
        os.set_blocking(self._stderr, False)
        reactor.add_reader(self._stderr, self._read_errors)
        reactor.add_reader(self._pidfd, self._exited)

    @property
    def errors(self) -> str:
        """The end of what it has written to standard error."""
        return self._errors.decode(errors="replace")

    def _read_errors(self) -> int:
        try:
            block = os.read(self._stderr, 65536)
        except BlockingIOError:
            return 0
        if not block:
            self._reactor.remove(self._stderr)
            return 0
        before = self._errors.rpartition(b"\n")[2]
        self._errors = (self._errors + block)[-_ERROR_BYTES:]
        for line in (before + block).split(b"\n")[:-1]:
            if line.strip():
                self._line(line.decode(errors="replace").rstrip())
        return len(block)

    def _exited(self) -> None:
        while self._read_errors():
            pass
        returncode = self._release()
        self._ended(returncode)

    def _release(self) -> int:
        self._reactor.remove(self._pidfd)
        self._reactor.remove(self._stderr)
        returncode, _ = spawn.reap(self._pidfd)
        os.close(self._pidfd)
        os.close(self._stderr)
        self._pidfd = -1
        return returncode

    def kill(self) -> None:
        """Have it end now; `ended` follows."""
        if self._pidfd >= 0:
            signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)

    def close(self) -> None:
        """Wait for its end, which is near since its standard input has ended, or kill it."""
        if self._pidfd < 0:
            return
        poll = select.poll()
        poll.register(self._pidfd, select.POLLIN)
        for signum in (signal.SIGTERM, signal.SIGKILL):
            if poll.poll(_END_S * 1000):
                break
            signal.pidfd_send_signal(self._pidfd, signum)
        self._release()
