"""The ROS side of a run, in a process of its own: `python -m launcher.ros.agent`.

It reads requests from standard input and answers on standard output, a JSON object a line, and
ends with its input. It keeps rclpy out of the supervisor, its client.

| request | answer |
|---|---|
| `{"do": "watch", "node": N}` | each time `{"node": N, "transition": T, "start_state": S, ...}` |
| `{"do": "change_state", "id": I, "node": N, ...}` | `{"id": I, "error": null or text}` |
| `{"do": "load", "id": I, "container": C, ...}` | `{"id": I, "full_node_name": F, "error": ...}` |

A request waits for its service as long as it takes, as in ROS 2.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from launcher.ros.lifecycle_client import LifecycleClient, Step

PERIOD_S = 0.1  # of checks for services that requests wait for

Answer = dict[str, Any]


class Agent(Node):  # type: ignore[misc]  # rclpy has no types
    """Sends requests of the launch file to services, and reports transitions."""

    def __init__(self, write: Callable[[Answer], None]) -> None:
        super().__init__(f"_launcher_agent_{os.getpid()}", start_parameter_services=False)
        self._write = write
        self._inbox: deque[Answer] = deque()
        self._waiting: list[tuple[Any, Callable[[], None]]] = []
        self._lifecycle_nodes: dict[str, LifecycleClient] = {}
        self._wake = self.create_guard_condition(self._take_requests)
        self.create_timer(PERIOD_S, self._poll)

    def submit(self, request: Answer) -> None:
        """Queue a request; may be called from another thread."""
        self._inbox.append(request)
        self._wake.trigger()

    def _take_requests(self) -> None:
        while self._inbox:
            request = self._inbox.popleft()
            {"watch": self._watch, "change_state": self._change_state, "load": self._load}[
                request["do"]
            ](request)

    def _watch(self, request: Answer) -> None:
        self._lifecycle_node(request["node"])

    def _change_state(self, request: Answer) -> None:
        number, label = request["transition_id"], request["transition"]
        self._lifecycle_node(request["node"]).request(
            number, label, lambda error: self._write({"id": request["id"], "error": error})
        )

    def _lifecycle_node(self, name: str) -> LifecycleClient:
        if name not in self._lifecycle_nodes:

            def report(step: Step, label: str) -> None:
                start, goal = step
                states = {"start_state": start, "goal_state": goal}
                self._write({"node": name, "transition": label, **states})

            self._lifecycle_nodes[name] = LifecycleClient(self, name, report)
        return self._lifecycle_nodes[name]

    def _load(self, request: Answer) -> None:
        try:
            from composition_interfaces.srv import LoadNode
        except ImportError:
            self._write({"id": request["id"], "error": "composition_interfaces is not installed"})
            return
        client = self.create_client(LoadNode, f"{request['container']}/_container/load_node")
        message = LoadNode.Request(
            package_name=request["package"],
            plugin_name=request["plugin"],
            node_name=request["name"] or "",
            node_namespace=request["namespace"] or "",
            remap_rules=[f"{source}:={target}" for source, target in request["remappings"]],
            parameters=_parameters(request["parameters"]),
            extra_arguments=_parameters(request["extra_arguments"]),
        )

        def answer(response: LoadNode.Response) -> Answer:
            return {
                "full_node_name": response.full_node_name,
                "unique_id": response.unique_id,
                "error": None if response.success else response.error_message,
            }

        self._call(client, message, request["id"], answer)

    def _call(
        self, client: Any, message: Any, request_id: int, answer: Callable[[Any], Answer]
    ) -> None:
        def send() -> None:
            future = client.call_async(message)
            future.add_done_callback(
                lambda done: self._write({"id": request_id, **answer(done.result())})
            )

        self._waiting.append((client, send))
        self._send_ready()

    def _poll(self) -> None:
        self._send_ready()
        for node in self._lifecycle_nodes.values():
            node.poll()

    def _send_ready(self) -> None:
        ready = [pair for pair in self._waiting if pair[0].service_is_ready()]
        self._waiting = [pair for pair in self._waiting if pair not in ready]
        for _, send in ready:
            send()


def _parameters(pairs: list[tuple[str, Any]]) -> list[Any]:
    return [Parameter(name, value=value).to_parameter_msg() for name, value in pairs]


def _write_line(answer: Answer) -> None:
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()


def _read_requests(agent: Agent) -> None:
    for line in sys.stdin:
        agent.submit(json.loads(line))
    rclpy.try_shutdown()


def main() -> None:
    # we end with our input; signals that stop a run are for its other processes
    for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(signum, signal.SIG_IGN)
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    agent = Agent(_write_line)
    threading.Thread(target=_read_requests, args=(agent,), daemon=True).start()
    try:
        rclpy.spin(agent)
    except ExternalShutdownException:
        pass  # the input has ended
    finally:
        agent.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
