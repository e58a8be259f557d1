"""`plan` and `args` as a person or a program calls them. Nothing is ever started."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence

import pytest

from tests.support.benches import TIMEOUT_S, Workspace
from tests.support.variations import few_of


def commands(document: dict) -> Sequence[Sequence[str]]:
    return [process["cmd"] for process in document["processes"]]


def test_a_plan_starts_nothing_and_writes_no_log(workspace: Workspace):
    done = workspace.call("plan", workspace.write(""))
    assert done.returncode == 0
    assert f"$ touch {workspace.started}" in done.stdout
    assert not workspace.started.exists()
    assert not (workspace.folder / "log").exists()


def test_paths_are_shown_without_dots(workspace: Workspace):
    (workspace.folder / "sub").mkdir()
    below = workspace.write("").rename(workspace.folder / "below.launch.py")
    include = f'IncludeLaunchDescription("{workspace.folder}/sub/../{below.name}"),'
    file = workspace.write(include)
    done = workspace.call("plan", f"{workspace.folder}/sub/../{file.name}")
    assert "below.launch.py:10" in done.stdout and "/../" not in done.stdout
    missing = workspace.call("plan", f"{workspace.folder}/sub/../no.launch.py")
    assert "no.launch.py' not found" in missing.stderr and "/../" not in missing.stderr


def test_the_document_is_all_that_is_on_standard_output(workspace: Workspace):
    file = workspace.write(
        """
        LogInfo(msg=Command("sh -c 'echo from a command'")),
        OpaqueFunction(function=lambda context: print("printed")),
        OpaqueFunction(function=lambda context: subprocess.run(["echo", "by a child"]) and None),
        OpaqueFunction(function=lambda context: os.write(1, b"by descriptor") and None),
        """
    )
    done = workspace.call("plan", "--json", file)
    document = json.loads(done.stdout)
    assert document["logs"][0]["message"] == "from a command\n"
    for text in ("printed", "by a child", "by descriptor"):
        assert text in done.stderr


UNLIKE = """
DeclareLaunchArgument("a", default_value="no"),
*[LogInfo(msg="m", condition=IfCondition(value)) for value in (
    EqualsSubstitution(LaunchConfiguration("a"), "yes"),
    NotEqualsSubstitution("b", ["b", ""]),
    AndSubstitution(LaunchConfiguration("a"), OrSubstitution("false", "no")),
    NotSubstitution("true"),
    AnySubstitution("false", LaunchConfiguration("a")),
    IfElseSubstitution(NotSubstitution("true"), "1", "0"),
    EqualsSubstitution(PathJoinSubstitution(["x", LaunchConfiguration("a")]), "y"),
    type("Mute", (Substitution,), {"describe": lambda self: "", "perform": lambda *_: "0"})(),
)],
LogInfo(msg="m", condition=Condition(predicate=lambda context: False)),
IncludeLaunchDescription("/no/b.launch.py", condition=IfCondition("0")),
IncludeLaunchDescription(["/no/", LaunchConfiguration("a")], condition=IfCondition("0")),
SetEnvironmentVariable("B", EqualsSubstitution(LaunchConfiguration("a"), "b")),
Node(executable="x", name=EqualsSubstitution("a", "b"), parameters=[{"b": [1, 2]}]),
"""
UNLIKE_XML = """<launch>
<log message="m" if="$(equals $(env HOME) $(and true false))"/>
<include file="$(dirname)/b.launch.py" if="$(not true)"/>
<shutdown reason="because $(env HOME)" unless="$(or true 1)"/>
<timer period="1"><shutdown reason="of $(env HOME)"/></timer>
</launch>
"""


@pytest.mark.parametrize("kind", ["py", pytest.param("xml", marks=pytest.mark.thorough)])
def test_a_plan_is_the_same_in_every_process(workspace: Workspace, kind: str):
    more = "from launch import Condition, Substitution; from launch_ros.actions import Node"
    workspace.HEAD = f"{more}{Workspace.HEAD}"
    file = workspace.write(UNLIKE)
    if kind == "xml":
        file = file.with_suffix(".xml")
        file.write_text(UNLIKE_XML)
    for words in [(), ("--json",)]:
        seeds = ("1", "2", "3")
        plans = [workspace.call("plan", file, *words, PYTHONHASHSEED=seed) for seed in seeds]
        assert len({one.stdout for one in plans}) == 1
        assert "object at" not in plans[0].stdout + plans[0].stderr
        assert plans[0].returncode == 0


def test_a_failing_file_gives_a_document_with_the_error_and_exit_code_0(workspace: Workspace):
    file = workspace.write('LogInfo(msg="before"), LogInfo(msg=LaunchConfiguration("nope")),')
    document = workspace.document(file)
    assert document["error"]["type"] == "SubstitutionFailure"
    assert [log["message"] for log in document["logs"]] == ["before"]


def test_a_failing_file_gives_its_tree_then_the_error_and_exit_code_2(workspace: Workspace):
    done = workspace.call("plan", workspace.write('LogInfo(msg=LaunchConfiguration("nope")),'))
    assert done.returncode == 2
    assert "touch-1" in done.stdout
    assert "a.launch.py:11: launch configuration 'nope' does not exist" in done.stderr
    assert "Traceback" not in done.stderr


def test_an_error_in_an_exit_handler_says_when_it_happens(workspace: Workspace):
    file = workspace.write(
        "ExecuteProcess(cmd=['true'], on_exit=[OpaqueFunction(function=lambda context: 1 / 0)]),"
    )
    done = workspace.call("plan", file)
    assert done.returncode == 2
    assert "hint: this happens later, when a process has ended" in done.stderr


def test_the_document_has_an_unknown_argument_as_ros_2_takes_it_and_says_so(workspace: Workspace):
    file = workspace.write('DeclareLaunchArgument("speed", default_value="1"),')
    done = workspace.call("plan", "--json", file, "sped:=2")
    assert done.returncode == 0
    assert json.loads(done.stdout)["declared"] == {"speed": "1"}
    assert "did you mean 'speed'?" in done.stderr


def test_colour_is_for_terminals(workspace: Workspace):
    file = workspace.write("")
    assert "\x1b[" not in workspace.call("plan", file).stdout
    assert "\x1b[" in workspace.call("plan", file, FORCE_COLOR="1").stdout


def test_a_reader_that_leaves_early_is_no_error(workspace: Workspace):
    file = workspace.write("*[ExecuteProcess(cmd=['true', 'x' * 1000]) for _ in range(200)],")
    line = f"{sys.executable} -m launcher plan {file} | head -1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(
        ["bash", "-c", line], env=workspace.env, capture_output=True, text=True, timeout=TIMEOUT_S
    )
    assert done.returncode == 0
    assert done.stderr == ""


def test_warnings_are_below_the_tree_and_not_in_the_document(workspace: Workspace):
    workspace.HEAD = f"from launch.event_handlers import OnProcessExit{Workspace.HEAD}"
    file = workspace.write(
        """
        GroupAction([SetLaunchConfiguration("x", "1"),
                     RegisterEventHandler(OnProcessExit(on_exit=[LogInfo(msg="later")]))]),
        """
    )
    done = workspace.call("plan", file)
    assert f"warning: {file}:13: the actions of this event handler run outside" in done.stdout
    plain = workspace.call("plan", "--json", file)
    assert "warning:" not in plain.stdout
    assert f"warning: {file}:13: " in plain.stderr


@pytest.mark.parametrize("option", ["-s", "--show-args", "--show-arguments"])
def test_the_launch_form_lists_arguments(workspace: Workspace, option: str):
    file = workspace.write('DeclareLaunchArgument("needed"),')
    done = workspace.call(file, option)
    assert done.returncode == 0
    assert done.stdout == workspace.call("args", file).stdout
    assert "    'needed':\n        no description given\n" in done.stdout
    assert not workspace.started.exists()


def test_arguments_of_included_files_are_listed(workspace: Workspace):
    workspace.write('DeclareLaunchArgument("inner", default_value="1"),', "child.launch.py")
    file = workspace.write(f'IncludeLaunchDescription("{workspace.folder}/child.launch.py"),')
    assert "    'inner':\n" in workspace.call("args", file).stdout


@pytest.mark.parametrize("option", few_of(["-p", "--print", "--print-description"], ["-p"]))
def test_the_launch_form_prints_the_plan(workspace: Workspace, option: str):
    file = workspace.write("")
    assert workspace.call(file, option).stdout == workspace.call("plan", file).stdout
    assert not workspace.started.exists()


def test_the_prefix_of_the_command_line_is_in_the_plan(workspace: Workspace):
    file = workspace.write('ExecuteProcess(cmd=["other", "b"]),')
    done = workspace.call(file, "-p", "--launch-prefix", "nice -n 5", "--launch-prefix-filter=oth")
    assert "$ nice -n 5 other b\n" in done.stdout
    assert f"$ touch {workspace.started}\n" in done.stdout


HEAVY = ("rich", "psutil", "rclpy", "prompt_toolkit", "asyncio", "dataclasses", "difflib")


@pytest.mark.parametrize("words", [["plan"], ["plan", "--json"], ["launch"]], ids=" ".join)
def test_nothing_heavy_is_imported_on_the_way_to_a_plan_or_a_process(workspace: Workspace, words):
    file = workspace.write("")
    script = (
        "import sys; from launcher.cli.dispatch import main; found = []\n"
        f"def look(): found.append([name for name in {HEAVY!r} if name in sys.modules])\n"
        "sys.addaudithook(lambda event, args: event == 'os.posix_spawn' and look())\n"
        f"code = main({[*words, str(file)]!r})\n"
        "look(); print(found[0], file=sys.stderr); sys.exit(code)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=workspace.env,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == "[]\n"
