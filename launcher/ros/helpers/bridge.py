"""A run as a ROS node: `python -m launcher.ros.helpers.bridge SOCKET`, started by `--ros`.

The node `/launcher` publishes /diagnostics once a second and on every change, and offers the
services `~/PROCESS/start`, `stop` and `restart`. It is a client of the run's control socket, and
ends with the run. Other commands read the graph from it (`discovery.graph_socket`).
"""

from __future__ import annotations

import errno
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from std_srvs.srv import Trigger

from launcher.base.model.run_events import Resources
from launcher.control.client import Connection, RefusedError
from launcher.posix.domains import environment_domain
from launcher.posix.socket_directory import ControlError
from launcher.posix.stdio import end_of_input
from launcher.ros.discovery.completeness import has_discovered_all
from launcher.ros.discovery.graph_server import GraphServer
from launcher.ros.discovery.graph_socket import graph_socket_path, query
from launcher.ros.discovery.observer import Observer
from launcher.ros.helpers.diagnostics import Status, all_stale, service_names, statuses

PERIOD_S = 1.0
WATCH_S = 0.25  # period of checks for new and lost participants
STEADY_S = 1.0  # a new participant is still announcing its endpoints
ANSWER_TIMEOUT_S = 3.0  # for the launcher's answer about its processes
SHUTDOWN_S = 3.0  # what takes longer at the end is abandoned
VERBS = ("start", "stop", "restart")
THREADS = 4  # a slow stop of a process occupies one of them
NODE = "launcher"  # of the first bridge of a domain on this machine


def claim_name(domain_id: int, run_socket: Path) -> tuple[str, socket.socket]:
    """`launcher` for the first bridge of a domain on this machine, `launcher_PID` for others.

    PID is that of the run. The first one holds an abstract socket, which the kernel frees however
    the process ends. Keep the socket as long as the node.
    """
    claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        claim.bind(f"\0ros-launcher/domain-{domain_id}/{NODE}".encode())
    except OSError as error:
        if error.errno != errno.EADDRINUSE:
            raise
        return f"{NODE}_{run_socket.name.partition('-')[0]}", claim
    return NODE, claim


