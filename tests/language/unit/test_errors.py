"""Faulty launch files: place, source line, caret, message and suggestion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from launcher.base.errors import ExitCode
from launcher.launch.plan.plan import Plan
from launcher.launch.plan.planner import make_plan

HEAD = """\
from launch import LaunchDescription
from launch.actions import *
from launch.substitutions import *
from launch_ros.actions import Node
from launch_ros.substitutions import *
def generate_launch_description():
"""
# What comes after HEAD is line 7.

BROKEN = {
    "syntax": ("    return LaunchDescription([\n", 7, "'[' was never closed", None),
    "raises": ("    return 1 / 0\n", 7, "ZeroDivisionError: division by zero", None),
    "returns None": ("    pass\n", 6, "returned NoneType, not a LaunchDescription", "return"),
    "misspelt keyword": (
        "    return LaunchDescription([\n        Node(executable='x', parametrs=[])])\n",
        8,
        "unexpected keyword argument 'parametrs'",
        "did you mean 'parameters'?",
    ),
    "unknown configuration": (
        "    return LaunchDescription([\n"
        "        DeclareLaunchArgument('robot_name', default_value='r'),\n"
        "        LogInfo(msg=LaunchConfiguration('robot_nam'))])\n",
        9,
        "launch configuration 'robot_nam' does not exist",
        "did you mean 'robot_name'?",
    ),
    "unknown package": (
        "    return LaunchDescription([\n        Node(package='no_such_pkg', executable='x')])\n",
        8,
        "package 'no_such_pkg' not found",
        None,
    ),
    "missing module": (
        "    import module_that_nobody_has\n",
        7,
        "No module named 'module_that_nobody_has'",
        "install the Python package",
    ),
    "exits": ("    raise SystemExit(3)\n", 7, "the launch file calls sys.exit(3)", None),
    "includes itself": (
        "    return LaunchDescription([\n        IncludeLaunchDescription([ThisLaunchFile()])])\n",
        8,
        "the launch file includes itself endlessly: broken.launch.py -> broken.launch.py",
        "remove an include or a call",
    ),
    "returns a list": (
        "    some = 1\n    return [LogInfo(msg='x')]\n",
        8,
        "returned list, not a LaunchDescription",
        "return LaunchDescription([...])",
    ),
    "None as an entry": (
        "    return LaunchDescription([\n        LogInfo(msg='first'),\n        None])\n",
        9,
        "entry 2 of 2 in LaunchDescription([...]) is not an action: None",
        "remove it",
    ),
    "None in a group in the description": (
        "    return LaunchDescription([\n        GroupAction([LogInfo(msg='x'),\n"
        "            None, LogInfo(msg='y')])])\n",
        9,
        "entry 2 of 3 in GroupAction([...]) is not an action: None",
        "remove it",
    ),
    "None that was added": (
        "    made = LaunchDescription()\n    made.add_action(None)\n    return made\n",
        7,
        "entry 1 of 1 in LaunchDescription([...]) is not an action: None",
        "remove it",
    ),
    "a list as an entry": (
        "    return LaunchDescription([\n        [LogInfo(msg='first')]])\n",
        8,
        "entry 1 of 1 in LaunchDescription([...]) is not an action: a list of actions",
        "write its actions without the inner brackets",
    ),
    "a text as an entry": (
        "    return LaunchDescription(['hello'])\n",
        7,
        "entry 1 of 1 in LaunchDescription([...]) is not an action: 'hello'",
        "LogInfo(msg=...) prints a text",
    ),
    "a class of events as an entry": (
        "    from launch.events import Shutdown\n    return LaunchDescription([Shutdown])\n",
        8,
        "is not an action: <class 'launch.events.shutdown.Shutdown'>",
        "take Shutdown from launch.actions",
    ),
    "a class of actions as an entry": (
        "    return LaunchDescription([LogInfo])\n",
        7,
        "is not an action: <class 'launch.actions.log_info.LogInfo'>",
        "LogInfo is a class: call it, as in LogInfo(...)",
    ),
    "one action instead of a list of them": (
        "    return LaunchDescription(LogInfo(msg='x'))\n",
        7,
        "LaunchDescription takes a list of actions, not a single LogInfo",
        "write LaunchDescription([LogInfo(...)])",
    ),
    "a function that returns an action": (
        "    def setup(context):\n        x = 1\n        return LogInfo(msg='x')\n"
        "    return LaunchDescription([OpaqueFunction(function=setup)])\n",
        9,
        "setup() did not return a list of actions: a LogInfo",
        "return [LogInfo(...)]",
    ),
    "a function that returns a text": (
        "    return LaunchDescription([OpaqueFunction(function=lambda context: 'hello')])\n",
        7,
        "<lambda>() did not return a list of actions: 'hello'",
        "return a list of actions",
    ),
    "a function that returns None among others": (
        "    def setup(context):\n        return [LogInfo(msg='x'), None]\n"
        "    return LaunchDescription([OpaqueFunction(function=setup)])\n",
        8,
        "entry 2 of 2 in what setup() returned is not an action: None",
        "remove it",
    ),
    "an event as what a process does at its end": (
        "    from launch.events import Shutdown\n    return LaunchDescription([\n"
        "        ExecuteProcess(cmd=['true'], on_exit=Shutdown())])\n",
        9,
        "expected a LaunchDescriptionEntity from event_handler, got '<launch.events.shutdown",
        "take Shutdown from launch.actions",
    ),
    "a handler's function that returns a text": (
        "    from launch.event_handlers import OnProcessExit\n"
        "    def ended(event, context):\n        return [LogInfo(msg='x'), 'text']\n"
        "    return LaunchDescription([ExecuteProcess(cmd=['true']),\n"
        "        RegisterEventHandler(OnProcessExit(on_exit=ended))])\n",
        9,
        "expected a LaunchDescriptionEntity from event_handler, got 'text'",
        "LogInfo(msg=...) prints a text",
    ),
    "no command": (
        "    return LaunchDescription([\n        ExecuteProcess(cmd=[])])\n",
        8,
        "a process has an empty command: cmd=[]",
        "cmd=['sleep', '5']",
    ),
    "loops": (
        "    def again(context):\n"
        "        return [OpaqueFunction(function=again)]\n"
        "    return LaunchDescription([OpaqueFunction(function=again)])\n",
        None,
        "includes itself, or recurses endlessly",
        None,
    ),
}


def planned(tmp_path: Path, text: str | bytes) -> Plan:
    file = tmp_path / "broken.launch.py"
    file.write_bytes(text if isinstance(text, bytes) else (HEAD + text).encode())
    return make_plan(str(file), [])


@pytest.mark.parametrize("name", BROKEN)
def test_a_fault_names_its_line_and_says_what_is_wrong(name: str, tmp_path: Path):
    text, line, message, hint = BROKEN[name]

    error = planned(tmp_path, text).error

    assert error is not None
    fault = error.fault
    assert fault.exit_code is ExitCode.USAGE
    assert message in fault.message
    if line is not None:
        assert fault.where == f"{tmp_path / 'broken.launch.py'}:{line}"
    assert hint is None or hint in str(fault.hint)


@pytest.mark.parametrize("name", sorted(set(BROKEN) - {"loops"}))
def test_the_caret_points_into_the_source_line(name: str, tmp_path: Path):
    error = planned(tmp_path, BROKEN[name][0]).error
    assert error is not None

    source, caret = error.fault.render().splitlines()[1:3] if error.fault.column else ("", "^")

    assert caret.strip() == "^"
    assert len(caret) <= max(len(source), 1)


def test_a_file_that_is_no_utf_8_is_a_fault_with_its_line(tmp_path: Path):
    error = planned(tmp_path, b'x = """\n\xff\xfe"""\n').error

    assert error is not None
    assert error.fault.message == "the byte 0xff is not UTF-8"
    assert str(error.fault.where).endswith(":2")


def test_a_binary_file_is_a_fault(tmp_path: Path):
    error = planned(tmp_path, b"\x7fELF\0\0").error

    assert error is not None
    where = tmp_path / "broken.launch.py"
    assert error.fault.render() == f"error: {where}: the launch file is not a text file"


def test_a_condition_that_is_no_truth_value_names_the_argument(tmp_path: Path):
    error = planned(
        tmp_path,
        "    from launch.conditions import IfCondition\n"
        "    return LaunchDescription([\n"
        "        DeclareLaunchArgument('debug', default_value='ja'),\n"
        "        LogInfo(msg='x', condition=IfCondition(LaunchConfiguration('debug')))])\n",
    ).error

    assert error is not None
    assert error.fault.message.endswith("but got 'ja'")
    where = tmp_path / "broken.launch.py"
    assert error.fault.hint == f"debug is 'ja', default at {where}:9; did you mean 'true'?"


def test_an_unknown_name_is_reported_with_the_existing_ones(tmp_path: Path):
    error = planned(tmp_path, b"from launch.actions import LogInf\n").error

    assert error is not None
    assert error.kind == "ImportError"
    assert "launch.actions.LogInf is not provided" in error.fault.message
    assert error.fault.hint == "did you mean LogInfo?"


def test_the_launch_file_is_named_also_when_its_helper_fails(tmp_path, monkeypatch):
    (tmp_path / "helper_of_mine.py").write_text("def build():\n    raise ValueError('no robot')\n")
    monkeypatch.syspath_prepend(str(tmp_path))

    error = planned(
        tmp_path, "    import helper_of_mine\n    return helper_of_mine.build()\n"
    ).error

    assert error is not None
    assert (error.kind, error.fault.message) == ("ValueError", "no robot")
    assert error.fault.where == f"{tmp_path / 'broken.launch.py'}:8"


def test_what_came_before_the_fault_is_in_the_plan(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    return LaunchDescription([LogInfo(msg='first'), Node(executable='x'),\n"
        "        LogInfo(msg=LaunchConfiguration('nope'))])\n",
    )

    assert [text for text, _ in plan.logs] == ["first"]
    assert [process.spec.label for process in plan.processes] == ["x"]
    assert plan.error is not None
    assert (plan.error.kind, plan.error.stage) == ("SubstitutionFailure", "run")


@pytest.mark.parametrize(
    ("entry", "kind"),
    [
        ("None", "AttributeError"),
        ("OpaqueFunction(function=lambda context: LogInfo(msg='x'))", "TypeError"),
        ("OpaqueFunction(function=lambda context: 'x')", "AttributeError"),
        ("ExecuteProcess(cmd=[])", "IndexError"),
    ],
)
def test_misplaced_values_raise_the_same_error_as_in_ros_2(entry, kind, tmp_path: Path):
    error = planned(tmp_path, f"    return LaunchDescription([{entry}])\n").error

    assert error is not None
    assert (error.kind, error.stage) == (kind, "run")


def test_a_generator_and_an_empty_text_are_lists_of_actions(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    def some(context):\n"
        "        yield LogInfo(msg='made')\n"
        "    return LaunchDescription([OpaqueFunction(function=some),\n"
        "        OpaqueFunction(function=lambda context: '')])\n",
    )

    assert (plan.error, [text for text, _ in plan.logs]) == (None, ["made"])


# ---- faults of the launcher


def failing(monkeypatch, error_of):
    from launcher.language.actions.event_actions import LogInfo

    monkeypatch.setattr(LogInfo, "execute", error_of)


# As code of the launcher, whatever file holds the test.
OWN = """
def index(self, context): return [][0]
def attribute(self, context): return None.visit
def deliberate(self, context): raise IndexError("bad value")
def in_library(self, context): import json; return json.loads(None)
def unpacked(self, context): a, b = (1,)
"""


def own_code() -> dict[str, Any]:
    import launcher

    code: dict[str, Any] = {}
    exec(compile(OWN, str(Path(launcher.__file__).parent / "x.py"), "exec"), code)
    return code


@pytest.mark.parametrize("name", ["index", "attribute", "in_library", "unpacked"])
def test_a_fault_of_the_launcher_says_so_and_asks_for_a_report(name, monkeypatch, tmp_path: Path):
    failing(monkeypatch, own_code()[name])

    error = planned(tmp_path, "    return LaunchDescription([\n        LogInfo(msg='x')])\n").error

    assert error is not None
    text = error.fault.render()
    assert text.startswith(f"error: {tmp_path / 'broken.launch.py'}:8: the launcher failed here: ")
    assert "launcher/x.py:" in text
    assert "not of the launch file; please report it with the traceback" in text
    assert error.fault.exit_code is ExitCode.PROCESS_FAILED


@pytest.mark.parametrize("name", ["deliberate"])
def test_what_the_launcher_raises_on_purpose_is_about_the_launch_file(name, monkeypatch, tmp_path):
    failing(monkeypatch, own_code()[name])

    error = planned(tmp_path, "    return LaunchDescription([\n        LogInfo(msg='x')])\n").error

    assert error is not None
    assert (error.fault.message, error.fault.exit_code) == ("IndexError: bad value", ExitCode.USAGE)


@pytest.mark.parametrize(
    "entry",
    [
        "DeclareLaunchArgument('x', choices=5)",
    ],
)
def test_a_value_of_a_wrong_type_that_nothing_checks_leaves_a_doubt(entry, tmp_path: Path):
    error = planned(tmp_path, f"    return LaunchDescription([{entry}])\n").error

    assert error is not None
    assert error.fault.exit_code is ExitCode.USAGE
    assert "if the values in this entry are right, please report it" in str(error.fault.hint)


def test_a_fault_of_the_launcher_in_an_xml_file_says_so(monkeypatch, tmp_path: Path):
    from launcher.language.actions.event_actions import LogInfo

    monkeypatch.setattr(LogInfo, "__init__", lambda self, **_: own_code()["index"](self, None))
    file = tmp_path / "x.launch.xml"
    file.write_text("<launch>\n  <log message='x'/>\n</launch>\n")

    error = make_plan(str(file), []).error

    assert error is not None
    assert error.fault.message.startswith("the launcher failed here: IndexError")
    assert error.fault.where == f"{file}:2"


def test_a_respawn_delay_that_is_no_number_is_a_warning(tmp_path: Path):
    entry = "Node(executable='x', respawn=True, respawn_delay='soon')"
    plan = planned(tmp_path, f"    return LaunchDescription([{entry}])\n")

    assert plan.error is None
    assert [w.text for w in plan.warnings] == [
        "respawn_delay 'soon' is not a number of seconds; using 0"
    ]


@pytest.mark.parametrize("entry", ["LogInfo(msg=Command(['']))"])
def test_an_empty_command_is_an_error_of_the_file(entry, tmp_path: Path):
    error = planned(tmp_path, f"    return LaunchDescription([{entry}])\n").error

    assert error is not None
    assert (error.kind, error.fault.exit_code) == ("IndexError", ExitCode.USAGE)
