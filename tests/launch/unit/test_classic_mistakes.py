"""Classic mistakes in launch files, one by one: sentence, line, caret, hint and exit code."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from launcher.base.errors import ExitCode
from launcher.cli.dispatch import main

HEAD = """\
import os
from launch import Action, Condition, LaunchDescription, LaunchDescriptionEntity, Substitution
from launch.actions import *
from launch.conditions import *
from launch.substitutions import *
from launch_ros.actions import Node
"""


class Case(NamedTuple):
    """A launch file; `at` is the text that the caret points to; `words`: launch arguments."""

    text: str
    line: int
    at: str
    message: str
    hint: str
    suffix: str = "py"
    words: tuple[str, ...] = ()


def python(
    body: str, at: str, message: str, hint: str, *, words: tuple[str, ...] = (), plus: int = 0
) -> Case:
    """A Python file; the line is the one marked with `# here`, and `plus` further ones."""
    text = HEAD + textwrap.dedent(body)
    (number,) = [n for n, line in enumerate(text.splitlines(), start=1) if "# here" in line]
    return Case(text, number + plus, at, message, hint, words=words)


def described(entry: str) -> str:
    """A Python file with one entry in its description."""
    return f"""
    def generate_launch_description():
        return LaunchDescription([
            DeclareLaunchArgument('d', default_value='/tmp'),
            {entry}  # here
        ])
    """


def yaml(text: str, line: int, at: str, message: str, hint: str) -> Case:
    return Case(textwrap.dedent(text), line, at, message, hint, suffix="yaml")


NO_TEXT = "a LaunchConfiguration is not a text: it gets its value only when the launch file is run"
IN_A_FUNCTION = "in the function of an OpaqueFunction"
NEITHER = "invalid condition expression, expected one of [true, 1, false, 0] but got '{}'"

ERRORS = {
    # ---- substitutions as texts
    "os.path.join": python(
        described("LogInfo(msg=os.path.join(LaunchConfiguration('d'), 'x.yaml'))"),
        "LaunchConfiguration(",
        NO_TEXT,
        "write PathJoinSubstitution([LaunchConfiguration('d'), 'x.yaml'])",
    ),
    "a sum": python(
        described("LogInfo(msg=LaunchConfiguration('d') + '/x' + '.yaml')"),
        "LaunchConfiguration(",
        NO_TEXT,
        "write [LaunchConfiguration('d'), '/x', '.yaml']",
    ),
    "a sum that begins with a text": python(
        described("LogInfo(msg='in ' + LaunchConfiguration('d'))"),
        "LaunchConfiguration(",
        NO_TEXT,
        "write ['in ', LaunchConfiguration('d')]",
    ),
    "a quotient": python(
        described("LogInfo(msg=LaunchConfiguration('d') / 'x.yaml')"),
        "LaunchConfiguration(",
        NO_TEXT,
        "write PathJoinSubstitution([LaunchConfiguration('d'), 'x.yaml'])",
    ),
    "open": python(
        """
        def generate_launch_description():
            config = LaunchConfiguration('config')
            with open(config) as file:  # here
                return LaunchDescription([LogInfo(msg=file.read())])
        """,
        "with open",
        NO_TEXT,
        f"write config.perform(context) {IN_A_FUNCTION}",
    ),
    "a number": python(
        described("LogInfo(msg=str(int(LaunchConfiguration('d'))))"),
        "LaunchConfiguration(",
        NO_TEXT,
        f"write LaunchConfiguration('d').perform(context) {IN_A_FUNCTION}",
    ),
    "a method of texts": python(
        described("LogInfo(msg=LaunchConfiguration('d').split('/'))"),
        "split(",
        "a LaunchConfiguration is not a text and has no method split(): "
        "it gets its value only when the launch file is run",
        f"write LaunchConfiguration('d').perform(context) {IN_A_FUNCTION}",
    ),
    "a misspelt method": python(
        described("OpaqueFunction(function=lambda c: LaunchConfiguration('d').preform(c))"),
        "preform(",
        "a LaunchConfiguration has no attribute 'preform'",
        "did you mean 'perform'?",
    ),
    # ---- values of a wrong type
    "parameters as a dictionary": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                Node(package='p',
                     executable='x',
                     parameters={'a': 1})])  # here
        """,
        "parameters=",
        "parameters of Node takes a list, not a dict",
        "write parameters=[{'a': 1}]",
    ),
    "parameters as a path": python(
        described("Node(package='p', executable='x', parameters='a.yaml'),"),
        "parameters=",
        "parameters of Node takes a list, not a str",
        "write parameters=['a.yaml']",
    ),
    "remappings as a pair": python(
        described("Node(package='p', executable='x', remappings=('a', 'b')),"),
        "remappings=",
        "each entry of remappings is a pair of names in parentheses, not a str",
        "write remappings=[('a', 'b')]",
    ),
    "remappings of three names": python(
        described("Node(package='p', executable='x', remappings=[('a', 'b', 'c')]),"),
        "remappings=",
        "each entry of remappings is a pair of names",
        "write remappings=[('from', 'to')]",
    ),
    "an int as period": python(
        described("TimerAction(period=3, actions=[]),"),
        "period=3",
        "period of TimerAction takes a float, a text or a Substitution, not an int",
        "write period=3.0",
    ),
    "a single action of a timer": python(
        described("TimerAction(period=3.0, actions=LogInfo(msg='x')),"),
        "actions=",
        "actions of TimerAction takes a list, not a LogInfo",
        "write actions=[LogInfo(msg='x')]",
    ),
    "a single action of a description": python(
        """
        def generate_launch_description():
            return LaunchDescription(Node(package='p', executable='x'))  # here
        """,
        "Node(",
        "LaunchDescription takes a list of actions, not a single Node",
        "write LaunchDescription([Node(...)])",
    ),
    "a single action of a group": python(
        described("GroupAction(LogInfo(msg='x')),"),
        "LogInfo(",
        "GroupAction takes a list of actions, not a single LogInfo",
        "write GroupAction([LogInfo(...)])",
    ),
    "a list in a list": python(
        """
        def generate_launch_description():
            nodes = [Node(package='p', executable='x')]
            return LaunchDescription([
                LogInfo(msg='x'),
                nodes,  # here
            ])
        """,
        "nodes,",
        "entry 2 of 2 in LaunchDescription([...]) is not an action: a list of actions",
        "unpack it: write *nodes",
    ),
    "a literal list in a list": python(
        """
        def generate_launch_description():
            return LaunchDescription([[LogInfo(msg='x')]])  # here
        """,
        "return",
        "entry 1 of 1 in LaunchDescription([...]) is not an action: a list of actions",
        "write its actions without the inner brackets",
    ),
    "a number among words": python(
        described("Node(executable='x', parameters=[{'a': 4}], arguments=['--count', 3]),"),
        "3]",
        "an int where a text or a substitution is expected",
        "write '3'",
    ),
    "a truth value as condition": python(
        described("LogInfo(msg='x', condition=IfCondition(True)),"),
        "True",
        "a bool where a text or a substitution is expected",
        "write 'true'",
    ),
    "a number as default": python(
        described("DeclareLaunchArgument('rate', default_value=10),"),
        "10)",
        "an int where a text or a substitution is expected",
        "write '10'",
    ),
    "a list among substitutions": python(
        described("LogInfo(msg=PathJoinSubstitution(['a', ['b', 'c']])),"),
        "LogInfo(",
        "a list among texts and substitutions",
        "write its items without the inner brackets",
    ),
    "a message by position": python(
        described("LogInfo('hello'),"),
        "LogInfo(",
        "LogInfo takes its arguments by name",
        "write LogInfo(msg='hello')",
    ),
    "actions by position": python(
        """
        def generate_launch_description():
            return LaunchDescription(LogInfo(msg='a'), LogInfo(msg='b'))  # here
        """,
        "LaunchDescription(",
        "LaunchDescription takes one list of actions",
        "write LaunchDescription([LogInfo(msg='a'), LogInfo(msg='b')])",
    ),
    "launch_arguments as a dictionary": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                IncludeLaunchDescription(
                    os.path.join(os.path.dirname(__file__), 'child.launch.xml'),
                    launch_arguments={'count': '2'})])  # here
        """,
        "launch_arguments",
        "launch_arguments takes pairs of name and value",
        "write launch_arguments={...}.items()",
    ),
    # ---- returns
    "a forgotten return": python(
        """
        def generate_launch_description():  # here
            ld = LaunchDescription()
            ld.add_action(LogInfo(msg='x'))
        """,
        "def generate",
        "generate_launch_description() returned NoneType, not a LaunchDescription",
        "write 'return ld' at its end",
    ),
    "a forgotten return of the whole": python(
        """
        def generate_launch_description():  # here
            LaunchDescription([LogInfo(msg='x')])
        """,
        "def generate",
        "generate_launch_description() returned NoneType, not a LaunchDescription",
        "write 'return' in front of LaunchDescription([...])",
    ),
    # ---- imports
    "from launch.action": python(
        "from launch.action import ExecuteProcess  # here\n",
        "from launch",
        "launch.action.ExecuteProcess is not provided by this launcher",
        "write 'from launch.actions import ExecuteProcess'",
    ),
    "a node from launch": python(
        "from launch.actions import Node  # here\n",
        "from launch",
        "launch.actions.Node is not provided by this launcher",
        "write 'from launch_ros.actions import Node'",
    ),
    "a misspelt module": python(
        "from launch.subsitutions import LaunchConfiguration  # here\n",
        "launch.subsitutions",
        "No module named 'launch.subsitutions'",
        "did you mean 'launch.substitutions'?",
    ),
    "an attribute of the wrong module": python(
        """
        import launch
        def generate_launch_description():
            return LaunchDescription([launch.actions.LaunchConfiguration('x')])  # here
        """,
        "launch.actions",
        "module 'launch.actions' has no attribute 'LaunchConfiguration'",
        "write 'from launch.substitutions import LaunchConfiguration'",
    ),
    "a name that was not imported": python(
        described("SetParameter('use_sim_time', True),"),
        "SetParameter(",
        "name 'SetParameter' is not defined",
        "write 'from launch_ros.actions import SetParameter'",
    ),
    # ---- classes derived from those of launch
    "a substitution without perform": python(
        """
        class Today(Substitution):
            def preform(self, context):  # here
                return 'Monday'
        def generate_launch_description():
            return LaunchDescription([LogInfo(msg=['it is ', Today()])])
        """,
        "preform(",
        "the substitution Today has no method perform()",
        "write 'def perform(self, context)' instead of 'def preform'",
    ),
    # ---- conditions
    "a condition": python(
        described("LogInfo(msg='x', condition=IfCondition(LaunchConfiguration('d'))),"),
        "d')",
        NEITHER.format("flase"),
        "d is 'flase', on the command line; did you mean d:=false?",
        words=("d:=flase",),
    ),
    "a condition whose value was set in the file": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                SetLaunchConfiguration('a', 'yes'),
                LogInfo(msg='x', condition=UnlessCondition(LaunchConfiguration('a')))])  # here
        """,
        "a')",
        NEITHER.format("yes"),
        "a is 'yes', set at FILE:10; did you mean 'true'?",
    ),
    "a condition on several values": python(
        described("LogInfo(msg='x', condition=IfCondition([LaunchConfiguration('d'), 'x'])),"),
        "d'), 'x'",
        NEITHER.format("/tmpx"),
        "d is '/tmp', default at FILE:10",
    ),
    "a negation": python(
        described(
            "LogInfo(msg='x', condition=IfCondition(NotSubstitution(LaunchConfiguration('d')))),"
        ),
        "d')",
        "Cannot convert value 'ture' to '<class 'bool'>'",
        "d is 'ture', on the command line; did you mean d:=true?",
        words=("d:=ture",),
    ),
    "a value outside of choices": python(
        described("DeclareLaunchArgument('mode', default_value='a', choices=['a', 'false']),"),
        "mode'",
        "argument 'mode' cannot be 'no'",
        "did you mean mode:=false?",
        words=("mode:=no",),
    ),
    "a condition in XML": Case(
        '<launch>\n  <arg name="x" default="1"/>\n  <log message="a"\n       if="$(var x)"/>\n'
        "</launch>\n",
        4,
        "x)",
        NEITHER.format("flase"),
        "x is 'flase', on the command line; did you mean x:=false?",
        suffix="xml",
        words=("x:=flase",),
    ),
    "a condition in YAML": Case(
        "launch:\n- arg:\n    name: x\n- log:\n    message: a\n    unless: $(var x)\n",
        6,
        "x)",
        NEITHER.format("flase"),
        "x is 'flase', on the command line; did you mean x:=false?",
        suffix="yaml",
        words=("x:=flase",),
    ),
    # ---- includes
    "an included file that does not exist": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                IncludeLaunchDescription(
                    os.path.join(os.path.dirname(__file__), 'chlid.launch.xml'))])  # here
        """,
        "chlid",
        "the included launch file FOLDER/chlid.launch.xml does not exist",
        "did you mean 'child.launch.xml'?",
    ),
    "an included file with another suffix": Case(
        '<launch>\n  <include\n      file="$(dirname)/child.launch.py"/>\n</launch>\n',
        3,
        "child",
        "the included launch file FOLDER/child.launch.py does not exist",
        "did you mean 'child.launch.xml'?",
        suffix="xml",
    ),
    "an included file in a folder that does not exist": Case(
        "launch:\n- include:\n    file: $(dirname)/lauch/child.launch.xml\n",
        3,
        "child",
        "the included launch file FOLDER/lauch/child.launch.xml does not exist",
        "the folder FOLDER/lauch does not exist; did you mean 'launch'?",
        suffix="yaml",
    ),
    "an included file that is one folder further": Case(
        "launch:\n- include:\n    file: $(dirname)/deep.launch.xml\n",
        3,
        "deep",
        "the included launch file FOLDER/deep.launch.xml does not exist",
        "did you mean 'launch/deep.launch.xml'?",
        suffix="yaml",
    ),
    "a cycle in XML": Case(
        '<launch>\n  <include file="$(dirname)/back.launch.xml"/>\n</launch>\n',
        2,
        "<include",
        "launch files include each other endlessly: "
        "case.launch.xml -> back.launch.xml -> case.launch.xml",
        "remove an include or a call, or give it a condition that becomes false",
        suffix="xml",
    ),
    "a cycle in YAML": Case(
        "launch:\n- include:\n    file: $(dirname)/case.launch.yaml\n",
        2,
        "- include",
        "the launch file includes itself endlessly: case.launch.yaml -> case.launch.yaml",
        "remove an include or a call, or give it a condition that becomes false",
        suffix="yaml",
    ),
    # ---- YAML
    "a tab": yaml(
        "launch:\n- executable:\n\tcmd: ls\n",
        3,
        "\tcmd",
        "a tab at the beginning of a line",
        "indent with spaces",
    ),
    "a key that is indented less than its neighbour": yaml(
        "launch:\n- executable:\n    cmd: ls\n   output: screen\n",
        4,
        "output",
        "this line is indented by 3 spaces, line 3 by 4",
        "begin it with 4 spaces, like line 3",
    ),
    "an item that is indented less than its neighbour": yaml(
        "launch:\n  - executable:\n      cmd: ls\n - log:\n     message: x\n",
        4,
        "- log",
        "this line is indented by 1 space, line 2 by 2",
        "begin it with 2 spaces, like line 2",
    ),
    "a key that is indented further than its neighbour": yaml(
        "launch:\n- log:\n    message: x\n      level: INFO\n",
        4,
        ": INFO",
        "this line is indented further than the key above, which has a value",
        "indent it like line 3: with 4 spaces",
    ),
    "attributes beside their action": yaml(
        "launch:\n- node:\n  pkg: demo\n  exec: x\n",
        3,
        "pkg",
        "'pkg' is beside 'node' instead of below it",
        "indent the attributes of 'node' further than 'node' itself",
    ),
    "items at the level of launch": yaml(
        " launch:\n- log:\n    message: x\n",
        2,
        "- log",
        "this line belongs to no block above",
        "indent it by the same number of spaces as the line above",
    ),
    "a key without colon": yaml(
        "launch:\n- executable:\n    cmd: ls\n    output screen\n    name: x\n",
        4,
        "output",
        "this line has no ':' after its key",
        "write 'output: screen'",
    ),
    "an action without colon": yaml(
        "launch:\n- log\n    message: x\n",
        3,
        ": x",
        "a key in a value: the line above has no ':' at its end",
        "write '- log:' in line 2",
    ),
    "a colon in a value": yaml(
        "launch:\n- log:\n    message: now: x\n",
        3,
        ": x",
        "the value holds a ':', as if it were a key",
        "put the value in quotes",
    ),
    "an open quote": yaml(
        'launch:\n- log:\n    message: "x\n- log:\n    message: y\n',
        3,
        '"x',
        "the quote that begins here has no end",
        "add the closing quote",
    ),
    "text behind a quote": yaml(
        'launch:\n- log:\n    message: "x" y\n',
        3,
        "y",
        "there is text behind the end of a value",
        "put the value in quotes",
    ),
    "an open brace": yaml(
        "launch:\n- log: {message: x\n- log:\n    message: y\n",
        2,
        "{message",
        "the '{' that begins here has no '}'",
        "add '}'",
    ),
    "a value that begins with @": yaml(
        "launch:\n- log:\n    message: @x\n",
        3,
        "@x",
        "a value cannot begin with '@'",
        "put the value in quotes",
    ),
    "a value that begins with *": yaml(
        "launch:\n- log:\n    message: *x\n",
        3,
        "*x",
        "'*x' stands for an anchor, and there is no '&x' above",
        "put the value in quotes if it is a text",
    ),
    "a value that begins with !": yaml(
        "launch:\n- log:\n    message: !x y\n",
        3,
        "!x",
        "a value that begins with '!' is a YAML tag, and '!x' is none",
        "put the value in quotes",
    ),
    "a backslash": yaml(
        'launch:\n- log:\n    message: "\\d"\n',
        3,
        'd"',
        "'\\d' means nothing in double quotes",
        "write two backslashes, or put the value in single quotes",
    ),
    "a list in the line of its key": yaml(
        "launch: - log:\n    message: x\n",
        1,
        "- log",
        "a list cannot begin in the line of its key",
        "begin the list in the next line, indented further than its key",
    ),
    "two documents": yaml(
        "launch: []\n---\nlaunch: []\n",
        2,
        "---",
        "a second document begins here",
        "a launch file is one document: remove '---'",
    ),
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with files to include, and log files in it only if something is started."""
    (tmp_path / "launch").mkdir()
    log = '<launch><arg name="count" default="1"/><log message="count $(var count)"/></launch>\n'
    for name in ("child.launch.xml", "launch/deep.launch.xml"):
        (tmp_path / name).write_text(log, encoding="utf-8")
    back = '<launch>\n  <include file="$(dirname)/case.launch.xml"/>\n</launch>\n'
    (tmp_path / "back.launch.xml").write_text(back, encoding="utf-8")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    yield tmp_path


