"""Parameter files that have nothing for the nodes that get them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from launcher.base.model import events as model
from launcher.language.actions.event_actions import (
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launcher.language.actions.process import ExecuteProcess, OnProcessExit
from launcher.language.actions.timer import TimerAction
from launcher.language.ros.composition import ComposableNode, ComposableNodeContainer
from launcher.language.ros.node import Node
from launcher.language.ros.parameter_descriptions import ParameterFile
from launcher.language.ros.scope import PushROSNamespace, SetParametersFromFile
from tests.language.unit.interpreter.interpreting import interpreting

BELOW = "{ros__parameters: {p: 1}}"


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "p.yaml"
    path.write_text(f"talker: {BELOW}\nsite: {{east: {{lidar: {BELOW}}}}}\n")
    return path


def node(name: str | None, *files: Any, **options: Any) -> Node:
    return Node(executable="x", name=name, parameters=list(files), **options)


def warnings_of(*entities: Any) -> list[str]:
    with interpreting(entities) as interpreter:
        interpreter.start()
        assert all(str(warning.origin).startswith(__file__) for warning in interpreter.warnings)
        return [warning.text for warning in interpreter.warnings]


def test_the_name_and_the_keys_are_reported(file: Path):
    (warning,) = warnings_of(node("camera", "p.yaml"))
    assert warning == (
        "the parameter file p.yaml has nothing for /camera: it is for /talker, /site/east/lidar; "
        "hint: write '/camera:', or '/**:' for all nodes"
    )


@pytest.mark.parametrize(
    ("entities", "reported"),
    [
        ([node("talker", "p.yaml", namespace="ns")], "/ns/talker: it is for /talker, "),
        ([PushROSNamespace("n"), node("lidar", "p.yaml")], "/n/lidar: it is for /site/east/lidar"),
    ],
    ids=["namespace", "pushed"],
)
def test_a_missing_or_another_namespace_is_the_hint(file: Path, entities: Any, reported: str):
    (warning,) = warnings_of(*entities)
    assert f"has nothing for {reported}" in warning
    name = reported.partition(":")[0]
    last = name.rpartition("/")[2]
    assert warning.endswith(f"write '{name}:', or '/**/{last}:' for any namespace")


def test_a_similar_key_is_the_hint(file: Path):
    (warning,) = warnings_of(node("talkr", "p.yaml"))
    assert warning.endswith("hint: write '/talkr:' instead of '/talker:'")


def test_a_file_that_one_node_uses_is_for_others_as_well(file: Path):
    assert warnings_of(node("camera", "p.yaml"), node("talker", "p.yaml")) == []
    assert warnings_of(SetParametersFromFile("p.yaml"), node("a"), node("talker")) == []


def test_a_file_of_several_nodes_is_reported_once(file: Path):
    (warning,) = warnings_of(SetParametersFromFile("p.yaml"), node("a"), node("b"), node("talkr"))
    assert "has nothing for /a, /b, /talkr: " in warning
    assert warning.endswith("write '/talkr:' instead of '/talker:'")


@pytest.mark.parametrize(
    "text",
    [
        f"/**: {BELOW}",
        f"/*: {BELOW}",
        f"'/**/camera': {BELOW}",
        f"camera: {BELOW}",
        f"/: {{camera: {BELOW}}}",
        f"/camera: {BELOW}\nother: {BELOW}",
        "",
        "# nothing\n",
        "[",
    ],
)
def test_a_file_with_something_for_the_node_or_without_names_is_not_reported(file: Path, text: str):
    file.write_text(text)
    assert warnings_of(node("camera", str(file))) == []


def test_a_node_whose_name_only_its_program_knows_may_be_meant(file: Path):
    assert warnings_of(node(None, "p.yaml")) == []
    assert warnings_of(node("camera", "p.yaml"), node(None, "p.yaml")) == []


def test_a_level_that_is_missing_is_reported(file: Path):
    file.write_text("talker: {p: 1}\n")
    (warning,) = warnings_of(node("talker", "p.yaml"))
    assert "p.yaml has no 'ros__parameters:', so that /talker cannot read it" in warning


def test_a_file_with_substitutions_is_reported_by_its_own_name(file: Path):
    (warning,) = warnings_of(node("camera", ParameterFile("p.yaml", allow_substs=True)))
    assert "the parameter file p.yaml has nothing for /camera" in warning


def test_arguments_of_a_process_count_and_rename(file: Path):
    words = ["x", "--ros-args", "-r", "__node:=camera", "--params-file", "p.yaml"]
    (warning,) = warnings_of(ExecuteProcess(cmd=words))
    assert "has nothing for /camera" in warning
    renamed = ["--ros-args", "-r", "__node:=talker"]
    assert warnings_of(node("camera", "p.yaml", ros_arguments=renamed[1:])) == []


def components(*names: str | None) -> ComposableNodeContainer:
    described = [
        ComposableNode(package="p", plugin="P", name=name, namespace="ns", parameters=["p.yaml"])
        for name in names
    ]
    return ComposableNodeContainer(
        name="box", namespace="", executable="x", composable_node_descriptions=described
    )


def test_components_are_nodes_too(file: Path):
    (warning,) = warnings_of(components("talker"))
    assert "p.yaml has nothing for /ns/talker" in warning
    assert warnings_of(components(None)) == []
    file.write_text("p: 1\n")  # as launch_ros allows it for components
    assert warnings_of(components("talker")) == []


LATER = {
    "timer": lambda: TimerAction(period=1.0, actions=[node("talker", "p.yaml")]),
    "exit": lambda: ExecuteProcess(cmd=["x"], on_exit=[node("talker", "p.yaml")]),
    "function": lambda: RegisterEventHandler(OnProcessExit(on_exit=lambda event, context: None)),
}


@pytest.mark.parametrize("later", LATER)
def test_with_more_nodes_to_come_only_what_is_probable_is_reported(file: Path, later: str):
    assert warnings_of(node("camera", "p.yaml"), LATER[later]()) == []
    (warning,) = warnings_of(node("talkr", "p.yaml"), LATER[later]())
    assert "has nothing for /talkr" in warning


def test_what_starts_nothing_is_not_waited_for(file: Path):
    harmless = ExecuteProcess(cmd=["x"], on_exit=[LogInfo(msg="a"), Shutdown()])
    assert len(warnings_of(node("camera", "p.yaml"), harmless)) == 1


def test_the_rest_is_reported_when_nothing_more_can_come(file: Path):
    timer = TimerAction(period=1.0, actions=[OpaqueFunction(function=lambda context: None)])
    with interpreting([node("camera", "p.yaml"), timer]) as interpreter:
        (call,) = [one for one in interpreter.start() if isinstance(one, model.CallLater)]
        assert interpreter.warnings == ()
        interpreter.handle(model.TimerFired(timer_id=call.timer_id))
        assert len(interpreter.warnings) == 1
    handler = RegisterEventHandler(OnProcessExit(on_exit=lambda event, context: None))
    with interpreting([node("camera", "p.yaml"), handler]) as interpreter:
        interpreter.start()
        assert interpreter.warnings == ()
        interpreter.handle(model.ShutdownAsked(reason="test"))
        assert len(interpreter.warnings) == 1
