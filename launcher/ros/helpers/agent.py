"""The ROS side of a run, in a separate process: `python -m launcher.ros.helpers.agent`.

It reads requests from standard input and answers on standard output, a JSON object a line, and
ends with its input. It keeps rclpy out of the supervisor, its client.

| request | answer |
|---|---|
| `{"do": "watch", "node": N}` | each time `{"node": N, "transition": T, "stamp_ns": ..., ...}` |
| `{"do": "change_state", "id": I, "node": N, ...}` | `{"id": I, "error": null or text}` |
| `{"do": "load", "id": I, "container": C, ...}` | `{"id": I, "full_node_name": F, "error": ...}` |
| `{"do": "drop", "id": I}` | none, and none to request I any more |
| `{"do": "timer", "id": I, "delay_s": S}` | `{"timer": I}` after this time on the ROS clock |
| `{"do": "cancel_timer", "id": I}` | |
| `{"do": "use_sim_time", "value": bool}` | |

A value of the type bytes is `{"bytes": [97, 98]}`.

A request waits for its service as long as it takes, as in ROS 2; after a while there is a
`{"warning": text}`.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from rclpy.signals import SignalHandlerOptions

from launcher.base import strict_json
from launcher.base.ros_errors import did_you_mean
from launcher.base.text import error_text
from launcher.packages.package_origins import INSTRUCTIONS, build_command
from launcher.posix import dispositions
from launcher.posix.stdio import keep_for_messages
from launcher.ros.helpers.clean_up import limited_clean_up
from launcher.ros.helpers.lifecycle_client import LifecycleClient, StateChange

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.ros.helpers.component_client import ContainerClient, Loaded

PERIOD_S = 0.1  # of checks for services that requests wait for
WARN_AFTER_S = 10.0  # that a node is not there which requests wait for

Answer = dict[str, Any]


class AgentNode(Node):  # type: ignore[misc]  # rclpy has no types
    """Sends requests of the launch file to services, and reports transitions."""

    def __init__(self, write: Callable[[Answer], None]) -> None:
        super().__init__(f"_launcher_agent_{os.getpid()}", start_parameter_services=False)
        self._write = write
        self._inbox: deque[Answer] = deque()
        self._lifecycle_nodes: dict[str, LifecycleClient] = {}
        self._containers: dict[str, ContainerClient] = {}
        self._timers_by_id: dict[int, Any] = {}
        self._missing = MissingNodes()
        self._explained = False
        self._wake = self.create_guard_condition(self._take_requests)
        # Not on the ROS clock, which stands still while a simulation does.
        self.create_timer(PERIOD_S, self._poll, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def submit(self, request: Answer) -> None:
        """Queue a request; may be called from another thread."""
        self._inbox.append(request)
        self._wake.trigger()

    def _take_requests(self) -> None:
        while self._inbox:
            request = self._inbox.popleft()
            try:
                getattr(self, f"_do_{request['do']}")(request)
            except Exception as error:  # an invalid name; other requests are carried out
                self._refuse(request, reason(error))

    def _refuse(self, request: Answer, error: str) -> None:
        if request["do"] in ("load", "change_state"):
            self._write({"id": request["id"], "error": error})
        else:
            self._write({"warning": f"cannot {request['do']} {request.get('node', '')}: {error}"})

    def _do_watch(self, request: Answer) -> None:
        self._lifecycle_node(request["node"])

    def _do_change_state(self, request: Answer) -> None:
        number, label = request["transition_id"], request["transition"]
        self._lifecycle_node(request["node"]).request(
            number, label, lambda error: self._write({"id": request["id"], "error": error})
        )

    def _do_drop(self, request: Answer) -> None:
        for container in self._containers.values():
            container.drop(request["id"])

    def _lifecycle_node(self, name: str) -> LifecycleClient:
        if name not in self._lifecycle_nodes:

            def report(step: StateChange, label: str, stamp_ns: int) -> None:
                start, goal = step
                states = {"start_state": start, "goal_state": goal}
                self._write({"node": name, "transition": label, **states, "stamp_ns": stamp_ns})

            self._lifecycle_nodes[name] = LifecycleClient(self, name, report)
        return self._lifecycle_nodes[name]

    def _do_load(self, request: Answer) -> None:
        try:
            from composition_interfaces.srv import LoadNode
        except ImportError:
            self._explain_missing_interfaces()  # before the answer, which may end the run
            self._refuse(request, "composition_interfaces is not installed")
            return
        message = LoadNode.Request(
            package_name=request["package"],
            plugin_name=request["plugin"],
            node_name=request["name"] or "",
            node_namespace=request["namespace"] or "",
            remap_rules=[f"{source}:={target}" for source, target in request["remappings"]],
            parameters=parameter_messages(request["parameters"]),
            extra_arguments=parameter_messages(request["extra_arguments"]),
        )
        _check_sendable(message, "the request")

        def done(loaded: Loaded | None, error: str | None) -> None:
            answer: Answer = {"id": request["id"], "error": error}
            if loaded is not None:
                answer.update(full_node_name=loaded.full_name, unique_id=loaded.unique_id)
            self._write(answer)

        self._container(request["container"]).load(request["id"], message, done)

    def _explain_missing_interfaces(self) -> None:
        if self._explained:
            return
        self._explained = True
        commands = build_command("composition_interfaces")
        what = "composition_interfaces, the services of containers, has no wheel"
        self._write({"warning": f"{what}; build it in a workspace: {commands}; {INSTRUCTIONS}"})

    def _container(self, name: str) -> ContainerClient:
        if name not in self._containers:
            from launcher.ros.helpers.component_client import ContainerClient

            self._containers[name] = ContainerClient(self, name)
        return self._containers[name]

    # ---- the ROS clock

    def _do_use_sim_time(self, request: Answer) -> None:
        self.set_parameters([Parameter("use_sim_time", value=request["value"])])

    def _do_timer(self, request: Answer) -> None:
        number = request["id"]

        def fire() -> None:
            self._do_cancel_timer(request)
            self._write({"timer": number})

        self._timers_by_id[number] = self.create_timer(request["delay_s"], fire)

    def _do_cancel_timer(self, request: Answer) -> None:
        timer = self._timers_by_id.pop(request["id"], None)
        if timer is not None:
            self.destroy_timer(timer)

    # ---- regularly

    def _poll(self) -> None:
        for container in self._containers.values():
            container.poll()
        for node in self._lifecycle_nodes.values():
            node.poll()
        waited_for = [n for n, one in self._lifecycle_nodes.items() if one.waits_for_node]
        waited_for += [n for n, c in self._containers.items() if c.request_ids and not c.is_there]
        for name in self._missing.overdue(waited_for, time.monotonic()):
            found = (f"{ns.rstrip('/')}/{n}" for n, ns in self.get_node_names_and_namespaces())
            hint = did_you_mean(name, [n for n in found if "/_" not in n])
            what = f"requests wait for node {name}, which is not there after {WARN_AFTER_S:.0f} s"
            self._write({"warning": f"{what}; {hint}" if hint else what})


class MissingNodes:
    """Which nodes have been waited for too long; each is reported once."""

    def __init__(self) -> None:
        self._since_s: dict[str, float] = {}
        self._reported: set[str] = set()

    def overdue(self, names: list[str], now_s: float) -> list[str]:
        """Those of the names that are to be reported now; call it regularly."""
        self._since_s = {name: self._since_s.get(name, now_s) for name in names}
        due = [name for name, since_s in self._since_s.items() if now_s - since_s >= WARN_AFTER_S]
        new = [name for name in due if name not in self._reported]
        self._reported.update(new)
        return new


def parameter_messages(pairs: list[tuple[str, Any]]) -> list[Any]:
    messages = []
    for name, value in pairs:
        messages.append(Parameter(name, value=value).to_parameter_msg())
        _check_sendable(messages[-1], f"parameter {name!r}")
    return messages


def _check_sendable(message: Any, what: str) -> None:
    """Raise ValueError for a value that does not fit into its field."""
    try:
        serialize_message(message)
    except Exception as error:  # of any type, by the field
        raise ValueError(f"{what} cannot be sent: {error.__cause__ or error}") from None


def reason(error: BaseException) -> str:
    """In one line, with the error that caused it, such as a library that is not found."""
    cause = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    text = " ".join(error_text(error).split())
    return text if cause is None else f"{text}: {reason(cause)}"


def _decoded(value: dict[str, Any]) -> Any:
    # As the message has it: a list of single bytes.
    return [bytes([one]) for one in value["bytes"]] if value.keys() == {"bytes"} else value


def _read_requests(agent: AgentNode) -> None:
    for line in sys.stdin:
        agent.submit(strict_json.unpacked(line, object_hook=_decoded))
    rclpy.try_shutdown()


def main() -> None:
    keep_for_messages()
    dispositions.ignore()  # we end with our input
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    agent = AgentNode(lambda answer: print(strict_json.packed(answer), flush=True))
    executor = SingleThreadedExecutor()  # made before the input, which may have ended already
    executor.add_node(agent)
    threading.Thread(target=_read_requests, args=(agent,), daemon=True).start()
    try:
        executor.spin()
    except ExternalShutdownException:
        pass  # the input has ended
    finally:
        with limited_clean_up():
            agent.destroy_node()
            rclpy.try_shutdown()


if __name__ == "__main__":
    main()
