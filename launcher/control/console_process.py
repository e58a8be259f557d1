"""Starts the console, a process that shows prompt and status bar on the terminal.

The console gets our output through a pipe, and otherwise is a client of the control socket. It may
fail at any time: then the terminal is restored here, output that it has not read is written to the
terminal, and the run continues without it.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import signal
import socket
import subprocess
import sys
import termios

from launcher.posix import pipes
from launcher.run.helpers.popen import last_line, start_module, wait_or_kill
from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.run import Run

READY, GO, BYE = b"R", b"G", b"B"
PIPE_BYTES = 256 * 1024  # fewer context switches than with the usual 64 KiB
GOODBYE_S = 2.0  # a console that does not exit with the run is killed after this
STALLED_S = 5.0  # without a byte written to a slow terminal, after which that time begins
# Cursor visible, lines wrap, no bracketed paste, no colour; erase everything below the cursor.
RESET = b"\x1b[?25h\x1b[?7h\x1b[?2004l\x1b[0m\r\x1b[J"

_NO_TERMINAL = (None, "", "dumb")  # values of TERM; programs treat an empty one as none


def is_at_terminal() -> bool:
    """Whether standard input and output are terminals, and we are in the foreground."""
    if not (os.isatty(0) and os.isatty(1)) or os.environ.get("TERM") in _NO_TERMINAL:
        return False
    return _in_foreground()


def _in_foreground() -> bool:
    try:
        return os.tcgetpgrp(0) == os.getpgrp()
    except OSError:
        return False  # not our controlling terminal


class ConsoleProcess(Part):
    """Starts the console, and restores the terminal when it exits, also after a killed launcher."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._screen = run.screen
        self._warn = run.log.warn
        self._process: subprocess.Popen[bytes] | None = None
        self._pidfd = -1
        self._pipe: tuple[int, int] = (-1, -1)
        self._link: socket.socket | None = None
        self._errors = -1
        self._before: list[object] = []
        self._saved: dict[int, int] = {}
        self._has_terminal = False

    def begin(self) -> None:
        """Start the console; until it is ready, nothing changes."""
        if not is_at_terminal():
            return  # sent to the background meanwhile
        self._before = termios.tcgetattr(0)
        self._pipe = os.pipe2(os.O_CLOEXEC)
        pipes.widen(self._pipe[1], PIPE_BYTES)
        os.set_blocking(self._pipe[1], False)
        self._link, theirs = socket.socketpair()
        self._errors = os.memfd_create("console-errors")
        with theirs:
            try:
                self._process = self._spawn(theirs.fileno())
            except OSError as error:
                self._release()
                self._warn(f"cannot start the console: {error.strerror}")
                return
        self.run.watchdog.keep(self._process.pid)
        self._pidfd = os.pidfd_open(self._process.pid)
        self._reactor.add_reader(self._link.fileno(), self._read_link)
        self._reactor.add_reader(self._pidfd, self._exited)

    def _spawn(self, theirs: int) -> subprocess.Popen[bytes]:
        # A Ctrl-C before it is ready is only for us: it inherits SIGINT as blocked.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            return start_module(
                ["launcher.control.console", str(os.getpid()), str(self._pipe[0]), str(theirs)],
                start_new_session=False,
                pass_fds=(self._pipe[0], theirs),
                stderr=self._errors,
            )
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    # ---- while it is running

    def _read_link(self) -> None:
        assert self._link is not None
        word = self._link.recv(1)
        if word == READY:
            self._screen.taken_bytes = self._written
            self._screen.divert(self._pipe[1], self._hand_over)
        elif not word:
            self._reactor.remove(self._link.fileno())

    def _hand_over(self) -> None:
        """Give the terminal to the console, and redirect our own standard streams to it."""
        assert self._link is not None
        self._has_terminal = True
        blocking = os.open(f"/proc/self/fd/{self._pipe[1]}", os.O_WRONLY | os.O_CLOEXEC)
        sys.stdout.flush()
        for fd in (1, 2):
            if os.isatty(fd):
                self._saved[fd] = fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, 3)
                os.dup2(blocking, fd)
        os.close(blocking)
        with contextlib.suppress(OSError):  # it has exited, which the pidfd reports
            self._link.send(GO)

    # ---- when it has exited, or the run is over

    def _exited(self) -> None:
        assert self._process is not None
        code = self._process.wait()
        line = last_line(self._errors)
        reason = f": {line}" if line else ""
        left = self._take_back()
        self._screen.come_back(left)
        how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        self._warn(f"the console died ({how}){reason}; the run continues without one")

    def close(self) -> None:
        """Let the console show the rest, and wait for its exit. Call it when all is written."""
        if self._process is None:
            return
        assert self._link is not None
        if not self._has_terminal:
            self._process.kill()  # it is still starting
        with contextlib.suppress(OSError):
            self._link.send(BYE)
        self._stop_printing()
        os.close(self._pipe[1])
        self._pipe = (self._pipe[0], -1)
        if self._has_terminal:
            self._wait_while_it_writes(self._process)
        if wait_or_kill(self._process, GOODBYE_S) == 0:
            self._release()
            return
        # It was suspended, or the terminal was, or it has failed.
        left = self._take_back()
        with contextlib.suppress(OSError):  # the terminal is gone
            while left:
                left = left[os.write(1, left) :]

    def _written(self) -> int:
        """Bytes that the console has written."""
        from launcher.output.backlog import written_by

        return 0 if self._process is None else written_by(self._process.pid)

    def _wait_while_it_writes(self, process: subprocess.Popen[bytes]) -> None:
        before, written = -1, self._written()
        while written != before:
            before = written
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(STALLED_S)
                return
            written = self._written()

    def _stop_printing(self) -> None:
        """Redirect our standard streams to the terminal again."""
        sys.stdout.flush()
        for fd, ours in self._saved.items():
            os.dup2(ours, fd)
            os.close(ours)
        self._saved.clear()

    def _take_back(self) -> bytes:
        """Restore the terminal, and return what is left in the pipe."""
        self._stop_printing()
        os.set_blocking(self._pipe[0], False)
        left = b""
        with contextlib.suppress(BlockingIOError):
            while chunk := os.read(self._pipe[0], PIPE_BYTES):
                left += chunk
        if self._has_terminal and _in_foreground():
            with contextlib.suppress(termios.error):  # the terminal is gone
                termios.tcsetattr(0, termios.TCSANOW, self._before)  # type: ignore[arg-type]
            left = RESET + left
        self._release()
        return left

    def _release(self) -> None:
        assert self._link is not None
        self._reactor.remove(self._link.fileno())
        self._link.close()
        for fd in (self._pidfd, self._errors, *self._pipe):
            if fd >= 0:
                self._reactor.remove(fd)
                os.close(fd)
        self._pidfd = self._errors = -1
        self._pipe = (-1, -1)
        self._process = None
