"""Peer: one client of a run, and what is still owed to it."""

from __future__ import annotations

import contextlib
import select
import socket
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from launcher.control import protocol
from launcher.control.protocol import REQUEST_LIMIT, Request, RequestError
from launcher.control.turns import Turns
from launcher.control.verbs import BadCallError
from launcher.engine.posix.reactor import Reactor

OUTPUT_LIMIT = 256 * 1024  # bytes that wait for a client; above it, lines of a stream are dropped
MOST_OPEN = 64  # requests of one client that are not answered yet
HALF_CLOSED_LOOK_S = 1.0  # nobody tells us when a client that has said its last word goes away


class Exchange:
    """One request and its answers. `on_end` is called once, when no more are wanted."""

    def __init__(self, peer: Peer, request_id: Any) -> None:
        self._peer = peer
        self.turns = peer.turns
        self.id = request_id
        self.is_open = True
        self.is_stream = False
        self.dropped = 0
        self.on_end: Callable[[], None] = lambda: None

    def reply(self, result: Mapping[str, Any], text: Sequence[str] = ()) -> None:
        """The last answer: it was done."""
        self._last(protocol.reply(self.id, result, text))

    def reply_raw(self, name: str, values: Sequence[str]) -> None:
        """The last answer: a list of values that are JSON already."""
        self._last(protocol.raw_reply(self.id, name, values))

    def _last(self, data: bytes) -> None:
        if self.is_open:
            self.say_dropped()
            self._peer.write(data)
            self.end()

    def fail(self, problem: BadCallError) -> None:
        """The last answer: it was not done."""
        if self.is_open:
            self._peer.write(protocol.failure(self.id, problem))
            self.end()

    def item(self, value: Mapping[str, Any]) -> None:
        """One of a stream; dropped and counted if the client does not read."""
        if self._has_room():
            self._peer.write(protocol.item(self.id, value))

    def item_raw(self, text: str) -> None:
        """The same, of what is JSON already."""
        if self._has_room():
            self._peer.write(protocol.raw_item(self.id, text))

    def _has_room(self) -> bool:
        if not self.is_open:
            return False
        if self._peer.is_full:
            self.dropped += 1
            return False
        self.say_dropped()
        return True

    def say_dropped(self) -> None:
        """Tell how many items found no room."""
        if self.dropped:
            count, self.dropped = self.dropped, 0
            self._peer.write(protocol.item(self.id, {"dropped": count}))

    def end(self) -> None:
        """Nothing more is said."""
        if self.is_open:
            self.is_open = False
            self._peer.forget(self)
            self.on_end()


class Peer:
    """A connection. `serve(request, exchange)` answers; `on_close(peer)` is called at its end.

    It is served one request per pass of the loop, read only as long as it reads itself, and what
    waits for it is bounded: whatever it does, it harms nobody else.
    """

    def __init__(
        self,
        reactor: Reactor,
        connection: socket.socket,
        *,
        serve: Callable[[Request, Exchange], None],
        on_close: Callable[[Peer], None],
    ) -> None:
        self.turns = Turns(reactor)
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
        self._has_said_all = False
        self._is_ending = False
        self._is_closed = False
        connection.setblocking(False)
        self._listen()

    @property
    def is_full(self) -> bool:
        """Whether more waits for it than it should."""
        return self._output_bytes > OUTPUT_LIMIT

    # ---- what it says

    def _listen(self) -> None:
        """Read, unless it does not read itself, has more to be served, or has said all."""
        if self._is_closed:
            return  # its descriptor may be somebody else's by now
        wanted = not (self._output or self._is_scheduled or self._has_said_all or self._is_ending)
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
            self._said_all()
            return
        self._input += chunk
        self._schedule()

    def _schedule(self) -> None:
        """Serve the next request in the next pass, when others have had their turn."""
        if b"\n" in self._input:
            if not self._is_scheduled:
                self._is_scheduled = True
                self._reactor.call_later(0, self._serve_next)
        elif len(self._input) >= REQUEST_LIMIT:
            self._refuse(f"a request is at most {REQUEST_LIMIT} bytes long")
        self._listen()

    def _serve_next(self) -> None:
        self._is_scheduled = False
        if self._is_closed or self._is_ending:
            return
        if self._output:
            return  # goes on when that has been read
        line, newline, rest = self._input.partition(b"\n")
        if newline:
            self._input = rest
            if len(line) >= REQUEST_LIMIT:
                self._refuse(f"a request is at most {REQUEST_LIMIT} bytes long")
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
        if len(self._open) >= MOST_OPEN:
            many = f"{MOST_OPEN} requests of this connection are not answered yet"
            exchange.fail(BadCallError("bad-request", many))
            return
        self._open.append(exchange)
        self._serve(request, exchange)

    def _refuse(self, message: str) -> None:
        self.write(protocol.failure(None, BadCallError("bad-request", message)))
        self.end()

    def refuse(self, problem: BadCallError) -> None:
        """Say why not, and close."""
        self.write(protocol.failure(None, problem))
        self.end()

    def _said_all(self) -> None:
        self._has_said_all = True
        self._input = b""
        self._listen()
        self._look_whether_it_is_there()

    def _look_whether_it_is_there(self) -> None:
        """A client that has closed only its own side may still wait for answers."""
        if self._is_closed:
            return
        poll = select.poll()
        poll.register(self._fd, 0)
        if poll.poll(0) or not (self._open or self._output):
            self.close()
        else:
            self._reactor.call_later(HALF_CLOSED_LOOK_S, self._look_whether_it_is_there)

    # ---- what it is told

    def write(self, data: bytes) -> None:
        """Say this, now or when it reads."""
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
            exchange.say_dropped()
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
                self.close()  # it has gone
                return
            self._output_bytes -= sent
            if sent < len(self._output[0]):
                self._output[0] = self._output[0][sent:]
                return
            self._output.popleft()

    def forget(self, exchange: Exchange) -> None:
        """An exchange is over."""
        if exchange in self._open:
            self._open.remove(exchange)
        if self._has_said_all:
            self._end_if_done()

    # ---- the end

    def end(self) -> None:
        """Close it when everything has been said."""
        self._is_ending = True
        self._listen()
        self._end_if_done()

    def _end_if_done(self) -> None:
        has_no_more = self._has_said_all and not self._open
        if (self._is_ending or has_no_more) and not self._output:
            self.close()

    def conclude(self, problem: BadCallError, patience_s: float) -> None:
        """The run ends: answer what is open, give it a moment to read, and close."""
        for exchange in list(self._open):
            if exchange.is_stream:
                exchange.reply({"ended": True})
            else:
                exchange.fail(problem)
        if self._output and not self._is_closed:
            self._connection.settimeout(patience_s)
            with contextlib.suppress(OSError):
                self._connection.sendall(b"".join(self._output))
        self.close()

    def close(self) -> None:
        """Close it now; more than once does no harm."""
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
