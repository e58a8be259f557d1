"""Independent mistakes in a launch file and its arguments are reported together."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.base.errors import (
    LauncherError,
    LaunchFileError,
    SeveralErrors,
    UsageError,
)
from launcher.launch import mistakes
from launcher.launch.known_names import KnownNames, known_names
from launcher.launch.plan.planner import make_plan

HEAD = """
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import *
from launch.substitutions import *
from launch_ros.actions import *

def generate_launch_description():
    return LaunchDescription([
"""


def found(tmp_path: Path, actions: str, *arguments: tuple[str, str]) -> list[LauncherError]:
    """What is wrong with a launch file, its own fault included."""
    file = tmp_path / "a.launch.py"
    file.write_text(f"{HEAD}{actions}\n    ])\n")
    plan = make_plan(str(file), arguments)
    assert plan.error is not None
    return mistakes.of_launch_file(
        plan.error.fault, plan.description, plan.context, arguments, dict(os.environ)
    )


def unknown(*names: str, known=(), declared=()) -> list[LauncherError]:
    errors, warnings = mistakes.unknown_names(
        [(name, "1") for name in names], KnownNames(known), declared
    )
    assert warnings == []
    return errors


def test_a_misspelt_argument_is_reported_with_the_nearest_name():
    (error,) = unknown("enable_debgu", known=["start_robot_2", "enable_debug"])
    assert isinstance(error, UsageError)
    assert error.hint == "did you mean 'enable_debug'?"


def test_an_argument_without_a_near_name_is_reported_with_the_declared_ones():
    (error,) = unknown("nonsense", known=["mode", "ros_namespace"], declared=["mode"])
    assert error.hint == "known arguments: mode; --lenient accepts any name"


def test_each_unknown_argument_is_an_error_and_known_ones_are_not():
    errors = unknown("nonsense", "mode", "rubbish", "nonsense", known=["mode"])
    assert [error.message for error in errors] == [
        "unknown launch argument 'nonsense'",
        "unknown launch argument 'rubbish'",
    ]


def test_a_launch_file_that_looks_at_all_names_knows_them_all():
    assert unknown("anything", known=["*"]) == []


@pytest.mark.parametrize("target", ["jazzy", "lyrical"])
def test_what_a_timer_keeps_is_no_use_of_a_name(tmp_path: Path, target: str):
    file = tmp_path / "a.launch.py"
    later = "TimerAction(period=1.0, actions=[ExecuteProcess(cmd=['true'])])"
    file.write_text(f"{HEAD}{later}\n    ])\n")
    plan = make_plan(str(file), [("speed", "1")], target=target)
    errors, warnings = mistakes.unknown_names([("speed", "1")], known_names(plan), ())
    assert [error.message for error in errors] == ["unknown launch argument 'speed'"]
    assert warnings == []


def test_all_missing_required_arguments_are_reported_with_their_places(tmp_path):
    errors = found(
        tmp_path,
        """
        DeclareLaunchArgument("map", description="The map"),
        DeclareLaunchArgument("robot", choices=["r1", "r2"]),
        DeclareLaunchArgument("given"),
        """,
        ("given", "1"),
    )
    assert [error.message for error in errors] == [
        "the required argument 'map' is not given (The map)",
        "the required argument 'robot' is not given (One of: ['r1', 'r2'])",
    ]
    assert [error.hint for error in errors] == ["give map:=VALUE", "give robot:=r1"]
    assert errors[0].where == f"{tmp_path}/a.launch.py:11"
    assert errors[0].source_line is not None and errors[0].column is not None
    assert errors[0].source_line[errors[0].column - 1 :].startswith("map")


def test_a_bad_choice_and_a_missing_argument_are_reported_together(tmp_path):
    errors = found(
        tmp_path,
        """
        DeclareLaunchArgument("mode", default_value="fast", choices=["fast", "slow"]),
        DeclareLaunchArgument("need"),
        """,
        ("mode", "fats"),
    )
    assert [error.hint for error in errors] == ["give need:=VALUE", "did you mean mode:=fast?"]


def test_all_nodes_that_cannot_be_found_are_reported(tmp_path):
    errors = found(
        tmp_path,
        """
        Node(package="no_such_package", executable="x"),
        GroupAction([Node(package="rcl_interfaces", executable="nothing")]),
        Node(package="also_missing", executable="x", condition=IfCondition("0")),
        DeclareLaunchArgument("v", default_value="not_there"),
        Node(package=LaunchConfiguration("v", default="w"), executable="x"),
        """,
    )
    lines = [str(error.where).rpartition(":")[2] for error in errors]
    assert lines == ["11", "12", "15"]
    assert "no_such_package" in errors[0].message
    assert "also_missing" not in "".join(error.message for error in errors)


def test_what_cannot_be_known_beforehand_is_not_guessed(tmp_path):
    errors = found(
        tmp_path,
        """
        LogInfo(msg=LaunchConfiguration("nope")),
        Node(package="no_such_package", executable="x",
             condition=IfCondition(PythonExpression(["1 == 2"]))),
        Node(package=Command("echo nothing"), executable="x"),
        """,
    )
    assert [error.message for error in errors] == ["launch configuration 'nope' does not exist"]


def test_a_file_that_cannot_be_loaded_has_only_its_own_fault():
    fault = LaunchFileError("broken")
    assert mistakes.of_launch_file(fault, None, None, [("a", "1")], {}) == [fault]


def test_the_same_mistake_is_reported_once():
    one, same, other = UsageError("one"), UsageError("one"), LaunchFileError("other")
    assert mistakes.together([one, same]).render() == "error: one"
    both = mistakes.together([one, other, same])
    assert isinstance(both, SeveralErrors)
    assert both.render() == "error: one\nerror: other"
    assert both.exit_code == 2


@pytest.mark.parametrize("count", [19, 21, 400])
def test_the_number_of_reported_mistakes_is_bounded(count):
    told = mistakes.together([UsageError(f"number {n}") for n in range(count)]).render()
    assert told.count("error: ") == min(count, mistakes.MAX_MISTAKES)


@pytest.mark.parametrize("column", [1, 150, 25_000, 50_000])
def test_of_a_long_line_the_part_around_the_column_is_shown(column: int):
    line = "".join(str(n % 10) for n in range(50_000))
    _, shown, mark = UsageError("wrong", source_line=line, column=column).render().split("\n")
    assert len(shown) <= 4 + 200
    assert shown[mark.index("^")] == line[column - 1]


def test_an_error_keeps_the_exception_that_a_traceback_shows():
    original = ValueError("odd")
    fault = LaunchFileError("odd", where="/a.launch.py:3")
    fault.__cause__ = original
    other = LaunchFileError("another", where="/a.launch.py:4")

    assert mistakes.together([fault], fault) is fault
    assert fault.__cause__ is original
    assert mistakes.together([fault, other], fault).__cause__ is fault
    assert mistakes.together([other], None).__cause__ is None
