"""The panel below the output: the picker, and the log or the facts of the process it chose."""

from __future__ import annotations

import asyncio
import shlex
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from launcher.control.active_runs import ListedRun
from launcher.control.answer_lines import log_line
from launcher.control.client import Connection
from launcher.control.console.bar import Line, fitted
from launcher.control.console.display import SHORT_ROWS, Display
from launcher.control.console.pager import Pager
from launcher.control.console.picker import CLOSE, Picker, Words, command_of, key_hints
from launcher.control.console.process_tables import state
from launcher.control.console.requests import answer, problem, read_call
from launcher.control.console.terminal import Terminal
from launcher.posix.socket_directory import ControlError

HISTORY_LINES = 1000  # of a log, when it is opened
FRAME_S = 1 / 20  # between two drawings of a log
PENDING_LINES = 1000  # of a log, between two drawings
SLOW_S = 0.2  # until a slow terminal is tried again
BACK = "q back"
_BACK_KEYS = ("q", "escape", "left", "c-d", "f2")
_ACTS = ("s", "k", "r", "m", "o", "i", "w")

Processes = Callable[[], Sequence[Mapping[str, Any]]]


class ProcessView:
    """The text of one process, read in a separate thread; `changed` is called on the loop.

    The thread waits while PENDING_LINES have not been taken. Then the run drops lines, and says so.
    """

    def __init__(self, verb: str, name: str, changed: Callable[[], None]) -> None:
        self.verb, self.name = verb, name
        self.pager = Pager(follows=verb == "logs")
        self.is_closed = False
        self._changed = changed
        self._loop = asyncio.get_running_loop()
        self._arrived: list[str] = []
        self._is_announced = False
        self._condition = threading.Condition()
        self._connection: Connection | None = None

    # ---- in the thread

    def read(self, run: ListedRun, columns: int, *, colour: bool) -> None:
        """Read until it is closed or the run ends."""
        try:
            if self.verb == "info":
                call = read_call(shlex.join((self.verb, self.name)))
                self._add(*answer(run, call, columns, colour=colour).split("\n"))
            else:
                self._follow(run)
        except ControlError as error:
            self._add(*problem(error, columns, colour=colour).split("\n"))

    def _follow(self, run: ListedRun) -> None:
        with run.connect() as self._connection:
            if self.is_closed:  # by a key before it was connected
                return
            for item in self._connection.follow(self.verb, [self.name], lines=HISTORY_LINES):
                self._add(log_line(item) if "dropped" in item else item["text"])

    def _add(self, *lines: str) -> None:
        with self._condition:
            self._condition.wait_for(lambda: len(self._arrived) < PENDING_LINES or self.is_closed)
            self._arrived += lines
            if self._is_announced or self.is_closed:
                return
            self._is_announced = True
        self._loop.call_soon_threadsafe(self._loop.call_later, FRAME_S, self.take)

    # ---- on the loop

    def take(self) -> None:
        """Take what has arrived, unless that would drop lines that are being looked at."""
        if self.is_closed or (self.pager.is_full and not self.pager.is_following):
            return
        with self._condition:
            lines, self._arrived = self._arrived, []
            self._is_announced = False
            self._condition.notify()
        if lines:
            self.pager.add(lines)
            self._changed()

    def close(self) -> None:
        with self._condition:
            self.is_closed = True
            self._condition.notify()
        if self._connection is not None:
            self._connection.shutdown()


