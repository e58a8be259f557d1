"""Passes on the messages of a topic that a process publishes under another name: late, or in part.

One JSON object on standard input says which, and what (`percent` or `delay_s`). It looks for the
publisher of the process, and answers on standard output with `{"ready": true}` when its own
endpoints, with the same QoS, are there: then the process is to be restarted; or with
`{"error": TEXT}`. When the process publishes under the other name, it says
`{"matched": true, "subscribes": BOOL}`: the last is whether the process subscribes to it, too.
It ends with its input.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections import deque
from collections.abc import Sequence
from typing import Any

from launcher.base import strict_json
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.posix import dispositions, proc
from launcher.posix.stdio import end_of_input, keep_for_messages
from launcher.ros.discovery.completeness import settle
from launcher.ros.discovery.gids import pid_low16
from launcher.ros.discovery.observer import Observer
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.interfaces import load_message
from launcher.ros.snapshot.ros_graph import INFINITE_NS, Direction, Endpoint
from launcher.ros.topics import qos

FIND_S = 8.0
DEPTH = 1000  # room for bursts
# What late subscriptions get of it: how much the publisher keeps is not announced, and most that
# keep anything keep their last message.
KEPT = 1
PERIOD_S = 0.05
_SHARED = ("/rosout", "/parameter_events")


class MessageFilter:
    """Which messages are passed on, and when."""

    def __init__(self, request: dict[str, Any]) -> None:
        self._delay_s = request.get("delay_s", 0.0)
        self._percent = 0.0 if self._delay_s else request.get("percent", 100.0)
        self._owed = 0.0
        self._waiting: deque[tuple[float, bytes]] = deque()

    def add(self, message: bytes, now: float) -> None:
        """Drop evenly: at 50 % every second one, at 100 % all."""
        self._owed += self._percent
        if self._owed >= 100.0:
            self._owed -= 100.0
        else:
            self._waiting.append((now + self._delay_s, message))

    def due(self, now: float) -> list[bytes]:
        found = []
        while self._waiting and self._waiting[0][0] <= now:
            found.append(self._waiting.popleft()[1])
        return found

    def wait_s(self, now: float) -> float:
        """Until the next one is due."""
        return max(0.0, min(PERIOD_S, self._waiting[0][0] - now)) if self._waiting else PERIOD_S


class TopicProxy:
    """Between a process and those who listen to it."""

    def __init__(self, observer: Observer, request: dict[str, Any]) -> None:
        self._observer = observer
        self._request = request
        self._topic: str = request["topic"]
        self._hidden: str = request["hidden"]
        self._filter = MessageFilter(request)
        self._is_matched = False

    def open(self) -> None:
        """Create both endpoints; VerbError if the process does not publish the topic."""
        from rclpy.executors import SingleThreadedExecutor

        found = self._publisher()
        kind = with_library(load_message(found.type))
        keeps = found.durability == "TRANSIENT_LOCAL"
        node = self._observer.node
        self._out = node.create_publisher(
            kind, self._topic, profile_of(found, KEPT if keeps else DEPTH)
        )
        listening = {"reliability": found.reliability, "durability": found.durability}
        node.create_subscription(
            kind, self._hidden, self._heard, qos.from_words(listening, DEPTH), raw=True
        )
        self._executor = SingleThreadedExecutor(context=self._observer.context)
        self._executor.add_node(node)

    def _publisher(self) -> Endpoint:
        def of_topic() -> list[Endpoint]:
            return self._own(self._observer.endpoints(self._topic), Direction.PUBLISHER)

        settle(self._observer, FIND_S, enough=of_topic)
        if found := of_topic():
            return found[0]
        own = self._own(self._observer.all_endpoints(), Direction.PUBLISHER)
        names = sorted({one.topic for one in own} - set(_SHARED))
        known = f"it publishes {', '.join(names)}" if names else "it publishes none"
        hint = did_you_mean(self._topic, names)
        more = f"; {hint}" if hint else ""
        raise VerbError(f"it does not publish {self._topic}; {known}{more}")

    def _own(self, endpoints: Sequence[Endpoint], direction: Direction) -> list[Endpoint]:
        """Those of the process: by the process id in their GIDs, or by the names of its nodes."""
        lows = {pid & 0xFFFF for pid in session_of(self._request["pid"])}
        nodes = self._request["nodes"]
        return [
            one
            for one in endpoints
            if one.direction == direction.value
            and (one.node in nodes or pid_low16(bytes.fromhex(one.gid.replace(".", ""))) in lows)
        ]

    def _heard(self, message: bytes) -> None:
        self._filter.add(message, time.monotonic())
        self._pass_on()

    def _pass_on(self) -> None:
        for message in self._filter.due(time.monotonic()):
            self._out.publish(message)

    def run(self, over: threading.Event) -> None:
        while not over.is_set():
            self._executor.spin_once(timeout_sec=self._filter.wait_s(time.monotonic()))
            self._pass_on()
            if not self._is_matched and self._observer.infos(self._hidden, Direction.PUBLISHER):
                self._is_matched = True
                own = self._observer.infos(self._hidden, Direction.SUBSCRIPTION)
                say(matched=True, subscribes=bool(own))


def profile_of(endpoint: Endpoint, depth: int) -> Any:
    """The QoS of a publisher, as far as it is announced."""
    from rclpy.duration import Duration

    names = ("reliability", "durability", "liveliness")
    profile = qos.from_words({name: getattr(endpoint, name) for name in names}, depth)
    for name, value_ns in (
        ("deadline", endpoint.deadline_ns),
        ("liveliness_lease_duration", endpoint.lease_ns),
    ):
        if value_ns < INFINITE_NS:
            setattr(profile, name, Duration(nanoseconds=value_ns))
    return profile


def session_of(leader: int) -> list[int]:
    """All processes of a session."""
    found = []
    for pid in proc.pids():
        try:
            if os.getsid(pid) == leader:
                found.append(pid)
        except OSError:
            continue  # it has just ended
    return found


def say(**answer: object) -> None:
    print(strict_json.packed(answer), flush=True)


def main() -> None:
    keep_for_messages()
    dispositions.ignore()  # we end with our input
    request = strict_json.unpacked(sys.stdin.readline())
    over = end_of_input()
    with Observer(purpose="inject") as observer:
        proxy = TopicProxy(observer, request)
        try:
            proxy.open()
        except VerbError as error:
            say(error=error.message)
            return
        say(ready=True)
        proxy.run(over)


if __name__ == "__main__":
    main()
