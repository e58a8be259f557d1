"""Runs a program with a document on its standard input, while the loop of the run goes on."""

from __future__ import annotations

import contextlib
import os
import select
import signal
from collections.abc import Callable, Mapping, Sequence

from launcher.base.text import escape_controls, how_it_ended
from launcher.posix.reactor import Reactor, Timer
from launcher.posix.spawn import execute, reap

GRACE_S = 1.0  # from SIGTERM to SIGKILL
MAX_LINES = 100  # what comes after them is dropped
MAX_LINE = 500
_READ_BYTES = 64 * 1024
_PAUSE_S = 0.1  # between two reads of what is dropped: a flood must not take the processor

Done = Callable[[bool, str], object]


class OutsideProgram:
    """Calls `on_line` with each line of its output, and once `done` (ok, detail): at its end.

    At `within_s`, or at `end`, that is called, too; then it and what it has started in its group
    get SIGTERM, and SIGKILL a second later.
    OSError if it cannot be started.
    """

    def __init__(
        self,
        reactor: Reactor,
        words: Sequence[str],
        env: Mapping[str, str],
        document: bytes,
        *,
        within_s: float,
        on_line: Callable[[str], object],
        done: Done,
    ) -> None:
        self._reactor = reactor
        self._within_s = within_s
        self._on_line = on_line
        self._done: Done | None = done
        self._partial, self._lines = b"", 0
        self._drain: Timer | None = None
        self._output, inner = os.pipe2(os.O_CLOEXEC)
        document_fd = _file_of(document)
        try:
            self.pid = execute(words, env=env, streams=(document_fd, inner, inner))
            self._pidfd = os.pidfd_open(self.pid)
        except BaseException:
            os.close(self._output)
            raise
        finally:
            os.close(document_fd)
            os.close(inner)
        os.set_blocking(self._output, False)
        reactor.add_reader(self._output, self._readable)
        reactor.add_reader(self._pidfd, self._exited)
        self._timer = reactor.call_later(within_s, self._late)

    # ---- output

    def _readable(self) -> None:
        data = self._read()
        if data:
            self._take(data)
        elif data is not None:
            self._reactor.remove(self._output)

    def _read(self) -> bytes | None:
        """None: there is nothing now; empty: nothing will come."""
        try:
            return os.read(self._output, _READ_BYTES)
        except BlockingIOError:
            return None

    def _take(self, data: bytes) -> None:
        *lines, self._partial = (self._partial + data).split(b"\n")
        self._partial = self._partial[:_READ_BYTES]
        for line in lines:
            self._say(line)
        if self._lines > MAX_LINES and self._drain is None:
            self._reactor.remove(self._output)
            self._partial = b""
            self._drop()

    def _say(self, line: bytes) -> None:
        self._lines += 1
        if self._lines == MAX_LINES + 1:
            self._on_line("(more lines are not shown)")
        if self._lines <= MAX_LINES:
            self._on_line(escape_controls(line.decode(errors="replace"))[:MAX_LINE])

    def _drop(self) -> None:
        self._drain = None
        if self._read() != b"":
            self._drain = self._reactor.call_later(_PAUSE_S, self._drop)

    # ---- its end

    def _late(self) -> None:
        self.end(f"not done within {self._within_s:g} s")

    @property
    def is_running(self) -> bool:
        return self._pidfd >= 0

    def end(self, why: str) -> None:
        """Let it end, within a second; `why` becomes the detail."""
        if self._done is not None:
            self._timer.cancel()
            self._signal(signal.SIGTERM)
            self._timer = self._reactor.call_later(GRACE_S, self.kill)
            self._report(False, why)

    def kill(self) -> None:
        if self.is_running:
            self._signal(signal.SIGKILL)

    def _report(self, ok: bool, detail: str) -> None:
        done, self._done = self._done, None
        if done is not None:
            done(ok, detail)

    def _signal(self, signum: int) -> None:
        with contextlib.suppress(OSError):
            os.killpg(self.pid, signum)
            os.killpg(self.pid, signal.SIGCONT)

    def _exited(self) -> None:
        self._signal(signal.SIGKILL)  # what it has left in its group
        code, _ = reap(self._pidfd)
        is_dropping = self._drain is not None
        self._timer.cancel()
        self._reactor.remove(self._pidfd)
        os.close(self._pidfd)
        self._pidfd = -1
        if not is_dropping and (rest := self._read()):
            self._take(rest)
        if self._partial:
            self._say(self._partial)
        self._close_output()
        self._report(code == 0, how_it_ended(code))

    def _close_output(self) -> None:
        if self._drain is not None:
            self._drain.cancel()
        self._reactor.remove(self._output)
        os.close(self._output)

    def close(self) -> None:
        """Kill it, and wait for that, without `done`: the loop is over, and the log closed."""
        if not self.is_running:
            return
        self._done, self._on_line = None, lambda line: None
        self.kill()
        ended = select.poll()
        ended.register(self._pidfd, select.POLLIN)
        if ended.poll(GRACE_S * 1000):
            self._exited()


def _file_of(document: bytes) -> int:
    """A file in memory, since a pipe would take 64 KB until somebody reads."""
    found = os.memfd_create("fault", os.MFD_CLOEXEC)
    with open(found, "wb", closefd=False) as file:
        file.write(document)
    os.lseek(found, 0, os.SEEK_SET)
    return found
