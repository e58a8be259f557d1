"""`top`: a table of processes that can be sorted and scrolled, in the console or a shell."""

from __future__ import annotations

import os
import re
import select
import signal
import sys
import termios
import tty
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from launcher.base.run_verb import Call
from launcher.control.client import Connection, NoRunError
from launcher.control.console.process_tables import process_table, render
from launcher.control.console.short_forms import end_cut, is_in_trouble
from launcher.posix.dispositions import Handled
from launcher.posix.keys import READ_BYTES, read_keys

Process = Mapping[str, Any]

ORDERS = {"c": "cpu", "m": "memory", "n": "name", "r": "restarts", "s": "state"}
KEYS_HINT = f"arrows scroll | sort: {' '.join(ORDERS)}"
HEAD_ROWS = 4  # with fewer rows, the table has no head
_DIGITS = re.compile(r"(\d+)")

HINT = f"{KEYS_HINT} | q ends"
_ENDS = ("q", "Q", "\x1b", "\x04")
_ENTER, _LEAVE = "\x1b[?1049h\x1b[?25l", "\x1b[?25h\x1b[?1049l"
_SIGNALS = (signal.SIGWINCH, signal.SIGTSTP, signal.SIGTERM, signal.SIGHUP)
_FATAL = (signal.SIGTERM, signal.SIGHUP)
_ALSO = {"k": "up", "j": "down", " ": "pagedown"}


def _by_name(process: Process) -> tuple[Any, ...]:
    """`robot_10` behind `robot_9`."""
    parts = _DIGITS.split(process["name"])
    return tuple(int(part) if place % 2 else part for place, part in enumerate(parts))


_KEYS: dict[str, Callable[[Process], Any]] = {
    "cpu": lambda process: -(process.get("cpu_percent") or 0.0),
    "memory": lambda process: -(process.get("uss_bytes") or 0),
    "name": _by_name,
    "restarts": lambda process: -(process.get("restarts") or 0),
    "state": lambda process: (not is_in_trouble(process), process["state"]),
}


class Top:
    """Order and scroll position of a table."""

    def __init__(self, order: str = "cpu") -> None:
        self.order = order
        self._first = 0
        self._page = 1

    def press(self, key: str) -> bool:
        """Scroll or sort; False for any other key."""
        if key in ORDERS:
            self.order, self._first = ORDERS[key], 0
            return True
        steps = {
            "up": -1,
            "down": 1,
            "pageup": -self._page,
            "pagedown": self._page,
            "home": -self._first,
            "end": 1_000_000,  # as far as there is anything
        }
        self._first = max(0, self._first + steps.get(key, 0))
        return key in steps

    def sorted(self, found: Sequence[Process]) -> list[Process]:
        return sorted(found, key=_KEYS[self.order])

    def lines(self, found: Sequence[Process], columns: int, rows: int, *, colour: bool) -> str:
        """The table in at most `rows` lines: a head, processes, and which of them are shown."""
        has_place = rows > 1
        has_head = rows >= HEAD_ROWS
        self._page = max(1, rows - has_place - has_head)
        self._first = min(self._first, max(0, len(found) - self._page))
        seen = self.sorted(found)[self._first : self._first + self._page]
        table = render(process_table(seen, columns, has_head=has_head), columns, colour=colour)
        return "\n".join([table, *([end_cut(self._place(found), columns)] if has_place else ())])

    def _place(self, found: Sequence[Process]) -> str:
        count, first = len(found), self._first + 1
        last = min(count, self._first + self._page)
        if count <= self._page:
            return f"{count} by {self.order}"
        seen = f"{first}-{last}" if last > first else str(first)
        more = ((first - 1, "above"), (count - last, "below"))
        return f"{seen} of {count} by {self.order}: " + ", ".join(
            f"{number} more {where}" for number, where in more if number
        )


