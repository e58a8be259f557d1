"""Brings clients and the ROS graph together."""

from __future__ import annotations

import asyncio
import contextlib
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from rclpy.serialization import deserialize_message, serialize_message

from launcher.base import strict_json
from launcher.base.ros_errors import VerbError
from launcher.packages.distribution import installed
from launcher.ros.discovery.observer import Observer
from launcher.ros.foxglove import protocol
from launcher.ros.foxglove.catalogue import Catalogue
from launcher.ros.foxglove.client_session import ClientSession
from launcher.ros.foxglove.feeds import TopicFeeds, reason
from launcher.ros.foxglove.graph_view import Connections, Look, TopicChoice, look
from launcher.ros.foxglove.parameter_services import ParameterEvents, Parameters
from launcher.ros.foxglove.protocol import ProtocolError, ServiceCall
from launcher.ros.foxglove.publishing import Publication
from launcher.ros.foxglove.receiver import Receiver
from launcher.ros.foxglove.service_calls import ServiceCalls
from launcher.ros.messages.from_yaml import fill, stamp_all
from launcher.ros.messages.interfaces import load
from launcher.ros.messages.message_schema import schema_text
from launcher.ros.messages.to_yaml import to_plain
from launcher.ros.verb import to_json_plain, warn

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

PERIOD_S = 0.5  # from one look at the graph to the next
_LISTS_PARAMETERS = "rcl_interfaces/srv/ListParameters"

Report = Callable[..., None]  # an event with its fields


