"""Mistakes in a script that are found before the run starts."""

from __future__ import annotations

import json
from pathlib import Path

import geometry_msgs.msg
import pytest
import std_msgs.msg

from launcher.base.errors import UsageError
from launcher.language import frontends
from launcher.language.compat import vocabulary
from launcher.language.interpreter import Interpreter
from launcher.launch.launch_core import LaunchCore
from launcher.launch.plan.plan_certainty import is_certain
from launcher.launch.run_forecast import document
from launcher.launch.target import LaunchRequest
from launcher.launch.verbs import plan as planning
from launcher.run.requests.process_selection import ProcessNames
from launcher.smoke.expect.message_conditions import Conditions, Expression
from launcher.smoke.expect.script import Script
from launcher.smoke.preflight import script_checks
from launcher.smoke.preflight.forecast import Forecast, ForecastTime, compare
from launcher.smoke.preflight.loader import parse
from launcher.smoke.preflight.message_fields import fault_of_expression, faults_of_fields
from tests.smoke.unit.cases import expectation_of


def told(text: str) -> list[str]:
    return [error.render() for error in script_checks.of_script(parse(text, "x.yaml")).errors]


BAD = {
    "a message that is not there": (
        "expect: [{message: /a,\n type: std_msgs/msg/Strin}]",
        ("x.yaml:2: unknown type std_msgs/msg/Strin", "std_msgs/msg/String"),
    ),
    "a topic's type of an installed package": (
        "expect: [{topic: /a, type: std_msgs/msg/Strin}]",
        ("std_msgs/msg/Strin", "String"),
    ),
    "a package that is not installed": (
        "expect: [{rate: /a, is: 1 Hz, type: moon_base_msgs/msg/Crater}]",
        ("'moon_base_msgs' of moon_base", "pip install ros-moon-base-msgs"),
    ),
    "a misspelt package": (
        "expect: [{rate: /a, is: 1 Hz, type: std_msg/msg/String}]",
        ("'std_msg' of std_msg/msg/String is not installed", "did you mean std_msgs/msg/String?"),
    ),
    "a field in an expression": (
        "expect: [{message: /a, type: std_msgs/String,\n where: m.dat == 1}]",
        ("x.yaml:2: std_msgs/msg/String has no field 'dat'", "did you mean 'data'?"),
    ),
    "a field that another entry's type decides": (
        "expect: [{topic: /a, type: std_msgs/msg/Int32}, {rate: /a, is: 1 Hz, where: m.dat > 1}]",
        ("std_msgs/msg/Int32 has no field 'dat'",),
    ),
    "a field among the conditions": (
        "expect: [{message: /a, type: std_msgs/msg/Int32, fields: {\n dat: 1}}]",
        ("x.yaml:2: ", "has no field 'dat'", "did you mean 'data'?"),
    ),
    "a field of a request": (
        "expect: [{service: /a, type: std_srvs/srv/SetBool, request: {dat: true}}]",
        ("has no attribute 'dat'", "did you mean 'data'?"),
    ),
    "a field of a response": (
        "expect: [{service: /a, type: std_srvs/SetBool, fields: {succes: true}}]",
        ("the response of std_srvs/srv/SetBool has no field 'succes'", "did you mean 'success'?"),
    ),
    "a type to publish": (
        "scenario: [{do: 'publish /a std_msgs/msg/Strin {data: x}'}]",
        ("unknown type std_msgs/msg/Strin",),
    ),
    "a value to publish": (
        "scenario: [{do: 'publish /a std_msgs/msg/Int32 {data: x}'}]",
        ("'data' takes a whole number",),
    ),
    "a service to call": (
        "scenario: [{do: 'call /a std_srvs/srv/SetBoll {data: true}'}]",
        ("unknown type std_srvs/srv/SetBoll", "SetBool"),
    ),
    "a step after the end": (
        "for: 5 s\nscenario: [{at: 5 s, do: kill a}]",
        ("x.yaml:2: the system is observed for 5 s only, and 'kill a' comes after 5 s",),
    ),
    "a step after a step": (
        "for: 5 s\nscenario: [{at: 3 s, do: kill a, name: k}, {after: k, at: 3 s, do: start a}]",
        ("'start a' comes after 6 s",),
    ),
    "a step after a pause": (
        "for: 5 s\nscenario: [{at: 1, do: pause a for 4, name: p}, {after: 'p: over', do: stop b}]",
        ("'stop b' comes after 5 s",),
    ),
    "a window after the end": (
        "for: 5 s\nexpect: [{log: a, within: 6 to 8 s}]",
        ("and this is expected after 6 s at the earliest",),
    ),
    "chaos after the end": (
        "for: 5 s\nchaos: kill one of a every 5 s",
        ("'kill one of a every 5 s' starts later",),
    ),
}
GOOD = {
    "a type that only the system has": "expect: [{topic: /a, type: moon_base_msgs/msg/Crater}]",
    "JSON in a string": "expect: [{message: /a, type: std_msgs/String, where: json.robot_id == 1}]",
    "fields of JSON": "expect: [{message: /a, type: std_msgs/msg/String, fields: {robot_id: x}}]",
    "no type": "expect: [{message: /a, where: m.dat > 1}]",
    "two minds about a type": (
        "expect: [{topic: /a, type: std_msgs/msg/Int32}, {topic: /a, type: std_msgs/msg/Bool},"
        " {message: /a, where: m.x}]"
    ),
    "a feedback of an action": "expect: [{topic: /a, type: moon_msgs/action/Land_FeedbackMessage}]",
    "a step in time": "for: 5 s\nscenario: [{at: 4 s, do: kill a}]",
    "a step that waits for a line": "for: 5 s\nscenario: [{after_log: x, at: 4 s, do: kill a}]",
    "no end": "scenario: [{at: 50 s, do: kill a}]",
    "a window that begins in time": "for: 5 s\nexpect: [{log: a, within: 30 s}]",
    "a window after the stop": "for: 5 s\nexpect: [{log: a, after: stop, within: 1 to 9 s}]",
}


