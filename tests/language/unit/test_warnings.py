"""Warnings about surprising behaviour of ROS 2, once each, with file and line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from launcher.base.model import events as model
from launcher.language.actions.arguments import DeclareLaunchArgument
from launcher.language.actions.configuration import SetEnvironmentVariable, SetLaunchConfiguration
from launcher.language.actions.event_actions import RegisterEventHandler
from launcher.language.actions.group import GroupAction
from launcher.language.actions.process import ExecuteProcess, OnProcessExit
from launcher.language.actions.timer import RosTimer, TimerAction
from launcher.language.ros.composition import ComposableNode, ComposableNodeContainer
from launcher.language.ros.lifecycle import LifecycleNode
from launcher.language.ros.node import Node
from launcher.language.ros.parameter_descriptions import ParameterValue
from launcher.language.ros.scope import PushROSNamespace, SetParameter, SetUseSimTime
from launcher.language.substitutions.configuration import LaunchConfiguration
from launcher.launch.plan.planner import make_plan
from tests.language.unit.interpreter.interpreting import interpreting


def warnings_of(*entities: Any) -> list[str]:
    with interpreting(entities) as interpreter:
        interpreter.start()
        assert all(str(warning.origin).startswith(__file__) for warning in interpreter.warnings)
        return [warning.text for warning in interpreter.warnings]


def test_a_ros_timer_beside_nodes_with_simulated_time_may_be_on_wall_time():
    timer = RosTimer(period=1.0, actions=[])
    parameter = SetParameter("use_sim_time", True)

    (warning,) = warnings_of(parameter, timer)

    assert "SetUseSimTime(True)" in warning
    timer = RosTimer(period=1.0, actions=[])
    assert warnings_of(parameter, timer, SetUseSimTime(True)) == []
    assert warnings_of(RosTimer(period=1.0, actions=[])) == []


@pytest.mark.parametrize("value", [False, LaunchConfiguration("sim")])
def test_simulated_time_that_is_switched_off_gives_a_warning(value: Any):
    given = SetLaunchConfiguration("sim", "false")

    assert warnings_of(given, SetUseSimTime(value)) == [
        "SetUseSimTime with false always ends the launch in ROS 2, with exit code 1"
    ]


def test_a_timer_in_a_group_keeps_what_the_group_has_set():
    settings = [PushROSNamespace("ns"), SetEnvironmentVariable("LAUNCHER_TEST", "1")]

    assert warnings_of(GroupAction([*settings, TimerAction(period=1.0, actions=[])])) == []


def test_a_handler_in_a_group_loses_the_groups_settings():
    handler = RegisterEventHandler(OnProcessExit(on_exit=[]))

    (warning,) = warnings_of(GroupAction([SetLaunchConfiguration("a", "1"), handler]))

    assert (
        warning == "the actions of this event handler run outside of the group or timer around it, "
        "without its a"
    )


def test_the_handlers_of_a_node_that_is_activated_need_no_settings():
    node = LifecycleNode(executable="x", name="n", namespace="", autostart=True)

    assert warnings_of(GroupAction([PushROSNamespace("ns"), node])) == []


def test_a_missing_parameter_file_gives_a_warning():
    node = Node(executable="x", parameters=["/no/such/file.yaml"])

    assert warnings_of(node) == [
        "Parameter file path is not a file: /no/such/file.yaml; the node starts without it"
    ]


def test_a_missing_parameter_file_gives_the_near_name(tmp_path: Path):
    (tmp_path / "robot.yaml").touch()
    (tmp_path / "other.txt").touch()

    (warning,) = warnings_of(Node(executable="x", parameters=[str(tmp_path / "robto.yaml")]))

    assert warning.endswith("the node starts without it; hint: did you mean 'robot.yaml'?")


@pytest.mark.parametrize("text", ["0483", "1e5", "y", "nan", "a: b"])
def test_a_text_that_nodes_do_not_get_as_one_gives_a_warning(text: str):
    (warning,) = warnings_of(SetParameter("a", ParameterValue(text, value_type=str)))

    assert warning.startswith(f"SetParameter passes '{text}' without quotes")


@pytest.mark.parametrize(
    ("given", "number"), [("1e3", "1000.0"), ("-2E-6", "-2.0e-06"), ("[1e5, 2e5]", "100000.0")]
)
def test_a_number_that_nodes_get_as_a_text_gives_a_warning(given: str, number: str):
    value = SetLaunchConfiguration("x", given)
    node = Node(executable="x", parameters=[{"gain": LaunchConfiguration("x")}])

    (warning,) = warnings_of(value, node)

    first = given.strip("[]").split(",")[0]
    assert warning == (
        f"parameter 'gain' is the text '{first}', which is a number in Jazzy; "
        f"hint: write {number}, or give it a type"
    )


@pytest.mark.parametrize(
    "value", [1e3, "1e3", "serial", ParameterValue("1e3", value_type=str), ["1e3"], [1e3]]
)
def test_a_value_with_a_type_gives_none(value: object):
    assert warnings_of(Node(executable="x", parameters=[{"gain": value}])) == []


@pytest.mark.parametrize("value", ["text", "12", 12, True, ParameterValue("a", value_type=str)])
def test_what_nodes_get_as_it_is_gives_none(value: object):
    assert warnings_of(SetParameter("a", value)) == []


def test_a_parameter_that_leaks_out_of_its_group_gives_a_warning():
    inside = GroupAction([SetParameter("b", 2)])

    assert warnings_of(SetParameter("a", 1), inside, GroupAction([])) == [
        "SetParameter also applies after its group, because of an earlier one outside"
    ]


def test_a_warning_comes_once_however_often_the_place_is_visited():
    handler = RegisterEventHandler(OnProcessExit(on_exit=[]))
    group = GroupAction([SetLaunchConfiguration("a", "1"), handler])
    with interpreting([group, group, ExecuteProcess(cmd=["x"])]) as interpreter:
        effects = interpreter.start()

    said = [e for e in effects if isinstance(e, model.LogMessage) and e.level == "WARNING"]
    assert len(interpreter.warnings) == len(said) == 1


def test_an_argument_that_keeps_the_value_of_another_include_gives_a_warning(tmp_path: Path):
    child = (
        "from launch import LaunchDescription\n"
        "from launch.actions import DeclareLaunchArgument\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([DeclareLaunchArgument('rate', default_value='{}')])\n"
    )
    (tmp_path / "one.launch.py").write_text(child.format(1))
    (tmp_path / "two.launch.py").write_text(child.format(2))
    parent = tmp_path / "parent.launch.py"
    parent.write_text(
        "from launch import LaunchDescription\n"
        "from launch.actions import IncludeLaunchDescription as Include\n"
        "def generate_launch_description():\n"
        f"    return LaunchDescription([Include('{tmp_path}/one.launch.py'),\n"
        f"                              Include('{tmp_path}/two.launch.py')])\n"
    )

    (warning,) = make_plan(str(parent), []).warnings

    assert warning.text.startswith(f"argument 'rate' keeps the value '1' of {tmp_path}/one.launch")
    assert str(warning.origin) == f"{tmp_path}/two.launch.py:4"


def test_an_argument_of_the_parent_gives_no_warning():
    declare = [DeclareLaunchArgument("rate", default_value=value) for value in "12"]

    assert warnings_of(*declare) == []


def names_warned_of(*entities: Any, **options: Any) -> list[str]:
    with interpreting(entities, **options) as interpreter:
        interpreter.start()
        return [f"{warning.origin}: {warning.text}" for warning in interpreter.warnings]


def test_two_nodes_of_one_full_name_are_named_with_their_places():
    first = Node(executable="x", name="n", namespace="arm")
    second = Node(executable="y", arguments=["--ros-args", "-r", "__ns:=/arm", "-r", "__node:=n"])

    (warning,) = names_warned_of(first, second)

    text = f"y-2 and x-1 ({first._origin}) have the same node name /arm/n"
    assert warning == f"{second._origin}: {text}"


def test_a_loaded_node_may_have_the_name_of_another_one():
    node = Node(executable="x", name="n")
    descriptions = [ComposableNode(package="p", plugin="P", name="n")]
    box = ComposableNodeContainer(
        executable="b", name="box", namespace="", composable_node_descriptions=descriptions
    )

    (warning,) = names_warned_of(node, box)

    text = f"P in /box and x-1 ({node._origin}) have the same node name /n"
    assert warning == f"{box._origin}: {text}"


def test_nodes_of_different_names_or_domains_or_times_do_not_collide():
    again = Node(executable="x", name="n")
    first = Node(executable="x", name="n", on_exit=[again])
    elsewhere = Node(executable="x", name="n", additional_env={"ROS_DOMAIN_ID": "7"})
    other = Node(executable="x", name="n", namespace="arm")
    unnamed = [Node(executable="x"), Node(executable="x")]
    with interpreting([first, elsewhere, other, *unnamed], environment={}) as interpreter:
        started, *_ = [e for e in interpreter.start() if isinstance(e, model.StartProcess)]
        exited = model.ProcessExited(process_id=started.process_id, pid=1, returncode=0)
        interpreter.handle(exited)

        assert interpreter.warnings == ()


def test_tracing_is_left_out_with_a_warning(tmp_path: Path):
    python = tmp_path / "b.launch.py"
    python.write_text(
        "from launch import LaunchDescription\n"
        "from tracetools_launch.action import Trace\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([Trace(session_name='s', events_ust=[])])\n"
    )
    xml = tmp_path / "a.launch.xml"
    trace = '<trace session-name="s" events-ust="a b" append-timestamp="true" if="true"/>'
    off = '<trace session-name="s" if="false"/>'
    xml.write_text(f'<launch>{trace}\n{off}<include file="{python}"/></launch>')

    plan = make_plan(str(xml), [])

    assert plan.error is None
    assert [str(warning.origin) for warning in plan.warnings] == [f"{xml}:1", f"{python}:4"]
    assert all("Trace is left out: " in warning.text for warning in plan.warnings)


INCLUDERS = {
    "xml": '<launch><include file="FILE"><TAG name="q" value="7"/></include></launch>',
    "yaml": "launch:\n- include:\n    file: FILE\n    TAG: [{name: q, value: '7'}]\n",
    "py": (
        "from launch import LaunchDescription\n"
        "from launch.actions import IncludeLaunchDescription\n"
        "def generate_launch_description():\n"
        "    given = {'q': '7'}.items()\n"
        "    return LaunchDescription([IncludeLaunchDescription('FILE', launch_arguments=given)])\n"
    ),
}
INCLUDED = {
    "xml": '<launch><arg name="q" default="1"/><log message="$(dirname)"/></launch>',
    "py": (
        "from launch import LaunchDescription\n"
        "from launch.actions import DeclareLaunchArgument\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([DeclareLaunchArgument('q', default_value='1')])\n"
    ),
}


@pytest.mark.parametrize("tag", ["arg", "let"])
@pytest.mark.parametrize("written", ["sub/b.launch", "sub/../sub/b.launch"])
@pytest.mark.parametrize("included", INCLUDED)
@pytest.mark.parametrize("includer", INCLUDERS)
def test_an_argument_of_an_include_with_a_relative_path_gives_no_warning(
    includer: str,
    included: str,
    written: str,
    tag: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    (tmp_path / f"sub/b.launch.{included}").write_text(INCLUDED[included])
    file = tmp_path / f"a.launch.{includer}"
    text = INCLUDERS[includer].replace("FILE", f"{written}.{included}").replace("TAG", tag)
    file.write_text(text)

    plan = make_plan(str(file), [])

    assert plan.error is None
    assert [warning.text for warning in plan.warnings] == []
    assert plan.declared == {"q": "7"}


def test_what_relative_includes_leave_behind_gives_the_same_warnings_as_with_absolute_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "b.launch.xml").write_text(INCLUDED["xml"])
    (tmp_path / "c.launch.xml").write_text(
        '<launch><include file="b.launch.xml"/><log message="$(filename)"/></launch>'
    )
    file = tmp_path / "a.launch.xml"
    found = []
    for folder in ("", f"{tmp_path}/"):
        file.write_text(
            f'<launch><include file="{folder}c.launch.xml"/>\n'
            f'<include file="{folder}b.launch.xml"/><log message="$(dirname)"/></launch>'
        )
        found.append([warning.text for warning in make_plan(str(file), []).warnings])

    assert found[0] == found[1]
    assert f"$(filename) is that of {tmp_path}/b.launch.xml, which was included before" in found[0]


MARKUP = """<launch>
  <set_parameter name="use_sim_time" value="true"/>
  <ros_timer period="1.0"><log message="x"/></ros_timer>
  <set_use_sim_time value="false"/>
  <group><set_parameter name="z" value="1"/><set_remap from="a" to="b"/></group>
  <include file="FOLDER/b.launch.xml"/>
  <log message="$(dirname) $(filename)"/>
  <executable cmd="'no_such_program -x'"/>
