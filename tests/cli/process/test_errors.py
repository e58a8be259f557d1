"""Faulty launch files: line, message, suggestion, exit code 2; nothing is started."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import launcher
from tests.support.benches import Workspace
from tests.support.repository import REPOSITORY

pytestmark = pytest.mark.thorough

# name -> (text of the launch file, what is said, the suggestion)
BROKEN = {
    "raises": (
        """
        def helper():
            return {}["robot"]

        def generate_launch_description():
            return helper()
        """,
        ":3: KeyError: 'robot'\n        return {}[\"robot\"]\n",
        "",
    ),
    "syntax": ("def generate_launch_description(:\n", ":1: ", ""),
    "returns None": (
        "def generate_launch_description():\n    pass\n",
        "returned NoneType",
        "return LaunchDescription([...])",
    ),
    "sys.exit": ("import sys\nsys.exit(0)\n", ":2: the launch file calls sys.exit(0)", ""),
    "empty": ("", "does not contain the required function", "define generate_launch_description()"),
    "includes itself": (
        """
        from launch import LaunchDescription
        from launch.actions import IncludeLaunchDescription

        def generate_launch_description():
            return LaunchDescription([IncludeLaunchDescription(__file__)])
        """,
        ":6: the launch file includes itself",
        "",
    ),
    "function without end": (
        """
        from launch import LaunchDescription
        from launch.actions import ExecuteProcess, OpaqueFunction

        def again(context):
            return [OpaqueFunction(function=again)]

        def generate_launch_description():
            return LaunchDescription(
                [ExecuteProcess(cmd=["touch", "started"]), OpaqueFunction(function=again)])
        """,
        "recurses endlessly",
        "",
    ),
    "module that is not installed": (
        "import nav2_comon\n",
        ":1: No module named 'nav2_comon'\n    import nav2_comon\n           ^\n",
        "install the Python package that has nav2_comon",
    ),
    "name that does not exist": (
        "from launch.actions import DeclareLaunchArgumnt\n",
        ":1: launch.actions.DeclareLaunchArgumnt is not provided by this launcher\n",
        "did you mean DeclareLaunchArgument?",
    ),
    "package that is not installed": (
        """
        from launch import LaunchDescription
        from launch.actions import ExecuteProcess
        from launch_ros.actions import Node

        def generate_launch_description():
            return LaunchDescription([
                ExecuteProcess(cmd=["touch", "started"]),
                Node(package="rcl_interface", executable="x"),
            ])
        """,
        ":9: package 'rcl_interface' not found",
        "did you mean 'rcl_interfaces'?",
    ),
    "wrong keyword": (
        """
        from launch import LaunchDescription
        from launch_ros.actions import Node

        def generate_launch_description():
            return LaunchDescription([Node(package="p", executable="x", parameter=[])])
        """,
        ":6: ",
        "did you mean 'parameters'?",
    ),
}
NOT_UTF_8 = b"# fine\nx = '\xe4'\n"


def assert_refused(workspace: Workspace, file: Path, said: str, suggestion: str) -> None:
    for words in ([file], ["plan", file]):
        done = workspace.call(*words)
        assert done.returncode == 2, done.stderr
        assert done.stderr.startswith("error: ")
        assert said in done.stderr
        assert suggestion in done.stderr
        assert "Traceback" not in done.stderr
    assert not (workspace.folder / "started").exists()
    assert not (workspace.folder / "log").exists()


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_launch_file_is_refused(workspace: Workspace, name: str):
    text, said, suggestion = BROKEN[name]
    file = workspace.folder / "broken.launch.py"
    file.write_text(textwrap.dedent(text))
    assert_refused(workspace, file, said, suggestion)


def test_a_file_that_is_not_utf_8_is_refused_at_its_line(workspace: Workspace):
    file = workspace.folder / "latin.launch.py"
    file.write_bytes(NOT_UTF_8)
    assert_refused(workspace, file, "latin.launch.py:2: the byte 0xe4 is not UTF-8", "as UTF-8")


@pytest.mark.parametrize("words", [["."], ["gone.launch.py"], ["no_such_target"], []])
def test_a_file_that_is_not_a_launch_file_is_refused(workspace: Workspace, words: list[str]):
    done = workspace.call("plan", *words)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert "Traceback" not in done.stderr


def test_a_dangling_link_is_refused(workspace: Workspace):
    link = workspace.folder / "link.launch.py"
    link.symlink_to(workspace.folder / "gone")
    assert_refused(workspace, link, "is not a file that can be read", "")


@pytest.mark.parametrize("verb", ["launch", "plan", "args"])
@pytest.mark.parametrize(
    "body",
    ["while True: pass", "import time\n    while True: time.sleep(0.05)"],
    ids=["computes", "waits"],
)
def test_a_launch_file_that_loops_is_interrupted_at_its_line(
    workspace: Workspace, verb: str, body: str
):
    file = workspace.folder / "loop.launch.py"
    file.write_text(f"def generate_launch_description():\n    {body}\n")
    done = workspace.call(verb, file, "--evaluation-timeout", "5")
    assert done.returncode == 2
    line = 2 + body.count("\n")
    assert f"loop.launch.py:{line}: evaluating the launch file takes more than 5 s" in done.stderr
    assert "hint: --evaluation-timeout" in done.stderr


def test_a_launch_file_that_catches_the_interruption_is_ended_all_the_same(workspace: Workspace):
    file = workspace.folder / "stubborn.launch.py"
    file.write_text("while True:\n    try:\n        while True: pass\n    except: pass\n")
    done = workspace.call(file, "--evaluation-timeout=5")
    assert done.returncode == 2
    assert "stubborn.launch.py:3: evaluating the launch file takes more than 5 s" in done.stderr


def test_the_document_of_a_launch_file_that_loops_has_the_error(workspace: Workspace):
    file = workspace.folder / "loop.launch.py"
    file.write_text("while True: pass\n")
    document = workspace.document(file, "--evaluation-timeout", "0.5")
    assert document["error"]["type"] == "TimeoutError"


def test_the_traceback_is_there_for_those_who_ask_for_it(workspace: Workspace):
    file = workspace.folder / "broken.launch.py"
    file.write_text("1 / 0\n")
    for option in ("--debug", "-d"):
        done = workspace.call("plan", file, option)
        assert "Traceback (most recent call last)" in done.stderr
        assert "ZeroDivisionError: division by zero" in done.stderr


# ---- arguments


def test_all_unknown_and_missing_arguments_are_reported_before_anything_starts(
    workspace: Workspace,
):
    file = workspace.write('DeclareLaunchArgument("map"), DeclareLaunchArgument("robot"),')
    for words in ([file], ["plan", file]):
        done = workspace.call(*words, "mapp:=1", "speed:=2")
        assert done.returncode == 2
        for text in (
            "unknown launch argument 'mapp'\nhint: did you mean 'map'?",
            "unknown launch argument 'speed'",
            "the required argument 'map' is not given",
            "the required argument 'robot' is not given",
        ):
            assert text in done.stderr
    assert not workspace.started.exists()


def test_lenient_accepts_unknown_names_as_ros_2_does(workspace: Workspace):
    file = workspace.write("")
    assert workspace.call(file, "bogus:=1").returncode == 2
    assert not workspace.started.exists()
    assert workspace.call("plan", file, "bogus:=1", "--lenient").returncode == 0
    assert workspace.call(file, "bogus:=1", "--lenient").returncode == 0
    assert workspace.started.exists()


# Nothing of this is plainly declared in the file, and ROS 2 uses it all.
USED = {
    "declared by a function": (
        "OpaqueFunction(function=lambda c: [DeclareLaunchArgument('x', default_value='1')]),"
    ),
    "read with a default": "LogInfo(msg=LaunchConfiguration('x', default='1')),",
    "asked for in a condition": ("LogInfo(msg='', condition=LaunchConfigurationEquals('x', '5')),"),
    "read by Python": (
        "OpaqueFunction(function=lambda c: c.launch_configurations.get('x') and None),"
    ),
    "looked for among all": (
        "OpaqueFunction(function=lambda c: dict(c.launch_configurations) and None),"
    ),
    "in an include that a condition decides about": (
        "IncludeLaunchDescription(__file__.replace('a.', 'child.'), condition=IfCondition('1')),"
    ),
    "in an include whose name is only known later": (
        "SetLaunchConfiguration('which', __file__.replace('a.', 'child.')), "
        "IncludeLaunchDescription(LaunchConfiguration('which')),"
    ),
    "behind a condition that says no": (
        "GroupAction([LogInfo(msg=LaunchConfiguration('x', default=''))], "
        "condition=IfCondition('0')),"
    ),
    "in the parameters of a node that is not started": (
        "__import__('launch_ros.actions').actions.Node(executable='true', "
        "condition=IfCondition('0'), parameters=[{'p': LaunchConfiguration('x', default='')}]),"
    ),
    "in an include behind a condition that says no": (
        "IncludeLaunchDescription(__file__.replace('a.', 'child.'), condition=IfCondition('0')),"
    ),
    "by an event that does not come": (
        "RegisterEventHandler(__import__('launch.event_handlers').event_handlers.OnProcessIO("
        "on_stdout=lambda event: [LogInfo(msg=LaunchConfiguration('x', default=''))])),"
    ),
    "in a timer": (
        "TimerAction(period=9.0, actions=[LogInfo(msg=LaunchConfiguration('x', default=''))]),"
    ),
}


@pytest.mark.parametrize("name", USED)
def test_an_argument_that_is_used_at_run_time_is_known(workspace: Workspace, name: str):
    workspace.write("DeclareLaunchArgument('x', default_value='1'),", "child.launch.py")
    done = workspace.call("plan", workspace.write(USED[name]), "x:=2")
    assert done.returncode == 0, done.stderr


def test_an_argument_that_a_function_declares_is_known_when_it_is_launched(workspace: Workspace):
    done = workspace.call(workspace.write(USED["declared by a function"]), "x:=2")
    assert done.returncode == 0, done.stderr
    assert workspace.started.exists()


FROM_ARGV = """
LogInfo(msg="n is " + next(word for word in sys.argv if word.startswith("n:="))),
"""


@pytest.mark.parametrize("verb", [["plan"], ["launch"], ["export", "systemd"], ["smoke"]])
def test_an_argument_that_the_file_takes_from_sys_argv_is_not_refused(
    workspace: Workspace, verb: list[str]
):
    file = workspace.write(FROM_ARGV)
    done = workspace.call(*verb, file, "n:=1")
    assert "unknown launch argument" not in done.stdout + done.stderr
    assert done.returncode == 0, done.stdout + done.stderr
    doubted = workspace.call(*verb, file, "n:=1", "mapp:=2")
    assert doubted.returncode == 0
    said = doubted.stderr + doubted.stdout
    if verb != ["smoke"]:  # the launcher's own output is in a file
        assert "warning: unknown launch argument 'mapp', unless the launch file takes it" in said


@pytest.mark.parametrize(
    "name",
    ["sigterm_timeout", "sigkill_timeout", "launch-prefix", "launch-prefix-filter", "emulate_tty"],
)
def test_arguments_that_ros_2_itself_reads_are_known(workspace: Workspace, name: str):
    assert workspace.call("plan", workspace.write(""), f"{name}:=0").returncode == 0


def test_each_warning_is_printed_once_at_launch(workspace: Workspace):
    file = workspace.write(
        """
        GroupAction([SetLaunchConfiguration("x", "1"),
                     RegisterEventHandler(OnShutdown(on_shutdown=[LogInfo(msg="later")]))]),
        """
    )
    file.write_text(f"from launch.event_handlers import OnShutdown\n{file.read_text()}")
    done = workspace.call(file)
    assert done.returncode == 0
    assert done.stdout.count(f"[WARNING] [launch]: {file}:14: ") == 1


# ---- misspelt verbs, and names outside of a project


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["lunch", "x"], "hint: did you mean `python -m launcher launch`?"),
        (["lunch", "p", "x.launch.py"], "hint: did you mean `python -m launcher launch`?"),
        (["tpoic", "list"], "hint: did you mean `python -m launcher topic`?"),
        (["docter"], "hint: did you mean `python -m launcher doctor`?"),
        (["kil", "robot_1"], "hint: did you mean `python -m launcher kill`?"),
        (["levle", "WARN", "--run", "X"], "hint: did you mean `python -m launcher level`?\n"),
        (["levle", "WARN", "--jsn"], "hint: did you mean `python -m launcher level`?\n"),
        (["./plan"], "error: launch file 'plan' not found\n"),
        (["plan.py"], "error: launch file 'plan.py' not found\n"),
        (["zzz"], "hint: launch files: system, warehouse; python -m launcher --help lists the "),
    ],
)
def test_a_misspelt_verb_or_a_name_outside_of_a_project_gets_a_suggestion(
    workspace: Workspace, words, said
):
    done = workspace.call(*words, AMENT_PREFIX_PATH="")
    assert done.returncode == 2
    assert said in done.stderr
    assert "did you mean" in said or "did you mean" not in done.stderr


@pytest.mark.parametrize(
    "words", [["--help"], ["ps", "--help"], ["plan", "system"], ["runs"], ["interface", "list"]]
)
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_output_that_cannot_be_written_is_reported_once(
    tmp_path: Path, words: list[str], unbuffered: str
):
    # The sockets of launchers that other tests have killed would be reported, too.
    env = {
        **os.environ,
        "PYTHONUNBUFFERED": unbuffered,
        "XDG_RUNTIME_DIR": str(tmp_path),
        "TMPDIR": str(tmp_path),
    }
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "launcher", *words],
            env=env,
            stdout=full,
            stderr=subprocess.PIPE,
            timeout=60,
        )
    said = b"error: cannot write the output: No space left on device\n"
    assert (done.returncode, done.stderr) == (1, said)


def test_words_behind_two_dashes_are_no_options(workspace: Workspace):
    file = workspace.write('DeclareLaunchArgument("x"),')
    file.rename(workspace.folder / "--timeout.launch.py")
    done = workspace.call("--no-log-files", "--", "--timeout.launch.py", "x:=2")
    assert done.returncode == 0, done.stderr
    assert workspace.started.exists()
    assert not (workspace.folder / "log").exists()


def test_a_removed_working_directory_is_reported_as_such(tmp_path: Path):
    gone = tmp_path / "gone"
    gone.mkdir()
    script = 'cd "$1" && rmdir "$1" && exec "$2" -m launcher plan system'
    root = Path(launcher.__file__).parents[1]
    done = subprocess.run(
        ["sh", "-c", script, "sh", str(gone), sys.executable],
        env={**os.environ, "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    said = "error: the current directory does not exist any more\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", said)


def test_a_closed_standard_input_is_an_empty_one(tmp_path: Path):
    command = shlex.join([sys.executable, "-m", "launcher", "interface", "show", "-"])
    done = subprocess.run(
        ["sh", "-c", f"{command} <&-"], cwd=REPOSITORY, capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("Unknown interface ''\n")