class Panel:
    """Opened by `open`; keys go to `press` while it `is_open`. `enter` runs a line."""

    def __init__(
        self,
        run: ListedRun,
        display: Display,
        terminal: Terminal,
        processes: Processes,
        enter: Callable[[str], None],
    ) -> None:
        self._run = run
        self._display = display
        self._terminal = terminal
        self._processes = processes
        self._enter = enter
        self._picker: Picker | None = None
        self._view: ProcessView | None = None
        self._is_delayed = False

    @property
    def is_open(self) -> bool:
        return self._picker is not None

    def open(self) -> None:
        if self._picker is None:
            self._picker = Picker()
            self._draw()

    def close(self) -> None:
        self._close_view()
        self._picker = None
        self._draw()

    def _close_view(self) -> None:
        if self._view is not None:
            self._view.close()
        self._view = None

    # ---- keys

    def press(self, key: str, text: str) -> None:
        if self._picker is None:
            return
        self._picker.update(self._processes())
        if self._view is None:
            self._do(self._picker.press(key, text))
        elif key in _BACK_KEYS:
            self._close_view()
        elif self._view.pager.press(key):
            self._view.take()
        elif key in _ACTS:
            process = self._of(self._view.name)
            if process is not None:
                self._do(command_of(key, process, self._processes()))
        self._draw()

    def _do(self, words: Words | None) -> None:
        if words == CLOSE:
            self.close()
        elif words and words[0] in ("logs", "info"):
            self._show(*words)
        elif words:
            self._enter(shlex.join(words))

    def _show(self, verb: str, name: str) -> None:
        self._close_view()
        view = self._view = ProcessView(verb, name, self._redraw)
        columns, colour = self._terminal.size().columns, self._display.colour
        threading.Thread(
            target=view.read, args=(self._run, columns), kwargs={"colour": colour}, daemon=True
        ).start()

    def _of(self, name: str) -> Mapping[str, Any] | None:
        return next((one for one in self._processes() if one["name"] == name), None)

    # ---- drawing

    def lines(self, columns: int, rows: int) -> list[Line]:
        """What it shows in a terminal of this size."""
        if self._picker is None:
            return []
        self._picker.update(self._processes())
        if self._view is None:
            height = min(self._picker.height(), _height(rows, 1 / 2))
            lines = self._picker.lines(columns, height, colour=self._display.colour)
        else:
            height = _height(rows, 2 / 3)
            title = [fitted(self._title(self._view), columns)][: height - 1]
            lines = [*title, *self._view.pager.lines(columns, height - len(title))]
        return lines + [[("", "")]] * (height - len(lines))

    def cursor(self, lines: Sequence[Line]) -> tuple[int, int]:
        """(character, row) in these lines."""
        if self._picker is None or self._view is not None:
            return 0, 0
        return self._picker.cursor(lines)

    @property
    def has_cursor(self) -> bool:
        """Whether a text is being typed."""
        return self._picker is not None and self._view is None and self._picker.is_searching

    def _title(self, view: ProcessView) -> Line:
        process = self._of(view.name)
        pager = view.pager
        what = "following" if pager.is_following and view.verb == "logs" else f"line {pager.place}"
        title: Line = [("class:prompt", f"{view.verb} {view.name}: ")]
        if process is not None:
            title.append(("", f"{state(process).plain}, "))
        return [*title, ("", what)]

    def hint(self, columns: int) -> str:
        """The keys, as many as fit; empty while it is closed."""
        if self._picker is None:
            return ""
        everyone = self._processes()
        if self._view is not None:
            keys = key_hints(self._of(self._view.name), everyone)
            follows = ["End follows"] if self._view.verb == "logs" else []
            return _fitting(["arrows scroll", *follows, *keys, "i info", BACK], columns)
        if self._picker.is_searching:
            return _fitting(["Enter keeps", "Esc clears", "arrows choose"], columns)
        if self._picker.chosen is None:
            return _fitting([BACK, "/ search"], columns)
        keys = key_hints(self._picker.chosen, everyone)
        return _fitting(["Enter log", *keys, "i info", "/ search", BACK], columns)

    def _draw(self) -> None:
        self._display.footer_changed()
        self._display.application.invalidate()

    def _redraw(self) -> None:
        """Draw what was added; a slow terminal is not given more than it can show."""
        if not self._terminal.is_slow:
            self._draw()
        elif not self._is_delayed:
            self._is_delayed = True
            asyncio.get_running_loop().call_later(SLOW_S, self._retry)

    def _retry(self) -> None:
        self._is_delayed = False
        self._redraw()


def _height(rows: int, part: float) -> int:
    """Rows of the panel: the part of the terminal that leaves room for output and status bar."""
    if rows < SHORT_ROWS:
        return max(1, rows - 2)
    return max(3, min(int(rows * part) + 1, rows - 4))


def _fitting(keys: Sequence[str], columns: int) -> str:
    """As many keys as fit; the way back is the last to be left out."""
    back = [BACK] if BACK in keys else []
    others = [key for key in keys if key != BACK]
    while others and len("  ".join([*others, *back])) > columns:
        others.pop()
    return "  ".join([*others, *back])
