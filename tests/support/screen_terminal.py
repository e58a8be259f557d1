"""A command in a real pseudo-terminal whose screen is read by a terminal emulator."""

from __future__ import annotations

import os
import select
import signal
import termios
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyte
from ptyprocess import PtyProcess, PtyProcessError

TIMEOUT_S = 60.0
READ_BYTES = 64 * 1024
SLOW_READ_BYTES = 4096
HISTORY_LINES = 50_000

Cell = tuple[str, str, bool, bool]  # character, colour, bold, reversed


def _settings_of_a_new_terminal() -> list[Any]:
    ours, theirs = os.openpty()
    try:
        return termios.tcgetattr(ours)
    finally:
        os.close(ours)
        os.close(theirs)


class ScreenTerminal:
    """Types, and reads the screen. Use `with`: what is left at the end is killed."""

    def __init__(
        self,
        command: Sequence[str],
        *,
        env: Mapping[str, str],
        cwd: Path | str | None = None,
        columns: int = 100,
        rows: int = 24,
    ) -> None:
        self._process = PtyProcess.spawn(
            list(command),
            env=dict(env),
            cwd=None if cwd is None else str(cwd),
            dimensions=(rows, columns),
        )
        self._fd = self._process.fd
        self.untouched = _settings_of_a_new_terminal()  # ours may have been changed by now
        self._screen = pyte.HistoryScreen(columns, rows, history=HISTORY_LINES, ratio=1)
        self._stream = pyte.ByteStream(self._screen)
        self.raw = b""
        self.ended = False
        self.bytes_per_s: float | None = None  # of a terminal that is slow
        self.emulates = True  # a flood takes the emulator long; `raw` has it, too

    def __enter__(self) -> ScreenTerminal:
        return self

    def __exit__(self, *exc: object) -> None:
        try:
            self._process.close(force=True)
        except PtyProcessError:  # it was still there 0.1 s after SIGKILL
            self._process.wait()

    @property
    def pid(self) -> int:
        return self._process.pid

    # ---- looking

    @property
    def rows(self) -> list[str]:
        """What is on the screen now, without blanks at the ends of the lines."""
        return [row.rstrip() for row in self._screen.display]

    @property
    def text(self) -> str:
        return "\n".join(self.rows)

    @property
    def scrolled(self) -> list[str]:
        """All rows, those that have scrolled away first."""
        columns = self._screen.columns
        gone = ["".join(row[x].data for x in range(columns)) for row in self._screen.history.top]
        return [row.rstrip() for row in gone] + self.rows

    @property
    def cursor(self) -> tuple[int, int]:
        """(row, column), from 0."""
        return self._screen.cursor.y, self._screen.cursor.x

    @property
    def cursor_is_hidden(self) -> bool:
        return self._screen.cursor.hidden

    @property
    def prompt_row(self) -> int:
        """The last row that begins as the prompt does; -1 if there is none."""
        found = [number for number, row in enumerate(self.rows) if row.startswith(">")]
        return found[-1] if found else -1

    def below_prompt(self, number: int) -> str:
        """The row so far below the prompt; empty where there is none."""
        return "".join(self.rows[self.prompt_row + number :][:1])

    def settings(self) -> list[Any]:
        """The terminal's, as `stty` would show them."""
        return termios.tcgetattr(self._fd)

    def cells(self) -> list[list[Cell]]:
        """Each place on the screen."""
        columns = range(self._screen.columns)
        rows = [self._screen.buffer[number] for number in range(self._screen.lines)]
        return [
            [(row[x].data, row[x].fg, row[x].bold, row[x].reverse) for x in columns] for row in rows
        ]

    # ---- waiting

    def read(self, timeout_s: float) -> bool:
        """Take what comes within this time; whether something came."""
        ready, _, _ = select.select([self._fd], [], [], timeout_s)
        if not ready:
            return False
        try:
            data = os.read(self._fd, READ_BYTES if self.bytes_per_s is None else SLOW_READ_BYTES)
        except OSError:  # EIO: the last one has closed it
            data = b""
        self.ended = not data
        self.raw += data
        if self.emulates:
            self._stream.feed(data)
        if self.bytes_per_s is not None:
            time.sleep(len(data) / self.bytes_per_s)  # a slow terminal is one that reads slowly
        return bool(data)

    def wait_until(
        self, fact: Callable[[], object], what: str, timeout_s: float = TIMEOUT_S
    ) -> None:
        """Read until the fact holds; AssertionError at the deadline."""
        deadline = time.monotonic() + timeout_s
        while not fact():
            left_s = deadline - time.monotonic()
            assert left_s > 0 and not self.ended, f"did not see {what}; on the screen:\n{self.text}"
            self._read_on(min(left_s, 0.05))

    def _read_on(self, timeout_s: float) -> None:
        """Read what is there: looking at the screen after every block would take longer."""
        until = time.monotonic() + timeout_s
        while self.read(max(0.0, until - time.monotonic())) and time.monotonic() < until:
            pass

    def wait_for(self, *texts: str, timeout_s: float = TIMEOUT_S) -> None:
        """Read until each of these is, or was, somewhere on the screen."""
        for text in texts:
            self.wait_until(
                lambda text=text: any(text in row for row in self.scrolled), repr(text), timeout_s
            )

    def wait_for_prompt(self, timeout_s: float = TIMEOUT_S) -> None:
        """Read until the console has the terminal."""
        self.wait_until(lambda: self.prompt_row >= 0, "the prompt", timeout_s)

    def exit_code(self, timeout_s: float = TIMEOUT_S) -> int:
        """Read to the end; the exit code, negative for a signal."""
        deadline = time.monotonic() + timeout_s
        while not self.ended:
            assert time.monotonic() < deadline, f"has not ended; on the screen:\n{self.text}"
            self.read(0.05)
        return self.reaped()

    def reaped(self) -> int:
        """The exit code of a command that is about to end or has ended."""
        self._process.wait()
        if self._process.signalstatus is not None:
            return -self._process.signalstatus
        return self._process.exitstatus

    # ---- acting

    def type(self, text: str) -> None:
        self.type_bytes(text.encode())

    def type_bytes(self, data: bytes) -> None:
        while data:  # a terminal takes what it has room for
            data = data[os.write(self._fd, data) :]

    def enter(self, line: str) -> None:
        self.type(line + "\r")

    def ctrl_c(self) -> None:
        self.type("\x03")

    def resize(self, columns: int, rows: int) -> None:
        self._screen.resize(rows, columns)
        self._process.setwinsize(rows, columns)

    def close_window(self) -> None:
        """As when a person closes it: the terminal is gone."""
        os.close(self._fd)
        self._process.closed = self.ended = True

    def kill(self, signum: int = signal.SIGKILL) -> None:
        self._process.kill(signum)
