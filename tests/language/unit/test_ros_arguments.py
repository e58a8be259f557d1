"""ROS arguments of a command line, and where the plan shows them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from launcher.base.model.spec import ParameterSource, RosIdentity
from launcher.language.ros.node import ros_arguments
from launcher.launch.plan.plan_json import document
from launcher.launch.plan.planner import make_plan


def parameters(*words: str) -> list[str | None]:
    return [source.rule or source.file for source in ros_arguments(words).parameters]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("x --ros-args -p a:=1 --param b:=[1,2] -p n:c:=x", ["a:=1", "b:=[1,2]", "n:c:=x"]),
        ("x --ros-args --params-file f.yaml -p a:=1 --params-file g", ["f.yaml", "a:=1", "g"]),
        ("x -p before:=1 --ros-args -p a:=1 -- -p after:=2", ["a:=1"]),
        ("x --ros-args -p a:=1 -- w --ros-args -p b:=2", ["a:=1", "b:=2"]),
        ("x --ros-args --ros-args -p a:=1", ["a:=1"]),
        ("x --ros-args --log-level -p a:=1", []),
        ("x --ros-args --enable-rosout-logs -p a:=1", ["a:=1"]),
        ("x --ros-args -p", []),
        ("x --ros-args -p nothing -p :=1 -p b:=", ["b:="]),
        ("x --ros-args -p a:=b:=c", ["a:=b:=c"]),
        ("", []),
    ],
)
def test_parameters_stand_behind_ros_args(line: str, expected: list[str]):
    assert parameters(*line.split()) == expected


def test_names_and_remappings_are_told_apart():
    line = (
        "x --ros-args -r __node:=n -r __ns:=/s --remap a:=b -r n:c:=d -r o:__node:=p -r __node:=m"
    )

    assert ros_arguments(line.split()) == RosIdentity(
        remappings=(("a", "b"), ("n:c", "d")), node_name="n", namespace="/s"
    )


def test_a_file_and_a_rule_are_different_sources():
    found = ros_arguments(["x", "--ros-args", "--params-file", "f", "-p", "a:=1"]).parameters
    assert found == (ParameterSource(file="f"), ParameterSource(rule="a:=1"))


LAUNCH_FILE = """
from launch import LaunchDescription
from launch_ros.actions import Node, SetParameter, SetRemap

def generate_launch_description():
    return LaunchDescription([
        SetParameter("every", 1),
        SetRemap("in", "out"),
        Node(
            executable="/bin/echo",
            arguments=["word", "--ros-args", "-p", "rate:=3", "--params-file", "a.yaml",
                       "--remap", "x:=y", "--", "-p", "mine"],
            ros_arguments=["--param", "other:=2"],
            parameters=[{"own": True}],
            remappings=[("q", "r")],
        ),
        Node(
            executable="/bin/echo",
            arguments=["--ros-args", "-r", "__node:=n", "-r", "__ns:=/s",
                       "--params-file", "/tmp/missing_params.yaml"],
        ),
        Node(executable="/bin/echo", name="given", arguments=["--ros-args", "-r", "__node:=n"]),
    ])
"""


@pytest.fixture
def processes(tmp_path: Path) -> Any:
    file = tmp_path / "some.launch.py"
    file.write_text(LAUNCH_FILE, encoding="utf-8")
    plan = document(make_plan(str(file), []))
    assert plan["error"] is None
    return plan["processes"]


def test_the_plan_lists_them_in_the_order_of_the_command_line(processes: Any):
    first = processes[0]
    assert first["parameters"] == [
        {"rule": "rate:=3"},
        {"file": "a.yaml"},
        {"rule": "other:=2"},
        {"rule": "every:=1"},
        {"generated": {"/**": {"ros__parameters": {"own": True}}}},
    ]
    assert first["remappings"] == [["x", "y"], ["in", "out"], ["q", "r"]]
    assert (first["node_name"], first["namespace"]) == (None, None)


def test_the_plan_has_a_name_that_only_the_arguments_give(processes: Any):
    assert [(p["node_name"], p["namespace"]) for p in processes[1:]] == [
        ("n", "/s"),
        ("given", None),
    ]
    assert processes[1]["parameters"] == [
        {"file": "/tmp/missing_params.yaml"},
        {"rule": "every:=1"},
    ]
