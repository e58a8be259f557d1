"""Live top: `python -m launcher top` in a terminal, on a screen of its own until `q`."""

from __future__ import annotations

import os
import select
import signal
import sys
import termios
import tty
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from launcher.console.cutting import end_cut
from launcher.console.keys import keys
from launcher.console.top import KEYS_HINT, Top
from launcher.control.client import Connection, NoRunError
from launcher.control.verbs import Call

HINT = f"{KEYS_HINT} | q ends"
_ENDS = ("q", "Q", "\x1b", "\x04")
_ENTER, _LEAVE = "\x1b[?1049h\x1b[?25l", "\x1b[?25h\x1b[?1049l"
_NOTICED = (signal.SIGWINCH, signal.SIGTSTP, signal.SIGTERM, signal.SIGHUP)
_DEADLY = (signal.SIGTERM, signal.SIGHUP)
READ_BYTES = 1024


class Stage:
    """The terminal's other screen, and keys one by one. Use `enter` and `leave` in pairs."""

    def __init__(self) -> None:
        self._settings: list[Any] | None = None

    def enter(self) -> None:
        """Take it; Ctrl-C and Ctrl-Z stay what they are."""
        if os.isatty(0):
            self._settings = termios.tcgetattr(0)
            tty.setcbreak(0, termios.TCSANOW)
        self.write(_ENTER)

    def leave(self) -> None:
        """Give it back as it was."""
        with suppress(OSError, termios.error):  # the window was closed
            self.write(_LEAVE)
            if self._settings is not None:
                termios.tcsetattr(0, termios.TCSANOW, self._settings)

    def draw(self, lines: Sequence[str]) -> None:
        """Show these from the top, in one write, without a moment of emptiness."""
        self.write("\x1b[H" + "\r\n".join(f"{line}\x1b[K" for line in lines) + "\x1b[J")

    @staticmethod
    def write(text: str) -> None:
        """Write all of it."""
        sys.stdout.write(text)
        sys.stdout.flush()


class LiveTop:
    """Shows what the run tells until a person has seen enough, or the run ends."""

    def __init__(self, connection: Connection, call: Call, *, colour: bool) -> None:
        self._connection = connection
        self._call = call
        self._colour = colour
        self._top = Top()
        self._stage = Stage()
        self._found: Sequence[Mapping[str, Any]] | None = None

    def run(self) -> None:
        """Show it; what was seen last stays on the terminal. Ctrl-C raises as everywhere."""
        request_id = self._connection.send(
            self._call.verb.name, self._call.names, **{"follow": True, **self._call.options}
        )
        with _signals() as news:
            self._stage.enter()
            try:
                self._loop(request_id, news)
            finally:
                self._stage.leave()
                with suppress(OSError):
                    self._stage.write("".join(f"{line}\n" for line in self._lines(hint=False)))

    def _loop(self, request_id: int, news: int) -> None:
        sources = [self._connection.fileno(), news, *([0] if os.isatty(0) else [])]
        while True:
            ready, _, _ = select.select(sources, [], [], 0 if self._connection.has_line else None)
            if news in ready:
                self._noticed(os.read(news, READ_BYTES))
            if 0 in ready and self._is_ended_by(_typed()):
                return
            if (sources[0] in ready or self._connection.has_line) and not self._heard(request_id):
                return
            self._stage.draw(self._lines(hint=True))

    def _heard(self, request_id: int) -> bool:
        """Take what the run says; whether it goes on."""
        try:
            item = self._connection.next_item(request_id)
        except NoRunError:
            return False
        if item is None:
            return False
        self._found = item.get("processes", self._found)
        return True

    def _is_ended_by(self, typed: bytes) -> bool:
        """Do what the keys say; whether one of them ends it."""
        for key in keys(typed.decode(errors="replace")):
            if not self._top.press(key) and key in _ENDS:
                return True
        return not typed  # the terminal is gone

    def _noticed(self, signals: bytes) -> None:
        for signum in signals:
            if signum in _DEADLY:
                raise SystemExit(128 + signum)
            if signum == signal.SIGTSTP:
                self._stage.leave()
                os.kill(os.getpid(), signal.SIGSTOP)
                self._stage.enter()

    def _lines(self, *, hint: bool) -> list[str]:
        if self._found is None:
            return []
        columns, rows = os.get_terminal_size(1)
        columns, rows = columns or 80, rows or 24
        hint = hint and rows > 2
        text = self._top.lines(self._found, columns, rows - hint, colour=self._colour)
        return [*text.split("\n"), *([end_cut(HINT, columns)] if hint else ())]


def _typed() -> bytes:
    """What was typed; nothing if the window was closed."""
    try:
        return os.read(0, READ_BYTES)
    except OSError:
        return b""


@contextmanager
def _signals() -> Iterator[int]:
    """A descriptor that tells the signals which are to be noticed between two looks."""
    reading, writing = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    before = {signum: signal.signal(signum, lambda *_: None) for signum in _NOTICED}
    old = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    try:
        yield reading
    finally:
        signal.set_wakeup_fd(old)
        for signum, handler in before.items():
            signal.signal(signum, handler)
        os.close(reading)
        os.close(writing)
