"""Streams in the console: `top` as a live table, `logs -f` and `events -f` as lines."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from prompt_toolkit.data_structures import Size

from launcher.base.run_verb import Call
from launcher.control.active_runs import ListedRun
from launcher.control.answer_lines import event_line, log_line, without_colour
from launcher.control.client import Connection
from launcher.control.console.display import GUTTER, SHORT_ROWS, Display
from launcher.control.console.requests import problem
from launcher.control.console.top import KEYS_HINT, Top
from launcher.control.fault_texts import FaultLines
from launcher.posix.socket_directory import ControlError


def table_rows(rows: int) -> int:
    """How many rows of the terminal the table gets, beside prompt, bar and output."""
    if rows < SHORT_ROWS:
        return max(1, rows - 2)
    return rows - 3 - min(3, (rows - SHORT_ROWS) // 4)


class StreamView:
    """Shows a stream until `close`, or until the run ends; `hint` explains the keys."""

    def __init__(
        self, run: ListedRun, call: Call, display: Display, size: Callable[[], Size]
    ) -> None:
        self._run = run
        self._call = call
        self._display = display
        self._size = size
        self._connection: Connection | None = None
        self.is_closed = False
        self._top = Top()
        self._found: Sequence[Mapping[str, Any]] | None = None
        self._drawn: tuple[Size, str] | None = None
        self._line_of = {"logs": log_line, "faults": FaultLines().of}.get(
            call.verb.name, event_line
        )
        self._is_table = call.verb.name == "top"
        self.hint = (
            f"{KEYS_HINT} | any other key ends this" if self._is_table else "any key ends this"
        )

    def run(self, loop: asyncio.AbstractEventLoop) -> None:
        """Read the stream, in a separate thread; items are shown on that of `loop`."""
        try:
            with self._run.connect() as self._connection:
                if self.is_closed:  # by a key before it was connected
                    return
                call = self._call
                for item in self._connection.follow(call.verb.name, call.names, **call.options):
                    loop.call_soon_threadsafe(self._show, item)
        except ControlError as error:
            if not self.is_closed:
                columns = self._size().columns - len(GUTTER)
                text = problem(error, columns, colour=self._display.colour)
                loop.call_soon_threadsafe(self._display.answer, text)

    def close(self) -> None:
        self.is_closed = True
        if self._connection is not None:
            self._connection.shutdown()

    def _show(self, item: Mapping[str, Any]) -> None:
        if self.is_closed:
            return
        if self._is_table:
            self._found = self._found if "dropped" in item else item["processes"]
            self._redraw()
        else:
            line = self._line_of(item)
            if line is not None:
                self._display.answer(line if self._display.colour else without_colour(line))

    def press(self, key: str) -> None:
        """Scroll or sort the table, or close."""
        if self._is_table and self._top.press(key):
            self._redraw()
        else:
            self.close()

    def text(self) -> str:
        """The table above the prompt, in the current size of the terminal."""
        if self._found is None:
            return ""
        size = self._size()
        if self._drawn is None or self._drawn[0] != size:
            colour = self._display.colour
            text = self._top.lines(self._found, size.columns, table_rows(size.rows), colour=colour)
            self._drawn = size, text
        return self._drawn[1]

    def _redraw(self) -> None:
        self._drawn = None
        self._display.footer_changed()
        self._display.application.invalidate()