@pytest.mark.parametrize(("text", "words"), BAD.values(), ids=BAD)
def test_a_mistake_is_reported_with_its_place_and_a_suggestion(text: str, words: tuple[str, ...]):
    (error,) = told(text)
    assert all(word in error for word in words), error


@pytest.mark.parametrize("text", GOOD.values(), ids=GOOD)
def test_an_expectation_that_may_be_met_is_no_mistake(text: str):
    assert told(text) == []


def test_a_misspelt_package_of_a_type_that_is_only_compared_is_a_warning():
    script = parse("expect: [{topic: /a, type: std_msg/msg/String}]", "x.yaml")
    (warning,) = script_checks.of_script(script).warnings
    assert "x.yaml:1: " in warning and "did you mean std_msgs/msg/String?" in warning


def test_a_mistake_in_an_option_names_the_option():
    flag = expectation_of("--expect-message", "/a=m.dat == 1")
    kind = expectation_of("--expect-topic", "/a=std_msgs/String")
    (error,) = script_checks.of_script(Script(expectations=(flag, kind))).errors
    assert isinstance(error, UsageError)
    assert error.message.startswith("--expect-message /a=m.dat == 1: std_msgs/msg/String has no")


def test_mistakes_of_all_kinds_are_reported_at_once_in_order_of_their_lines():
    text = "for: 5 s\nexpect:\n- {message: /a, type: std_msgs/msg/Strin}\n- {nod: /b}\n"
    with pytest.raises(Exception) as raised:
        parse(text, "x.yaml")
    rendered = raised.value.render()
    assert 0 <= rendered.find("x.yaml:3: unknown type") < rendered.find("x.yaml:4: unknown")


# ---- shapes


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("m.poses[0].position.x > 0 and m.header.frame_id.startswith('m')", None),
        ("all(p.position.z > 0 for p in m.poses if p.orientation.w)", None),
        ("all(p.positon.z > 0 for p in m.poses)", "geometry_msgs/msg/Pose has no field 'positon'"),
        ("[p for p in m.poses if p.positon]", "geometry_msgs/msg/Pose has no field 'positon'"),
        ("{p.positon: p for p in m.poses}", "geometry_msgs/msg/Pose has no field 'positon'"),
        ("m.poses[1:][0].positon", "geometry_msgs/msg/Pose has no field 'positon'"),
        ("m['header'].stamp.sec > m.header.stamp.seconds", "Time has no field 'seconds'"),
        ("m.poses.x", "a list has no 'x'"),
        ("m.header.frame_id.x", "a string has no 'x'"),
        ("json.x", "has no string 'data' for JSON"),
        ("sorted(m.poses, key=lambda m: m.position.x)", None),
        ("[m for m in range(3) if m.x]", None),
        ("(n := m) and n.whatever", None),
        ("max(len(m.poses), 3).real", None),
    ],
)
def test_an_expression_is_followed_to_the_fields(text: str, fault: str | None):
    found = fault_of_expression(Expression.parse(text), geometry_msgs.msg.PoseArray)
    assert found is None if fault is None else found is not None and fault in found.message


