"""Watch: an answer that does not end: `top` as a live table, `logs -f` and `events -f` as lines."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
from collections.abc import Callable, Mapping
from typing import Any

from prompt_toolkit.data_structures import Size

from launcher.console import tables, talk
from launcher.console.display import Display
from launcher.control.client import Connection
from launcher.control.folder import ControlError
from launcher.control.runs import Run
from launcher.control.verbs import Call

FOOTER_ROWS = 6  # that the prompt, the bar and a few lines of output keep beside a table


class Watch:
    """`run` follows in a thread of its own until `close`, or until the run ends.

    `text` is the table to show above the prompt.
    """

    def __init__(self, run: Run, call: Call, display: Display, size: Callable[[], Size]) -> None:
        self._run = run
        self._call = call
        self._display = display
        self._size = size
        self._connection: Connection | None = None
        self._closed = False
        self.text = ""

    def run(self, loop: asyncio.AbstractEventLoop) -> None:
        """Follow; what comes is shown on the loop's thread."""
        try:
            with self._run.connect() as self._connection:
                for item in talk.items(self._connection, self._call):
                    loop.call_soon_threadsafe(self._show, item)
        except ControlError as error:
            if not self._closed:
                text = talk.problem(error, colour=self._display.colour)
                loop.call_soon_threadsafe(self._display.say, text)

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
            self._display.say(talk.item_text(self._call, item))
            return
        columns, rows = self._size().columns, self._size().rows
        table = tables.processes(item["processes"], columns, max(1, rows - FOOTER_ROWS))
        self.text = tables.render(table, columns, colour=self._display.colour)
        self._display.footer_changed()
        self._display.application.invalidate()
