"""One client: its subscriptions, what it publishes, and what waits to be sent to it."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
import traceback
from collections import deque
from collections.abc import Coroutine, Iterator
from typing import TYPE_CHECKING, Any

from websockets.exceptions import ConnectionClosed

from launcher.base.ros_errors import VerbError
from launcher.base.text import typed_error
from launcher.ros.foxglove import protocol
from launcher.ros.foxglove.protocol import Channel, ClientData, ProtocolError, ServiceCall
from launcher.ros.verb import warn

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

    from launcher.ros.foxglove.foxglove_bridge import FoxgloveBridge
    from launcher.ros.foxglove.publishing import Publication


_MOST_TASKS = 100  # requests of a client that are not answered yet
_NOTICE_S = 5.0  # from one notice of dropped messages to the next
_TURN = 50  # messages in a row, after which others have a turn
CONTROL_BYTES = 64 * 1024 * 1024  # of messages that must not be lost; after it the client is lost


class ClientSession:
    """Everything here runs in the event loop, except `deliver`."""

    def __init__(
        self, socket: ServerConnection, bridge: FoxgloveBridge, number: int, most: int
    ) -> None:
        self.number = number
        host, port, *_ = socket.remote_address or ("?", 0)
        self.address = f"{host}:{port}"
        self.parameters: set[str] | None = set()  # subscribed to; None: to all
        self.wants_connections = False
        self.publications: dict[int, Publication] = {}
        self.topics: dict[int, Channel] = {}  # by the number of the subscription
        self._socket = socket
        self._bridge = bridge
        self._outbox = ClientOutbox(most)
        self._loop = asyncio.get_running_loop()
        self._wake = asyncio.Event()
        self._tasks: set[asyncio.Task[None]] = set()
        self._dropped = 0
        self._noticed_s = 0.0

    async def run(self) -> None:
        """Until the client has gone."""
        writer = asyncio.create_task(self._write())
        try:
            async for message in self._socket:
                await self._handle(message)
        except ConnectionClosed:
            pass
        finally:
            for task in [writer, *self._tasks]:
                task.cancel()
            await asyncio.gather(writer, *self._tasks, return_exceptions=True)

    async def _write(self) -> None:
        """Send what waits, and wait wherever the client does not read: the outbox drops data.

        If that is not possible, the client is given up, and sees it.
        """
        try:
            while True:
                await self._wake.wait()
                self._wake.clear()
                sent = 0
                while (message := self._outbox.take()) is not None:
                    await self._socket.send(message)
                    sent += 1
                    if sent % _TURN == 0:
                        await asyncio.sleep(0)
        except ConnectionClosed:
            pass
        except Exception as error:
            warn(f"client {self.number} is disconnected: {typed_error(error)}")
            self.abort()

    def send(self, message: str | bytes) -> None:
        if self._outbox.put(message):
            self._wake.set()

    def warn(self, text: str, level: int = protocol.WARNING) -> None:
        self.send(protocol.status(level, text))

    def deliver(self, subscription: int, time_ns: int, payload: bytes) -> None:
        """From the thread of the receiver."""
        if self._outbox.put_data(subscription, time_ns, payload):
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(self._wake.set)

    def tick(self) -> None:
        """Tell the client of what it has lost; give it up if it does not read at all."""
        self._dropped += self._outbox.take_dropped()
        if self._dropped and time.monotonic() - self._noticed_s > _NOTICE_S:
            self.warn(f"{self._dropped} messages were dropped: this client reads too slowly")
            self._dropped, self._noticed_s = 0, time.monotonic()
        if self._outbox.is_overfull:
            self.abort()

    def abort(self) -> None:
        self._socket.transport.abort()

    def forget(self, subscription: int) -> Channel | None:
        """End a subscription here; the channel that it was for."""
        channel = self.topics.pop(subscription, None)
        if channel is not None:
            self._outbox.forget(subscription)
        return channel

    async def _handle(self, message: str | bytes) -> None:
        with self._errors_reported():
            if isinstance(message, str):
                await self._handle_text(protocol.parse_text(message))
            else:
                self._handle_data(protocol.parse_data(message))

    @contextlib.contextmanager
    def _errors_reported(self) -> Iterator[None]:
        try:
            yield
        except ProtocolError as error:
            self.warn(str(error), protocol.ERROR)
        except VerbError as error:
            self.warn(error.message, protocol.ERROR)
        except Exception as error:  # a client that waits for an answer is never left alone
            self.warn(f"{typed_error(error)}; this is a bug", protocol.ERROR)
            traceback.print_exc()

    def _handle_data(self, data: ClientData | ServiceCall) -> None:
        if isinstance(data, ServiceCall):
            self._start(self._bridge.call_service(self, data))
            return
        publication = self.publications.get(data.channel)
        if publication is None:
            raise ProtocolError(f"channel {data.channel} is not advertised by this client")
        try:
            publication.publish(data.payload)
        except VerbError as error:
            raise VerbError(f"{publication.topic}: {error.message}") from None

    async def _handle_text(self, message: dict[str, Any]) -> None:
        handler = _HANDLERS.get(message["op"])
        if handler is None:
            raise ProtocolError(f"invalid message: unknown op '{message['op']}'")
        await handler(self, message)

    async def _subscribe(self, message: dict[str, Any]) -> None:
        for item in protocol.objects(message, "subscriptions", id=int, channelId=int):
            self._bridge.subscribe(self, item["id"], item["channelId"])

    async def _unsubscribe(self, message: dict[str, Any]) -> None:
        for number in protocol.numbers(message, "subscriptionIds"):
            self._bridge.unsubscribe(self, number)

    async def _advertise(self, message: dict[str, Any]) -> None:
        kinds = {"id": int, "topic": str, "encoding": str, "schemaName": str}
        for item in protocol.objects(message, "channels", **kinds):
            await self._bridge.advertise(self, item)

    async def _unadvertise(self, message: dict[str, Any]) -> None:
        for number in protocol.numbers(message, "channelIds"):
            self._bridge.unadvertise(self, number)

    async def _get_parameters(self, message: dict[str, Any]) -> None:
        names, request = protocol.strings(message, "parameterNames"), protocol.identifier(message)
        self._start(self._bridge.get_parameters(self, names, request))

    async def _set_parameters(self, message: dict[str, Any]) -> None:
        items = protocol.objects(message, "parameters", name=str)
        request = protocol.identifier(message)
        self._start(self._bridge.set_parameters(self, items, request))

    async def _subscribe_parameters(self, message: dict[str, Any]) -> None:
        names = protocol.strings(message, "parameterNames")
        if not names:
            self.parameters = None
        elif self.parameters is not None:
            self.parameters.update(names)
        self._bridge.follow_parameters()

    async def _unsubscribe_parameters(self, message: dict[str, Any]) -> None:
        names = protocol.strings(message, "parameterNames")
        if not names:
            self.parameters = set()
        elif self.parameters is not None:
            self.parameters.difference_update(names)
        self._bridge.follow_parameters()

    async def _subscribe_connections(self, message: dict[str, Any]) -> None:
        self._bridge.show_connections(self)

    async def _unsubscribe_connections(self, message: dict[str, Any]) -> None:
        self.wants_connections = False

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        """Answer later, and meanwhile listen to the client."""
        if len(self._tasks) >= _MOST_TASKS:
            work.close()
            raise ProtocolError(f"more than {_MOST_TASKS} requests wait for an answer")
        task = asyncio.create_task(self._finish(work))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _finish(self, work: Coroutine[Any, Any, None]) -> None:
        with self._errors_reported():
            await work


_HANDLERS = {
    "subscribe": ClientSession._subscribe,
    "unsubscribe": ClientSession._unsubscribe,
    "advertise": ClientSession._advertise,
    "unadvertise": ClientSession._unadvertise,
    "getParameters": ClientSession._get_parameters,
    "setParameters": ClientSession._set_parameters,
    "subscribeParameterUpdates": ClientSession._subscribe_parameters,
    "unsubscribeParameterUpdates": ClientSession._unsubscribe_parameters,
    "subscribeConnectionGraph": ClientSession._subscribe_connections,
    "unsubscribeConnectionGraph": ClientSession._unsubscribe_connections,
}


class ClientOutbox:
    """What waits to be sent, bounded, since a client may read slowly or not at all.

    Data of topics is dropped where it does not fit, the oldest first; all else is kept.

    Any thread may put something in; one takes it out. `put...` says whether that one has to be
    woken up, which it has not while it is still busy.
    """

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes = most_bytes
        self._lock = threading.Lock()
        self._control: deque[str | bytes] = deque()
        self._control_bytes = 0
        self._data: deque[tuple[int, int, bytes]] = deque()  # subscription, time, message
        self._data_bytes = 0
        self._dropped = 0
        self._is_idle = True

    @property
    def is_overfull(self) -> bool:
        """Whether even what must not be lost has become too much."""
        return self._control_bytes > CONTROL_BYTES

    def put(self, message: str | bytes) -> bool:
        """A message that must not be lost; it overtakes data of topics."""
        with self._lock:
            if not self.is_overfull:
                self._control.append(message)
                self._control_bytes += len(message)
            return self._wakes()

    def put_data(self, subscription: int, time_ns: int, payload: bytes) -> bool:
        """A message of a topic. One that is larger than the bound is sent if it is alone."""
        with self._lock:
            self._data.append((subscription, time_ns, payload))
            self._data_bytes += len(payload)
            while self._data_bytes > self._most_bytes and len(self._data) > 1:
                self._data_bytes -= len(self._data.popleft()[2])
                self._dropped += 1
            return self._wakes()

    def forget(self, subscription: int) -> None:
        """Remove the data of a subscription that has ended."""
        with self._lock:
            self._data = deque(item for item in self._data if item[0] != subscription)
            self._data_bytes = sum(len(item[2]) for item in self._data)

    def take(self) -> str | bytes | None:
        """The next message to send; None if there is none, and then the next put wakes."""
        with self._lock:
            if self._control:
                message = self._control.popleft()
                self._control_bytes -= len(message)
                return message
            if self._data:
                subscription, time_ns, payload = self._data.popleft()
                self._data_bytes -= len(payload)
                return protocol.message_data(subscription, time_ns, payload)
            self._is_idle = True
            return None

    def take_dropped(self) -> int:
        """How many messages were dropped since the last call."""
        with self._lock:
            dropped, self._dropped = self._dropped, 0
            return dropped

    def _wakes(self) -> bool:
        wakes, self._is_idle = self._is_idle, False
        return wakes
