"""The picker's list: which process is chosen, and the command that a key stands for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from prompt_toolkit.formatted_text import ANSI, to_formatted_text

from launcher.control.console.bar import Line, fitted
from launcher.control.console.process_tables import process_table, render
from launcher.control.console.short_forms import end_cut

Process = Mapping[str, Any]  # a row of `ps`
Words = tuple[str, ...]  # a verb and the name of a process

CLOSE: Words = ()
HEAD_ROWS = 5  # with fewer rows, the list has no head
MARK_COLUMNS = 3  # `>1 `
DIGITS = "123456789"
_ALIVE = ("STARTING", "RUNNING", "BACKOFF", "STOPPING")
_CLOSING = ("q", "c-d", "f2", "escape")


def command_of(key: str, process: Process, everyone: Sequence[Process]) -> Words | None:
    """The command of a key for this process; None if the key has none."""
    name = process["name"]
    commands: dict[str, Words] = {
        "s": ("stop" if process["state"] in _ALIVE else "start", name),
        "k": ("kill", name),
        "r": ("restart", name),
        "m": ("unmute" if process.get("muted") else "mute", name),
        "o": ("unmute",) if _is_alone(process, everyone) else ("solo", name),
        "i": ("info", name),
        "c-m": ("logs", name),
        "w": ("web",),
    }
    return commands.get(key)


def _is_alone(process: Process, everyone: Sequence[Process]) -> bool:
    """Whether a `solo` shows only this process."""
    shown = [one for one in everyone if one.get("hidden_by") != "solo"]
    return len(shown) < len(everyone) and [one["name"] for one in shown] == [process["name"]]


def key_hints(process: Process | None, everyone: Sequence[Process]) -> list[str]:
    """`s stop`, `m mute` and so on, in the words of what the keys do now."""
    if process is None:
        return []
    hints = []
    for key in "skrmo":
        words = command_of(key, process, everyone)
        assert words is not None
        hints.append(f"{key} {'end solo' if words == ('unmute',) else words[0]}")
    return hints


class Picker:
    """A list of processes to choose from; it keeps to the chosen one while others come and go."""

    def __init__(self) -> None:
        self.search = ""
        self.is_searching = False
        self._chosen: str | None = None
        self._everyone: Sequence[Process] = ()
        self._found: list[Process] = []
        self._place = self._first = 0
        self._page = 1
        self._above = 0  # rows above the first process

    def update(self, everyone: Sequence[Process]) -> None:
        """Take new rows of `ps`."""
        self._everyone = everyone
        text = self.search.casefold()
        self._found = [one for one in everyone if any(text in n.casefold() for n in _names(one))]
        names = [one["name"] for one in self._found]
        if self._chosen in names:
            self._place = names.index(self._chosen)
        else:
            self._choose(self._place)

    @property
    def chosen(self) -> Process | None:
        return self._found[self._place] if self._found else None

    def _choose(self, place: int) -> None:
        self._place = max(0, min(place, len(self._found) - 1))
        self._chosen = self._found[self._place]["name"] if self._found else None

    # ---- keys

    def press(self, key: str, text: str) -> Words | None:
        """The command that the key asks for, CLOSE, or None if it only changes the list."""
        if key in (steps := self._steps()):
            self._choose(self._place + steps[key])
        elif self.is_searching:
            self._edit(key, text)
        elif key == "/":
            self.is_searching = True
        elif key == "escape" and self.search:
            self._search_for("")
        elif key in _CLOSING:
            return CLOSE
        elif key in DIGITS:
            self._choose_row(int(key) - 1)
        elif self.chosen is not None:
            return command_of(key, self.chosen, self._everyone)
        return None

    def _steps(self) -> dict[str, int]:
        count = len(self._found)
        return {
            "up": -1,
            "down": 1,
            "pageup": -self._page,
            "pagedown": self._page,
            "home": -count,
            "end": count,
        }

    def _choose_row(self, row: int) -> None:
        if row < min(self._page, len(self._found) - self._first):
            self._choose(self._first + row)

    def _edit(self, key: str, text: str) -> None:
        if key in ("escape", "c-m", "c-i"):
            self.is_searching = False
        if key == "escape":
            self._search_for("")
        elif key == "c-h":
            self.is_searching = bool(self.search)
            self._search_for(self.search[:-1])
        elif key == "c-u":
            self._search_for("")
        elif key == "<bracketed-paste>" or len(key) == 1:
            self._search_for(self.search + "".join(filter(str.isprintable, text.split("\n")[0])))

    def _search_for(self, text: str) -> None:
        self.search = text
        self._place = 0  # unless the chosen one is found again
        self.update(self._everyone)

    # ---- drawing

    def height(self) -> int:
        """Rows that show everything; a search does not change them."""
        return 2 + max(1, len(self._everyone))

    def lines(self, columns: int, rows: int, *, colour: bool) -> list[Line]:
        """A title, a head and processes, in at most `rows` rows."""
        has_head = rows >= HEAD_ROWS
        self._above = (rows > 1) + has_head
        self._page = max(1, rows - self._above)
        self._scroll()
        lines = [fitted(self._title(), columns)][: rows - 1]
        seen = self._found[self._first : self._first + self._page]
        if not seen:
            return [*lines, [("", end_cut("no process has this name", columns))]]
        inner = max(1, columns - MARK_COLUMNS)
        texts = render(process_table(seen, inner, has_head=has_head), inner, colour=colour)
        head, *rest = texts.split("\n") if has_head else ("", *texts.split("\n"))
        if has_head:
            lines.append(fitted([("", " " * MARK_COLUMNS), *_fragments(head)], columns))
        return lines + [fitted(self._row(row, text), columns) for row, text in enumerate(rest)]

    def cursor(self, lines: Sequence[Line]) -> tuple[int, int]:
        """(character, row): behind the search while it is typed, else the chosen process."""
        if self.is_searching:
            return max(0, sum(len(text) for _, text in lines[0]) - 1), 0
        return 0, self._above + self._place - self._first

    def _scroll(self) -> None:
        self._first = max(0, min(self._first, len(self._found) - self._page))
        self._first = max(min(self._first, self._place), self._place - self._page + 1)

    def _title(self) -> Line:
        count = len(self._found)
        last = min(count, self._first + self._page)
        seen = f"{count}" if count <= self._page else f"{self._first + 1}-{last} of {count}"
        line: Line = [("class:prompt", f"processes: {seen}")]
        if self.search or self.is_searching:
            line.append(("class:prompt", "  /"))
            line.append(("", f"{self.search} "))  # the blank is where the cursor is
        return line

    def _row(self, row: int, text: str) -> Line:
        is_chosen = self._first + row == self._place
        mark = f"{'>' if is_chosen else ' '}{DIGITS[row : row + 1] or ' '} "
        style = "class:chosen " if is_chosen else ""
        return [(style + old, part) for old, part in [("", mark), *_fragments(text)]]


def _fragments(text: str) -> Line:
    return [(style, part) for style, part, *_ in to_formatted_text(ANSI(text))]


def _names(process: Process) -> list[str]:
    return [process["name"], process.get("label") or "", *(process.get("node_names") or ())]
