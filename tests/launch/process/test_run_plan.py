"""`plan.json` of a run: the same document as `plan --json`, of what really happened."""

from __future__ import annotations

import json
import re
import subprocess
from typing import Any

from tests.support.benches import Bench, Workspace
from tests.support.supervising import events

RICH = """
    DeclareLaunchArgument("speed", default_value="3", description="how fast"),
    DeclareLaunchArgument("side", default_value="left", choices=["left", "right"]),
    LogInfo(msg=["speed ", LaunchConfiguration("speed")]),
    ExecuteProcess(cmd=["echo", LaunchConfiguration("speed")], output="screen",
                   additional_env={"EXTRA": "1"}, cwd="/", respawn=False),
    ExecuteProcess(cmd=["true"], condition=IfCondition("false")),
    __import__("launch_ros.actions").actions.Node(
        executable="/bin/true", name="porter", namespace="fleet", remappings=[("a", "b")],
        parameters=[{"depth": 5, "names": ["x", "y"]}]),
"""


def run_plan(workspace: Workspace, *words: object) -> dict[str, Any]:
    done = workspace.call(*words)
    assert done.returncode == 0, done.stderr
    return json.loads((workspace.folder / "log" / "latest" / "plan.json").read_text())


def timeless(document: dict[str, Any]) -> dict[str, Any]:
    return {
        key: [{k: v for k, v in entry.items() if k != "time"} for entry in value]
        if key in ("processes", "logs", "loads", "lifecycle")
        else value
        for key, value in document.items()
        if key != "shutdowns"
    }


def test_the_plan_of_a_run_is_the_plan_that_was_made_beforehand(workspace: Workspace):
    file = workspace.write(RICH)
    done, planned = run_plan(workspace, file, "speed:=9"), workspace.document(file, "speed:=9")
    assert timeless(done) == timeless(planned)
    assert [list(entry) for entry in done["processes"]] == [
        list(entry) for entry in planned["processes"]
    ]
    assert done["processes"][0]["time"] == 0.0
    assert done["declared"] == {"speed": "9", "side": "left"}


def test_functions_of_the_launch_file_are_evaluated_once(workspace: Workspace):
    count = "lambda context: open('evaluated', 'a').write('once ') and None"
    run_plan(workspace, workspace.write(f"OpaqueFunction(function={count}),"))
    assert (workspace.folder / "evaluated").read_text() == "once "


def test_actions_of_an_exit_handler_name_the_process_that_exited(workspace: Workspace):
    follows = "ExecuteProcess(cmd=['echo', 'after'])"
    file = workspace.write(
        f"""
        *(lambda first: [first, RegisterEventHandler(
            __import__("launch.event_handlers").event_handlers.OnProcessExit(
                target_action=first, on_exit=[{follows}]))])(ExecuteProcess(cmd=["sleep", "0.3"])),
        """
    )
    document = run_plan(workspace, file)
    first = next(p for p in document["processes"] if p["cmd"][0] == "sleep")
    after = next(p for p in document["processes"] if p["cmd"] == ["echo", "after"])
    assert (first["phase"], first["cause"]) == ("run", None)
    assert after["phase"] == "exit"
    assert after["cause"] == document["processes"].index(first)
    assert after["time"] >= 0.3
    assert (first["since_cause"], after["since_cause"]) == (None, 0.0)
    assert [shutdown["reason"] for shutdown in document["shutdowns"]] == ["idle"]


def test_what_a_handler_raises_is_the_error_of_the_plan(workspace: Workspace):
    file = workspace.write(
        "TimerAction(period=0.2, actions=[OpaqueFunction(function=lambda context: 1 / 0)]),"
    )
    assert workspace.call(file).returncode == 1
    document = json.loads((workspace.folder / "log" / "latest" / "plan.json").read_text())
    assert document["error"]["type"] == "ZeroDivisionError"


def test_names_in_a_plan_are_those_of_the_run(bench: Bench):
    actions = """
        quick := sh("exit 0", name="quick"), sh("exit 0", name="other"),
        RegisterEventHandler(OnProcessExit(target_action=quick, on_exit=[
            sh("exit 0", name="second"),
            TimerAction(period=0.1, actions=[sh("exit 0", name="third")])])),
        TimerAction(period=0.5, actions=[
            late := sh("exit 0", name="late"), sh("exit 0", name="with_late")]),
        RegisterEventHandler(OnProcessExit(target_action=late, on_exit=[
            sh("exit 0", name="last")])),"""
    command = bench.command(actions)
    plan = [*command[:3], "plan", *command[3:]]
    tree = subprocess.run(plan, env=bench.env, capture_output=True, text=True, check=True).stdout
    names = re.findall(r"^[│├└─ ]*── ([a-z_]+(?:-\d+)?)  ", tree, re.M)
    bench.run(actions)
    started = [event["process"] for event in events(bench) if event["event"] == "started"]
    labels = ["quick", "other", "second", "third", "late", "with_late", "last"]
    assert [name.partition("-")[0] for name in names] == labels
    assert {name for name in names if "-" in name} <= {*started}
    assert [name for name in names if "-" in name] == ["quick-1", "other-2"]
    assert len(started) == len(labels)
