"""Facts that are tried again and again: a TCP connection, and a command."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
from collections.abc import Callable, Mapping

from launcher.base.model.supervision import Fact
from launcher.posix.reactor import Reactor, Timer
from launcher.posix.spawn import execute, reap

# Whether it holds, and what is seen instead.
Report = Callable[[bool, str], None]
ATTEMPT_S = 10.0  # at most


class _Attempts:
    """Calls `_try` now, and again some time after `_failed`, until it is closed."""

    def __init__(self, fact: Fact, reactor: Reactor, report: Report) -> None:
        self._fact = fact
        self._reactor = reactor
        self._report = report
        self._timer: Timer | None = reactor.call_later(0, self._try)

    def _try(self) -> None:
        raise NotImplementedError

    def _in(self, delay_s: float, call: Callable[[], None]) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._reactor.call_later(delay_s, call)

    def _failed(self, text: str) -> None:
        self._in(self._fact.every_s, self._try)
        self._report(False, text)

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


class PortAttempts(_Attempts):
    """Connects to `ADDRESS:PORT`, and closes the connection at once."""

    _socket: socket.socket | None = None

    def _try(self) -> None:
        host, _, port = self._fact.subject.rpartition(":")
        host = host.strip("[]")
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self._socket = socket.socket(family, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
        except OSError as error:
            self._failed(f"no connection to {self._fact.subject}: {error.strerror}")
            return
        self._socket.connect_ex((host, int(port)))
        self._reactor.add_writer(self._socket.fileno(), self._connected)
        self._in(ATTEMPT_S, self._connected)

    def _connected(self) -> None:
        assert self._socket is not None
        number = self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        with contextlib.suppress(OSError):
            self._socket.getpeername()  # fails while it is being connected
            if number == 0:
                self.close()
                self._report(True, "")
                return
        self._close_socket()
        why = os.strerror(number).lower() if number else "no answer"
        self._failed(f"no connection to {self._fact.subject}: {why}")

    def _close_socket(self) -> None:
        if self._socket is not None:
            self._reactor.remove(self._socket.fileno())
            self._socket.close()
            self._socket = None

    def close(self) -> None:
        super().close()
        self._close_socket()


class CommandRun(_Attempts):
    """Runs a command in the environment and folder of a process; its output is dropped."""

    def __init__(
        self,
        fact: Fact,
        reactor: Reactor,
        report: Report,
        *,
        env: Mapping[str, str],
        cwd: str | None,
    ) -> None:
        self._env = env
        self._cwd = cwd
        self._pid = self._pidfd = -1
        super().__init__(fact, reactor, report)

    def _try(self) -> None:
        null = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
        try:
            streams = (null, null, null)
            self._pid = execute(self._fact.words, env=self._env, streams=streams, cwd=self._cwd)
            self._pidfd = os.pidfd_open(self._pid)
        except OSError as error:
            self._failed(f"`{self._fact.subject}` cannot be started: {error.strerror}")
            return
        finally:
            os.close(null)
        self._reactor.add_reader(self._pidfd, self._exited)
        self._in(ATTEMPT_S, self._kill)

    def _kill(self) -> None:
        with contextlib.suppress(OSError):
            os.killpg(self._pid, signal.SIGKILL)

    def _exited(self) -> None:
        self._kill()  # what it has left in its group
        code, _ = reap(self._pidfd)
        self._reactor.remove(self._pidfd)
        os.close(self._pidfd)
        self._pidfd = -1
        is_closed = self._timer is None
        if is_closed:
            return
        if code == 0:
            self.close()
            self._report(True, "")
        else:
            how = f"exits with code {code}" if code > 0 else f"ends by signal {-code}"
            late = code == -signal.SIGKILL
            text = f"has not ended within {ATTEMPT_S:g} s" if late else how
            self._failed(f"`{self._fact.subject}` {text}")

    def close(self) -> None:
        super().close()
        if self._pidfd >= 0:
            self._kill()  # it is reaped when it has ended
