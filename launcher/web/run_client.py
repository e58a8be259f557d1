"""The control socket of a run (docs/reference/control.md), for asyncio: requests and streams."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from launcher.base import strict_json
from launcher.control.protocol import Request
from launcher.posix.socket_directory import ControlError

_LINE_LIMIT = 16 * 1024 * 1024  # an answer of `logs` has 1 MB of lines
_HELLO_TIMEOUT_S = 10.0

Answer = dict[str, Any]
OnItem = Callable[[dict[str, Any]], None]


class RunClient:
    """One connection. `on_end` is called once, when the run closes it or has ended.

    `said_goodbye` is then True if a stream was ended by the run, and False if it was killed.
    """

    def __init__(self, on_end: Callable[[], None]) -> None:
        self.hello: dict[str, Any] = {}
        self.said_goodbye = False
        self.failure: Exception | None = None  # what was raised for an item
        self._on_end = on_end
        self._ids = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[Answer]] = {}
        self._streams: dict[int, OnItem] = {}
        self._writer: asyncio.StreamWriter | None = None
        self._task: asyncio.Task[None] | None = None

    async def connect(self, path: Path) -> None:
        """Connect to the run at this socket; ControlError."""
        try:
            reader, self._writer = await asyncio.open_unix_connection(path, limit=_LINE_LIMIT)
            line = await asyncio.wait_for(reader.readline(), _HELLO_TIMEOUT_S)
        except (TimeoutError, asyncio.TimeoutError):
            raise ControlError(f"{path}: the run does not answer") from None
        except OSError as error:
            raise ControlError(f"{path}: {error.strerror or error}") from None
        self.hello = strict_json.loads(line) if line.strip() else {}
        if "run" not in self.hello:
            refusal = self.hello.get("error") or {}
            raise ControlError(f"{path}: {refusal.get('message', 'the run has ended')}")
        self._task = asyncio.create_task(self._read(reader))

    async def ask(
        self, verb: str, names: Sequence[str] = (), options: Mapping[str, Any] | None = None
    ) -> Answer:
        """The last answer to a request, as the protocol has it."""
        number = self._send(verb, names, options or {})
        future: asyncio.Future[Answer] = asyncio.get_running_loop().create_future()
        self._waiting[number] = future
        try:
            return await future
        finally:
            self._waiting.pop(number, None)

    def follow(self, verb: str, on_item: OnItem, **options: Any) -> None:
        """Call `on_item` with each item of a stream until the end of the run."""
        self._streams[self._send(verb, (), {"follow": True, **options})] = on_item

    def _send(self, verb: str, names: Sequence[str], options: Mapping[str, Any]) -> int:
        number = next(self._ids)
        request = Request(number, verb, tuple(names), options)
        if self._writer is not None and not self._writer.is_closing():
            self._writer.write(request.line())
        return number

    async def _read(self, reader: asyncio.StreamReader) -> None:
        try:
            async for answer in _answers(reader):
                self._take(answer)
        except Exception as error:  # else it would be lost
            self.failure = error
        for future in self._waiting.values():
            if not future.done():
                future.set_result(_ENDED)
        if self._writer is not None:
            self._writer.close()
        self._on_end()

    def _take(self, answer: Answer) -> None:
        number = answer.get("id")
        if not isinstance(number, int):
            return
        on_item = self._streams.get(number)
        if on_item is not None:
            if "item" in answer:
                on_item(answer["item"])
            elif (answer.get("result") or {}).get("ended"):
                self.said_goodbye = True
            return
        future = self._waiting.get(number)
        if future is not None and not future.done():
            future.set_result(answer)

    async def close(self) -> None:
        """Close the connection; `on_end` is called."""
        if self._writer is not None:
            self._writer.close()
        if self._task is not None:
            await asyncio.wait([self._task], timeout=1.0)


async def _answers(reader: asyncio.StreamReader) -> AsyncIterator[Answer]:
    with contextlib.suppress(OSError, ValueError):  # it was killed in the middle of a line
        while line := await reader.readline():
            yield strict_json.loads(line)


_ENDED: Answer = {"ok": False, "error": {"code": "stopping", "message": "the run has ended"}}
