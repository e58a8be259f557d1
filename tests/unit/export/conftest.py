from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.export.model import System
from launcher.export.system import system_of
from launcher.hosts.model import Discovery, Host
from launcher.model.spec import ProcessSpec
from launcher.planner import make_plan

HEAD = """
from launch import LaunchDescription
from launch.actions import *
from launch.event_handlers import *
from launch_ros.actions import *
from launch_ros.descriptions import ComposableNode

def node(name, **more):
    return Node(package="group_gp1", executable="robot_1", name=name, **more)

def generate_launch_description():
    return LaunchDescription([{}])
"""


@pytest.fixture
def exported(tmp_path: Path) -> Callable[..., System]:
    """Exports the actions of a launch file `demo.launch.py`."""

    def export(
        actions: str,
        host_of: Callable[[ProcessSpec], Host | None] = lambda spec: None,
        adapt: Callable[[ProcessSpec], ProcessSpec] = lambda spec: spec,
        before: str = "",
        prefix: str = "",
        discovery: Discovery | None = None,
    ) -> System:
        path = tmp_path / "demo.launch.py"
        path.write_text(before + HEAD.replace("{}", actions))
        plan = make_plan(str(path), [])
        assert plan.error is None, plan.error
        return system_of(
            plan,
            host_of=host_of,
            adapt=adapt,
            command="launcher export",
            prefix=prefix,
            discovery=discovery,
        )

    return export
