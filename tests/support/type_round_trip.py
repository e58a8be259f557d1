"""Send values of every interface of some packages through DDS, and compare what arrives.

    python -m tests.support.type_round_trip EXAMPLES PACKAGE ...

Runs in the environment of a workspace. Prints a line for each interface, and what differs.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import rclpy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rclpy.action import ActionClient, ActionServer
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

from launcher.ros.messages.interfaces import class_of, interfaces_of
from launcher.ros.messages.to_yaml import to_plain
from tests.support.any_message import extreme, messages, same

TIMEOUT_S = 60.0


class Ends:
    """Two nodes with a context and participant each, so that everything passes through DDS."""

    def __init__(self) -> None:
        self.nodes = []
        self.executors = []
        for name in ("near", "far"):
            context = Context()
            rclpy.init(context=context)
            self.nodes.append(Node(name, context=context))
            self.executors.append(MultiThreadedExecutor(num_threads=2, context=context))
            self.executors[-1].add_node(self.nodes[-1])
        self.near, self.far = self.nodes

    def wait_until(self, fact: Callable[[], object]) -> None:
        deadline = time.monotonic() + TIMEOUT_S
        while not fact():
            assert time.monotonic() < deadline, f"not within {TIMEOUT_S:g} s"
            for executor in self.executors:
                executor.spin_once(timeout_sec=0.001)

    def wait_until_clients_are_known(self, service: str) -> None:
        """A service drops its answer to a client that it has not discovered."""
        self.wait_until(lambda: self.far.count_clients(service))

    def result(self, future: Any) -> Any:
        self.wait_until(future.done)
        return future.result()

    def close(self) -> None:
        for node, executor in zip(self.nodes, self.executors, strict=True):
            executor.shutdown()
            node.destroy_node()
            node.context.try_shutdown()


def through_topic(ends: Ends, cls: Any) -> Callable[[Any], Any]:
    arrived: list[Any] = []
    ends.far.create_subscription(cls, "round_trip", arrived.append, 10)
    publisher = ends.near.create_publisher(cls, "round_trip", 10)
    ends.wait_until(lambda: publisher.get_subscription_count() == 1)

    def send(message: Any) -> Any:
        arrived.clear()
        publisher.publish(message)
        ends.wait_until(lambda: arrived)
        return arrived[0]

    return send


def through_service(ends: Ends, kind: Any) -> Callable[[Any, Any], tuple[Any, Any]]:
    seen: list[Any] = []
    answers: list[Any] = []

    def answer(request: Any, _: Any) -> Any:
        seen.append(request)
        return answers[-1]

    ends.far.create_service(kind, "round_trip", answer)
    client = ends.near.create_client(kind, "round_trip")
    ends.wait_until(client.service_is_ready)
    ends.wait_until_clients_are_known("round_trip")

    def call(request: Any, response: Any) -> tuple[Any, Any]:
        answers.append(response)
        answered = ends.result(client.call_async(request))
        return seen[-1], answered

    return call


def through_action(ends: Ends, kind: Any) -> Callable[[Any, Any, Any], tuple[Any, Any, Any]]:
    seen: list[Any] = []
    planned: list[tuple[Any, Any]] = []
    may_end: list[bool] = []

    def execute(goal: Any) -> Any:
        feedback, result = planned[-1]
        seen.append(goal.request)
        deadline = time.monotonic() + TIMEOUT_S
        while not may_end and time.monotonic() < deadline:  # the first may come too early
            goal.publish_feedback(feedback)
            time.sleep(0.01)
        goal.succeed()
        return result

    ActionServer(ends.far, kind, "round_trip", execute)
    client = ActionClient(ends.near, kind, "round_trip")
    ends.wait_until(client.server_is_ready)
    for service in ("send_goal", "get_result"):
        ends.wait_until_clients_are_known(f"round_trip/_action/{service}")

    def perform(request: Any, feedback: Any, result: Any) -> tuple[Any, Any, Any]:
        planned.append((feedback, result))
        may_end.clear()
        heard: list[Any] = []
        goal = ends.result(client.send_goal_async(request, heard.append))
        assert goal.accepted
        ends.wait_until(lambda: heard)
        may_end.append(True)
        returned = ends.result(goal.get_result_async()).result
        return seen[-1], heard[0].feedback, returned

    return perform


WAYS = {"msg": through_topic, "srv": through_service, "action": through_action}


def parts_of(kind: str, cls: Any) -> tuple[Any, ...]:
    if kind == "msg":
        return (cls,)
    return (cls.Request, cls.Response) if kind == "srv" else (cls.Goal, cls.Feedback, cls.Result)


def difference(ends: Ends, name: str, count: int) -> str | None:
    """What was sent and what arrived where the two are not the same."""
    package, kind, last = name.split("/")
    cls = class_of(package, kind, last)
    send = WAYS[kind](ends, cls)
    parts = parts_of(kind, cls)

    def check(sent: tuple[Any, ...]) -> None:
        arrived = send(*sent)
        for one, other in zip(sent, arrived if kind != "msg" else (arrived,), strict=True):
            assert same(to_plain(one), to_plain(other)), f"sent {one}, received {other}"

    @settings(
        max_examples=count, deadline=None, database=None, suppress_health_check=list(HealthCheck)
    )
    @given(st.tuples(*map(messages, parts)))
    def search(sent: tuple[Any, ...]) -> None:
        check(sent)

    try:
        for high in (False, True):
            check(tuple(extreme(part, high=high) for part in parts))
        search()
    except AssertionError as error:
        return str(error)
    return None


def names(packages: list[str]) -> Iterator[str]:
    for package in packages:
        yield from interfaces_of(package)


def main() -> int:
    failed = 0
    for name in names(sys.argv[2:]):
        ends = Ends()
        try:
            wrong = difference(ends, name, int(sys.argv[1]))
        finally:
            ends.close()
        print(name, f"DIFFERS: {wrong}" if wrong else "ok", flush=True)
        failed += wrong is not None
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
