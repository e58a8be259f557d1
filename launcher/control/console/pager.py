"""Lines of text in a few rows of the terminal, which can be scrolled and follow what is added."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from prompt_toolkit.formatted_text import ANSI, to_formatted_text
from prompt_toolkit.utils import get_cwidth

from launcher.control.console.bar import Line

MAX_LINES = 5000
CACHED_LINES = 500
TAB_COLUMNS = 8

Position = tuple[int, int]  # the number of a line, counted from the first, and a row in it


class Pager:
    """Shows the last lines until it is scrolled up; the end makes it follow again."""

    def __init__(self, *, follows: bool) -> None:
        self._lines: deque[str] = deque(maxlen=MAX_LINES)
        self._count = 0  # of all lines so far
        self._columns, self._page = 80, 1
        self._rows: dict[int, list[Line]] = {}
        # The row at the bottom; None: the last one, whatever is added.
        self._bottom: Position | None = None
        self._starts_at_top = not follows

    def add(self, lines: Iterable[str]) -> None:
        for line in lines:
            self._lines.append(line)
            self._count += 1

    @property
    def is_following(self) -> bool:
        return self._bottom is None and not self._starts_at_top

    @property
    def is_full(self) -> bool:
        """Whether the next line drops the oldest one."""
        return len(self._lines) == MAX_LINES

    @property
    def place(self) -> str:
        """`120 of 812`: the line at the bottom."""
        number, _ = self._shown_bottom
        return f"{max(0, number + 1)} of {self._count}"

    # ---- keys

    def press(self, key: str) -> bool:
        """Scroll; False for any other key."""
        match key:
            case "up":
                self._move(-1)
            case "down":
                self._move(1)
            case "pageup" | "b":
                self._move(-self._page)
            case "pagedown" | " ":
                self._move(self._page)
            case "home" | "g":
                self._bottom = self._moved(self._top, self._page - 1)
            case "end" | "G" | "f":
                self._bottom, self._starts_at_top = None, False
            case _:
                return False
        return True

    def _move(self, rows: int) -> None:
        """Down to the last row, after which it follows; up until the first row is at the top."""
        self._bottom = self._moved(self._shown_bottom, rows)
        self._bottom = self._shown_bottom
        if self._bottom >= self._last:
            self._bottom = None

    # ---- drawing

    def lines(self, columns: int, rows: int) -> list[Line]:
        """As many rows as there is text for, at most `rows`."""
        if columns != self._columns:
            self._rows.clear()
            self._bottom = self._bottom and (self._bottom[0], 0)
        self._columns, self._page = columns, max(1, rows)
        if not self._lines:
            return []
        if self._starts_at_top:
            self._starts_at_top = False
            self.press("home")
        number, row = self._shown_bottom
        shown = self._rows_of(number)[: row + 1]
        while len(shown) < rows and number > self._top[0]:
            number -= 1
            shown = self._rows_of(number) + shown
        return shown[-rows:]

    @property
    def _top(self) -> Position:
        return self._count - len(self._lines), 0

    @property
    def _last(self) -> Position:
        if not self._lines:
            return -1, 0
        return self._count - 1, len(self._rows_of(self._count - 1)) - 1

    @property
    def _shown_bottom(self) -> Position:
        """The row at the bottom; what it stood for may be gone, or be less than a page."""
        return max(self._bottom or self._last, self._moved(self._top, self._page - 1))

    def _moved(self, position: Position, rows: int) -> Position:
        number, row = position
        row += rows
        while row < 0 and number > self._top[0]:
            number -= 1
            row += len(self._rows_of(number))
        while self._lines and number < self._count - 1 and row >= len(self._rows_of(number)):
            row -= len(self._rows_of(number))
            number += 1
        return min(max((number, row), self._top), self._last)

    def _rows_of(self, number: int) -> list[Line]:
        rows = self._rows.get(number)
        if rows is None:
            if len(self._rows) >= CACHED_LINES:
                self._rows.clear()
            index = max(0, number - self._top[0])
            rows = self._rows[number] = wrapped(self._lines[index], self._columns)
        return rows


def wrapped(text: str, columns: int) -> list[Line]:
    """A line with colours as rows of at most so many columns."""
    rows: list[Line] = [[]]
    used = 0
    for style, part, *_ in to_formatted_text(ANSI(text)):
        for character in part:
            if character == "\t":
                character = " " * min(TAB_COLUMNS - used % TAB_COLUMNS, max(1, columns - used))
            width = get_cwidth(character)
            if used + width > columns and used:
                rows.append([])
                used = 0
            used += width
            if rows[-1] and rows[-1][-1][0] == style:
                rows[-1][-1] = (style, rows[-1][-1][1] + character)
            else:
                rows[-1].append((style, character))
    return rows
