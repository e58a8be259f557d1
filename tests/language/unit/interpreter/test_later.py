"""What a run may start after its first moment, before anything has happened."""

from __future__ import annotations

from typing import Any

import pytest

from launcher.base.model.events import TimerFired
from launcher.base.model.ros_arguments import full_node_name
from launcher.base.model.spec import Scope
from launcher.language.actions.configuration import SetLaunchConfiguration
from launcher.language.actions.event_actions import (
    EmitEvent,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
)
from launcher.language.actions.group import GroupAction
from launcher.language.actions.process import ExecuteProcess, OnProcessExit, OnProcessStart
from launcher.language.actions.timer import RosTimer, TimerAction
from launcher.language.conditions import IfCondition
from launcher.language.events.base import Event, EventHandler
from launcher.language.events.handlers import OnShutdown
from launcher.language.interpreter.later import later
from launcher.language.interpreter.unvisited import EventTime
from launcher.language.ros.composition import (
    ComposableNode,
    ComposableNodeContainer,
    LoadComposableNodes,
)
from launcher.language.ros.node import Node
from launcher.language.ros.scope import PushROSNamespace
from launcher.language.substitutions.command import Command
from launcher.language.substitutions.configuration import LaunchConfiguration
from tests.language.unit.interpreter.interpreting import interpreting, started


def process(name: str = "late", **options: Any) -> ExecuteProcess:
    return ExecuteProcess(cmd=["program"], name=name, **options)


def after(period_s: float, *actions: Any, **options: Any) -> TimerAction:
    return TimerAction(period=period_s, actions=list(actions), **options)


NOW = process("now")
FOUND = {
    "a timer": ([after(5.0, process())], [("late", EventTime(time_s=5.0), True)]),
    "a timer in a timer": (
        [after(5.0, after(2.0, process()))],
        [("late", EventTime(time_s=7.0), True)],
    ),
    "a timer on the ROS clock": (
        [RosTimer(period=5.0, actions=[process()])],
        [("late", EventTime(), True)],
    ),
    "a timer whose period is not known": (
        [after(5.0, TimerAction(period=Command("echo 1"), actions=[process()]))],
        [("late", EventTime(), True)],
    ),
    "a condition that is false now": (
        [after(5.0, process(condition=IfCondition("0")), process("b"))],
        [("late", EventTime(time_s=5.0), False), ("b", EventTime(time_s=5.0), True)],
    ),
    "a condition around it": (
        [after(5.0, GroupAction([process()], condition=IfCondition("0")))],
        [("late", EventTime(time_s=5.0), False)],
    ),
    "a configuration of then": (
        [
            after(
                5.0,
                SetLaunchConfiguration("go", "0"),
                process(condition=IfCondition(LaunchConfiguration("go"))),
            )
        ],
        [("late", EventTime(time_s=5.0), False)],
    ),
    "an exit": (
        [NOW, RegisterEventHandler(OnProcessExit(target_action=NOW, on_exit=[process()]))],
        [("late", EventTime(cause="now"), True)],
    ),
    "an exit, and some time": (
        [RegisterEventHandler(OnProcessExit(target_action=NOW, on_exit=[after(1.0, process())]))],
        [("late", EventTime(), True)],
    ),
    "any exit": (
        [RegisterEventHandler(OnProcessExit(on_exit=[process()]))],
        [("late", EventTime(), True)],
    ),
    "a start": (
        [RegisterEventHandler(OnProcessStart(target_action=NOW, on_start=process()))],
        [("late", EventTime(), True)],
    ),
    "the exit of what comes later": (
        [after(5.0, process("a", on_exit=[process("b")]))],
        [("a", EventTime(time_s=5.0), True), ("b", EventTime(cause="a"), True)],
    ),
    "an event of its own": (
        [
            after(5.0, EmitEvent(event=Event())),
            RegisterEventHandler(EventHandler(matcher=lambda e: False, entities=process())),
        ],
        [("late", EventTime(), True)],
    ),
    "the shutdown": (
        [process("now"), RegisterEventHandler(OnShutdown(on_shutdown=[process()]))],
        [("late", EventTime(), True)],
    ),
    "what a function has returned": (
        [OpaqueFunction(function=lambda context: [after(5.0, process())])],
        [("late", EventTime(time_s=5.0), True)],
    ),
    "nothing": ([process("now", cached_output=True), LogInfo(msg="")], []),
}


@pytest.mark.parametrize("name", FOUND)
def test_what_comes_later_is_found_with_its_time(name: str):
    entities, expected = FOUND[name]
    with interpreting([process("first"), *entities]) as interpreter:
        interpreter.start()
        found = later(interpreter)
        assert [(one.spec.label, one.moment, one.is_likely) for one in found.processes] == expected
        assert found.is_complete
        assert "go" not in interpreter.context.launch_configurations


def test_the_scopes_of_what_comes_later_are_those_around_its_timer():
    actions = [PushROSNamespace("ns"), after(5.0, Node(executable="x", name="n"))]
    with interpreting([GroupAction(actions), process()]) as interpreter:
        interpreter.note_scopes()
        interpreter.start()
        (found,) = later(interpreter).processes
    ((line, namespace),) = [(one.line > 0, one.namespace) for one in found.spec.scopes if one.line]
    assert (line, namespace) == (True, "/ns")
    assert found.spec.ros is not None and found.spec.ros.namespace == "/ns"
    assert all(isinstance(one, Scope) for one in found.spec.scopes)
    assert found.spec.ros.node_name == "n"
    assert full_node_name(found.spec.argv) is None  # it has no command line


def test_a_namespace_that_a_timer_pushes_is_not_that_of_its_group():
    late = after(5.0, PushROSNamespace("late"), Node(executable="x", name="n"))
    with interpreting([GroupAction([PushROSNamespace("ns"), late]), process()]) as interpreter:
        interpreter.note_scopes()
        interpreter.start()
        effects = interpreter.handle(TimerFired(timer_id=next(iter(interpreter.host.timers))))
        (found,) = started(effects)
    assert found.spec.ros is not None and found.spec.ros.namespace == "/ns/late"
    assert [one.namespace for one in found.spec.scopes if one.line] == ["/ns"]


def test_components_are_found_with_their_containers():
    node = ComposableNode(package="p", plugin="P", name="part", namespace="/a")
    box = ComposableNodeContainer(
        executable="/bin/cat", name="box", namespace="/b", composable_node_descriptions=[node]
    )
    load = LoadComposableNodes(target_container="/b/other", composable_node_descriptions=[node])
    with interpreting([after(5.0, box), after(6.0, load), process()]) as interpreter:
        interpreter.start()
        found = later(interpreter)
    names = [(one.container, one.namespace, one.name, one.package) for one in found.loads]
    assert names == [("/b/box", "/a", "part", "p"), ("/b/other", "/a", "part", "p")]
    assert found.is_complete


def test_configurations_that_a_launch_file_keeps_stay_as_they_are():
    kept: list[Any] = []
    keep = OpaqueFunction(function=lambda context: kept.append(context.launch_configurations))
    handler = OnProcessExit(target_action=NOW, on_exit=[SetLaunchConfiguration("a", "later")])
    with interpreting(
        [SetLaunchConfiguration("a", "1"), keep, RegisterEventHandler(handler)]
    ) as run:
        run.start()
        later(run)
        (now,) = kept
        assert now is run.context.launch_configurations
        assert dict(now) == {"a": "1"}
