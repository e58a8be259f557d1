"""The plan: virtual time, visits, settings, and known argument names."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.language.configurations import ALL_NAMES
from launcher.language.interpreter.trace import Visit
from launcher.launch.plan.plan import Plan
from launcher.launch.plan.planner import make_plan

HEAD = (
    "from launch import LaunchDescription\n"
    "from launch.actions import *\n"
    "from launch.conditions import *\n"
    "from launch.event_handlers import *\n"
    "from launch.substitutions import *\n"
    "from launch_ros.actions import Node\n"
    "def generate_launch_description():\n"
)


def planned(tmp_path: Path, body: str, **arguments: str) -> Plan:
    file = tmp_path / "some.launch.py"
    file.write_text(HEAD + body)
    plan = make_plan(str(file), list(arguments.items()))
    assert plan.error is None, plan.error
    return plan


def visits(plan: Plan) -> list[Visit]:
    return [visit for root in plan.visits for visit in root.walk()]


def test_time_is_virtual_and_timers_add_up(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    late = TimerAction(period=1000.5, actions=[Node(executable='late')])\n"
        "    return LaunchDescription([TimerAction(period=2.0, actions=[late])])\n",
    )

    assert [process.stamp.time_s for process in plan.processes] == [1002.5]


def test_what_is_planned_after_an_hour_is_left_out(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    def again(context):\n"
        "        return [LogInfo(msg='x'), TimerAction(period=1000.0, actions=[\n"
        "            OpaqueFunction(function=again)])]\n"
        "    return LaunchDescription([OpaqueFunction(function=again)])\n",
    )

    assert len(plan.logs) == 4


def test_a_cancelled_timer_takes_no_time(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    timer = TimerAction(period=50.0, actions=[])\n"
        "    stop = OpaqueFunction(function=lambda context: timer.cancel())\n"
        "    p = ExecuteProcess(cmd=['p'], on_exit=[LogInfo(msg='end')])\n"
        "    return LaunchDescription([timer, stop, p])\n",
    )

    assert [(stamp.time_s, stamp.phase, stamp.cause) for _, stamp in plan.logs] == [
        (0.0, "exit", 0)
    ]


def test_a_timer_that_outlives_the_shutdown_is_planned_after_it(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    return LaunchDescription([\n"
        "        TimerAction(period=2.0, cancel_on_shutdown=False,"
        " actions=[LogInfo(msg='kept')]),\n"
        "        TimerAction(period=3.0, actions=[LogInfo(msg='cancelled')]),\n"
        "        TimerAction(period=1.0, actions=[Shutdown()]),\n    ])\n",
    )

    assert [(text, stamp.time_s) for text, stamp in plan.logs] == [("kept", 2.0)]


def test_a_respawned_process_starts_again_after_its_delay_and_ends_no_more(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    p = Node(executable='p', respawn=True, respawn_delay=4.0)\n"
        "    return LaunchDescription([p, RegisterEventHandler(OnProcessStart(\n"
        "        target_action=p, on_start=[LogInfo(msg='start')]))])\n",
    )

    assert [(stamp.time_s, stamp.phase) for _, stamp in plan.logs] == [(0.0, "run"), (4.0, "exit")]
    assert len(plan.processes) == 1


def test_visits_form_a_tree_with_the_skipped_and_the_started(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    return LaunchDescription([GroupAction([\n"
        "        Node(executable='a'),\n"
        "        Node(executable='b', condition=IfCondition('false'))], scoped=False)])\n",
    )

    nodes = [visit for visit in visits(plan) if type(visit.entity).__name__ == "Node"]
    assert [(visit.skipped, visit.processes) for visit in nodes] == [(False, [0]), (True, [])]
    parents = {type(visit.parent.entity).__name__ for visit in nodes if visit.parent}
    assert parents == {"GroupAction"}


def test_settings_say_where_each_value_came_from(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    return LaunchDescription([\n"
        "        DeclareLaunchArgument('a', default_value='1'),\n"
        "        DeclareLaunchArgument('b', default_value='2')])\n",
        a="given",
    )

    settings = [setting for visit in visits(plan) for setting in visit.settings]
    origins = {it.name: (it.value, it.origin and it.origin.line) for it in settings}
    assert origins == {"a": ("given", None), "b": ("2", 10)}


def test_names_are_known_that_are_declared_or_read_at_run_time_too(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    def more(context):\n"
        "        context.launch_configurations.get('looked_at')\n"
        "        return [DeclareLaunchArgument('late', default_value='')]\n"
        "    return LaunchDescription([\n"
        "        DeclareLaunchArgument('early', default_value=''),\n"
        "        LogInfo(msg=LaunchConfiguration('read', default='')),\n"
        "        OpaqueFunction(function=more)])\n",
    )

    assert {"early", "late", "looked_at", "read", "sigterm_timeout"} <= plan.known_names
    assert "unheard_of" not in plan.known_names
    assert ALL_NAMES not in plan.known_names


def test_a_file_that_looks_at_all_configurations_knows_every_name(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    look = OpaqueFunction(function=lambda context: [\n"
        "        LogInfo(msg=str(dict(context.launch_configurations)))])\n"
        "    return LaunchDescription([look])\n",
        anything="1",
    )

    assert ALL_NAMES in plan.known_names


def test_what_launch_files_print_does_not_end_up_on_standard_output(tmp_path: Path, capsys):
    planned(tmp_path, "    print('hello')\n    return LaunchDescription([])\n")

    assert capsys.readouterr() == ("", "hello\n")


@pytest.mark.parametrize(
    ("text", "waits_s", "says"),
    [
        ("nan", 5.0, "is not a number of seconds; using 5"),
        ("inf", 5.0, "is not a number of seconds; using 5"),
        ("x", 5.0, "is not a number of seconds; using 5"),
        ("", 5.0, "is not a number of seconds; using 5"),
        ("-1", 0.0, "is negative; using 0"),
    ],
)
def test_an_invalid_timeout_is_reported_once_and_ends_the_run(text, waits_s, says, tmp_path: Path):
    two = "    return LaunchDescription([Node(executable='a'), Node(executable='b')])\n"

    for name, at in (("sigterm_timeout", 0), ("sigkill_timeout", 1)):
        plan = planned(tmp_path, two, **{name: text})

        assert [one.spec.stop.steps[at][1] for one in plan.processes] == [waits_s] * 2
        assert [one.text for one in plan.warnings] == [f"{name} '{text}' {says}"]


def test_a_bad_timeout_of_one_process_is_reported_with_its_line(tmp_path: Path):
    plan = planned(
        tmp_path,
        "    return LaunchDescription([\n        Node(executable='a', sigterm_timeout='soon')])\n",
    )

    (warning,) = plan.warnings
    assert warning.text.startswith("sigterm_timeout 'soon' is not a number")
    assert warning.origin is not None
    assert warning.origin.line == 9
