"""Calls services of nodes, with a limit on how long an answer may take."""

from __future__ import annotations

import contextlib
import functools
import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError, did_you_mean, name_fault
from launcher.ros.discovery.completeness import settle
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.decoding import kept_interrupts

if TYPE_CHECKING:
    from rclpy.client import Client
    from rclpy.node import Node
    from rclpy.qos import QoSProfile

    from launcher.ros.discovery.observer import Observer

ANSWER_S = 5.0
_CONNECT_S = 1.0  # from the discovery of a service until it is ready
_PREFETCHED_S = 5.0  # the same where only the prefetch has discovered it
# A service of rmw_fastrtps drops its answer to a client that it has not discovered 0.1 s after the
# request; to discover a new participant takes as long, and longer on a busy machine.
_DISCOVERED_S = 0.2
ASK_AGAIN_S = 1.0
_PERIOD_S = 0.005
_NODE_PERIOD_S = 0.05


class NoAnswerError(VerbError):
    """The service is not there, or did not answer in time."""


class ServiceCaller:
    """Calls services from the observer's node, or another one; close it before the observer.

    `answer_s` is the time limit where a call has no other, `node` has the clients.
    """

    def __init__(
        self, observer: Observer, node: Node | None = None, answer_s: float | None = None
    ) -> None:
        from rclpy.executors import SingleThreadedExecutor

        self.observer = observer
        self.answer_s = ANSWER_S if answer_s is None else answer_s
        self.node = observer.node if node is None else node
        self._executor = SingleThreadedExecutor(context=observer.context)
        self._executor.add_node(self.node)
        self._clients: dict[tuple[Any, str], Any] = {}

    def __enter__(self) -> ServiceCaller:
        return self

    def __exit__(self, *exit_info: object) -> None:
        self._executor.shutdown()

    def client(self, kind: object, name: str, profile: QoSProfile | None = None) -> Any:
        """The client of a service, created once; VerbError if the name is not valid.

        `profile` is for a client that is created now; without, it is that of services.
        """
        from rclpy.exceptions import InvalidServiceNameException
        from rclpy.qos import qos_profile_services_default

        if (kind, name) not in self._clients:
            usual = qos_profile_services_default
            try:
                created = self.node.create_client(kind, name, qos_profile=profile or usual)
                self._clients[kind, name] = created
            except InvalidServiceNameException as error:
                raise VerbError(name_fault(error)) from None
        return self._clients[kind, name]

    def load(self, kind: object) -> None:
        """Load the libraries of a type, while its service is being discovered; VerbError."""
        with_library(kind)

    def wait_for(self, client: Client, limit_s: float) -> bool:
        """Whether the service is ready within the limit."""
        deadline = time.monotonic() + limit_s
        while not client.service_is_ready():
            if time.monotonic() >= deadline:
                return False
            time.sleep(_PERIOD_S)
        return True

    def start(self, kind: object, name: str, request: object) -> Any:
        """The future of an answer; NoAnswerError if the service does not become ready."""
        client = self.client(kind, name)
        if not self.wait_for(client, self._connecting_s(name)):
            raise NoAnswerError(f"service '{name}' is not available")
        self.await_introduction()
        return client.call_async(request)

    def await_introduction(self) -> None:
        """Wait until others have probably discovered our participant."""
        since_s = time.monotonic() - self.observer.created_s
        time.sleep(max(0.0, _DISCOVERED_S - since_s))

    def _connecting_s(self, name: str) -> float:
        graph = self.observer.prefetched_graph()
        return _PREFETCHED_S if graph and name in graph.service_types() else _CONNECT_S

    def call(self, kind: object, name: str, request: object, limit_s: float | None = None) -> Any:
        """The answer; NoAnswerError if there is none in time."""
        limit_s = self.answer_s if limit_s is None else limit_s
        future = self.start(kind, name, request)
        self.wait_until_done([future], limit_s)
        if not future.done():
            raise silence(name, limit_s)
        return future.result()

    def ask(self, kind: object, name: str, request: object) -> Any:
        """As `call`, repeated if the answer is lost; for requests that may be carried out twice."""
        deadline = time.monotonic() + self.answer_s
        futures: list[Any] = []
        while (left_s := deadline - time.monotonic()) > 0:
            futures.append(self.start(kind, name, request))
            self.spin_until(lambda: any(one.done() for one in futures), min(left_s, ASK_AGAIN_S))
            if done := [future for future in futures if future.done()]:
                return done[0].result()
        raise silence(name, self.answer_s)

    def ask_each(
        self, kind: object, nodes: Sequence[str], service: str, request: object
    ) -> Iterator[tuple[str, Any]]:
        """Each node with the answer of its service, None if there is none in time, in this order.

        All are asked at once, and again if need be; each comes as soon as those before it have.
        """
        deadline = time.monotonic() + self.answer_s
        asked: dict[str, list[Any]] = {node: [] for node in nodes}
        due_s = -math.inf

        def answers(node: str) -> list[Any]:
            return [future for future in asked[node] if future.done()]

        for node in nodes:
            while not answers(node) and (now := time.monotonic()) < deadline:
                if now >= due_s:
                    due_s = now + ASK_AGAIN_S
                    for silent in [one for one in nodes if not answers(one)]:
                        with contextlib.suppress(NoAnswerError):
                            asked[silent].append(self.start(kind, f"{silent}/{service}", request))
                wait_s = min(due_s, deadline) - time.monotonic()
                self.spin_until(functools.partial(answers, node), wait_s)
            yield node, next((future.result() for future in answers(node)), None)

    def wait_until_done(self, futures: list[Any], limit_s: float) -> None:
        self.spin_until(lambda: all(future.done() for future in futures), limit_s)

    def spin_until(self, is_done: Callable[[], object], limit_s: float) -> None:
        """Run callbacks until `is_done`, which is called again and again, or for `limit_s`."""
        deadline = time.monotonic() + limit_s
        while not is_done() and (left_s := deadline - time.monotonic()) > 0:
            with kept_interrupts():
                self._executor.spin_once(timeout_sec=min(left_s, 0.1))


def silence(name: str, limit_s: float) -> NoAnswerError:
    return NoAnswerError(
        f"service '{name}' did not answer within {limit_s:g} s",
        hint="its node may be busy or stopped: node ps",
    )


def require_node(
    observer: Observer, name: str, spin_time_s: float, until_s: float = -math.inf
) -> str:
    """The full name of a node; VerbError with the text of ros2cli if it does not exist.

    It may still appear up to `until_s`, on the monotonic clock.
    """
    full = full_name(name)
    known: Sequence[str]
    if (graph := observer.prefetched_graph()) is not None:
        known = graph.nodes
    else:
        settle(observer, spin_time_s, enough=lambda: full in observer.node_names())
        known = observer.node_names()
    while full not in known and time.monotonic() < until_s:
        time.sleep(_NODE_PERIOD_S)
        known = observer.node_names()
    if full not in known:
        raise VerbError("Node not found", hint=did_you_mean(full, known))
    return full
