"""Sends recorded calls of services and actions to the servers that are there now."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

from launcher.base.ros_errors import VerbError
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.decoding import decoder, kept_interrupts
from launcher.ros.messages.interfaces import load

if TYPE_CHECKING:
    from rclpy.node import Node

_REQUEST_SENT, _REQUEST_RECEIVED = 0, 1  # service_msgs/msg/ServiceEventInfo
_NOT_SENT = -1  # in place of the number of a request
_NO_ID = bytes(16)  # of a goal: all of them

Send = Callable[[Any], int]  # the number of the request


class Requester:
    """Sends the requests in the events of a service.

    `source` is whose events are used, `client` or `service`, since both may have been recorded.
    `prepare` gets each request and what sends it; `answered` each response. Nobody waits for
    responses that are not `awaited`. Requests are `unserved` without a server.
    """

    def __init__(
        self,
        node: Node,
        service: str,
        kind: Any,
        source: str,
        *,
        prepare: Callable[[Any, Send], object] = lambda request, send: send(request),
        answered: Callable[[int, Any], None] | None = None,
        awaited: bool = True,
    ) -> None:
        with_library(kind)
        self.service = service
        self._decode, self._response = decoder(kind.Event), kind.Response
        self.sent = self.unserved = self.of_others = self.without_contents = 0
        self._pending: set[int] = set()
        self._prepare = prepare
        self._answered = answered
        self._awaited = awaited
        self._client = node.create_client(kind, service)
        self.is_ready = self._client.service_is_ready
        self._wanted = _REQUEST_SENT if source == "client" else _REQUEST_RECEIVED

    def send(self, data: bytes) -> None:
        event = self._decode(data)
        kind = event.info.event_type
        if kind != self._wanted:
            self.of_others += kind in (_REQUEST_SENT, _REQUEST_RECEIVED)
        elif event.request:
            self._prepare(event.request[0], self.request)
        else:
            self.without_contents += 1

    def request(self, request: Any) -> int:
        """Its number, with which its response comes; below 0 if there is no server."""
        if not self.is_ready():
            self.unserved += 1
            return _NOT_SENT
        self.sent += 1
        self.awaits_answers()  # there is room for a few only
        with self._client.handle:
            number = int(self._client.handle.send_request(request))
        self._pending.add(number)
        return number

    def awaits_answers(self) -> bool:
        """Whether an answer has not come yet; a request that is under way ends with its client."""
        with self._client.handle:
            while self._pending:
                with kept_interrupts():
                    header, response = self._client.handle.take_response(self._response)
                if header is None:
                    break
                number = header.request_id.sequence_number
                self._pending.discard(number)
                if self._answered is not None:
                    self._answered(number, response)
        return self._awaited and bool(self._pending)


def why_nothing_was_sent(requesters: Collection[Requester]) -> str:
    """The reason, perhaps with a hint in a second line."""
    if not requesters:
        return "the bag has no events of them"
    if absent := [one.service for one in requesters if one.unserved]:
        return f"{absent[0]} is not there"
    if any(one.of_others for one in requesters):
        return "the events are of the other side\nhint: see --service-requests-source"
    if any(one.without_contents for one in requesters):
        return "the events have no contents"
    return "no request was played"


def requester(node: Node, service: str, type_name: str, source: str) -> Requester:
    """VerbError if the type is not installed."""
    kind = load(type_name, "srv", "The passed service type is invalid")
    return Requester(node, service, kind, source)


class ActionRequests:
    """The clients of one action.

    Goals get new ids, since a server refuses one that it knows. What asks for a goal waits until
    the server has accepted it.
    """

    def __init__(self, node: Node, source: str) -> None:
        self._node = node
        self._source = source
        self._goals: Requester | None = None
        self._ids: dict[bytes, bytes] = {}  # recorded -> sent
        self._asked: dict[int, bytes] = {}  # number of a request -> the id that was sent
        self._waiting: dict[bytes, list[Callable[[], object]]] = {}  # for the answer to these ids

    def client(self, service: str, part: str, type_name: str) -> Requester:
        """That of one of the services; VerbError if the type is not installed."""
        if part == "cancel_goal":
            from action_msgs.srv import CancelGoal

            return self._requester(service, CancelGoal, self._cancel)
        kind = load(type_name, "action", "The passed action type is invalid")
        if part == "get_result":
            # The answer comes when the goal has ended, and nobody needs it.
            of_results = kind.Impl.GetResultService
            return self._requester(service, of_results, self._result, awaited=False)
        goals = kind.Impl.SendGoalService
        self._goals = self._requester(service, goals, self._goal, answered=self._decided)
        return self._goals

    def _requester(
        self, service: str, kind: Any, prepare: Callable[[Any, Send], object], **more: Any
    ) -> Requester:
        return Requester(self._node, service, kind, self._source, prepare=prepare, **more)

    def _goal(self, request: Any, send: Send) -> None:
        sent = uuid.uuid4().bytes
        self._ids[bytes(request.goal_id.uuid)] = sent
        request.goal_id.uuid = list(sent)
        self._waiting[sent] = []
        self._asked[send(request)] = sent

    def _decided(self, number: int, response: Any) -> None:
        waiting = self._waiting.pop(self._asked.pop(number, b""), [])
        if response.accepted:
            for order in waiting:
                order()

    def _cancel(self, request: Any, send: Send) -> None:
        info = request.goal_info
        if bytes(info.goal_id.uuid) == _NO_ID:  # all goals, or those before a time
            if info.stamp.sec:
                info.stamp = self._node.get_clock().now().to_msg()
            send(request)
        else:
            self._when_accepted(info.goal_id, lambda: send(request))

    def _result(self, request: Any, send: Send) -> None:
        self._when_accepted(request.goal_id, lambda: send(request))

    def _when_accepted(self, goal_id: Any, order: Callable[[], object]) -> None:
        sent = self._ids.get(bytes(goal_id.uuid))
        if sent is None:
            raise VerbError("its goal is not in what was played")
        goal_id.uuid = list(sent)
        if sent in self._waiting:
            self._waiting[sent].append(order)
        else:
            order()

    def poll(self) -> None:
        """Take the answers that have come."""
        if self._goals is not None:
            self._goals.awaits_answers()