class FoxgloveBridge:
    """Runs in the event loop. What changes endpoints runs in one other thread, in order."""

    def __init__(
        self,
        observer: Observer,
        choice: TopicChoice,
        report: Report,
        *,
        most_bytes: int,
        is_read_only: bool,
    ) -> None:
        self._observer = observer
        self._choice = choice
        self._report = report
        self._most_bytes = most_bytes
        self._is_read_only = is_read_only
        self._worker = ThreadPoolExecutor(1, "endpoints")
        self._receiver = Receiver(observer)
        self._feeds = TopicFeeds(observer, self._receiver)
        self._calls = ServiceCalls(observer, self._worker)
        self._parameters = Parameters(self._calls)
        self._events = ParameterEvents(self._feeds, self._send_parameters)
        self._catalogue = Catalogue(schema_text, warn)
        self._connections = Connections()
        self._sessions: set[ClientSession] = set()
        self._numbers = 0
        self._soon = asyncio.Event()

    async def serve(self, socket: ServerConnection) -> None:
        """One client, until it has gone."""
        self._numbers += 1
        session = ClientSession(socket, self, self._numbers, self._most_bytes)
        self._greet(session)
        self._sessions.add(session)
        self._report("connected", client=session.number, address=session.address)
        try:
            await session.run()
        finally:
            self._sessions.discard(session)
            self._forget(session)
            self._report("disconnected", client=session.number, address=session.address)

    def _greet(self, session: ClientSession) -> None:
        session.send(
            protocol.text(
                "serverInfo",
                name=f"ROS domain {self._observer.domain_id}",
                capabilities=[
                    *protocol.CAPABILITIES,
                    *(() if self._is_read_only else protocol.WRITING_CAPABILITIES),
                ],
                supportedEncodings=list(protocol.ENCODINGS),
                metadata={"ROS_DISTRO": installed() or ""},
                sessionId=f"{os.getpid()}-{self._observer.created_s:.3f}",
            )
        )
        channels, services = self._catalogue.channels, self._catalogue.services
        session.send(protocol.text("advertise", channels=[one.to_json() for one in channels]))
        if services and not self._is_read_only:
            offered = [one.to_json() for one in services]
            session.send(protocol.text("advertiseServices", services=offered))

    def _forget(self, session: ClientSession) -> None:
        for number in list(session.topics):
            self.unsubscribe(session, number)
        for number in list(session.publications):
            self.unadvertise(session, number)
        self.follow_parameters()

    async def watch(self) -> None:
        """Follow the graph for ever."""
        while True:
            self._apply(await self._calls.work(self._look))
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._soon.wait(), PERIOD_S)
            self._soon.clear()

    def _look(self) -> Look:
        wanted = any(session.wants_connections for session in self._sessions)
        published = {p.topic for s in self._sessions for p in list(s.publications.values())}
        own = self._feeds.topics - published
        found = look(self._observer, self._choice, own, with_connections=wanted)
        self._feeds.fit_all()
        return found

    def _apply(self, found: Look) -> None:
        change = self._catalogue.update(found.topics, found.services)
        ending = "/list_parameters"
        self._parameters.nodes = {
            name.removesuffix(ending)
            for name, kind in found.services.items()
            if name.endswith(ending) and kind == _LISTS_PARAMETERS
        }
        self._calls.forget({service.name for service in change.gone_services})
        gone = {channel.id for channel in change.gone_channels}
        for session in self._sessions:
            for number, channel in list(session.topics.items()):
                if channel.id in gone:
                    self.unsubscribe(session, number)
            session.tick()
        self._announce("unadvertise", "channelIds", [one.id for one in change.gone_channels])
        self._announce("advertise", "channels", [one.to_json() for one in change.channels])
        if not self._is_read_only:
            ids = [one.id for one in change.gone_services]
            self._announce("unadvertiseServices", "serviceIds", ids)
            offered = [one.to_json() for one in change.services]
            self._announce("advertiseServices", "services", offered)
        if found.connections is not None:
            self._send_connections(found.connections)

    def _announce(self, op: str, field: str, items: list[Any]) -> None:
        if items:
            message = protocol.text(op, **{field: items})
            for session in self._sessions:
                session.send(message)

    # topics

    def subscribe(self, session: ClientSession, number: int, channel_id: int) -> None:
        channel = self._catalogue.channel(channel_id)
        if channel is None:
            raise ProtocolError(f"there is no channel {channel_id}")
        if number in session.topics:
            raise ProtocolError(f"subscription {number} exists already")
        if channel in session.topics.values():
            raise ProtocolError(f"this client has subscribed to {channel.topic} already")
        session.topics[number] = channel

        def begin() -> None:
            self._feeds.subscribe(
                channel.topic,
                channel.type,
                session,
                lambda time_ns, payload: session.deliver(number, time_ns, payload),
            )

        self._submit(session, channel.topic, begin)

    def unsubscribe(self, session: ClientSession, number: int) -> None:
        channel = session.forget(number)
        if channel is not None:
            self._worker.submit(self._feeds.unsubscribe, channel.topic, session)

    def _submit(self, session: ClientSession, topic: str, function: Callable[[], None]) -> None:
        """Run it in the other thread; send errors to the client."""
        loop = asyncio.get_running_loop()

        def run() -> None:
            try:
                function()
            except VerbError as error:
                loop.call_soon_threadsafe(session.warn, f"{topic}: {error.message}", protocol.ERROR)

        self._worker.submit(run)

    # what clients publish

    async def advertise(self, session: ClientSession, item: dict[str, Any]) -> None:
        self._require_writing("publish")
        if item["id"] in session.publications:
            raise ProtocolError(f"channel {item['id']} is advertised already")
        topic, kind, encoding = item["topic"], item["schemaName"], item["encoding"]
        try:
            publication = await self._calls.work(Publication, self._observer, topic, kind, encoding)
        except VerbError as error:
            hint = f" ({error.hint})" if error.hint else ""
            raise VerbError(f"{topic}: {error.message}{hint}") from None
        session.publications[item["id"]] = publication
        self._soon.set()

    def unadvertise(self, session: ClientSession, number: int) -> None:
        publication = session.publications.pop(number, None)
        if publication is not None:
            self._worker.submit(publication.close)

    def _require_writing(self, what: str) -> None:
        if self._is_read_only:
            raise ProtocolError(f"clients cannot {what}: the server is read-only")

    # services

    async def call_service(self, session: ClientSession, call: ServiceCall) -> None:
        def fail(reason: str) -> None:
            ids = {"serviceId": call.service, "callId": call.call}
            session.send(protocol.text("serviceCallFailure", **ids, message=reason))

        try:
            payload = await self._answer(call)
        except (VerbError, ProtocolError) as error:
            fail(str(error))
        except Exception as error:  # every call gets an answer
            fail(f"{type(error).__name__}: {error}")
            raise
        else:
            session.send(protocol.service_response(call, payload))

    async def _answer(self, call: ServiceCall) -> bytes:
        self._require_writing("call services")
        service = self._catalogue.service(call.service)
        if service is None:
            raise ProtocolError(f"there is no service {call.service}")
        if call.encoding not in protocol.ENCODINGS:
            raise ProtocolError(f"unknown encoding '{call.encoding}'")
        kind = load(service.type, "srv", f"{service.type} cannot be used")
        is_json = call.encoding == "json"
        try:
            if is_json:
                request = kind.Request()
                stamps = fill(request, strict_json.loads(call.payload or b"{}"))
                stamp_all(stamps, self._observer.node.get_clock().now().to_msg())
            else:
                request = deserialize_message(call.payload, kind.Request)
        except VerbError:
            raise
        except Exception as error:  # of rclpy: of several types
            raise VerbError(f"no request of {service.type}: {reason(error)}") from None
        response = await self._calls.call(kind, service.name, request)
        if is_json:
            return strict_json.dumps(to_json_plain(to_plain(response)), ensure_ascii=False).encode()
        return bytes(serialize_message(response))

    # parameters

    async def get_parameters(
        self, session: ClientSession, names: list[str], request: str | None
    ) -> None:
        values = await self._parameters.get(names)
        session.send(protocol.text("parameterValues", parameters=values, id=request))

    async def set_parameters(
        self, session: ClientSession, items: list[dict[str, Any]], request: str | None
    ) -> None:
        self._require_writing("set parameters")
        values, problems = await self._parameters.set(items)
        for problem in problems:
            session.warn(problem)
        if request is not None:
            session.send(protocol.text("parameterValues", parameters=values, id=request))

    def follow_parameters(self) -> None:
        """Subscribe to changes of parameters while a client has requested them."""
        wanted = any(session.parameters != set() for session in self._sessions)
        self._worker.submit(self._events.follow, wanted)

    def _send_parameters(self, values: list[dict[str, Any]]) -> None:
        for session in self._sessions:
            names = session.parameters
            mine = [one for one in values if names is None or one["name"] in names]
            if mine:
                session.send(protocol.text("parameterValues", parameters=mine))

    # connections

    def show_connections(self, session: ClientSession) -> None:
        """What is known now is sent at once, changes later."""
        if session.wants_connections:
            return
        session.wants_connections = True
        update = self._connections.update_from(Connections())
        if update is not None:
            session.send(protocol.text("connectionGraphUpdate", **update))
        self._soon.set()

    def _send_connections(self, found: Connections) -> None:
        update = found.update_from(self._connections)
        self._connections = found
        if update is not None:
            message = protocol.text("connectionGraphUpdate", **update)
            for session in self._sessions:
                if session.wants_connections:
                    session.send(message)

    async def close(self) -> None:
        """After the server."""
        for session in self._sessions:
            session.abort()
        await self._calls.work(self._feeds.close)
        self._worker.shutdown()
        self._receiver.close()
        self._calls.close()
