"""What methods and functions of a launch file return: a wrong value is a mistake of the file."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.language.compat import vocabulary
from launcher.launch.plan.plan import Plan
from launcher.launch.plan.planner import make_plan

HEAD = """\
import os, pathlib
from launch import *
from launch import Action, Condition, LaunchDescriptionEntity, LaunchDescriptionSource, Substitution
from launch.actions import *
from launch.conditions import IfCondition
from launch.descriptions import Executable
from launch.event_handler import BaseEventHandler
from launch.event_handlers import *
from launch.substitutions import *
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
"""
VALUES = ("None", "3", "2.5", "'x'", "b'x'", "[3]", "{'a': 1}", "object()", "pathlib.Path('/')")


def planned(folder: Path, definition: str, entry: str) -> Plan:
    file = folder / "own.launch.py"
    body = (
        f"def generate_launch_description():\n    return LaunchDescription([\n        {entry}])\n"
    )
    file.write_text(f"{HEAD}{definition}\n{body}")
    return make_plan(str(file), [])


def own(base: str, method: str, value: str, rest: str = "") -> str:
    """A class with a method that returns a value, in line 14."""
    return f"class Own({base}):\n    def {method}:\n        return {value}\n{rest}"


# How an object of the class gets into a launch file.
METHODS = {
    ("Substitution", "perform(self, context)"): (
        "LogInfo(msg=['a ', Own()])",
        "LogInfo(msg=PathJoinSubstitution(['/a', Own()]))",
        "LogInfo(msg=ThisLaunchFileDir() / Own())",
        "LogInfo(msg=EqualsSubstitution('a', Own()))",
        "LogInfo(msg=EnvironmentVariable('NONE_SUCH', default_value=Own()))",
        "LogInfo(msg='x', condition=IfCondition(Own()))",
        "ExecuteProcess(cmd=['true', Own()], cwd=Own())",
        "ExecuteProcess(cmd=['true'], sigterm_timeout=Own())",
        "SetEnvironmentVariable('A', Own())",
        "DeclareLaunchArgument('a', default_value=Own())",
        "IncludeLaunchDescription(Own())",
        "TimerAction(period=1.0, actions=[LogInfo(msg=Own())])",
        "TimerAction(period=Own(), actions=[])",
        "Node(executable='true', name=Own())",
        "Node(executable='true', parameters=[{'x': Own()}])",
        "Node(executable='true', parameters=[{'x': ParameterValue(Own(), value_type=str)}])",
        "Node(executable='true', remappings=[('a', Own())])",
    ),
    ("Condition", "evaluate(self, context)"): ("LogInfo(msg='x', condition=Own())",),
    ("Action", "execute(self, context)"): ("Own()", "GroupAction([Own()])"),
    ("Action", "get_sub_entities(self)"): ("Own()", "Own(condition=IfCondition('true'))"),
    ("Action", "describe_sub_entities(self)"): ("Own()",),
    ("Action", "describe_conditional_sub_entities(self)"): ("Own()",),
    ("LaunchDescriptionEntity", "visit(self, context)"): ("Own()",),
    ("BaseEventHandler", "describe(self)"): (
        "RegisterEventHandler(Own(matcher=lambda event: False))",
    ),
    ("BaseEventHandler", "handle(self, event, context)"): (
        "RegisterEventHandler(Own(matcher=lambda event: True))",
    ),
    ("LaunchDescriptionSource", "get_launch_description(self, context)"): (
        "IncludeLaunchDescription(Own())",
    ),
    ("LaunchDescriptionSource", "_get_launch_description(self, location)"): (
        "IncludeLaunchDescription(Own())",
    ),
    ("Executable", "prepare(self, context, action)"): (
        "ExecuteLocal(process_description=Own(cmd=['true']))",
    ),
}
FUNCTIONS = (
    "OpaqueFunction(function=lambda context: {})",
    "ForLoop('1', function=lambda i: {})",
    "ForEach('{{a: 1}}', function=lambda a: {})",
    "ExecuteProcess(cmd=['true'], on_exit=lambda event, context: {})",
    "RegisterEventHandler(OnShutdown(on_shutdown=lambda event, context: {})), Shutdown()",
    "RegisterEventHandler(OnProcessStart(on_start=lambda event, context: {})), "
    "ExecuteProcess(cmd=['true'])",
)


@pytest.mark.parametrize(("base", "method"), METHODS, ids=lambda name: name.partition("(")[0])
def test_no_value_of_a_method_makes_a_fault_of_the_launcher(base: str, method: str, tmp_path: Path):
    for entry in METHODS[base, method]:
        for value in VALUES:
            error = planned(tmp_path, own(base, method, value), entry).error
            if error is not None:
                text = f"{entry}, {value}\n{error.fault.render()}"
                assert "of the launcher" not in text, text
                assert "launcher's own" not in text, text
                assert error.fault.where is not None and error.fault.where.endswith(
                    (":12", ":13", ":14", ":17", ":18")
                ), text


@pytest.mark.parametrize("entry", FUNCTIONS)
def test_no_value_of_a_function_makes_a_fault_of_the_launcher(entry: str, tmp_path: Path):
    for value in VALUES:
        error = planned(tmp_path, "", entry.format(value)).error
        if error is not None:
            text = f"{value}\n{error.fault.render()}"
            assert "of the launcher" not in text, text
            assert "launcher's own" not in text, text
            assert error.fault.where is not None and error.fault.where.endswith(":15"), text


@pytest.mark.parametrize(
    ("value", "shown", "hint"),
    [
        ("None", "None", "return a text"),
        ("['a']", "['a']", "return a text"),
        ("3", "3", "write 'return str(...)'"),
        ("pathlib.Path('/a')", "PosixPath('/a')", "write 'return str(...)'"),
        (
            "LaunchConfiguration('a')",
            "a launch.substitutions.launch_configuration.LaunchConfiguration",
            "write 'return ....perform(context)'",
        ),
    ],
)
def test_a_substitution_that_gives_no_text_is_named_with_its_line(
    value: str, shown: str, hint: str, tmp_path: Path
):
    definition = own("Substitution", "perform(self, context)", value)
    error = planned(tmp_path, definition, "LogInfo(msg=['a ', Own()])").error
    assert error is not None
    assert error.kind == "TypeError"  # as in ROS 2
    assert error.fault.message.startswith(f"Own.perform() returned {shown}")
    assert error.fault.message.endswith(", not a text")
    assert error.fault.where == f"{tmp_path / 'own.launch.py'}:14"
    assert error.fault.hint == hint


def test_a_configuration_that_is_set_to_no_text_is_no_fault_of_the_launcher(tmp_path: Path):
    setting = "def f(context):\n    context.launch_configurations['n'] = 5\n"
    entry = "OpaqueFunction(function=f), LogInfo(msg=['a', LaunchConfiguration('n')])"
    error = planned(tmp_path, setting, entry).error
    assert error is not None
    assert error.fault.message == "LaunchConfig('n') is 5, not a text"
    assert str(error.fault.where).endswith(":17")


@pytest.mark.parametrize(
    ("value", "truth"), [("None", "false"), ("'false'", "true"), ("[]", "false")]
)
def test_a_condition_that_gives_no_truth_value_is_reported(value: str, truth: str, tmp_path: Path):
    definition = own("Condition", "evaluate(self, context)", value)
    for entry, name in (
        ("Own()", "Own.evaluate()"),
        (f"Condition(predicate=lambda context: {value})", "<lambda>(), a predicate of Condition,"),
    ):
        plan = planned(tmp_path, definition, f"LogInfo(msg='x', condition={entry})")
        (warning,) = plan.warnings
        shown = value.replace('"', "'")
        assert warning.text == (
            f"{name} returned {shown}, which counts as {truth}; hint: return True or False"
        )
        assert [log for log, _ in plan.logs] == (["x"] if truth == "true" else [])


@pytest.mark.parametrize("value", ["True", "False", "0", "1"])
def test_a_truth_value_or_a_number_is_a_condition(value: str, tmp_path: Path):
    definition = own("Condition", "evaluate(self, context)", value)
    plan = planned(tmp_path, definition, "LogInfo(msg='x', condition=Own())")
    assert plan.warnings == ()


def test_an_included_file_that_returns_nothing_is_reported_with_its_place(tmp_path: Path):
    included = tmp_path / "included.launch.py"
    included.write_text("def generate_launch_description():\n    pass\n")
    error = planned(tmp_path, "", f"IncludeLaunchDescription({str(included)!r})").error
    assert error is not None
    assert error.kind == "AttributeError"  # as in ROS 2
    assert "returned None, not a LaunchDescription" in error.fault.message
    assert error.fault.where == f"{included}:1"
    assert error.fault.hint == "return LaunchDescription([...])"


MARKUP = """
from launch.frontend import expose_action, expose_substitution

