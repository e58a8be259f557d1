"""Which launch arguments are refused, after one evaluation of the static part."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.language import frontends
from launcher.language.compat import vocabulary
from launcher.language.interpreter import Interpreter
from launcher.launch import launch_checks

HEAD = """\
import argparse, functools, sys
from launch import LaunchDescription, Substitution
from launch.actions import *
from launch.conditions import *
from launch.event_handlers import *
from launch.substitutions import *

NAME = "x_constant"
NAMES = {"one": ["x_listed"]}


def read(context):
    return [LogInfo(msg=LaunchConfiguration("x_read"))]


def helped(context):
    return [LogInfo(msg=LaunchConfiguration(NAME)), *read(context)]


def listed(context, extra="x_default"):
    return [LogInfo(msg=LaunchConfiguration(name)) for name in NAMES["one"]]


def made(context):
    return [LogInfo(msg=LaunchConfiguration(f"robot_{n}_speed", default="")) for n in range(2)]


def reads_all(context):
    return [LogInfo(msg=str(dict(context.launch_configurations)))]


class Own(__import__("launch").Action):
    def execute(self, context):
        return [LogInfo(msg=LaunchConfiguration("x_own", default=""))]


class Wide(Substitution):
    def __init__(self, name):
        super().__init__()
        self.name = name

    def perform(self, context):
        return context.launch_configurations.get("x_performed", self.name)


def later(*actions):
    return TimerAction(period=9.0, actions=list(actions))


def function(called):
    return OpaqueFunction(function=called)


"""
Judged = Callable[..., tuple[list[str], list[str]]]


@pytest.fixture
def judged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Judged:
    """The (refused, doubted) arguments of a launch file, given the text of its actions."""
    monkeypatch.chdir(tmp_path)

    def judge(actions: str, *names: str, head: str = "") -> tuple[list[str], list[str]]:
        body = f"def generate_launch_description():\n    return LaunchDescription([{actions}])\n"
        Path("a.launch.py").write_text(f"{HEAD}{head}\n{body}")
        arguments = [(name, "1") for name in names]
        with vocabulary(["a.launch.py", *(f"{name}:=1" for name in names)]):
            description = frontends.load("a.launch.py")
            interpreter = Interpreter(description, path="a.launch.py", arguments=arguments)
            interpreter.start()
            errors, warnings = launch_checks.unknown_arguments(interpreter, description)
            interpreter.close()
        found = [re.findall(r"argument '(\w+)'", str(one)) for one in (*errors, *warnings)]
        return [one for (one,) in found[: len(errors)]], [one for (one,) in found[len(errors) :]]

    return judge


USED = [
    ("DeclareLaunchArgument('x', default_value='')", "x"),
    ("LogInfo(msg=LaunchConfiguration('x', default=''))", "x"),
    ("LogInfo(msg='', condition=LaunchConfigurationEquals('x', '5'))", "x"),
    ("LogInfo(msg=LaunchConfiguration('x'), condition=IfCondition('0'))", "x"),
    ("function(lambda c: [DeclareLaunchArgument('x', default_value='')])", "x"),
    ("function(lambda c: c.launch_configurations.get('x') and None)", "x"),
    ("function(lambda c: dict(c.launch_configurations) and None)", "anything"),
    ("function(made)", "robot_1_speed"),
    ("later(DeclareLaunchArgument('x'))", "x"),
    ("later(later(LogInfo(msg=LaunchConfiguration('x'))))", "x"),
    ("later(function(read))", "x_read"),
    ("later(function(helped))", "x_read"),
    ("later(function(helped))", "x_constant"),
    ("later(function(listed))", "x_listed"),
    ("later(function(listed))", "x_default"),
    ("later(function(functools.partial(listed, extra='x_partial')))", "x_partial"),
    ("later(Own())", "x_own"),
    ("later(LogInfo(msg=Wide('')))", "x_performed"),
    ("function(lambda c: [later(LogInfo(msg=LaunchConfiguration('x')))])", "x"),
    ("RegisterEventHandler(OnProcessExit(on_exit=lambda e, c: read(c)))", "x_read"),
    ("RegisterEventHandler(OnProcessIO(on_stdout=lambda e: read(None)))", "x_read"),
    (
        "ExecuteProcess(cmd=['x']),"
        "RegisterEventHandler(OnShutdown(on_shutdown=lambda e, c: helped(c)))",
        "x_read",
    ),
    ("ExecuteProcess(cmd=['x'], on_exit=lambda e, c: read(c))", "x_read"),
]


@pytest.mark.filterwarnings("ignore:.*deprecated")
@pytest.mark.parametrize(("actions", "name"), USED)
def test_what_is_used_at_some_time_is_known(judged: Judged, actions: str, name: str):
    assert judged(actions, name) == ([], [])
    assert judged(actions, "unheard_of") == (["unheard_of"] * (name != "anything"), [])


@pytest.mark.parametrize(
    "actions",
    [
        "later(function(made))",
        "RegisterEventHandler(OnProcessExit(on_exit=lambda e, c: made(c)))",
        "function(lambda c: [later(function(made))])",
    ],
)
def test_a_name_that_a_function_may_make_later_is_doubted(judged: Judged, actions: str):
    assert judged(actions, "robot_1_speed") == ([], ["robot_1_speed"])
    assert judged(actions, "rate") == (["rate"], [])


def test_a_function_that_was_called_makes_no_more_names(judged: Judged):
    assert judged("function(made)", "robot_1_sped") == (["robot_1_sped"], [])


@pytest.mark.parametrize(
    "actions",
    [
        "later(function(reads_all))",
        "RegisterEventHandler(OnProcessExit(on_exit=lambda e, c: reads_all(c)))",
        "later(IncludeLaunchDescription(LocalSubstitution('event.path')))",
        "later(IncludeLaunchDescription(Command('false')))",
    ],
)
def test_where_anything_may_be_used_later_every_name_is_doubted(judged: Judged, actions: str):
    assert judged(actions, "x") == ([], ["x"])


@pytest.mark.parametrize(
    "actions",
    [
        "IncludeLaunchDescription('no.launch.py', condition=IfCondition('0'))",
        "later(IncludeLaunchDescription('child.launch.py'))",
        "IncludeLaunchDescription('broken.launch.py', condition=IfCondition('0'))",
    ],
)
def test_files_that_are_not_included_yet_are_looked_into(judged: Judged, actions: str):
    body = "def generate_launch_description():\n    return LaunchDescription([{}])\n"
    child = body.format("DeclareLaunchArgument('x', default_value='')")
    Path("child.launch.py").write_text(HEAD + child)
    Path("broken.launch.py").write_text("1 / 0\n")
    assert judged(actions, "y") == (["y"], [])
    assert judged(actions, "x") == ([] if "child" in actions else ["x"], [])


LOOP = """
WANTED = "0"
for word in sys.argv:
    if word.startswith("n:="):
        WANTED = word
