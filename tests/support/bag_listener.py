"""Subscribes to topics before they exist, and serves `/bag/switch`, for tests of bags.

Arguments are topics, `NAME=TYPE`; with `--latched` before them, as TRANSIENT_LOCAL. Without
arguments there is only the service, which publishes its events. Prints `ready`, then one line of
JSON per message, `[topic, hex, source_ns]`, and per request, `["/bag/switch", true]`.
"""

from __future__ import annotations

import contextlib
import json
import sys
import threading

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile, qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState
from std_srvs.srv import SetBool

from launcher.ros.messages.interfaces import load_message


def say(*values: object) -> None:
    print(json.dumps(values), flush=True)


def main() -> None:
    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    node = rclpy.create_node("bag_listener")
    words = sys.argv[1:]
    latched = words[:1] == ["--latched"]
    profile = QoSProfile(depth=5000, durability=1 if latched else 2)
    for word in words[latched:]:
        topic, _, kind = word.partition("=")

        def heard(data: bytes, info: dict[str, int], topic: str = topic) -> None:
            say(topic, data.hex(), info["source_timestamp"])

        node.create_subscription(load_message(kind), topic, heard, profile, raw=True)

    def switch(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        say("/bag/switch", request.data)
        response.success = True
        return response

    if not words:
        service = node.create_service(SetBool, "/bag/switch", switch)
        service.configure_introspection(
            node.get_clock(), qos_profile_system_default, ServiceIntrospectionState.CONTENTS
        )

    def end_with_stdin() -> None:
        sys.stdin.read()
        rclpy.shutdown()

    threading.Thread(target=end_with_stdin, daemon=True).start()
    print("ready", flush=True)
    with contextlib.suppress(ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
