"""At the end of a run: waits for a slow reader, or drops visibly what an interrupted one left."""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import signal
import termios
import time

from launcher.posix import proc

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.output.stdout import StdoutWriter
    from launcher.posix.reactor import Reactor

STALLED_S = 5.0  # without a byte taken, after which nothing more is expected
INTERRUPTED_S = 3.0  # that a terminal gets after an interrupt, before output is dropped
SLICE_S = 0.05
SMALL_BYTES = 16 * 1024  # what may be left to the console without waiting for it
_STOPS = frozenset({signal.SIGINT, signal.SIGTERM, signal.SIGQUIT, signal.SIGHUP})


class Backlog:
    """Output that has not been taken; `screen` writes it."""

    def __init__(self, reactor: Reactor, screen: StdoutWriter) -> None:
        self._reactor = reactor
        self._screen = screen
        self._seen: object = None
        self._seen_at_s = self._begun_s = time.monotonic()

    def settle(self, *, is_interrupted: bool) -> int:
        """Wait until it is taken, or stalls; the number of lines that were dropped.

        They are dropped at a further signal, and on a terminal INTERRUPTED_S after the first.
        """
        enough = SMALL_BYTES if self._screen.has_console else 0
        limited = is_interrupted and self._screen.is_tty
        while self._unread() > enough and self._goes_on():
            late = limited and time.monotonic() - self._begun_s > INTERRUPTED_S
            if late or _STOPS.intersection(self._reactor.take_signals()):
                return self._drop()
        return 0

    def finish(self) -> int:
        """Wait until it is written, or stalls; the number of lines that were not written."""
        while self._screen.waiting_bytes and self._goes_on():
            pass
        return self._screen.take_waiting().count(b"\n")

    def _goes_on(self) -> bool:
        """Write what can be written; whether something was taken in the last STALLED_S."""
        if self._screen.waiting_bytes:
            is_writable(self._screen.fd, SLICE_S)
            self._screen.flush()
        else:
            time.sleep(SLICE_S)  # for the console to read its pipe
        now, seen = time.monotonic(), (self._unread(), self._screen.taken_bytes())
        if seen != self._seen:
            self._seen, self._seen_at_s = seen, now
        return now - self._seen_at_s < STALLED_S

    def _unread(self) -> int:
        in_pipe = _pipe_bytes(self._screen.fd) if self._screen.has_console else 0
        return self._screen.waiting_bytes + in_pipe

    def _drop(self) -> int:
        """Drop all but the rest of the line that has begun."""
        in_pipe = _taken_from_pipe(self._screen.fd) if self._screen.has_console else b""
        first, newline, rest = (in_pipe + self._screen.take_waiting()).partition(b"\n")
        self._screen.write(first + newline)
        return rest.count(b"\n")


def is_writable(fd: int, timeout_s: float) -> bool:
    poll = select.poll()
    poll.register(fd, select.POLLOUT)
    return bool(poll.poll(timeout_s * 1000))


def written_by(pid: int) -> int:
    """Bytes that a process has written; 0 if that is unknown."""
    counters = dict(line.split(b": ") for line in proc.read(pid, "io").splitlines())
    return int(counters.get(b"wchar", 0))


def _pipe_bytes(fd: int) -> int:
    return int.from_bytes(fcntl.ioctl(fd, termios.FIONREAD, bytes(4)), "little")


def _taken_from_pipe(fd: int) -> bytes:
    """The contents of the pipe with this write end."""
    ours = os.open(f"/proc/self/fd/{fd}", os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    taken = b""
    try:
        while chunk := os.read(ours, 1024 * 1024):
            taken += chunk
    except BlockingIOError:
        pass
    finally:
        os.close(ours)
    return taken


def complain(text: str, *, shown_fd: int = 1, fd: int = 2) -> None:
    """Write an error to `fd` unless that is the same file as `shown_fd`; never blocks or raises."""
    with contextlib.suppress(OSError):
        if os.path.sameopenfile(shown_fd, fd) or not is_writable(fd, 0):
            return
        os.write(fd, f"error: {text}\n".encode(errors="surrogateescape"))