def written(folder: Path, case: Case) -> Path:
    file = folder / f"case.launch.{case.suffix}"
    file.write_text(case.text, encoding="utf-8")
    return file


@pytest.mark.parametrize("verb", ["launch", "plan"])
@pytest.mark.parametrize("name", ERRORS)
def test_a_mistake_is_told_in_one_sentence_with_its_place_and_its_repair(
    name: str, verb: str, folder: Path, capfd: pytest.CaptureFixture[str]
):
    case = ERRORS[name]
    file = written(folder, case)

    code = main([verb, str(file), *case.words])

    head, source, caret, hint, *_ = capfd.readouterr().err.splitlines()
    message = case.message.replace("FOLDER", str(folder))
    assert code == ExitCode.USAGE
    assert head.replace("NameError: ", "").replace("AttributeError: ", "") == (
        f"error: {file}:{case.line}: {message}"
    )
    assert hint == "hint: " + case.hint.replace("FILE", str(file)).replace("FOLDER", str(folder))
    assert caret.strip() == "^"
    assert source[caret.index("^") :].startswith(case.at), (source, caret)
    assert not (folder / "log").exists()


# name -> (text, line, warning, what the plan ends with instead of success)
WARNINGS = {
    "an f-string": python(
        described("LogInfo(msg=f\"in {LaunchConfiguration('d')}\"),"),
        "",
        "a LaunchConfiguration is used as text, which gives "
        "'<launch.substitutions.launch_configuration.LaunchConfiguration object ...>'",
        "write ['in ', LaunchConfiguration('d')]",
    ),
    "str()": python(
        described("LogInfo(msg=str(LaunchConfiguration('d'))),"),
        "",
        "a LaunchConfiguration is used as text, which gives "
        "'<launch.substitutions.launch_configuration.LaunchConfiguration object ...>'",
        "write a list, as in ['text', LaunchConfiguration('d')]",
    ),
    "a comparison": python(
        """
        def generate_launch_description():
            mode = LaunchConfiguration('mode')
            if mode == 'fast':  # here
                return LaunchDescription([])
            return LaunchDescription([DeclareLaunchArgument('mode', default_value='fast')])
        """,
        "",
        "a LaunchConfiguration is compared with a text, and is never equal to it",
        "write condition=IfCondition(EqualsSubstitution(LaunchConfiguration('mode'), 'fast'))",
    ),
    "a command of one word": python(
        described("ExecuteProcess(cmd=['ls -la', '/tmp']),"),
        "",
        "'ls -la' is one word, and there is no program of this name",
        "write cmd=['ls', '-la', '/tmp'], or add shell=True",
    ),
    "a shell command of one word": python(
        described("ExecuteProcess(cmd=['ls | wc']),"),
        "",
        "'ls | wc' is one word, and there is no program of this name",
        "add shell=True",
    ),
    "an executable with arguments": python(
        described("Node(executable='ls -la'),"),
        "",
        "'ls -la' is one word, and there is no program of this name",
        "write executable='ls', and the rest in arguments=['-la']",
    ),
    "a command as a text": python(
        described("ExecuteProcess(cmd='ls -la'),"),
        "",
        "cmd is a text, of which each letter becomes a word",
        "write cmd=['ls', '-la']",
    ),
    "arguments as a text": python(
        described("Node(executable='ls', arguments='-l -a'),"),
        "",
        "arguments is a text, of which each letter becomes a word",
        "write arguments=['-l', '-a']",
    ),
    "a function without return": python(
        """
        def setup(context):
            actions = []
            actions.append(ExecuteProcess(cmd=['ls']))  # here
        def generate_launch_description():
            return LaunchDescription([OpaqueFunction(function=setup)])
        """,
        "",
        "setup() returns nothing, so its ExecuteProcess is not run",
        "return a list of the actions at its end",
    ),
    "an entity without visit": python(
        """
        class Mine(LaunchDescriptionEntity):
            def visti(self, context):  # here
                return [LogInfo(msg='x')]
        def generate_launch_description():
            return LaunchDescription([Mine()])
        """,
        "",
        "Mine does nothing, since it has no method visit()",
        "write 'def visit(self, context)' instead of 'def visti'",
    ),
    "an action without execute": python(
        """
        class Mine(Action):
            def excute(self, context):  # here
                return [LogInfo(msg='x')]
        def generate_launch_description():
            return LaunchDescription([Mine()])
        """,
        "",
        "Mine does nothing, since it has no method execute()",
        "write 'def execute(self, context)' instead of 'def excute'",
    ),
    "a condition without evaluate": python(
        """
        class Mine(Condition):
            def evalute(self, context):  # here
                return True
        def generate_launch_description():
            return LaunchDescription([LogInfo(msg='x', condition=Mine())])
        """,
        "",
        "Mine is always false, since it has no method evaluate()",
        "write 'def evaluate(self, context)' instead of 'def evalute'",
    ),
    "a misspelt argument of an include": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                IncludeLaunchDescription(
                    os.path.join(os.path.dirname(__file__), 'child.launch.xml'),
                    launch_arguments={
                        'cuont': '3'}.items())])  # here
        """,
        "",
        "child.launch.xml does not declare the argument 'cuont', which is ignored",
        "did you mean 'count'?",
    ),
    "an unknown argument of an include": Case(
        '<launch>\n  <include file="$(dirname)/child.launch.xml">\n'
        '    <arg name="colour" value="3"/>\n  </include>\n</launch>\n',
        3,
        "",
        "child.launch.xml does not declare the argument 'colour', which is ignored",
        "it declares: count",
        suffix="xml",
    ),
    "a misspelt argument of an include in YAML": Case(
        "launch:\n- include:\n    file: $(dirname)/child.launch.xml\n    arg:\n"
        "    - name: cuont\n      value: '3'\n",
        5,
        "",
        "child.launch.xml does not declare the argument 'cuont', which is ignored",
        "did you mean 'count'?",
        suffix="yaml",
    ),
}


@pytest.mark.parametrize("name", WARNINGS)
def test_what_ros_2_runs_nevertheless_gives_a_warning(
    name: str, folder: Path, capfd: pytest.CaptureFixture[str]
):
    case = WARNINGS[name]
    file = written(folder, case)

    code = main(["plan", str(file), *case.words])

    said = [line for line in capfd.readouterr().out.splitlines() if line.startswith("warning: ")]
    assert code == ExitCode.OK
    assert said[0] == f"warning: {file}:{case.line}: {case.message}; hint: {case.hint}"


RIGHT = {
    "a description": "LogInfo(msg=LaunchConfiguration('d').describe()),",
    "a comparison with another substitution": (
        "LogInfo(msg=str(LaunchConfiguration('d') == TextSubstitution(text='x'))),"
    ),
    "an argument that the other file declares": (
        "IncludeLaunchDescription(HERE + '/child.launch.xml', launch_arguments=[('count', '1')]),"
    ),
    "an argument that ROS 2 itself reads": (
        "IncludeLaunchDescription(HERE + '/child.launch.xml',"
        " launch_arguments=[('sigterm_timeout', '1')]),"
    ),
    "an argument that is read without a declaration": (
        "IncludeLaunchDescription(HERE + '/reads.launch.xml', launch_arguments=[('b', '1')]),"
    ),
    "an argument that a function may read": (
        "IncludeLaunchDescription(HERE + '/function.launch.py', launch_arguments=[('r_2', '1')]),"
    ),
    "a program with a space in its name": "ExecuteProcess(cmd=[HERE + '/my program']),",
    "a shell command": "ExecuteProcess(cmd=['ls -la'], shell=True),",
    "a function that has nothing to return": "OpaqueFunction(function=lambda context: None),",
}


@pytest.mark.parametrize("name", RIGHT)
def test_what_is_right_gives_no_warning(name: str, folder: Path, capfd: pytest.CaptureFixture[str]):
    (folder / "my program").touch()
    (folder / "reads.launch.xml").write_text(
        '<launch><arg name="a" default="1"/><log message="$(var b)"/></launch>'
    )
    (folder / "function.launch.py").write_text(
        HEAD + "def read(context):\n"
        "    return [LogInfo(msg=context.launch_configurations[f'r_{n}']) for n in (1, 2)]\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([DeclareLaunchArgument('r_1', default_value='x'),\n"
        "        OpaqueFunction(function=read)])\n"
    )
    file = folder / "case.launch.py"
    body = textwrap.dedent(described(RIGHT[name]))
    file.write_text(f"{HEAD}HERE = os.path.dirname(__file__)\n{body}")

    code = main(["plan", str(file)])

    said = capfd.readouterr()
    assert (code, said.err) == (ExitCode.OK, "")
    assert [line for line in said.out.splitlines() if line.startswith(f"warning: {folder}")] == []