class Bridge:
    """The node's publisher and services; `observer` has been entered."""

    def __init__(self, observer: Observer, path: Path) -> None:
        self._observer = observer
        self._path = path
        self._connection = Connection(path)
        self._known: list[Status] = []
        self._is_watched = True  # until the run refuses to list faults
        self._services: dict[str, str] = {}
        self._participants: set[bytes] = set()
        self._changed_s = time.monotonic()
        node = self._node = observer.node
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        one_at_a_time = MutuallyExclusiveCallbackGroup()
        self._verb_group = ReentrantCallbackGroup()
        node.create_timer(PERIOD_S, self.publish, callback_group=one_at_a_time)
        node.create_timer(
            WATCH_S, self._watch_graph, callback_group=MutuallyExclusiveCallbackGroup()
        )
        self._change = node.create_guard_condition(self.publish, callback_group=one_at_a_time)
        # last: its thread calls `answer`
        self._server = GraphServer(graph_socket_path(path), self.answer)

    # processes

    def follow_events(self, on_end: Callable[[], None]) -> None:
        """Publish on every change until the run ends; for a separate thread."""
        try:
            with Connection(self._path) as connection:
                for item in connection.follow("events", history=False):
                    if item.get("event") != Resources.event:
                        self._change.trigger()
        except ControlError:
            pass  # it has ended
        on_end()

    def publish(self) -> None:
        """Ask for the state of the processes and for faults, and publish it."""
        try:
            rows = self._connection.ask("ps", timeout_s=ANSWER_TIMEOUT_S).result["processes"]
            faults = self._faults()
        except ControlError as error:
            self._send(all_stale(self._known, f"the launcher does not answer: {error.message}"))
            self._reconnect()
            return
        self._offer_services(rows)
        run, name = self._connection.hello["run"], self._observer.name
        self._known = statuses(rows, run, name, faults)
        self._send(self._known)

    def _faults(self) -> Sequence[Mapping[str, Any]]:
        """Those of a watched run; ControlError."""
        if not self._is_watched:
            return ()
        try:
            result = self._connection.ask("faults", timeout_s=ANSWER_TIMEOUT_S).result
        except RefusedError:
            self._is_watched = False
            return ()
        return cast("list[Mapping[str, Any]]", result["faults"])

    def _reconnect(self) -> None:
        """Reconnect: a late answer would be taken for that to the next request."""
        self._connection.close()
        try:
            self._connection = Connection(self._path, timeout_s=ANSWER_TIMEOUT_S)
        except ControlError as error:
            self._node.get_logger().warning(error.message, throttle_duration_sec=10.0)

    def publish_end(self) -> None:
        self._server.close()
        self._send(all_stale(self._known, "the run has ended"))
        # messages that were not taken yet would vanish with our shared memory
        self._publisher.wait_for_all_acked(Duration(seconds=SHUTDOWN_S / 3))

    def _send(self, found: list[Status]) -> None:
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.status = [_to_message(one) for one in found]
        self._publisher.publish(message)

    # services

    def _offer_services(self, rows: list[dict[str, Any]]) -> None:
        """Create services for new processes; they keep their names."""
        for process, name in service_names(rows).items():
            if process in self._services:
                continue
            self._services[process] = name
            for verb in VERBS:
                self._node.create_service(
                    Trigger,
                    f"~/{name}/{verb}",
                    self._callback(verb, process),
                    callback_group=self._verb_group,
                )

    def _callback(self, verb: str, process: str) -> Callable[[Any, Any], Any]:
        def answer(request: object, response: Any) -> Any:
            response.success, response.message = self._control(verb, process)
            return response

        return answer

    def _control(self, verb: str, process: str) -> tuple[bool, str]:
        try:
            with Connection(self._path) as connection:
                return True, "\n".join(connection.ask(verb, [process]).text)
        except ControlError as error:
            hint = f" ({error.hint})" if isinstance(error, RefusedError) and error.hint else ""
            return False, f"{error.message}{hint}"

    # the graph

    def _watch_graph(self) -> None:
        self._server.restore()
        self._note_changes()

    def _note_changes(self) -> None:
        participants = self._observer.participants()
        if participants != self._participants:
            self._participants, self._changed_s = participants, time.monotonic()

    def answer(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        """The graph, unless participants are just coming or going."""
        if request != query(self._observer.domain_id, os.environ):
            return {"no": "another domain, or other settings of discovery"}
        self._note_changes()
        if time.monotonic() - self._changed_s < STEADY_S or not has_discovered_all(self._observer):
            return {"no": "the graph is changing"}
        return {"look": self._observer.graph_snapshot().to_document()}


def _to_message(one: Status) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=bytes([one.level]),
        name=one.name,
        message=one.message,
        hardware_id=socket.gethostname(),
        values=[KeyValue(key=key, value=value) for key, value in one.values],
    )


def main(words: list[str]) -> int:
    """Serve until the run ends, or our standard input does."""
    path = Path(words[0])
    over = end_of_input()
    for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(signum, lambda *_: over.set())
    name, claim = claim_name(environment_domain(), path)
    with Observer(name=name) as observer:
        bridge = Bridge(observer, path)
        executor = MultiThreadedExecutor(THREADS, context=observer.context)
        executor.add_node(observer.node)
        for target in (executor.spin, lambda: bridge.follow_events(over.set)):
            threading.Thread(target=target, daemon=True).start()
        over.wait()
        # the executor may be waiting for a slow stop
        threading.Timer(SHUTDOWN_S, os._exit, (0,)).start()
        bridge.publish_end()
        executor.shutdown(SHUTDOWN_S / 3)
    claim.close()
    os._exit(0)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except ControlError as error:
        sys.exit(error.message)
