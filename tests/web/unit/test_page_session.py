"""One page: when its socket is closed, and what odd requests are answered."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from starlette.websockets import WebSocket

from launcher.web.graph_feed import GraphFeed
from launcher.web.hub import MOST_BYTES, Hub, Message
from launcher.web.page_session import (
    BROKEN,
    MAX_PAGES,
    NO_KEY,
    TOO_MANY,
    Doors,
    Feeds,
    PageSession,
)
from launcher.web.run_feed import _FIRST_LINES, RunFeed

KEY = "the key"
DEADLINE_S = 60.0


class Feed(RunFeed):
    """A run that has said nothing but its name."""

    @property
    def run(self) -> dict[str, Any]:
        return {"id": "1"}


class NoGraph(GraphFeed):
    """That of a machine where the probe cannot be started, which a slow test would start."""

    async def start(self) -> None:
        self.reason = "there is no probe"


class Page:
    """A socket with a session: `said` is what the page is sent, `code` that of the close."""

    def __init__(self, doors: Doors, key_s: float = DEADLINE_S) -> None:
        self.hub = Hub(lambda: None)
        self.said: asyncio.Queue[Any] = asyncio.Queue()
        self.code: int | None = None
        self._requests: asyncio.Queue[Message] = asyncio.Queue()
        self.feed = Feed(self.hub, lambda: None)
        feeds = Feeds(self.hub, self.feed, NoGraph(self.hub), read_only=False)
        scope = {"type": "websocket", "path": "/feed", "headers": []}
        self._requests.put_nowait({"type": "websocket.connect"})
        socket = WebSocket(scope, self._requests.get, self._send)
        self.session = PageSession(feeds, socket, doors, key_s)
        self._doors = doors
        self._socket = socket

    async def _send(self, message: Any) -> None:
        if message["type"] == "websocket.close":
            self.code = message["code"]
        if message["type"] == "websocket.send":
            message["text"].encode()  # as the server does
            self.said.put_nowait(json.loads(message["text"]))

    async def serve(self) -> None:
        await self._socket.accept()
        self._doors.arrive(self.session)
        try:
            await self.session.serve()
        finally:
            self._doors.leave(self.session)

    def send(self, text: str) -> None:
        self._requests.put_nowait({"type": "websocket.receive", "text": text})

    def disconnect(self) -> None:
        self._requests.put_nowait({"type": "websocket.disconnect", "code": 1001})

    async def answer(self, number: object) -> Any:
        while (found := await asyncio.wait_for(self.said.get(), DEADLINE_S)).get("id") != number:
            pass
        return found

    async def open(self) -> Any:
        self.send(json.dumps({"id": 0, "do": "open", "key": KEY}))
        return await self.answer(0)


def doors() -> Doors:
    return Doors(lambda key: key == KEY)


def run(work: Callable[[], Awaitable[None]]) -> None:
    asyncio.run(asyncio.wait_for(work(), DEADLINE_S))


def test_a_socket_that_does_not_send_the_key_in_time_is_closed():
    async def work() -> None:
        page = Page(doors(), key_s=0.0)
        await page.serve()
        assert page.code == NO_KEY

    run(work)


def test_a_page_with_the_key_stays_however_long_it_is_silent():
    async def work() -> None:
        page = Page(doors())
        serving = asyncio.create_task(page.serve())
        await page.open()
        page.session._end_without_key()  # what the timer calls
        page.send('{"id": 1, "do": "nothing"}')
        assert (await page.answer(1))["error"]["code"] == "bad-request"
        page.disconnect()
        await serving

    run(work)


def test_silent_sockets_keep_no_page_out_and_the_oldest_gives_way():
    async def work() -> None:
        shared = doors()
        silent = [Page(shared) for _ in range(MAX_PAGES)]
        waiting = [asyncio.create_task(page.serve()) for page in silent]
        await asyncio.sleep(0)  # they have arrived
        owner = Page(shared)
        serving = asyncio.create_task(owner.serve())
        assert (await owner.open())["ok"]
        await waiting[0]
        assert silent[0].code == TOO_MANY and owner.code is None
        assert not any(task.done() for task in waiting[1:])
        for page in (owner, *silent[1:]):
            page.disconnect()
        await asyncio.gather(serving, *waiting)

    run(work)


def test_there_is_a_limit_for_pages_with_the_key_and_one_that_leaves_makes_room():
    async def work() -> None:
        shared = doors()
        pages = [Page(shared) for _ in range(MAX_PAGES)]
        serving = [asyncio.create_task(page.serve()) for page in pages]
        for page in pages:
            await page.open()
        late = Page(shared)
        late.send(json.dumps({"id": 0, "do": "open", "key": KEY}))
        await late.serve()
        assert late.code == TOO_MANY
        pages[0].disconnect()
        await serving[0]
        again = Page(shared)
        task = asyncio.create_task(again.serve())
        assert (await again.open())["ok"]
        for page in (again, *pages[1:]):
            page.disconnect()
        await asyncio.gather(task, *serving[1:])

    run(work)


def test_what_ends_the_sender_closes_the_socket_and_is_raised():
    async def work() -> None:
        page = Page(doors())
        serving = asyncio.create_task(page.serve())
        await page.open()
        page.session._outbox.put_asked("answer", "no \udcff character")
        with pytest.raises(UnicodeEncodeError):
            await serving
        assert page.code == BROKEN
        assert len(page.hub) == 0

    run(work)


def test_a_page_opens_however_long_the_last_lines_are():
    async def work() -> None:
        page = Page(doors())
        for number in range(_FIRST_LINES):
            text = f"{number} " + "x" * (2 * MOST_BYTES // _FIRST_LINES)
            line = {"process": "a-1", "stream": "stdout", "wall_s": 0.0, "text": text}
            page.feed.log.add(line)
        serving = asyncio.create_task(page.serve())
        assert (await page.open())["ok"]
        page.hub.send({"event": "run_events", "items": [1]})
        assert (await page.said.get())["items"] == [1]
        page.disconnect()
        await serving

    run(work)


@pytest.mark.parametrize(
    "text",
    [
        "[" * 100_000,
        '{"id": 1e999}',
        '{"id": NaN}',
        '{"id": ' + "1" * 5000 + "}",
        '{"id": ' + "1" * 400 + "}",
        "7",
        "",
        '{"do": ["open"]}',
        '{"do": "older", "before": [], "count": {}}',
        '{"do": "probe", "request": {"do": ["publish"]}}',
        '{"do": "run", "verb": "ps", "options": 5, "names": 5}',
        '{"do": "cancel", "of": {}}',
    ],
    ids=lambda text: text[:40],
)
def test_an_odd_request_is_answered_and_the_next_one_too(text: str):
    async def work() -> None:
        page = Page(doors())
        serving = asyncio.create_task(page.serve())
        await page.open()
        page.send(text)
        answer = await page.answer(None)
        assert not answer.get("ok") or answer["result"] == {"cancelled": False}
        page.send('{"id": "\\udcff", "do": "older", "before": 1, "count": 1}')
        assert (await page.answer("\ufffd"))["ok"]
        page.disconnect()
        await serving

    run(work)
