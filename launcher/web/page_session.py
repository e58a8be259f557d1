"""One page: sends it what is queued, and answers its requests."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from launcher.base import strict_json
from launcher.base.text import typed_error
from launcher.control.verbs import only_reads
from launcher.posix.socket_directory import ControlError
from launcher.web.graph_feed import CHANGING, READING, GraphFeed
from launcher.web.hub import Hub, Message, PageOutbox, encode
from launcher.web.run_client import RunClient
from launcher.web.run_feed import RunFeed

PROTOCOL = 1
MAX_OLDER = 20_000
MAX_TIMES = 100_000  # messages that one request publishes
MAX_OPEN = 64  # requests of one page that are not answered yet
MAX_PAGES = 100  # open at the same time, and as many that have not sent the key yet
KEY_S = 10.0  # for a page to send the key
_CLOSE_S = 2.0
BROKEN, NO_KEY, TOO_MANY = 1011, 4403, 4429  # codes with which a socket is closed
# Verbs of the control socket that a page does not need: they answer with a stream, or end the page.
_NOT_HERE = frozenset({"pick", "detach"})

Request = dict[str, Any]


class BadRequestError(Exception):
    """A request that is refused: (code, message)."""


class Feeds:
    """What all pages share."""

    def __init__(self, hub: Hub, run: RunFeed, graph: GraphFeed, *, read_only: bool) -> None:
        self.hub = hub
        self.run = run
        self.graph = graph
        self.read_only = read_only
        self.server = f"{time.time():.6f}"


class Doors:
    """Which pages are served: only those with the key count as open.

    Of sockets that have not sent it, the oldest gives way to a new one: they may be of others, to
    whom a browser has sent the cookie, and must not keep out who has the key.
    """

    def __init__(self, is_key: Callable[[object], bool]) -> None:
        self.is_key = is_key
        self._waiting: dict[PageSession, None] = {}  # the oldest first
        self._open: set[PageSession] = set()

    def arrive(self, session: PageSession) -> None:
        self._waiting[session] = None
        if len(self._waiting) > MAX_PAGES:
            oldest = next(iter(self._waiting))
            del self._waiting[oldest]
            oldest.end(TOO_MANY)

    def admit(self, session: PageSession) -> bool:
        """Whether there is room for a session that has the key."""
        self._waiting.pop(session, None)
        if len(self._open) < MAX_PAGES:
            self._open.add(session)
        return session in self._open

    def leave(self, session: PageSession) -> None:
        self._waiting.pop(session, None)
        self._open.discard(session)


class PageSession:
    """Serves a WebSocket that has been accepted, until it is closed."""

    def __init__(self, feeds: Feeds, socket: WebSocket, doors: Doors, key_s: float = KEY_S) -> None:
        self._feeds = feeds
        self._doors = doors
        self._key_s = key_s
        self._is_trusted = False
        self._code: asyncio.Future[int] = asyncio.get_running_loop().create_future()
        self._socket = socket
        self._outbox = PageOutbox(lambda: self.end(BROKEN))
        self._answers: set[asyncio.Task[None]] = set()
        self._client: RunClient | None = None
        self._connecting = asyncio.Lock()
        self._at_probe: dict[str, int] = {}  # open requests: our id, and that of the probe
        self._handlers: dict[str, Callable[[Request], Awaitable[Request]]] = {
            "open": self._open,
            "run": self._run,
            "older": self._older,
            "tree": self._tree,
            "topics": self._subscribe,
            "echo": self._subscribe,
            "plot": self._subscribe,
            "probe": self._probe,
            "cancel": self._cancel,
            "arrange": self._arrange,
            "forget": self._forget,
        }

    async def serve(self) -> None:
        """Until one side closes the socket; what ends the sender or the reader is raised."""
        tasks = [asyncio.create_task(self._receive()), asyncio.create_task(self._send())]
        end = asyncio.get_running_loop().call_later(self._key_s, self._end_without_key)
        ends: list[asyncio.Future[Any]] = [*tasks, self._code]
        try:
            done, _ = await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            end.cancel()
            self._feeds.hub.leave(self._outbox)
            self._feeds.graph.cancel_all(self._at_probe.values())
            for task in [*tasks, *self._answers]:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            if self._client is not None:
                await self._client.close()
            code = self._code.result() if self._code.done() else BROKEN
            with contextlib.suppress(RuntimeError, TimeoutError, asyncio.TimeoutError):
                # It may have been closed, or its page may read nothing.
                await asyncio.wait_for(self._socket.close(code), _CLOSE_S)

    def end(self, code: int) -> None:
        """Close the socket with this code."""
        if not self._code.done():
            self._code.set_result(code)

    def _end_without_key(self) -> None:
        if not self._is_trusted:
            self.end(NO_KEY)

    async def _receive(self) -> None:
        while (message := await self._socket.receive())["type"] != "websocket.disconnect":
            self._take(message.get("text") or "")

    async def _send(self) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # it has been closed
            while True:
                text = await self._outbox.get()
                await self._socket.send_text(text)
                if self._outbox.skipped_lines:
                    skipped, self._outbox.skipped_lines = self._outbox.skipped_lines, 0
                    note = f"{skipped:,} lines were not sent: this page reads too slowly"
                    await self._socket.send_text(encode({"event": "slow", "text": note}))

    def _put(self, message: Message) -> None:
        self._outbox.put_asked(message.get("event", "answer"), encode(message))

    def _take(self, text: str) -> None:
        try:
            request = strict_json.loads(text)
        except ValueError as error:
            self._put(_refusal(None, "bad-request", f"a request is a JSON object: {error}"))
            return
        if not isinstance(request, dict):
            self._put(_refusal(None, "bad-request", "a request is a JSON object"))
            return
        if len(self._answers) >= MAX_OPEN:
            self._put(_refusal(request.get("id"), "bad-request", "too many open requests"))
            return
        task = asyncio.create_task(self._answer(request))
        self._answers.add(task)
        task.add_done_callback(self._answers.discard)

    async def _answer(self, request: Request) -> None:
        number = request.get("id")
        handler = self._handlers.get(str(request.get("do")))
        try:
            if not self._is_trusted and request.get("do") != "open":
                raise BadRequestError("no-key", "the first request is 'open', with the key")
            if handler is None:
                raise BadRequestError("bad-request", f"unknown request {request.get('do')!r}")
            answer = await handler(request)
        except BadRequestError as error:
            code, message = error.args
            answer = _refusal(number, code, message)
        except Exception as error:  # every request gets an answer
            answer = _refusal(number, "bad-request", typed_error(error))
        self._put({**answer, "id": number})

    # ---- requests

    async def _open(self, request: Request) -> Request:
        feeds = self._feeds
        if not self._doors.is_key(request.get("key")):
            self.end(NO_KEY)
            raise BadRequestError("no-key", "open the link that the launcher has printed")
        if not self._doors.admit(self):
            self.end(TOO_MANY)
            raise BadRequestError("too-many", f"{MAX_PAGES} pages are open already")
        self._is_trusted = True
        feeds.run.flush()  # what waits is part of everything so far
        feeds.hub.join(self._outbox)
        is_same = request.get("server") == feeds.server
        hello = {
            "event": "hello",
            "protocol": PROTOCOL,
            "server": feeds.server,
            "run": feeds.run.run,
            "launcher": feeds.run.launcher,
            "ros": feeds.run.ros,
            "wall": time.time(),
            "read_only": feeds.read_only,
            "frozen": None,
            "ended": feeds.run.ended,
            "graph": feeds.graph.available(),
        }
        self._put(hello)
        for message in feeds.run.opening(request.get("after") if is_same else None):
            self._put(message)
        for message in feeds.graph.opening():
            self._put(message)
        feeds.graph.start_soon()
        return _done({})

    async def _run(self, request: Request) -> Request:
        verb = str(request.get("verb"))
        if verb in _NOT_HERE:
            raise BadRequestError("bad-request", f"'{verb}' is not possible from the page")
        options = dict(request.get("options") or {})
        if options.pop("follow", False):
            raise BadRequestError("bad-request", "the page follows the run already")
        self._allow(not only_reads(verb, options))
        names = [str(name) for name in request.get("names") or ()]
        try:
            async with self._connecting:
                if self._client is None:
                    self._client = await self._feeds.run.connect_page()
        except ControlError as error:
            raise BadRequestError("stopping", error.message) from None
        return await self._client.ask(verb, names, options)

    def _allow(self, changes: bool) -> None:
        if changes and self._feeds.read_only:
            raise BadRequestError("read-only", "this page only shows (--web-read-only)")

    async def _older(self, request: Request) -> Request:
        count = min(int(request["count"]), MAX_OLDER)
        first, lines = self._feeds.run.log.before(int(request["before"]), count)
        return _done({"first": first, "lines": lines})

    async def _tree(self, request: Request) -> Request:
        self._feeds.run.want_tree()
        return _done({})

    async def _subscribe(self, request: Request) -> Request:
        kind = request["do"]
        topic, field = str(request.get("topic", "")), str(request.get("field", ""))
        what = f"{topic}\n{field}" if kind == "plot" else topic
        self._feeds.hub.set_subscription(self._outbox, kind, what, on=bool(request["on"]))
        if request["on"]:
            await self._feeds.graph.start()
        if kind == "plot" and request["on"]:
            earlier = self._feeds.graph.earlier_points(topic, field)
            if earlier is not None:
                self._put(earlier)
        return _done({})

    async def _arrange(self, request: Request) -> Request:
        return _done({"arranged": self._feeds.graph.arrange()})

    async def _forget(self, request: Request) -> Request:
        return _done({"forgotten": self._feeds.graph.forget(str(request["node"]))})

    async def _probe(self, request: Request) -> Request:
        inner = dict(request["request"])
        what = inner.get("do")
        if what not in READING | CHANGING:
            raise BadRequestError("bad-request", f"the page cannot ask the probe for {what!r}")
        self._allow(what in CHANGING)
        if what == "publish":
            _check_times(inner.get("times"))
        mine = repr(request.get("id"))
        try:
            return await self._feeds.graph.ask(inner, partial(self._at_probe.__setitem__, mine))
        finally:
            self._at_probe.pop(mine, None)

    async def _cancel(self, request: Request) -> Request:
        """End a request of this page to the probe."""
        number = self._at_probe.get(repr(request.get("of")))
        if number is None:
            return _done({"cancelled": False})
        return await self._feeds.graph.cancel(number)


def _check_times(times: object) -> None:
    if isinstance(times, int | float) and not times <= MAX_TIMES:
        raise BadRequestError("bad-request", f"'times' must be at most {MAX_TIMES:,}")


def _done(result: Request) -> Request:
    return {"ok": True, "result": result}


def _refusal(number: object, code: str, message: str) -> Request:
    error = {"code": code, "message": message, "hint": None}
    return {"id": number, "ok": False, "error": error}
