"""The server's side of one connection: reads requests, queues answers until the client reads."""

from __future__ import annotations

import contextlib
import select
import socket
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence

from launcher.base.run_verb import BadCallError
from launcher.control import protocol
from launcher.control.protocol import REQUEST_LIMIT, Request, RequestError
from launcher.posix.reactor import Reactor

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

OUTPUT_LIMIT = 256 * 1024  # unread bytes above which items of a stream are dropped
MAX_OPEN = 64  # unanswered requests of one client
HALF_CLOSED_CHECK_S = 1.0  # epoll does not report when a client closes the other half, too
TOO_LONG = BadCallError("bad-request", f"a request is at most {REQUEST_LIMIT} bytes long")


class Exchange:
    """A request and its answers; `on_end` is called once, after the last answer or a disconnect.

    `before_last` is called before the last answer, and may send items.
    """

    def __init__(self, peer: Peer, request_id: object) -> None:
        self._peer = peer
        self.id = request_id
        self.is_open = True
        self.is_stream = False
        self.dropped = 0
        self.before_last: Callable[[], None] = lambda: None
        self.on_end: Callable[[], None] = lambda: None

    def reply(self, result: Mapping[str, Any], text: Sequence[str] = ()) -> None:
        self._last(protocol.reply(self.id, result, text))

    def reply_raw(self, name: str, values: Sequence[str]) -> None:
        """Send a list of values that are JSON already as the last answer."""
        self._last(protocol.raw_reply(self.id, name, values))

    def _last(self, data: bytes) -> None:
        if self.is_open:
            self.before_last()
            self.report_dropped()
            self._peer.write(data)
            self.end()

    def fail(self, problem: BadCallError) -> None:
        self._last(protocol.failure(self.id, problem))

    def item(self, value: Mapping[str, Any], *, stands_for: int = 1) -> None:
        """Send an item of a stream; it is dropped and counted if the client does not read.

        `stands_for`: so many items that were left out are reported by it.
        """
        if self._has_room(stands_for):
            self._peer.write(protocol.raw_item(self.id, protocol.to_json(value)))

    def item_raw(self, text: str) -> None:
        """The same for an item that is JSON already."""
        if self._has_room():
            self._peer.write(protocol.raw_item(self.id, text))

    def past_items(self, texts: Iterable[str]) -> None:
        """The same for what was before, a bounded number: however slowly the client reads."""
        data = b"".join(protocol.raw_item(self.id, text) for text in texts)
        if data and self.is_open:
            self._peer.write(data)

    def _has_room(self, items: int = 1) -> bool:
        if not self.is_open:
            return False
        if self._peer.is_full:
            self.dropped += items
            return False
        self.report_dropped()
        return True

    def report_dropped(self) -> None:
        """Send how many items were dropped, if any."""
        if self.dropped:
            self._peer.write(protocol.raw_item(self.id, f'{{"dropped":{self.dropped}}}'))
            self.dropped = 0

    def end(self) -> None:
        if self.is_open:
            self.is_open = False
            self._peer.forget(self)
            self.on_end()


