"""Asks nodes once a second whether they answer, as a separate process.

A line of JSON on standard input is the list of nodes, in place of the last one; on standard output
there is one for each node that does not answer, once a second, and one when it answers (again), or
cannot be asked (`silent_s` 0 and null). It ends with its input. A node that is `expected` to answer
is reported even if it never has.

The question is the parameter service of the node itself, which its executor answers between its
callbacks. No executor runs here: what has arrived is taken once a second, which costs a fraction
of waking up for each answer.
"""

from __future__ import annotations

import os
import select
import sys
import time
from typing import TYPE_CHECKING, Any

from launcher.base import strict_json
from launcher.posix import dispositions, proc
from launcher.posix.stdio import keep_for_messages

if TYPE_CHECKING:
    from rclpy.client import Client
    from rclpy.node import Node

PERIOD_S = 1.0
LATE_S = 0.5  # more than this between two rounds is our own delay, and not that of a node
SILENT_S = 3.0  # of no answer, before a node is reported
_NANOSECONDS = 1e9


class WatchedNode:
    """A node in a process, for one life of it.

    Only a node that has answered once can fall silent: others are starting, or never serve their
    parameter services; unless it is expected to answer. Time that its process waited for a
    processor, or that we did, does not count.
    """

    def __init__(self, name: str, pid: int, *, is_expected: bool = False) -> None:
        self.name = name
        self.pid = pid
        self.silent_s = 0.0
        self.has_answered = False
        self.is_expected = is_expected
        self._waited_s = _waited_s(pid)

    @property
    def is_silent(self) -> bool:
        return self.silent_s >= SILENT_S

    def answered(self) -> bool:
        """Note an answer; whether that is new: the first one, or after it was silent."""
        is_new = self.is_silent or not self.has_answered
        self.silent_s, self.has_answered = 0.0, True
        return is_new

    def no_answer(self, elapsed_s: float) -> None:
        """Nothing has arrived in this time, which began with an unanswered question."""
        waited_s = _waited_s(self.pid)
        own_s = max(0.0, elapsed_s - max(0.0, waited_s - self._waited_s))
        self._waited_s = waited_s
        if self.has_answered or self.is_expected:
            self.silent_s += min(own_s, PERIOD_S + LATE_S)

    def lost(self) -> None:
        """Its service is not there (any more): it cannot be asked."""
        self.silent_s, self.has_answered = 0.0, False


def _waited_s(pid: int) -> float:
    """How long its main thread was ready to run, and had no processor."""
    fields = proc.read(pid, "schedstat").split()
    return int(fields[1]) / _NANOSECONDS if len(fields) > 1 else 0.0


class Questions:
    """The clients of the services, one for each node name."""

    def __init__(self, node: Node) -> None:
        from rcl_interfaces.srv import GetParameterTypes

        self._node = node
        self._type = GetParameterTypes
        self._clients: dict[str, Any] = {}
        self._watched: dict[str, WatchedNode] = {}
        self._asked: set[str] = set()

    def watch(self, entries: list[dict[str, Any]]) -> None:
        """Watch these, and no others; the state of those that stay is kept."""
        before, self._watched = self._watched, {}
        for entry in entries:
            name, pid, node = entry["name"], entry["pid"], entry["node"]
            old = before.get(node)
            is_same = old is not None and (old.name, old.pid) == (name, pid)
            kept = old if is_same and old is not None else WatchedNode(name, pid)
            kept.is_expected = entry["expected"]
            self._watched[node] = kept
            if not is_same:
                self._forget(node)
                self._clients[node] = self._node.create_client(
                    self._type, f"{node}/get_parameter_types"
                )
        for node in self._clients.keys() - self._watched.keys():
            self._forget(node)

    def _forget(self, node: str) -> None:
        self._asked.discard(node)
        client = self._clients.pop(node, None)
        if client is not None:
            self._node.destroy_client(client)

    def round(self, elapsed_s: float) -> list[dict[str, Any]]:
        """Take the answers of the last round, and ask again; what is to be reported."""
        reports: list[dict[str, Any]] = []
        for node, watched in self._watched.items():
            client, about = self._clients[node], {"name": watched.name, "pid": watched.pid}
            if self._take(client):
                if watched.answered():
                    reports.append({**about, "silent_s": 0})
            elif not client.service_is_ready():
                if watched.has_answered:
                    reports.append({**about, "silent_s": None})
                watched.lost()
                continue
            elif node in self._asked:
                watched.no_answer(elapsed_s)
            if watched.is_silent:
                reports.append({**about, "silent_s": round(watched.silent_s, 1), "node": node})
            with client.handle:
                client.handle.send_request(self._type.Request())
            self._asked.add(node)
        return reports

    def _take(self, client: Client) -> bool:
        """Whether an answer has arrived; takes all, of which the last is as good as any."""
        is_there = False
        with client.handle:
            while client.handle.take_response(self._type.Response)[1] is not None:
                is_there = True
        return is_there


class Input:
    """Lines of standard input, without waiting."""

    def __init__(self) -> None:
        self._buffer = b""
        self.has_ended = False

    def last_line(self, timeout_s: float) -> bytes | None:
        """The last whole line that has arrived, waiting at most so long; None if there is none."""
        readable, _, _ = select.select([0], [], [], max(0.0, timeout_s))
        if not readable:
            return None
        chunk = os.read(0, 1 << 20)
        self.has_ended = not chunk
        *lines, self._buffer = (self._buffer + chunk).split(b"\n")
        return lines[-1] if lines else None


def serve(questions: Questions, lines: Input) -> None:
    last_s = time.monotonic()
    while not lines.has_ended:
        line = lines.last_line(last_s + PERIOD_S - time.monotonic())
        if line is not None:
            questions.watch(strict_json.unpacked(line))
        elapsed_s = time.monotonic() - last_s
        if elapsed_s < PERIOD_S:
            continue
        last_s += elapsed_s
        for report in questions.round(elapsed_s):
            print(strict_json.packed(report), flush=True)


def main() -> None:
    keep_for_messages()
    dispositions.ignore()  # we end with our input
    try:
        from launcher.ros.discovery.observer import Observer
    except ImportError:
        sys.exit("rclpy cannot be used")
    with Observer(purpose="responsiveness") as observer:
        serve(Questions(observer.node), Input())


if __name__ == "__main__":
    main()
