"""Nodes, components and lifecycle nodes in a run: command lines, requests and their answers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from launcher.base.model import events as model
from launcher.language.actions.configuration import SetLaunchConfiguration
from launcher.language.actions.event_actions import EmitEvent, LogInfo, RegisterEventHandler
from launcher.language.actions.group import GroupAction
from launcher.language.actions.process import ExecuteProcess
from launcher.language.events.launch import matches_action
from launcher.language.ros.composition import (
    ComposableNode,
    ComposableNodeContainer,
    LoadComposableNodes,
)
from launcher.language.ros.lifecycle import (
    ChangeState,
    LifecycleNode,
    LifecycleTransition,
    OnStateTransition,
)
from launcher.language.ros.node import Node
from launcher.language.ros.scope import PushROSNamespace, SetParameter, SetRemap, SetROSLogDir
from launcher.language.substitutions.configuration import LaunchConfiguration
from tests.language.unit.interpreter.interpreting import interpreting, started, texts


def command_line(*entities: Any) -> str:
    with interpreting(entities) as interpreter:
        (start,) = started(interpreter.start())
        return start.spec.command_line


def test_the_words_of_a_node_come_in_ros_2s_order(tmp_path: Path):
    file = tmp_path / "params.yaml"
    file.write_text("/**: {ros__parameters: {a: 1}}")
    node = Node(
        executable="exe",
        name="n",
        namespace="sub",
        arguments=["word"],
        ros_arguments=["--log-level", "debug"],
        parameters=[str(file)],
        remappings=[("own", "x")],
    )
    group = GroupAction([PushROSNamespace("g"), SetParameter("p", 3), SetRemap("in", "out"), node])

    assert command_line(group) == (
        "exe word --ros-args --log-level debug --ros-args -r __node:=n -r __ns:=/g/sub "
        f"-p p:=3 --params-file {file} -r in:=out -r own:=x"
    )


def test_a_node_without_anything_still_gets_the_flag():
    assert command_line(Node(executable="exe")) == "exe --ros-args"


@pytest.mark.parametrize(
    ("environment", "root"),
    [
        ({"ROS_LOG_DIR": "/logs"}, "/logs"),
        ({"ROS_LOG_DIR": "", "ROS_HOME": "/ros"}, "/ros/log"),
        ({"HOME": "/home/u"}, "/home/u/.ros/log"),
        ({"ROS_LOG_DIR": "~/logs", "HOME": "/home/u"}, "/home/u/logs"),
        ({"ROS_LOG_DIR": "logs"}, f"{Path.cwd()}/logs"),
    ],
)
def test_a_relative_log_folder_is_below_the_current_one(environment: dict[str, str], root: str):
    def node(name: str) -> Node:
        return Node(executable="exe", exec_name=name)

    nested = GroupAction([SetROSLogDir("arm"), node("nested")])
    group = GroupAction([SetROSLogDir("robot_1"), node("relative"), nested])
    entities = [group, SetROSLogDir("/elsewhere"), node("absolute")]
    with interpreting(entities, environment=environment) as interpreter:
        starts = started(interpreter.start())

    folders = {start.spec.label: start.spec.env["ROS_LOG_DIR"] for start in starts}
    assert folders == {
        "relative": f"{root}/robot_1",
        "nested": f"{root}/robot_1/arm",
        "absolute": "/elsewhere",
    }


@pytest.mark.parametrize("name", ["", "bad name", "1st", "a-b"])
def test_an_invalid_node_name_is_refused(name: str):
    with interpreting([Node(executable="exe", name=name)]) as interpreter:
        interpreter.begin()

        assert interpreter.failure is not None
        assert "node name must not" in interpreter.failure.message


def container() -> ComposableNodeContainer:
    nodes = [ComposableNode(package="p", plugin=f"P{i}", name=f"n{i}") for i in (1, 2)]
    return ComposableNodeContainer(
        name="box", namespace="ns", executable="exe", composable_node_descriptions=nodes
    )


def loads(effects: list[model.Effect]) -> list[model.LoadComponent]:
    return [effect for effect in effects if isinstance(effect, model.LoadComponent)]


def test_a_container_is_asked_for_one_node_after_the_other():
    with interpreting([container()]) as interpreter:
        (first,) = loads(interpreter.start())
        done = model.ComponentLoaded(request_id=first.request_id, full_node_name="/n1")
        effects = interpreter.handle(done)
        (second,) = loads(effects)

    assert (first.request.container, first.request.name) == ("/ns/box", "n1")
    assert second.request.name == "n2"
    assert "Loaded node '/n1' in container '/ns/box'" in [
        effect.text for effect in effects if isinstance(effect, model.LogMessage)
    ]


def test_a_node_that_cannot_be_loaded_is_an_error_and_the_next_one_follows():
    with interpreting([container()]) as interpreter:
        (first,) = loads(interpreter.start())
        failed = model.ComponentLoaded(request_id=first.request_id, error="no such plug-in")
        effects = interpreter.handle(failed)

    errors = [e.text for e in effects if isinstance(e, model.LogMessage) and e.level == "ERROR"]
    assert errors == [
        "Failed to load node 'n1' of type 'P1' in container '/ns/box': no such plug-in"
    ]
    assert len(loads(effects)) == 1


def test_a_load_request_carries_what_its_scope_sets():
    load = LoadComposableNodes(
        target_container="box",
        composable_node_descriptions=[
            ComposableNode(package="p", plugin="P", name="n", parameters=[{"own": [1, 2]}])
        ],
    )
    settings = [PushROSNamespace("g"), SetParameter("p", True), SetRemap("a", "b")]
    with interpreting([GroupAction([*settings, load])]) as interpreter:
        (effect,) = loads(interpreter.start())

    assert effect.request.namespace == "/g"
    assert effect.request.remappings == (("a", "b"),)
    assert effect.request.parameters == (("p", True), ("own", (1, 2)))


def lifecycle_node() -> LifecycleNode:
    return LifecycleNode(name="n", namespace="", executable="exe")


def seen(start: str, goal: str, transition: str = "t") -> model.TransitionSeen:
    return model.TransitionSeen(
        node="/n", transition=transition, start_state=start, goal_state=goal
    )


@pytest.mark.parametrize("empty", ["", [LaunchConfiguration("empty")]])
def test_an_empty_namespace_is_none_also_of_a_component_without_a_name(empty, tmp_path: Path):
    file = tmp_path / "some.yaml"
    file.write_text(
        "/**: {ros__parameters: {for_all: 1}}\nother: {ros__parameters: {not_mine: 1}}\n"
    )
    node = ComposableNode(
        package="p", plugin="P", namespace=empty, parameters=[{"own": 1}, str(file)]
    )
    load = LoadComposableNodes(target_container="c", composable_node_descriptions=[node])

    with interpreting([SetLaunchConfiguration("empty", ""), load]) as interpreter:
        effects = interpreter.start()

    (request,) = [e.request for e in effects if isinstance(e, model.LoadComponent)]
    assert (request.name, request.namespace.strip("/")) == ("", "")
    assert request.parameters == (("own", 1), ("for_all", 1))


def test_a_parameter_file_of_a_component_has_the_types_that_rcl_reads(tmp_path: Path):
    file = tmp_path / "some.yaml"
    file.write_text("/**: {ros__parameters: {a: 1e-9, b: [1e-9, 0.0], c: '1e-9', d: 0x10, e: y}}\n")
    node = ComposableNode(package="p", plugin="P", parameters=[str(file)])
    load = LoadComposableNodes(target_container="c", composable_node_descriptions=[node])
    with interpreting([load]) as interpreter:
        (effect,) = loads(interpreter.start())
    values = dict(effect.request.parameters)
    assert values == {"a": 1e-9, "b": (1e-9, 0.0), "c": "1e-9", "d": 16, "e": True}


def test_a_lifecycle_node_is_watched_and_asked_for_its_transition():
    node = lifecycle_node()
    change = ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=1)
    with interpreting([node, EmitEvent(event=change)]) as interpreter:
        effects = interpreter.start()

    assert model.WatchLifecycle(node="/n") in effects
    (request,) = [e for e in effects if isinstance(e, model.ChangeState)]
    assert request.request == model.StateRequest(node="/n", transition_id=1, transition="configure")


def test_a_refused_transition_is_an_error_of_the_launcher():
    node = lifecycle_node()
    change = ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=3)
    with interpreting([node, EmitEvent(event=change)]) as interpreter:
        (request,) = [e for e in interpreter.start() if isinstance(e, model.ChangeState)]
        effects = interpreter.handle(
            model.StateChanged(request_id=request.request_id, error="not inactive")
        )

    (error,) = [effect for effect in effects if isinstance(effect, model.LogMessage)]
    assert error.text == ("Failed to make transition 'TRANSITION_ACTIVATE' for LifecycleNode '/n'")


def test_a_handler_waits_for_its_transition():
    node = lifecycle_node()
    handler = OnStateTransition(
        target_lifecycle_node=node, goal_state="inactive", entities=[LogInfo(msg="ready")]
    )
    with interpreting([RegisterEventHandler(handler), node]) as interpreter:
        interpreter.start()

        assert texts(interpreter.handle(seen("unconfigured", "configuring"))) == []
        assert texts(interpreter.handle(seen("configuring", "inactive"))) == ["ready"]


def test_a_sequence_of_transitions_goes_on_when_the_last_one_succeeded():
    sequence = LifecycleTransition(lifecycle_node_names=["n"], transition_ids=[1, 3])
    with interpreting([lifecycle_node(), sequence]) as interpreter:
        (first,) = [e for e in interpreter.start() if isinstance(e, model.ChangeState)]
        between = interpreter.handle(seen("unconfigured", "configuring"))
        effects = interpreter.handle(seen("configuring", "inactive"))
        (second,) = [e for e in effects if isinstance(e, model.ChangeState)]

    assert between == []
    assert (first.request.transition, second.request.transition) == ("configure", "activate")


def test_a_third_party_process_that_cleans_up_is_asked_at_shutdown():
    asked: list[bool] = []

    class Tidy(ExecuteProcess):
        def _shutdown_process(self, context: Any, *, send_sigint: bool) -> Any:
            asked.append(send_sigint)
            return super()._shutdown_process(context, send_sigint=send_sigint)

    with interpreting([Tidy(cmd=["x"])]) as interpreter:
        interpreter.start()
        effects = interpreter.handle(model.SignalReceived(signum=2))

    assert asked == [False]
    assert effects == [model.RequestShutdown(reason="ctrl-c (SIGINT)")]