@pytest.mark.parametrize(
    ("path", "fault"),
    [
        ("poses[0].position.x", None),
        ("poses[0].positon.x", "geometry_msgs/msg/Pose has no field 'positon'"),
        ("poses.position", "a list has no field 'position'"),
        ("header.frame_id[0]", "a string has no index [0]"),
    ],
)
def test_a_path_is_followed_to_the_field(path: str, fault: str | None):
    conditions = Conditions.parse({path: 1})
    found = [one.message for _, one in faults_of_fields(conditions, geometry_msgs.msg.PoseArray)]
    assert found == [] if fault is None else fault in found[0]
    assert not list(faults_of_fields(conditions, std_msgs.msg.String))  # it may be JSON


# ---- processes


PROCESSES = (
    ProcessNames("patient-1", "patient"),
    ProcessNames("robot_2-2", "robot_2", ("/fleet/robot_2",), "/"),
)
MEANT = "[{do: kill patient}, {do: stop robot_2-7}, {do: start /fleet/robot_2}, {do: pause rob*}]"


@pytest.mark.parametrize(
    "text",
    [
        f"scenario: {MEANT}",
        "expect: [{log: x, process: launch}, {log: x}, {no_errors: '*'}, {memory: r*, below: 1}]",
        "chaos: kill one of robot_* every 1 s",
    ],
)
def test_a_process_that_is_planned_is_known(text: str):
    found = compare(parse(text, "x.yaml"), Forecast(processes=PROCESSES, is_certain=True))
    assert (found.errors, found.warnings) == ((), ())


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("scenario: [{at: 1 s, do: kill\n patent}]", "x.yaml:1: "),
        ("scenario: [{do: kill patient, after_log: x,\n process: patent}]", "x.yaml:2: "),
        ("expect: [{log: x,\n process: patent}]", "x.yaml:2: "),
        ("expect: [{no_errors: patent}]", "x.yaml:1: "),
        ("chaos: kill one of patent every 1 s", "chaos 'kill one of patent every 1 s': "),
    ],
)
def test_a_process_that_is_not_planned_is_refused_if_the_plan_is_certain(text: str, place: str):
    script = parse(text, "x.yaml")
    (error,) = compare(script, Forecast(processes=PROCESSES, is_certain=True)).errors
    assert f"{place}the launch file starts no process 'patent'" in error.render()
    assert error.hint == "did you mean 'patient'?"
    perhaps = compare(script, Forecast(processes=PROCESSES, is_certain=False))
    assert perhaps.errors == () and "did you mean 'patient'?" in perhaps.warnings[0]


LAUNCH = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess, OpaqueFunction, RegisterEventHandler, TimerAction
from launch.event_handlers import OnProcessExit, OnProcessIO

def generate_launch_description():
    one = ExecuteProcess(cmd=["true"], name="one")
    two = ExecuteProcess(cmd=["true"], name="two")
    look = OpaqueFunction(function=lambda context: [])
    return LaunchDescription([one, {more}])