</launch>
"""


def test_warnings_about_xml_use_its_words(tmp_path: Path):
    (tmp_path / "b.launch.xml").write_text(INCLUDED["xml"])
    file = tmp_path / "a.launch.xml"
    file.write_text(MARKUP.replace("FOLDER", str(tmp_path)))

    plan = make_plan(str(file), [])

    text = "\n".join(warning.text for warning in plan.warnings)
    assert text.count("\n") == 5
    for word in (
        '<set_use_sim_time value="true"> for timers',
        "<set_use_sim_time> with false",
        "<set_parameter> also applies after its group",
        "$(dirname) is that of",
        "$(filename) is that of",
        'write cmd="no_such_program -x", or add shell="true"',
    ):
        assert word in text
    assert not any(word in text for word in ("SetParameter", "ThisLaunchFile", "shell=True"))


@pytest.mark.parametrize(
    "tag",
    [
        '<set_use_sim_time value="$(var sim)"/>',
        '<timer period="1" cancel_on_shutdown="$(var sim)"/>',
    ],
)
def test_a_truth_value_from_an_argument_names_it(tmp_path: Path, tag: str):
    file = tmp_path / "a.launch.xml"
    file.write_text(f'<launch><arg name="sim" default="true"/>\n{tag}</launch>')

    error = make_plan(str(file), [("sim", "maybe")]).error

    assert error is not None
    assert error.fault.hint == "sim is 'maybe', on the command line"
    assert error.fault.source_line is not None
    assert error.fault.source_line[(error.fault.column or 0) - 1 :].startswith("sim)")


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("$(var nope)", "declare it with <arg>, or give nope:=VALUE"),
        ("$(env NOPE_)", "set it (export NOPE_=VALUE), or write $(env NOPE_ DEFAULT)"),
    ],
)
def test_hints_about_xml_use_its_words(tmp_path: Path, word: str, hint: str):
    file = tmp_path / "a.launch.xml"
    file.write_text(f'<launch><log message="{word}"/></launch>')

    error = make_plan(str(file), []).error

    assert error is not None
    assert error.fault.hint == hint
