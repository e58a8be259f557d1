"""The message about a run that starts nothing, and the runs that must not give it."""

from __future__ import annotations

import signal
from typing import Any

import pytest

from launcher.base.model import events as model
from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.configuration import SetLaunchConfiguration
from launcher.language.actions.event_actions import (
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launcher.language.actions.group import GroupAction
from launcher.language.actions.process import ExecuteProcess, OnProcessExit
from launcher.language.actions.timer import TimerAction
from launcher.language.conditions import IfCondition, LaunchConfigurationEquals, UnlessCondition
from launcher.language.events.handlers import OnShutdown
from launcher.language.ros.composition import ComposableNode, LoadComposableNodes
from launcher.language.substitutions.configuration import LaunchConfiguration
from tests.language.unit.interpreter.interpreting import interpreting, notices, started

pytestmark = pytest.mark.filterwarnings("ignore:LaunchConfigurationEquals is deprecated")


def process(**options: Any) -> ExecuteProcess:
    return ExecuteProcess(cmd=["program"], **options)


def start(*entities: Any) -> list[model.Effect]:
    with interpreting(entities) as interpreter:
        return interpreter.start()


def if_(name: str) -> IfCondition:
    return IfCondition(LaunchConfiguration(name))


def test_the_false_condition_is_named_with_its_action_place_and_value():
    effects = start(DeclareLaunchArgument("x", default_value="false"), process(condition=if_("x")))

    (notice,) = notices(effects)

    assert notice.startswith(
        "no process was started, since this condition is false: "
        "IfCondition(LaunchConfig('x')) of ExecuteProcess at test_empty_run.py:"
    )
    assert notice.endswith(" (x is 'false')")


def test_the_message_is_a_warning_only_if_a_condition_was_false():
    levels = [
        [effect.level for effect in effects if isinstance(effect, model.LogMessage)]
        for effects in (start(), start(process(condition=IfCondition("false"))))
    ]

    assert levels == [["INFO"], ["WARNING"]]


def test_the_value_is_that_at_the_time_of_the_condition():
    inside = [SetLaunchConfiguration("x", "1"), process(condition=UnlessCondition("true"))]
    equals = process(condition=LaunchConfigurationEquals("x", "2"))

    (notice,) = notices(start(GroupAction([*inside, equals])))

    assert "these conditions are false: UnlessCondition('true') of ExecuteProcess" in notice
    assert notice.endswith(" (x is '1')")


def test_many_conditions_are_shortened_and_equal_ones_named_once():
    twice = [process(condition=IfCondition("0")) for _ in range(2)]
    others = [
        GroupAction([process()], condition=LaunchConfigurationEquals(f"x{n}", "1"))
        for n in range(8)
    ]

    (notice,) = notices(start(*twice, *others))

    assert notice.count("IfCondition('0') of ExecuteProcess") == 1
    assert "LaunchConfigurationEquals('x3', '1') of GroupAction" in notice
    assert "(x3 is not set)" in notice
    assert notice.endswith("; and 4 more")


def test_conditions_of_actions_that_start_nothing_are_not_named():
    skipped = LogInfo(msg="x", condition=IfCondition("0"))

    assert notices(start(skipped)) == ["no process was started"]


def test_a_file_with_messages_only_started_nothing_either():
    assert notices(start(LogInfo(msg="hi"))) == ["no process was started"]


def test_a_process_behind_a_timer_counts_when_it_is_due():
    with interpreting([TimerAction(period=1.0, actions=[process()])]) as interpreter:
        (timer,) = interpreter.start()
        assert isinstance(timer, model.CallLater)

        effects = interpreter.handle(model.TimerFired(timer_id=timer.timer_id))

        assert [len(started(effects)), notices(effects)] == [1, []]
        exited = model.ProcessExited(
            process_id=started(effects)[0].process_id, pid=1, returncode=0, will_restart=False
        )
        assert notices(interpreter.handle(exited)) == []


def test_a_timer_that_starts_nothing_is_waited_for():
    skipped = process(condition=IfCondition("0"))
    with interpreting([TimerAction(period=1.0, actions=[skipped])]) as interpreter:
        (timer,) = interpreter.start()
        assert isinstance(timer, model.CallLater)

        (notice,) = notices(interpreter.handle(model.TimerFired(timer_id=timer.timer_id)))

    assert "IfCondition('0') of ExecuteProcess" in notice


def test_a_process_that_a_handler_starts_counts():
    handler = RegisterEventHandler(OnProcessExit(on_exit=[LogInfo(msg="x")]))
    made = OpaqueFunction(function=lambda context: [process()])

    assert notices(start(handler, process(condition=IfCondition("0")), made)) == []


def test_a_component_that_is_loaded_counts():
    node = ComposableNode(package="p", plugin="p::Q", name="q")

    with interpreting(
        [LoadComposableNodes(composable_node_descriptions=[node], target_container="/c")]
    ) as interpreter:
        (load,) = interpreter.start()
        assert isinstance(load, model.LoadComponent)
        answer = model.ComponentLoaded(request_id=load.request_id, full_node_name="/q", unique_id=1)
        assert "no process was started" not in notices(interpreter.handle(answer))


def test_a_user_who_stops_the_run_before_a_timer_is_told_nothing():
    with interpreting([TimerAction(period=9.0, actions=[process()])]) as interpreter:
        interpreter.start()

        effects = interpreter.handle(model.SignalReceived(signum=signal.SIGINT))

    assert [one for one in notices(effects) if "no process" in one] == []


def test_a_shutdown_of_the_launch_file_is_named():
    assert notices(start(process(), Shutdown(reason="enough"))) == [
        "no process was started, since the launch file requests a shutdown: enough"
    ]


def test_the_message_comes_once():
    again = RegisterEventHandler(OnShutdown(on_shutdown=[LogInfo(msg="end")]))

    assert notices(start(again)) == ["no process was started"]
