"""`help`: the verbs that are used most, above the prompt until a line is entered or Esc."""

from __future__ import annotations

from launcher.control.console.bar import Line
from launcher.control.console.display import Display
from launcher.control.console.pager import Pager
from launcher.control.console.process_tables import manual, render
from launcher.control.console.stream_view import table_rows

MAX_ROWS = 12
# Side by side in 66 columns; all others are in `help all`.
ROWS = (
    ("ps, top, info NAME", "state, CPU, memory; live; all facts"),
    ("logs NAME [-f]", "the last lines, hidden ones too"),
    ("start, stop, restart NAME", "NAME may be a pattern, as robot_*"),
    ("kill, pause, resume NAME", "end it at once; suspend it"),
    ("mute, solo, grep, level, show", "which output is shown"),
    ("stack, debug, loglevel NAME", "look into a process"),
    ("events, plan, web", "what happened; started; the page"),
    ("reload, watch on", "apply changes of files"),
    ("topic list, node list, ...", "verbs of shells, until Ctrl-C"),
    ("Tab, Up, F2", "complete; previous lines; processes"),
    ("quit, or Ctrl-C", "stop everything"),
    ("help all, help VERB", "every verb; how one is used"),
)


class HelpView:
    """Opened by `open`; the prompt stays in use below it."""

    def __init__(self, display: Display) -> None:
        self._display = display
        self._pager: Pager | None = None
        self._columns = 0
        self._count = 0  # of the lines in this width
        self._is_cut = False

    @property
    def hint(self) -> str:
        """The keys; empty while it is closed."""
        if self._pager is None:
            return ""
        return "Esc closes the help" + ("  PageUp, PageDown scroll" if self._is_cut else "")

    @property
    def is_open(self) -> bool:
        return self._pager is not None

    def open(self) -> None:
        self._pager, self._columns = Pager(follows=False), 0
        self._redraw()

    def close(self) -> None:
        if self._pager is not None:
            self._pager = None
            self._redraw()

    def press(self, key: str) -> None:
        """Scroll, where the terminal is too low."""
        if self._pager is not None and self._pager.press(key):
            self._redraw()

    def lines(self, columns: int, rows: int) -> list[Line]:
        """What it shows in a terminal of this size."""
        if self._pager is None:
            return []
        if columns != self._columns:
            self._columns, self._pager = columns, Pager(follows=False)
            text = render(manual(ROWS, columns), columns, colour=self._display.colour)
            lines = text.split("\n")
            self._pager.add(lines)
            self._count = len(lines)
        shown = self._pager.lines(columns, max(1, min(MAX_ROWS, table_rows(rows))))
        self._is_cut = len(shown) < self._count
        return shown

    def _redraw(self) -> None:
        self._display.footer_changed()
        self._display.application.invalidate()