class AlternateScreen:
    """The alternate screen of the terminal, with keys read one by one."""

    def __init__(self) -> None:
        self._settings: list[Any] | None = None

    def enter(self) -> None:
        """Ctrl-C and Ctrl-Z still send their signals."""
        if os.isatty(0):
            self._settings = termios.tcgetattr(0)
            tty.setcbreak(0, termios.TCSANOW)
        self.write(_ENTER)

    def leave(self) -> None:
        with suppress(OSError, termios.error):  # the window was closed
            self.write(_LEAVE)
            if self._settings is not None:
                termios.tcsetattr(0, termios.TCSANOW, self._settings)

    def draw(self, lines: Sequence[str]) -> None:
        """Replace the contents in one write, which does not flicker."""
        self.write("\x1b[H" + "\r\n".join(f"{line}\x1b[K" for line in lines) + "\x1b[J")

    @staticmethod
    def write(text: str) -> None:
        sys.stdout.write(text)
        sys.stdout.flush()


class LiveTop:
    """`top` in a shell, until `q` or the end of the run."""

    def __init__(self, connection: Connection, call: Call, *, colour: bool) -> None:
        self._connection = connection
        self._call = call
        self._colour = colour
        self._top = Top()
        self._screen = AlternateScreen()
        self._found: Sequence[Mapping[str, Any]] | None = None

    def run(self) -> None:
        """Show it; the last table stays on the terminal. Ctrl-C raises KeyboardInterrupt."""
        request_id = self._connection.send(
            self._call.verb.name, self._call.names, **{"follow": True, **self._call.options}
        )
        with _signals() as signals:
            self._screen.enter()
            try:
                self._loop(request_id, signals)
            finally:
                self._screen.leave()
                with suppress(OSError):
                    self._screen.write("".join(f"{line}\n" for line in self._lines(hint=False)))

    def _loop(self, request_id: int, signals: int) -> None:
        sources = [self._connection.fileno(), signals, *([0] if os.isatty(0) else [])]
        while True:
            ready, _, _ = select.select(sources, [], [], 0 if self._connection.has_line else None)
            if signals in ready:
                self._on_signals(os.read(signals, READ_BYTES))
            if 0 in ready and self._is_ended_by(read_keys()):
                return
            if (sources[0] in ready or self._connection.has_line) and not self._receive(request_id):
                return
            self._screen.draw(self._lines(hint=True))

    def _receive(self, request_id: int) -> bool:
        """Read an item; False at the end of the run."""
        try:
            item = self._connection.next_item(request_id)
        except NoRunError:
            item = None
        if item is not None:
            self._found = item.get("processes", self._found)
        return item is not None

    def _is_ended_by(self, keys: Sequence[str]) -> bool:
        """Handle the keys; True if one of them quits."""
        for key in keys:
            if not self._top.press(_ALSO.get(key, key)) and key in _ENDS:
                return True
        return not keys  # the terminal was closed

    def _on_signals(self, signals: bytes) -> None:
        for signum in signals:
            if signum in _FATAL:
                raise SystemExit(128 + signum)
            if signum == signal.SIGTSTP:
                self._screen.leave()
                os.kill(os.getpid(), signal.SIGSTOP)
                self._screen.enter()

    def _lines(self, *, hint: bool) -> list[str]:
        if self._found is None:
            return []
        columns, rows = os.get_terminal_size(1)
        columns, rows = columns or 80, rows or 24
        hint = hint and rows > 2
        text = self._top.lines(self._found, columns, rows - hint, colour=self._colour)
        return [*text.split("\n"), *([end_cut(HINT, columns)] if hint else ())]


@contextmanager
def _signals() -> Iterator[int]:
    """A descriptor from which the numbers of signals are read."""
    reading, writing = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    old = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    try:
        with Handled(lambda *_: None, _SIGNALS):
            yield reading
    finally:
        signal.set_wakeup_fd(old)
        os.close(reading)
        os.close(writing)
