"""Messages to the pages: each is encoded once, and a page that reads slowly delays nobody."""

from __future__ import annotations

import asyncio
import re
from collections import deque
from collections.abc import Callable, Coroutine
from typing import Any

from launcher.base import strict_json

QUEUE_BYTES = 4 * 1024 * 1024  # what may wait for one page, of what may be left out
MOST_BYTES = QUEUE_BYTES + 2 * 1024 * 1024  # of the news: a page that has not read that is closed

Message = dict[str, Any]
_LARGEST = 2**53 - 1  # Number.MAX_SAFE_INTEGER
_BIG = re.compile(r"\d{16}")

# Of these events only the newest counts.
_LATEST = frozenset(
    {"processes", "graph", "topics", "plan", "expectations", "history", "probe", "alive"}
)
# These are left out for a page that does not read. Of the others none is: it has all, or is closed.
_EXPENDABLE = frozenset({"lines", "message", "points"})


def encode(message: Message) -> str:
    """JSON. Integers that JavaScript would round become texts, in messages and answers."""
    text = _dumps(message)
    if message.get("event", "message") == "message" and _BIG.search(text):
        return _dumps(_exact(message))
    return text


def _dumps(value: object) -> str:
    return strict_json.dumps(value, separators=(",", ":"), ensure_ascii=False, default=str)


def _exact(value: object) -> Any:
    if isinstance(value, dict):
        return {key: _exact(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_exact(one) for one in value]
    is_big = isinstance(value, int) and not -_LARGEST <= value <= _LARGEST
    return str(value) if is_big else value


class PageOutbox:
    """What waits for one page. `skipped_lines` counts log lines that it was not sent.

    `on_full` is called when the page has not read for so long that it cannot have everything: a
    browser that is suspended would let the queue grow for days.
    """

    def __init__(self, on_full: Callable[[], None] = lambda: None) -> None:
        self._on_full = on_full
        self._queue: deque[tuple[str, str, int]] = deque()  # event, text, bytes of news
        self._latest: dict[str, str] = {}
        self._bytes = 0
        self._wake = asyncio.Event()
        self.skipped_lines = 0

    def put(self, event: str, text: str, lines: int = 0) -> None:
        """Queue an encoded message; `lines`: how many log lines it holds."""
        if event not in _LATEST:
            if event in _EXPENDABLE and self._bytes > QUEUE_BYTES:
                self.skipped_lines += lines
                return
            if self._bytes > MOST_BYTES:
                self._on_full()
                return
        self._add(event, text, len(text))

    def put_asked(self, event: str, text: str) -> None:
        """Queue what the page has asked for, of any size: who does not read does not ask."""
        self._add(event, text, 0)

    def _add(self, event: str, text: str, size: int) -> None:
        if event not in _LATEST:
            self._queue.append((event, text, size))
            self._bytes += size
        else:
            if event not in self._latest:
                self._queue.append((event, "", 0))
            self._latest[event] = text
        self._wake.set()

    async def get(self) -> str:
        """The next message."""
        while not self._queue:
            self._wake.clear()
            await self._wake.wait()
        event, text, size = self._queue.popleft()
        self._bytes -= size
        return self._latest.pop(event) if event in _LATEST else text


class Hub:
    """All pages that are open. `on_change` is called when their subscriptions have changed.

    A subscription is ("topics", ""), ("echo", topic) or ("plot", "topic\\nfield"): what is
    expensive is read only while a page shows it.
    """

    def __init__(
        self,
        on_change: Callable[[], None],
        on_failure: Callable[[BaseException], None] = lambda error: None,
    ) -> None:
        self._pages: dict[PageOutbox, set[tuple[str, str]]] = {}
        self._on_change = on_change
        self.fail = on_failure  # for what all pages need and that cannot go on

    def start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Do what all pages need in the background; what ends it is a failure of the server."""
        task = asyncio.create_task(work)
        task.add_done_callback(self._ended)
        return task

    def _ended(self, task: asyncio.Task[None]) -> None:
        error = None if task.cancelled() else task.exception()
        if error is not None:
            self.fail(error)

    def __len__(self) -> int:
        return len(self._pages)

    def join(self, outbox: PageOutbox) -> None:
        """Send what follows to this page, too."""
        self._pages.setdefault(outbox, set())

    def leave(self, outbox: PageOutbox) -> None:
        if self._pages.pop(outbox, None):
            self._on_change()

    def set_subscription(self, outbox: PageOutbox, kind: str, what: str, *, on: bool) -> None:
        subscriptions = self._pages.get(outbox)
        if subscriptions is None:
            return
        (subscriptions.add if on else subscriptions.discard)((kind, what))
        self._on_change()

    def subscribed(self, kind: str) -> set[str]:
        """The subscriptions of all pages of a kind."""
        pages = self._pages.values()
        return {what for page in pages for one, what in page if one == kind}

    def send(self, message: Message, *, to: tuple[str, str] | None = None) -> None:
        """Send to all pages, or to those with this subscription."""
        chosen = [page for page, held in self._pages.items() if to is None or to in held]
        if not chosen:
            return
        text = encode(message)
        lines = len(message["lines"]) if message["event"] == "lines" else 0
        for outbox in chosen:
            outbox.put(message["event"], text, lines)
