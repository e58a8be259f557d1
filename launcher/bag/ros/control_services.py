"""Services of rosbag2's recorder and player, as far as their types are installed.

rosbag2_interfaces is in no package of PyPI; it is built in a workspace, or belongs to an installed
ROS. Its types differ between distributions: an answer has the fields that the installed one has.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from launcher.base.ros_errors import VerbError
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.interfaces import load, load_message

if TYPE_CHECKING:
    from rclpy.node import Node

PACKAGE = "rosbag2_interfaces"
_PERIOD_S = 0.05
_S = 10**9

# Gets the request, and fills in the response.
Handler = Callable[[Any, Any], None]


def are_installed() -> bool:
    return importlib.util.find_spec(PACKAGE) is not None


def message_type(name: str) -> Any:
    """A type of the package; None if it has none of this name."""
    try:
        return with_library(load_message(f"{PACKAGE}/msg/{name}"))
    except VerbError:
        return None


def time_ns(request: Any, name: str) -> int | None:
    """A time of a request; None if it is 0, or not in the installed type."""
    stamp = getattr(request, name, None)
    return (stamp.sec * _S + stamp.nanosec) or None if stamp is not None else None


def answer(response: Any, text: str = "", code: int = 1) -> None:
    """Success without a text; responses of older types have no room for either."""
    if hasattr(response, "return_code"):
        response.return_code = code if text else 0
        response.error_string = text


class ControlServices:
    """Services below the name of a node; call `poll` again and again.

    `handlers` has their names with the names of their types.
    """

    def __init__(self, node: Node, handlers: Mapping[str, tuple[str, Handler]]) -> None:
        self._services: list[tuple[Any, Any, Handler]] = []
        self._next_s = 0.0
        for name, (type_name, handler) in handlers.items():
            try:
                kind = with_library(load(f"{PACKAGE}/srv/{type_name}", "srv", "no such type"))
            except VerbError:  # an older distribution
                continue
            service = node.create_service(kind, f"~/{name}", lambda request, response: response)
            self._services.append((service, kind, handler))

    def poll(self) -> None:
        """Answer what has come, if it is time."""
        now = time.monotonic()
        if now < self._next_s:
            return
        self._next_s = now + _PERIOD_S
        for service, kind, handler in self._services:
            with service.handle:
                request, header = service.handle.service_take_request(kind.Request)
            if header is None:
                continue
            response = kind.Response()
            handler(request, response)
            service.send_response(response, header)
