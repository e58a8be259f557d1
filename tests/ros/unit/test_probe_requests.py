"""What the probe makes of a request before it reaches ROS."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any, cast

import pytest

pytest.importorskip("rclpy")

from nav_msgs.srv import GetPlan
from rclpy.clock import Clock

from launcher.ros.probe.probe_snapshot import ProbeSnapshot
from launcher.ros.probe.protocol import ProbeRequest
from launcher.ros.probe.request_handlers import Handlers
from launcher.ros.probe.subscriptions import Subscriptions
from launcher.ros.service_caller import ServiceCaller
from launcher.ros.snapshot.ros_graph import TopicGraph

PLAN = "nav_msgs/srv/GetPlan"


class Caller:
    """Answers every call, and keeps the requests."""

    def __init__(self) -> None:
        self.requests: list[Any] = []
        self.observer = SimpleNamespace(node=SimpleNamespace(get_clock=Clock))

    def client(self, kind: object, name: str) -> None: ...

    def wait_for(self, client: object, limit_s: float) -> bool:
        return True

    def call(self, kind: object, name: str, request: object, limit_s: float) -> GetPlan.Response:
        self.requests.append(request)
        return GetPlan.Response()


def test_a_time_that_is_now_is_that_of_the_call():
    snapshot = cast("ProbeSnapshot", SimpleNamespace(services={"/plan": (PLAN,)}))
    handlers = Handlers(lambda: snapshot, cast("Subscriptions", None))
    values = {"start": {"header": "auto"}, "goal": {"header": {"stamp": "now"}}}
    words = {"id": 1, "do": "call", "service": "/plan", "values": values}
    caller = Caller()
    handlers.call(cast("ServiceCaller", caller), ProbeRequest(json.dumps(words).encode()))
    (request,) = caller.requests
    assert request.start.header.stamp.sec > 0
    assert request.goal.header.stamp == request.start.header.stamp


def test_services_that_every_node_has_are_left_out():
    services = {
        "/cam/get_parameters": ("rcl_interfaces/srv/GetParameters",),
        "/cam/set_logger_levels": ("rcl_interfaces/srv/SetLoggerLevels",),
        "/cam/keep": ("rcl_interfaces/srv/SetParameters",),
        "/plan": (PLAN,),
    }
    graph = ProbeSnapshot(snapshot=TopicGraph(nodes=("/cam",), endpoints=()), services=services)

    listed = [one["name"] for one in graph.document()["services"]]
    assert listed == ["/cam/set_logger_levels", "/cam/keep", "/plan"]
