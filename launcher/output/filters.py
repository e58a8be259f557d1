"""Filters that choose which lines of a process are shown; log files and memory get all lines."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Hashable, Sequence

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType
    from typing import Any


MAX_CPU_S = 0.1  # for one block of lines; 64 KiB take a hundredth of that


class Pattern:
    """A user's regular expression that cannot block the run, as `(a+)+$` could; re.error."""

    def __init__(self, text: str) -> None:
        self.text = text
        self._expression = re.compile(text.encode(errors="surrogateescape"))

    def choose(self, lines: Sequence[bytes]) -> list[bytes]:
        """The lines in which it is found; TooSlowError. For the main thread only."""
        with CpuLimit(MAX_CPU_S):
            return [line for line in lines if self._expression.search(line)]


# By the names that ROS prints; Python's logging writes two of them differently.
LEVELS = ("DEBUG", "INFO", "WARN", "ERROR", "FATAL")
_ALIASES = {"WARNING": "WARN", "CRITICAL": "FATAL"}
_COLOUR = rb"(?:\x1b\[[0-9;:]*m)*"
_NAMES = b"|".join(name.encode() for name in (*_ALIASES, *LEVELS))
# At the beginning (`[WARN] [123.4] [node]: text`, `WARNING: text`), or in brackets not far from it.
_LEVEL = re.compile(_COLOUR + rb"\[?(" + _NAMES + rb")\b|.{0,80}?\[(" + _NAMES + rb")\]")
_CONTINUES = (b" ", b"\t")
_TRACEBACK = b"Traceback (most recent call last):"
INFO = LEVELS.index("INFO")
ERROR = LEVELS.index("ERROR")
_IN_TRACEBACK = len(LEVELS)


class LineLevels:
    """The levels of lines, as indices into LEVELS.

    A line without a level is INFO; an indented one belongs to the line before it, and so does the
    last line of a traceback.
    """

    def __init__(self) -> None:
        self._last: dict[Hashable, int] = {}

    def of(self, source: Hashable, line: bytes) -> int:
        """`source` identifies the stream that the line is of."""
        level = level_of(line)
        if level is not None:
            self._last[source] = level
            return level
        if line.startswith(_TRACEBACK):
            self._last[source] = _IN_TRACEBACK
            return ERROR
        before = self._last.get(source, INFO)
        if line.startswith(_CONTINUES):
            return ERROR if before == _IN_TRACEBACK else before
        self._last[source] = INFO
        return ERROR if before == _IN_TRACEBACK else INFO  # `ValueError: ...` below the frames


class LineFilter:
    """Chooses lines; a process that is not filtered has none.

    `level` is an index into LEVELS: lower ones are hidden (`LineLevels`). `hidden_lines`
    counts. A pattern that takes too long is dropped, and `on_slow` is called.
    """

    def __init__(self) -> None:
        self.muted = False  # by name
        self.outside = False  # of a `solo` of other processes
        self.level = 0
        self.pattern: Pattern | None = None
        self.on_slow: Callable[[Pattern], None] = lambda pattern: None
        self.hidden_lines = 0
        self._levels = LineLevels()

    @property
    def is_open(self) -> bool:
        return not (self.muted or self.outside or self.level or self.pattern)

    @property
    def is_silent(self) -> bool:
        return self.muted or self.outside

    def choose(self, source: int, lines: bytes) -> bytes:
        """The lines to show, of these whole lines; `source` identifies the stream."""
        if self.is_silent:
            self.hidden_lines += lines.count(b"\n")
            return b""
        shown = lines[:-1].split(b"\n")
        if self.level:
            shown = [line for line in shown if self._levels.of(source, line) >= self.level]
        if self.pattern is not None:
            shown = self._found(shown, self.pattern)
        self.hidden_lines += lines.count(b"\n") - len(shown)
        return b"\n".join(shown) + b"\n" if shown else b""

    def _found(self, lines: list[bytes], pattern: Pattern) -> list[bytes]:
        try:
            return pattern.choose(lines)
        except TooSlowError:
            self.pattern = None
            self.on_slow(pattern)
            return lines


def level_of(line: bytes) -> int | None:
    """The level that a line names, as an index into LEVELS; None if it names none."""
    found = _LEVEL.match(line)
    if found is None:
        return None
    name = (found[1] or found[2]).decode()
    return LEVELS.index(_ALIASES.get(name, name))


def level_named(word: str) -> int:
    """The index of `WARN`, `warning`, `all` (everything) and so on; ValueError."""
    name = word.upper()
    if name in ("ALL", "OFF"):
        return 0
    name = _ALIASES.get(name, name)
    if name not in LEVELS:
        raise ValueError(f"unknown level '{word}'")
    return LEVELS.index(name)


class TooSlowError(Exception):
    """What was limited has used up its CPU time."""


class CpuLimit:
    """Within, TooSlowError after `max_cpu_s` of CPU time of this process, as `(a+)+$` takes.

    For the main thread only. Python handles signals while it searches, unlike in the middle of
    arithmetic.
    """

    def __init__(self, max_cpu_s: float) -> None:
        self._max_cpu_s = max_cpu_s
        self._is_at_work = False
        self._before: Any = None

    def __enter__(self) -> None:
        self._before = signal.signal(signal.SIGVTALRM, self._struck)
        self._is_at_work = True
        signal.setitimer(signal.ITIMER_VIRTUAL, self._max_cpu_s)

    def __exit__(self, *exc: object) -> None:
        self._is_at_work = False
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, self._before)

    def _struck(self, signum: int, frame: FrameType | None) -> None:
        if self._is_at_work:
            raise TooSlowError