@expose_action("own_action")
class OwnAction(Action):
    @classmethod
    def parse(cls, entity, parser):
        return {value}

@expose_substitution("own-substitution")
class OwnSubstitution(Substitution):
    @classmethod
    def parse(cls, data):
        return {value}
"""


@pytest.mark.parametrize("tag", ["<own_action/>", '<log message="$(own-substitution)"/>'])
@pytest.mark.parametrize("value", ["None", "5", "cls", "(cls,)", "(cls, None)", "(None, {})"])
def test_a_parse_method_that_returns_something_else_is_reported(
    tag: str, value: str, tmp_path: Path
):
    markup = tmp_path / "own.launch.xml"
    markup.write_text(f"<launch>\n{tag}\n</launch>\n")
    definition = MARKUP.format(value=value)
    error = planned(tmp_path, definition, f"IncludeLaunchDescription({str(markup)!r})").error
    assert error is not None
    name = "OwnAction" if "action" in tag else "OwnSubstitution"
    assert f"{name}.parse() returned " in error.fault.message
    assert "not a class and a dictionary of arguments" in error.fault.message
    assert error.fault.where == f"{markup}:2"
    line = 19 if "action" in tag else 25
    assert str(error.fault.hint).endswith(f"own.launch.py:{line}")


def test_a_custom_context_may_have_values_that_are_no_texts():
    with vocabulary():
        from launch import LaunchContext
        from launch.substitutions import LaunchConfiguration

        context = LaunchContext()
        context.launch_configurations["list"] = [1]
        assert context.perform_substitution(LaunchConfiguration("list")) == [1]