"""


@pytest.mark.parametrize(
    ("more", "certain"),
    [
        ("", True),
        ("TimerAction(period=5.0, actions=[look])", True),
        ("RegisterEventHandler(OnProcessExit(target_action=one, on_exit=[two]))", True),
        (
            "RegisterEventHandler(OnProcessExit(target_action=one, on_exit=["
            "TimerAction(period=5.0, actions=[two])]))",
            True,
        ),
        ("RegisterEventHandler(OnProcessIO(target_action=one, on_stdout=lambda e: None))", False),
        ("RegisterEventHandler(OnProcessExit(on_exit=lambda event, context: None))", False),
        ("RegisterEventHandler(OnProcessExit(target_action=one, on_exit=[look]))", False),
        ("ExecuteProcess(cmd=['true'], on_exit=lambda event, context: None)", False),
    ],
)
def test_a_plan_is_certain_unless_functions_receive_events(
    tmp_path: Path, more: str, certain: bool
):
    path = tmp_path / "x.launch.py"
    path.write_text(LAUNCH.replace("{more}", more), encoding="utf-8")
    plan = planning.evaluate(LaunchRequest(str(path)))
    assert plan.error is None
    assert is_certain(plan) is certain


UNCERTAIN = [
    "TimerAction(period=5.0, actions=[look])",
    "RegisterEventHandler(OnProcessIO(target_action=one, on_stdout=lambda e: None))",
    "RegisterEventHandler(OnProcessExit(on_exit=lambda event, context: None))",
    "RegisterEventHandler(OnProcessExit(target_action=one, on_exit=[TimerAction("
    "period=1.0, actions=[look])]))",
    "ExecuteProcess(cmd=['true'], on_exit=lambda event, context: None)",
    "OpaqueFunction(function=lambda context: context.asyncio_loop.call_later(9, print) and None)",
    "TimerAction(period=1.0, actions=[type('Own', (OpaqueFunction,), {})(function=print)])",
]
CERTAIN = [
    "look",
    "OpaqueFunction(function=lambda context: [TimerAction(period=1.0, actions=[two])])",
    "TimerAction(period=5.0, actions=[two])",
    "RegisterEventHandler(OnProcessExit(target_action=one, on_exit=[two]))",
    "ExecuteProcess(cmd=['true'], cached_output=True, on_exit=[two])",
]


@pytest.mark.parametrize("more", [*UNCERTAIN, *CERTAIN])
def test_a_forecast_is_certain_unless_functions_are_called_later(tmp_path: Path, more: str):
    path = tmp_path / "x.launch.py"
    path.write_text(LAUNCH.replace("{more}", more), encoding="utf-8")
    foreseen = forecast_of(path)
    assert foreseen.is_certain is (more in CERTAIN)
    assert foreseen.starts("two") is ("two" in more)


MOMENTS = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess, RegisterEventHandler, TimerAction
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit, OnProcessStart

def process(name, when="true"):
    return ExecuteProcess(cmd=["true"], name=name, condition=IfCondition(when))

def generate_launch_description():
    one = process("one")
    then = [process("two"), TimerAction(period=9.0, actions=[process("three")])]
    return LaunchDescription([
        one,
        process("never", "false"),
        TimerAction(period=5.0, actions=[process("late"), process("perhaps", "false")]),
        RegisterEventHandler(OnProcessExit(target_action=one, on_exit=then)),
        RegisterEventHandler(OnProcessExit(target_action=one, on_exit=[process("x", "false")])),
        RegisterEventHandler(OnProcessStart(target_action=one, on_start=[process("y", "false")])),
    ])
"""


def forecast_of(path: Path) -> Forecast:
    """What a launcher would say, when it has evaluated the launch file."""
    with vocabulary([str(path)]):
        description = frontends.load(str(path))
        interpreter = Interpreter(description, path=str(path))
        core = LaunchCore(interpreter, description, LaunchRequest(str(path)))
        core.evaluate()
        found = json.loads(json.dumps(document(core)))
        interpreter.close()
    return Forecast.of(found)


def test_a_forecast_says_when_processes_are_started_and_conditions_are_evaluated(tmp_path: Path):
    path = tmp_path / "x.launch.py"
    path.write_text(MOMENTS, encoding="utf-8")
    foreseen = forecast_of(path)
    moments = {
        process.label: moment
        for process, moment in zip(foreseen.processes, foreseen.moments, strict=True)
    }
    assert moments == {
        "one": ForecastTime(time_s=0.0),
        "late": ForecastTime(time_s=5.0),
        "two": ForecastTime(cause="one"),
        "three": ForecastTime(),  # some time after an exit
    }
    assert set(foreseen.conditions) == {
        ForecastTime(time_s=5.0),
        ForecastTime(cause="one"),
        ForecastTime(),
    }
