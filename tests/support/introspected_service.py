"""A service and a client that publish their calls, and call ten times a second.

`python -m tests.support.introspected_service` prints `ready` and runs until its stdin is closed.
"""

from __future__ import annotations

import contextlib
import sys
import threading

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState
from std_srvs.srv import SetBool

PERIOD_S = 0.1


class Introspected(Node):
    """Offers and calls `told`; offers `untold` without introspection."""

    def __init__(self) -> None:
        super().__init__("introspected")
        service = self.create_service(SetBool, "told", self._answer)
        self.create_service(SetBool, "untold", self._answer)
        self._client = self.create_client(SetBool, "told")
        for one in (service, self._client):
            one.configure_introspection(
                self.get_clock(), qos_profile_system_default, ServiceIntrospectionState.CONTENTS
            )
        self.create_timer(PERIOD_S, self._call)

    def _answer(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.message = "answered"
        response.success = request.data
        return response

    def _call(self) -> None:
        self._client.call_async(SetBool.Request(data=True))


def main() -> None:
    """Spin until stdin ends."""
    rclpy.init()
    node = Introspected()
    threading.Thread(target=lambda: (sys.stdin.read(), rclpy.try_shutdown()), daemon=True).start()
    print("ready", flush=True)
    with contextlib.suppress(ExternalShutdownException):  # stdin has ended
        rclpy.spin(node)
    node.destroy_node()


if __name__ == "__main__":
    main()