"""
PARSER = """
parser = argparse.ArgumentParser()
parser.add_argument("--n")
parser.parse_known_args()
"""


@pytest.mark.parametrize(
    "head",
    [
        LOOP,
        PARSER,
        "n = [word for word in sys.argv[3:]]",
        "n = dict(word.partition(':=')[::2] for word in sys.argv[3:])",
        "given = 'n:=1' in sys.argv",
        "n = ' '.join(sys.argv)",
        "n, words = 1, [*sys.argv]",
    ],
)
def test_a_file_may_take_arguments_from_sys_argv(judged: Judged, head: str):
    assert judged("", "n", head=head) == ([], [])
    assert judged("", "m", head=head) == ([], ["m"])


@pytest.mark.parametrize(
    "head", ["path = sys.argv[2]", "n = len(sys.argv)", "n = sys.argv[:3]", "n = 1", ""]
)
def test_a_file_that_does_not_look_at_its_arguments_takes_none(judged: Judged, head: str):
    assert judged("", "n", head=head) == (["n"], [])


def test_the_context_gives_arguments_to_a_function(judged: Judged):
    actions = "function(lambda c: [] if 'n:=1' in c.argv else [])"
    assert judged(actions, "n") == ([], [])
    assert judged(actions, "m") == ([], ["m"])


def test_an_included_file_may_take_arguments_from_sys_argv(judged: Judged):
    body = "def generate_launch_description():\n    return LaunchDescription([])\n"
    Path("child.launch.py").write_text(HEAD + LOOP + body)
    assert judged("IncludeLaunchDescription('child.launch.py')", "n") == ([], [])


def test_copies_of_sys_argv_are_plain_lists():
    import copy
    import pickle

    with vocabulary(["a.launch.py", "n:=1"]) as session:
        words = ["ros2", "launch", "a.launch.py", "n:=1"]
        assert isinstance(sys.argv, list)
        assert type(sys.argv) is not list and len(sys.argv) == 4
        assert not session.reads_arguments
        for copied in (sys.argv.copy(), copy.copy(sys.argv), pickle.loads(pickle.dumps(sys.argv))):
            assert (type(copied), copied) == (list, words)
        assert session.reads_arguments
        assert [] + sys.argv == sys.argv + [] == words  # noqa: RUF005
        assert sys.argv == words and sys.argv[-1] == "n:=1"
        with pytest.raises(IndexError):
            sys.argv[4]