class Peer:
    """A connection; `serve(request, exchange)` handles requests, `on_close(peer)` is called once.

    To protect other clients, it is served one request per pass of the loop, its requests are not
    read while it does not read answers, and its unread answers are bounded.
    """

    def __init__(
        self,
        reactor: Reactor,
        connection: socket.socket,
        *,
        serve: Callable[[Request, Exchange], None],
        on_close: Callable[[Peer], None],
    ) -> None:
        self._reactor = reactor
        self._connection = connection
        self._fd = connection.fileno()
        self._serve = serve
        self._on_close = on_close
        self._input = b""
        self._output: deque[bytes] = deque()
        self._output_bytes = 0
        self._open: list[Exchange] = []
        self._is_reading = False
        self._is_scheduled = False
        self._has_eof = False
        self._is_ending = False
        self._is_closed = False
        connection.setblocking(False)
        self._listen()

    @property
    def is_full(self) -> bool:
        return self._output_bytes > OUTPUT_LIMIT

    # ---- input

    def _listen(self) -> None:
        """Read, unless answers are unread, requests are waiting, or the input has ended."""
        if self._is_closed:
            return  # the descriptor may have been given out again
        wanted = not (self._output or self._is_scheduled or self._has_eof or self._is_ending)
        if wanted and not self._is_reading:
            self._reactor.add_reader(self._fd, self._read)
        elif not wanted and self._is_reading:
            self._reactor.remove(self._fd)
        self._is_reading = wanted

    def _read(self) -> None:
        try:
            chunk = self._connection.recv(REQUEST_LIMIT)
        except BlockingIOError:
            return
        except OSError:
            self.close()
            return
        if not chunk:
            self._received_eof()
            return
        self._input += chunk
        self._schedule()

    def _schedule(self) -> None:
        """Serve the next request in the next pass of the loop, after other clients."""
        if b"\n" in self._input:
            if not self._is_scheduled:
                self._is_scheduled = True
                self._reactor.call_later(0, self._serve_next)
        elif len(self._input) >= REQUEST_LIMIT:
            self.refuse(TOO_LONG)
        self._listen()

    def _serve_next(self) -> None:
        self._is_scheduled = False
        if self._is_closed or self._is_ending or self._output:
            return  # with unread answers, `_writable` continues
        line, newline, rest = self._input.partition(b"\n")
        if newline:
            self._input = rest
            if len(line) >= REQUEST_LIMIT:
                self.refuse(TOO_LONG)
                return
            if line.strip():
                self._answer(line)
        self._schedule()
        self._end_if_done()

    def _answer(self, line: bytes) -> None:
        try:
            request = protocol.parse_request(line)
        except RequestError as error:
            self.write(protocol.failure(error.id, error.cause))
            return
        exchange = Exchange(self, request.id)
        if len(self._open) >= MAX_OPEN:
            text = f"{MAX_OPEN} requests of this connection are not answered yet"
            exchange.fail(BadCallError("bad-request", text))
            return
        self._open.append(exchange)
        self._serve(request, exchange)

    def refuse(self, problem: BadCallError) -> None:
        self.write(protocol.failure(None, problem))
        self.end()

    def _received_eof(self) -> None:
        self._has_eof = True
        self._input = b""
        self._listen()
        self._check_half_closed()

    def _check_half_closed(self) -> None:
        """A client that has closed only its own half may still wait for answers."""
        if self._is_closed:
            return
        poll = select.poll()
        poll.register(self._fd, 0)
        if poll.poll(0) or not (self._open or self._output):
            self.close()
        else:
            self._reactor.call_later(HALF_CLOSED_CHECK_S, self._check_half_closed)

    # ---- output

    def write(self, data: bytes) -> None:
        """Send this, now or when the client reads."""
        if self._is_closed:
            return
        was_waiting = bool(self._output)
        self._output.append(data)
        self._output_bytes += len(data)
        if not was_waiting:
            self._flush()
            if self._output and not self._is_closed:
                self._listen()
                self._reactor.add_writer(self._fd, self._writable)

    def _writable(self) -> None:
        self._flush()
        if self._is_closed or self._output:
            return
        self._reactor.remove(self._fd)
        for exchange in list(self._open):
            exchange.report_dropped()
        self._end_if_done()
        if not self._is_closed:
            self._schedule()

    def _flush(self) -> None:
        while self._output:
            try:
                sent = self._connection.send(self._output[0])
            except BlockingIOError:
                return
            except OSError:
                self.close()
                return
            self._output_bytes -= sent
            if sent < len(self._output[0]):
                self._output[0] = self._output[0][sent:]
                return
            self._output.popleft()

    def forget(self, exchange: Exchange) -> None:
        if exchange in self._open:
            self._open.remove(exchange)
        if self._has_eof:
            self._end_if_done()

    # ---- the end

    def end(self) -> None:
        """Close when everything has been sent."""
        self._is_ending = True
        self._listen()
        self._end_if_done()

    def _end_if_done(self) -> None:
        has_no_more = self._has_eof and not self._open
        if (self._is_ending or has_no_more) and not self._output:
            self.close()

    def conclude(self, problem: BadCallError, timeout_s: float) -> None:
        """At the end of the run: answer open requests, wait for the client to read, and close."""
        for exchange in list(self._open):
            if exchange.is_stream:
                exchange.reply({"ended": True})
            else:
                exchange.fail(problem)
        if self._output and not self._is_closed:
            self._connection.settimeout(timeout_s)
            with contextlib.suppress(OSError):
                self._connection.sendall(b"".join(self._output))
        self.close()

    def close(self) -> None:
        if self._is_closed:
            return
        self._is_closed = True
        self._reactor.remove(self._fd)
        self._output.clear()
        self._output_bytes = 0
        self._connection.close()
        for exchange in list(self._open):
            exchange.end()
        self._on_close(self)
