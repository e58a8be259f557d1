"""`plan --hosts`: where each process of a launch file runs, and what runs there."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.cli.dispatch import main

HEAD = """\
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, PushRosNamespace


def node(name, **more):
    return Node(package="group_gp1", executable="robot_1", name=name, **more)


def generate_launch_description():
    return LaunchDescription([
"""
HOSTS = """\
hosts:
  bot1: {address: 10.0.0.2, python: .venv/bin/python,
         environment: {TOKEN: {from_environment: FLEET_TOKEN}}}
  bot2: {address: 10.0.0.3, ros: /opt/ros/jazzy, environment: {PLAIN: s3cret}}
place:
"""
Plan = Callable[..., tuple[int, str, str]]


@pytest.fixture
def plan(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Plan:
    """(exit code, output, errors) of `plan --hosts` with these actions and rules."""
    monkeypatch.chdir(tmp_path)

    def run(actions: str, rules: str, *words: str, more: str = "") -> tuple[int, str, str]:
        body = textwrap.indent(textwrap.dedent(actions), "        ")
        Path("a.launch.py").write_text(f"{HEAD}{body}\n    ])\n")
        places = textwrap.indent(textwrap.dedent(rules), "  ")
        Path("hosts.yaml").write_text(f"{HOSTS}{places}\n{more}")
        code = main(["plan", "a.launch.py", "--hosts", "hosts.yaml", *words])
        output, errors = capfd.readouterr()
        return code, output, errors

    return run


def lines_with(text: str, output: str) -> list[str]:
    return [line.strip(" │├└─") for line in output.splitlines() if text in line]


def test_a_skipped_host_is_shown(plan: Plan):
    actions = 'node("one"), node("two"),'
    places = "one: bot1\ntwo: bot2"

    code, output, _ = plan(actions, places, "--skip-host", "bot[2-9]")
    assert code == 0
    found = [line.split(", on ")[1].split(",")[0] for line in lines_with(", on ", output)]
    assert found == ["bot1", "bot2 (skipped)"]
    _, output, _ = plan(actions, places, "--skip-host", "bot2", "--json")
    shown = [(p["host"], p["skipped"]) for p in json.loads(output)["processes"]]
    assert shown == [("bot1", False), ("bot2", True)]


@pytest.mark.parametrize(
    ("words", "more", "message"),
    [
        (["--skip-host", "bot3"], "", "no host 'bot3' in hosts.yaml"),
        (["--skip-host", "robot*"], "", "no host 'robot*' in hosts.yaml"),
        (
            ["--skip-host", "bot1"],
            "discovery: {mode: server, server: bot1}",
            "the discovery server runs on 'bot1'",
        ),
    ],
)
def test_a_host_that_cannot_be_skipped_is_an_error(
    plan: Plan, words: list[str], more: str, message: str
):
    code, _, errors = plan('node("one"),', "one: bot1", *words, more=more)

    assert code == 2
    assert f"--skip-host: {message}" in errors
    assert "hint: " in errors


def test_a_backup_server_may_be_skipped(plan: Plan):
    discovery = "discovery: {mode: server, server: bot1, backup: bot2}"
    code, output, _ = plan('node("one"),', "one: bot1", "--skip-host", "bot2", more=discovery)

    assert code == 0
    assert "no backup of the discovery server: 'bot2' is skipped" in output


def test_each_process_shows_its_host_and_what_runs_there(plan: Plan):
    actions = 'node("one"), node("two", parameters=[{"speed": 2}]), node("three"),'

    code, output, _ = plan(actions, "one: bot1\ntwo: bot2")

    assert code == 0
    assert [line.split(", on ")[1].split(",")[0] for line in lines_with(", on ", output)] == [
        "bot1",
        "bot2",
        "local",
    ]
    assert lines_with("__node:=one", output) == [
        "$ .venv/bin/python -m launcher run group_gp1 robot_1 --ros-args -r __node:=one"
    ]
    assert lines_with("__node:=two", output) == [
        "$ . /opt/ros/jazzy/setup.sh && <python> -m launcher run group_gp1 robot_1 --ros-args "
        "-r __node:=two --params-file <files>/params.yaml"
    ]
    assert lines_with("speed: ", output) == ["speed: 2"]


def test_values_of_the_hosts_file_are_not_shown(plan: Plan, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ROS_SECRET_THING", "s3cret")
    rules = "one: bot1\ntwo: bot2"

    for words in ((), ("--json",)):
        _, output, errors = plan('node("one"), node("two"),', rules, *words)

        assert "s3cret" not in output + errors
        assert all(name in output for name in ("TOKEN", "PLAIN", "ROS_SECRET_THING"))


def test_variables_that_the_launch_file_sets_are_shown(plan: Plan):
    actions = 'SetEnvironmentVariable("LEVEL", "3"), node("one", additional_env={"A": "b c"}),'

    _, output, _ = plan(actions, "one: bot1")

    (line,) = lines_with("__node:=one", output)
    assert line.startswith("$ env A='b c' LEVEL=3 .venv/bin/python -m launcher run")


def test_the_document_has_the_host_of_each_process(plan: Plan):
    _, output, _ = plan('node("one"), node("two"),', "two: bot2", "--json")

    one, two = json.loads(output)["processes"]
    assert (one["host"], one["on_host"]) == ("local", None)
    assert two["host"] == "bot2"
    there = two["on_host"]
    assert there["cmd"][:4] == ["<python>", "-m", "launcher", "run"]
    assert there["setup"] == ["/opt/ros/jazzy/setup.sh"]
    assert "PLAIN" in there["env_names"]


SERVER = "discovery: {mode: server, server: bot1, backup: local}"


@pytest.mark.parametrize(
    ("more", "words", "mode", "text"),
    [
        (SERVER, (), "server", "discovery-server on bot1, discovery-backup on local"),
        ("", ("--discovery", "server"), "server", "discovery-server on local"),
        (SERVER, ("--discovery", "peers"), "peers", "ROS_STATIC_PEERS"),
        (SERVER, ("--discovery=multicast",), "multicast", "ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET"),
    ],
)
def test_discovery_is_shown(plan: Plan, more: str, words: tuple[str, ...], mode: str, text: str):
    _, output, _ = plan('node("one"),', "one: bot1", *words, more=more)
    (line,) = lines_with("discovery by", output)
    assert f"discovery by {mode}" in line
    assert text in line

    _, output, _ = plan('node("one"),', "one: bot1", *words, "--json", more=more)
    assert json.loads(output)["discovery"]["mode"] == mode


def test_without_hosts_the_document_has_no_hosts(
    plan: Plan, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    plan('node("one"),', "one: bot1")

    assert main(["plan", "a.launch.py", "--json"]) == 0
    (process,) = json.loads(capfd.readouterr().out)["processes"]
    assert not {"host", "on_host"} & process.keys()


def test_groups_and_includes_are_named_with_what_starts_in_them_later(plan: Plan):
    Path("b.launch.py").write_text(f'{HEAD}        node("inner"),\n    ])\n')
    actions = """
        GroupAction([
            PushRosNamespace("left"),
            TimerAction(period=2.0, actions=[ExecuteProcess(cmd=["sleep", "1"], name="late")]),
            node("first", on_exit=[ExecuteProcess(cmd=["true"], name="after")]),
            IncludeLaunchDescription("b.launch.py"),
        ]),
        ExecuteProcess(cmd=["true"], name="outside"),
    """

    code, output, errors = plan(actions, "group:/left: bot1\ninclude:b.launch.py: bot2")

    assert (code, errors) == (0, "")
    lines = [*lines_with(", on ", output), *lines_with("  on ", output)]
    hosts = {line.split("  ")[0].split("-")[0]: line for line in lines}
    where = {name: line.split("on ")[1].split(",")[0] for name, line in hosts.items()}
    assert where.pop("outside") == "local"
    assert {where[name] for name in ("late", "after")} == {"bot1"}
    assert [line.split(", on ")[1][:4] for line in lines_with("/left/", output)] == ["bot1", "bot2"]


def test_what_conditions_keep_away_is_found_in_groups_and_includes(plan: Plan):
    argument = 'DeclareLaunchArgument("name"), node(LaunchConfiguration("name")),'
    Path("b.launch.py").write_text(f"{HEAD}        {argument}\n    ])\n")
    actions = """
        node("one"),
        node("two", condition=IfCondition("false")),
        GroupAction([
            PushRosNamespace("far"),
            IncludeLaunchDescription("b.launch.py", launch_arguments=[("name", "three")]),
        ], condition=IfCondition("false")),
    """
    rules = "one: bot1\ntwo: bot2\n/far/three: bot2\ngroup:/far: bot2\ninclude:b.launch.py: bot2"

    code, output, errors = plan(actions, rules)

    assert (code, errors) == (0, "")
    notes = lines_with("note: ", output)
    assert [line.split("'")[1] for line in notes] == [
        "two",
        "/far/three",
        "group:/far",
        "include:b.launch.py",
    ]
    assert "keeps away: /far/three at" in notes[1]


def test_commands_of_what_is_switched_off_are_not_executed(plan: Plan):
    actions = """
        node("one"),
        node([__import__("launch").substitutions.Command("touch executed")],
             condition=IfCondition("false")),
    """

    code, output, _ = plan(actions, "one: bot1\nother: bot2")

    assert code == 0
    assert not Path("executed").exists()
    assert "warning: hosts.yaml:7: 'other' matches nothing that can be foreseen" in output


def test_all_mistakes_are_told_at_once_with_the_exit_code_of_usage(plan: Plan):
    Path("map.pgm").write_bytes(b"0" * (2 * 1024**2))
    actions = 'node("one", arguments=[__file__[:-11] + "map.pgm"]), node("two"),'
    rules = "one: bot1\nthree: bot2\n'tw*': bot1\npackage:group_gp1: bot2\n"

    code, _, errors = plan(actions, rules)

    assert code == 2
    assert errors.count("error: ") == 3
    assert "hosts.yaml:7: 'three' matches no process" in errors
    assert "two hosts for robot_1-2" in errors
    assert "more than 1 MiB are not sent" in errors and "a.launch.py:9" in errors


def test_a_wrong_file_is_told_before_anything_is_evaluated(plan: Plan):
    code, output, errors = plan('open("evaluated", "w"),', "one: bot7")

    assert (code, output) == (2, "")
    assert errors == (
        "error: hosts.yaml:6: unknown host 'bot7'\n"
        "      one: bot7\n"
        "           ^\n"
        "hint: known: bot1, bot2, local\n"
    )
    assert not Path("evaluated").exists()


def test_warnings_about_what_cannot_be_sent_name_the_place(plan: Plan, tmp_path: Path):
    actions = 'ExecuteProcess(cmd=["ls", __file__[:-11]], name="one", cwd=__file__[:-12]),'

    code, output, _ = plan(actions, "one: bot1\n'**': bot2")

    assert code == 0
    assert "a.launch.py:14: one-1: the folder is not sent" in output
    assert "a.launch.py:14: one-1: the working directory must be there" in output
