"""Keys of a person while a bag is recorded or played, and a line of status below the output."""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import signal
import sys
import termios
import time
import tty
from collections.abc import Callable, Iterator
from typing import Any, TextIO

from launcher.base.text import escape_controls
from launcher.posix.keys import read_keys
from launcher.ros.verb import unescaped

REDRAW_S = 0.2
_RATE_S = 1.0


class Keys:
    """The keys that were pressed since the last look; none where stdin is no terminal of ours."""

    def __init__(self, *, enabled: bool = True) -> None:
        self.enabled = enabled and sys.stdin.isatty() and _is_in_foreground()
        self._settings: Any = None

    def __enter__(self) -> Keys:
        if self.enabled:
            self._settings = termios.tcgetattr(0)
            self._set_mode()
            signal.signal(signal.SIGCONT, self._set_mode)  # the shell has restored its settings
        return self

    def __exit__(self, *exit_info: object) -> None:
        if self.enabled:
            signal.signal(signal.SIGCONT, signal.SIG_DFL)
            with contextlib.suppress(termios.error):  # the terminal is gone
                termios.tcsetattr(0, termios.TCSANOW, self._settings)

    def _set_mode(self, *_: object) -> None:
        if _is_in_foreground():
            with contextlib.suppress(termios.error):
                tty.setcbreak(0, termios.TCSANOW)

    def pressed(self) -> Iterator[str]:
        """Names of the keys (`up`), or their characters."""
        while self.enabled and _is_in_foreground() and select.select([0], [], [], 0)[0]:
            keys = read_keys()
            self.enabled = bool(keys)  # else the terminal was closed
            yield from keys


def _is_in_foreground() -> bool:
    try:
        return os.tcgetpgrp(0) == os.getpgrp()
    except OSError:
        return False


class StatusLine:
    """One line on the terminal that is drawn every `redraw_s` (None: never), if it is a terminal.

    `escaped_output` would show the control characters that this takes as text, so it writes them to
    the terminal itself, and nothing else.
    """

    def __init__(self, render: Callable[[int], str], redraw_s: float | None = REDRAW_S) -> None:
        self._render = render
        self._redraw_s = redraw_s or 0.0
        is_terminal = sys.stderr.isatty() and os.environ.get("TERM") != "dumb"
        self.enabled = is_terminal and redraw_s is not None
        self._terminal = unescaped(sys.stderr)
        self._next_s = 0.0
        self._drawn = False

    def draw(self, *, now: bool = False) -> None:
        """Draw it if it is time."""
        if not self.enabled or (not now and time.monotonic() < self._next_s):
            return
        self._next_s = time.monotonic() + self._redraw_s
        width = shutil.get_terminal_size().columns
        text = escape_controls(self._render(width - 1))[: width - 1]
        self._control(f"\r{text}\x1b[K")
        self._drawn = True

    def print(self, text: str) -> None:
        """A line that stays, above the status."""
        self.clear()
        _write(sys.stderr, f"{text}\n")
        self.draw(now=True)

    def clear(self) -> None:
        if self._drawn:
            self._control("\r\x1b[K")
            self._drawn = False

    def close(self) -> None:
        """Remove it for good, so that what follows stays alone: lines of ours, then the prompt."""
        self.clear()
        self.enabled = False

    def _control(self, text: str) -> None:
        _write(self._terminal, text)


def _write(stream: TextIO, text: str) -> None:
    """What is recorded and played does not need it: stderr may be on a full disk, or be closed."""
    with contextlib.suppress(OSError):
        stream.write(text)
        stream.flush()


class StatusRates:
    """Messages and bytes per second, over the last second."""

    def __init__(self) -> None:
        self.messages = self.bytes = 0.0
        self._last = (time.monotonic(), 0, 0)

    def update(self, messages: int, amount: int) -> None:
        """Of messages and bytes there are so many by now."""
        then, messages_then, amount_then = self._last
        now = time.monotonic()
        if now - then >= _RATE_S:
            self.messages = (messages - messages_then) / (now - then)
            self.bytes = (amount - amount_then) / (now - then)
            self._last = (now, messages, amount)
