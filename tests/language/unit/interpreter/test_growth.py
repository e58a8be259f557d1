"""The evaluation of a launch file takes time in proportion to its length."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.event_actions import RegisterEventHandler
from launcher.language.actions.group import GroupAction
from launcher.language.actions.process import OnProcessExit
from launcher.language.actions.timer import TimerAction
from launcher.language.configurations import Configurations
from launcher.language.events.handlers import OnShutdown
from launcher.language.ros.composition import ComposableNode, ComposableNodeContainer
from launcher.language.ros.node import Node
from launcher.language.ros.scope import PushROSNamespace
from launcher.language.substitutions.configuration import LaunchConfiguration
from tests.language.unit.interpreter.interpreting import interpreting

FEW, MANY = 20, 80
TOLERANCE = 1.1


def robot(number: int) -> list[Any]:
    """Arguments, a group with a node and a container with a component, a handler and a timer."""
    name = f"robot_{number}"
    talker = Node(executable="talker", name=LaunchConfiguration(name), remappings=[("a", "b")])
    component = ComposableNode(package="p", plugin="C", name="camera", namespace=name)
    box = ComposableNodeContainer(
        executable="box", name=f"{name}_box", namespace="", composable_node_descriptions=[component]
    )
    return [
        DeclareLaunchArgument(name, default_value=name),
        GroupAction([PushROSNamespace(name), talker, box]),
        RegisterEventHandler(OnProcessExit(target_action=talker, on_exit=[])),
        RegisterEventHandler(OnShutdown(on_shutdown=[])),
        TimerAction(period=1.0, actions=[]),
    ]


def calls(count: int) -> int:
    """How many functions are called in the evaluation of so many robots."""
    found = 0

    def note(frame: object, event: str, argument: object) -> None:
        nonlocal found
        found += event in ("call", "c_call")

    entities = [entity for number in range(count) for entity in robot(number)]
    with interpreting(entities) as interpreter:
        before = sys.getprofile()
        sys.setprofile(note)
        try:
            interpreter.start()
        finally:
            sys.setprofile(before)
    return found


def test_twice_as_many_entities_take_twice_as_many_calls():
    calls(1)  # imports
    assert calls(MANY) / calls(FEW) < MANY / FEW * TOLERANCE


def test_a_scope_copies_no_configurations(monkeypatch: pytest.MonkeyPatch):
    """Groups times launch arguments would be quadratic, in one call each."""
    copies: list[int] = []  # not the copied ones, which a reference would keep
    snapshot = Configurations.snapshot
    monkeypatch.setattr(Configurations, "snapshot", lambda self: copies.append(1) or snapshot(self))
    calls(2)
    assert len(copies) == 2  # for the timers
