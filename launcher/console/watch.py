"""Watch: an answer that does not end: `top` as a live table, `logs -f` and `events -f` as lines."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from prompt_toolkit.data_structures import Size

from launcher.console import requests
from launcher.console.display import GUTTER, LITTLE_HEIGHT, Display
from launcher.console.top import KEYS_HINT, Top
from launcher.control.client import Connection
from launcher.control.runs import Run
from launcher.control.socket_directory import ControlError
from launcher.control.verbs import Call


def table_rows(rows: int) -> int:
    """How many of the terminal's rows are for a table: the prompt, the bar, output have others."""
    if rows < LITTLE_HEIGHT:
        return max(1, rows - 2)
    return rows - 3 - min(3, (rows - LITTLE_HEIGHT) // 4)


class Watch:
    """`run` follows in a thread of its own until `close`, or until the run ends.

    `hint` says what keys do.
    """

    def __init__(self, run: Run, call: Call, display: Display, size: Callable[[], Size]) -> None:
        self._run = run
        self._call = call
        self._display = display
        self._size = size
        self._connection: Connection | None = None
        self._closed = False
        self._top = Top()
        self._found: Sequence[Mapping[str, Any]] | None = None
        self._drawn: tuple[Size, str] | None = None
        self._is_table = call.verb.name == "top"
        self.hint = (
            f"{KEYS_HINT} | any other key ends this" if self._is_table else "any key ends this"
        )

    def run(self, loop: asyncio.AbstractEventLoop) -> None:
        """Follow; what comes is shown on the loop's thread."""
        try:
            with self._run.connect() as self._connection:
                if self._closed:  # by a key that came before the connection
                    return
                for item in requests.items(self._connection, self._call):
                    loop.call_soon_threadsafe(self._show, item)
        except ControlError as error:
            if not self._closed:
                columns = self._size().columns - len(GUTTER)
                text = requests.problem(error, columns, colour=self._display.colour)
                loop.call_soon_threadsafe(self._display.answer, text)

    def close(self) -> None:
        """End it: the thread wakes up and finds its connection shut."""
        self._closed = True
        if self._connection is not None:
            with contextlib.suppress(OSError), socket.socket(fileno=self._duplicate()) as shut:
                shut.shutdown(socket.SHUT_RDWR)

    def _duplicate(self) -> int:
        assert self._connection is not None
        return os.dup(self._connection.fileno())

    def _show(self, item: Mapping[str, Any]) -> None:
        if self._closed:
            return
        if "processes" not in item:
            self._display.answer(requests.item_text(self._call, item))
            return
        self._found = item["processes"]
        self._draw_anew()

    def press(self, key: str) -> None:
        """Scroll or sort the table; every other key ends it."""
        if self._is_table and self._top.press(key):
            self._draw_anew()
        else:
            self.close()

    def text(self) -> str:
        """The table to show above the prompt, for the size that the terminal has now."""
        if self._found is None:
            return ""
        size = self._size()
        if self._drawn is None or self._drawn[0] != size:
            colour = self._display.colour
            text = self._top.lines(self._found, size.columns, table_rows(size.rows), colour=colour)
            self._drawn = size, text
        return self._drawn[1]

    def _draw_anew(self) -> None:
        self._drawn = None
        self._display.footer_changed()
        self._display.application.invalidate()

    @property
    def is_closed(self) -> bool:
        """Whether it is ending."""
        return self._closed
