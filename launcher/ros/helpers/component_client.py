"""Asks a container to load nodes, and notices requests and answers that were lost.

rmw_fastrtps drops an answer to a client that the container has not discovered within 0.1 s, and a
container that was restarted does not know earlier requests. If an answer is overdue, the container
is asked for its nodes. It carries out requests one after the other: a list without the node, asked
for after the request, says that the request was lost, and it is sent again.
"""

from __future__ import annotations

import enum
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rclpy.node import Node

OVERDUE_S = 1.0  # an answer after its request, a list of nodes after a question
MAX_OPEN = 10  # questions without an answer: on a busy machine it takes long, and may be lost
MAX_ABSENT = 3  # lists without the node
MAX_SENT = 3
UNANSWERED = "the container answers other requests, but not this one"


class Loaded(NamedTuple):
    """A node in a container."""

    unique_id: int
    full_name: str


class LoadStep(enum.Enum):
    """What to do next for a request."""

    WAIT = enum.auto()
    SEND = enum.auto()
    ASK = enum.auto()  # the container for its nodes
    GIVE_UP = enum.auto()


class ComponentLoad:
    """The state machine of a load request; no I/O. Times are seconds of one monotonic clock.

    `full_name` is empty if the plug-in chooses the name of its node.
    """

    def __init__(self, full_name: str) -> None:
        self._full_name = full_name
        self._due_s: float | None = None
        self._sent = self._absent = 0

    def next_step(self, now_s: float) -> LoadStep:
        """Call it regularly while the container is there."""
        if self._due_s is not None and now_s < self._due_s:
            return LoadStep.WAIT
        is_new = self._due_s is None
        self._due_s = now_s + OVERDUE_S
        if not is_new and self._absent < MAX_ABSENT:
            return LoadStep.ASK
        if self._sent == MAX_SENT:
            return LoadStep.GIVE_UP
        self._absent = 0
        self._sent += 1
        return LoadStep.SEND

    def look_up(self, nodes: Mapping[int, str], known: set[Loaded]) -> Loaded | None:
        """The node that was requested, by a list of the container; `known` are other requests'."""
        found = [Loaded(*item) for item in nodes.items() if Loaded(*item) not in known]
        found = [node for node in found if self._full_name in ("", node.full_name)]
        if not found:
            self._absent += 1
            return None
        return max(found)  # the newest: numbers increase


class _PendingLoad:
    """A request, its futures, and who waits for the answer."""

    def __init__(self, request_id: int, message: Any, done: Done) -> None:
        self.request_id = request_id
        self.message = message
        self.done = done
        name = message.node_name
        namespace = message.node_namespace.strip("/")
        prefix = f"/{namespace}" if namespace else ""
        self.state = ComponentLoad(f"{prefix}/{name}" if name else "")
        self.answers: list[Any] = []
        self.questions: list[Any] = []


Done = Callable[["Loaded | None", "str | None"], None]  # a node, or an error


class ContainerClient:
    """The load requests for one container. Call `poll()` regularly: it does everything."""

    def __init__(self, node: Node, container: str) -> None:
        from composition_interfaces.srv import ListNodes, LoadNode  # may not be installed

        self._question = ListNodes.Request
        self._load = node.create_client(LoadNode, f"{container}/_container/load_node")
        self._list = node.create_client(ListNodes, f"{container}/_container/list_nodes")
        self._pending: list[_PendingLoad] = []
        self._known: set[Loaded] = set()

    @property
    def is_there(self) -> bool:
        return bool(self._load.service_is_ready())

    @property
    def request_ids(self) -> list[int]:
        """Requests without an answer."""
        return [one.request_id for one in self._pending]

    def load(self, request_id: int, message: Any, done: Done) -> None:
        """Request a node once the container is there; `done` is called with the answer."""
        self._pending.append(_PendingLoad(request_id, message, done))
        self.poll()

    def drop(self, request_id: int) -> None:
        """Forget a request; an answer to it is ignored."""
        for one in self._pending:
            if one.request_id == request_id:
                self._release(one)
        self._pending = [one for one in self._pending if one.request_id != request_id]

    def poll(self) -> None:
        now_s, is_there = time.monotonic(), self.is_there
        for one in tuple(self._pending):
            self._take_answers(one)
            if one in self._pending and is_there:
                self._do(one, one.state.next_step(now_s))

    def _take_answers(self, one: _PendingLoad) -> None:
        for future in one.answers:
            if future.done():
                answer = future.result()
                loaded = Loaded(answer.unique_id, answer.full_node_name)
                error = None if answer.success else answer.error_message or "no reason given"
                self._settle(one, loaded if error is None else None, error)
                return
        for question in [future for future in one.questions if future.done()]:
            one.questions.remove(question)
            answer = question.result()
            nodes = dict(zip(answer.unique_ids, answer.full_node_names, strict=False))
            found = one.state.look_up(nodes, self._known)
            if found is not None:
                self._settle(one, found, None)
                return

    def _do(self, one: _PendingLoad, step: LoadStep) -> None:
        if step is LoadStep.SEND:
            one.answers.append(self._load.call_async(one.message))
        elif step is LoadStep.GIVE_UP:
            self._settle(one, None, UNANSWERED)
        elif step is LoadStep.ASK and self._list.service_is_ready():
            one.questions.append(self._list.call_async(self._question()))
            if len(one.questions) > MAX_OPEN:
                self._list.remove_pending_request(one.questions.pop(0))

    def _settle(self, one: _PendingLoad, loaded: Loaded | None, error: str | None) -> None:
        if loaded is not None:
            self._known.add(loaded)
        self._pending.remove(one)
        self._release(one)
        one.done(loaded, error)

    def _release(self, one: _PendingLoad) -> None:
        for future in one.answers:
            self._load.remove_pending_request(future)
        for question in one.questions:
            self._list.remove_pending_request(question)
