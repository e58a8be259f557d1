"""The plan as a tree, and command lines that can be pasted."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from launcher.base.model.spec import ProcessSpec
from launcher.launch.plan.entities import short_path
from launcher.launch.plan.plan_tree import plan_tree
from launcher.launch.plan.planner import make_plan
from launcher.launch.plan.shell_command import ParameterFileWriter, command_line
from launcher.launch.plan.tree import Branch, draw
from launcher.launch.verbs.args import describe_arguments

HEAD = """
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import *
from launch.event_handlers import *; from launch.events.process import *
from launch.substitutions import *
from launch_ros.actions import *
from launch_ros.descriptions import ComposableLifecycleNode, ComposableNode

def sh(name, **options):
    return ExecuteProcess(cmd=["true", name], name=name, **options)

def generate_launch_description():
    return LaunchDescription([
"""


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The tree of a launch file, given the text of its actions, as lines without branches."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def make(actions: str, *arguments: tuple[str, str]) -> list[str]:
        file = tmp_path / "a.launch.py"
        file.write_text(f"{HEAD}{textwrap.indent(textwrap.dedent(actions), '        ')}\n    ])\n")
        plan = make_plan(str(file), arguments)
        return draw(plan_tree(plan, ParameterFileWriter()), colour=False).splitlines()

    return make


def entries(lines: list[str]) -> list[tuple[int, str]]:
    """(depth, text) of the tree's entries, without remarks and without lines below them."""
    found = []
    for line in lines[1:]:
        head, tip, text = line.rpartition("── ")
        if tip:
            found.append((len(head) // 4, text.split("  ")[0]))
    return found


def test_an_argument_shows_where_its_value_comes_from(tree):
    lines = tree(
        """
        DeclareLaunchArgument("a", default_value="1"),
        DeclareLaunchArgument("b", default_value="2"),
        SetLaunchConfiguration("c", "3"),
        DeclareLaunchArgument("c", default_value="4"),
        """,
        ("b", "given"),
    )
    assert lines[1:] == [
        "├── argument a = '1'  default at a.launch.py:16",
        "├── argument b = 'given'  command line",
        "├── set c = '3'  set at a.launch.py:18",
        "└── argument c = '3'  set before at a.launch.py:18",
    ]


def test_the_arguments_of_an_include_are_shown_with_their_place(tree, tmp_path):
    child = tmp_path / "child.launch.py"
    child.write_text(f'{HEAD} DeclareLaunchArgument("x", default_value="0")])')
    lines = tree(f'IncludeLaunchDescription("{child}", launch_arguments=[("x", "7")]),')
    assert lines[1:] == [
        "└── include child.launch.py  a.launch.py:15",
        "    ├── set x = '7'  launch_arguments at a.launch.py:15",
        "    └── argument x = '7'  set before at a.launch.py:15",
    ]


@pytest.mark.parametrize(
    ("condition", "shown"),
    [
        ('IfCondition(LaunchConfiguration("v"))', "if LaunchConfig('v'): no (v = 'false')"),
        ('UnlessCondition("1")', "unless 1: no"),
        ('LaunchConfigurationEquals("v", "x")', "if v == 'x': no (v = 'false')"),
        ('LaunchConfigurationNotEquals("v", "false")', "if v != 'false': no (v = 'false')"),
        (
            'IfCondition(EqualsSubstitution(LaunchConfiguration("v"), "1"))',
            "(v = 'false')",
        ),
    ],
)
def test_what_is_skipped_says_why(tree, condition, shown):
    lines = tree(f'SetLaunchConfiguration("v", "false"), sh("x", condition={condition}),')
    assert lines[-1].startswith("└── skipped: process true x  ")
    assert lines[-1].endswith(shown)


def test_what_a_condition_lets_through_shows_its_value(tree):
    lines = tree('sh("x", condition=IfCondition("1")),')
    assert "if 1: yes" in lines[1]


def test_a_timer_holds_what_it_starts_with_the_time(tree):
    lines = tree('TimerAction(period=2.5, actions=[sh("late")]), sh("now"),')
    assert entries(lines) == [(0, "after 2.5 s"), (1, "late-2"), (0, "now-1")]
    assert "at 2.5 s" in next(line for line in lines if "late-2" in line)


def test_a_loop_shows_its_values_and_what_it_makes(tree):
    loops = """
        ForEach("{word: a};{word: b}", function=lambda word: [sh(word)]),
        ForLoop(2, function=lambda i: [sh(f"n{i}")]),
    """
    lines = tree(loops)
    assert entries(lines) == [
        (0, "for each of {word: a};{word: b}"),
        *((1, "a-1"), (1, "b-2")),
        (0, "for i from 0, 2 times"),
        *((1, "n0-3"), (1, "n1-4")),
    ]


def test_the_rounds_of_a_loop_in_xml_show_only_its_actions(tmp_path):
    path = tmp_path / "a.launch.xml"
    child = '<log message="$(for-var a)"/>'
    path.write_text(f'<launch><for_each values="{{a: 1}};{{a: 2}}">{child}</for_each></launch>')
    branch = plan_tree(make_plan(str(path), []), ParameterFileWriter()).children[0]
    assert [one.head for one in branch.children] == ["log: 1", "log: 2"]


def test_a_handler_holds_what_it_starts_and_names_its_process(tree):
    lines = tree(
        """
        RegisterEventHandler(OnProcessExit(
            target_action=(a := sh("first")), on_exit=[sh("second")])),
        a,
        """
    )
    assert entries(lines) == [(0, "when first-1 exits"), (1, "second-2"), (0, "first-1")]


def detail(lines: list[str], name: str) -> str:
    """What the line of this entry says behind its name, without the place."""
    (line,) = [line for line in lines if f"── {name}  " in line]
    return line.partition(f"── {name}  ")[2].rpartition("a.launch.py")[0].removesuffix(", ")


EXITS = """
    first := sh("first"),
    RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[
        second := sh("second"),
        TimerAction(period=2.0, actions=[
            sh("nested"), TimerAction(period=1.5, actions=[sh("deeper")])]),
        LoadComposableNodes(target_container="/box", composable_node_descriptions=[
            ComposableNode(package="p", plugin="P", name="part")]),
    ])),
    RegisterEventHandler(OnProcessStart(target_action=second, on_start=[
        TimerAction(period=1.0, actions=[sh("other")])])),
"""


def test_what_follows_an_exit_counts_from_it(tree):
    lines = tree(f'{EXITS} TimerAction(period=5.0, actions=[sh("late")]),')
    assert (0, "when first-1 exits") in entries(lines)
    details = {name: detail(lines, name) for name in ("second", "nested", "deeper", "other")}
    assert details == {
        "second": "",
        "nested": "2 s after first-1 exits",
        "deeper": "3.5 s after first-1 exits",
        "other": "1 s after first-1 exits",
    }
    assert detail(lines, "late") == "at 5 s"
    (part,) = [line for line in lines if "component /part" in line]
    assert part.endswith(", into /box, when first-1 exits")


def test_a_process_has_a_number_only_where_a_run_gives_it_the_same(tree):
    timer = 'TimerAction(period=5.0, actions=[sh("late")]),'
    names = lambda actions: {text for _, text in entries(tree(actions))}  # noqa: E731
    assert {"late-2", "end-3"} <= names(
        """TimerAction(period=5.0, actions=[late := sh("late")]), sh("now"),
        RegisterEventHandler(OnProcessExit(target_action=late, on_exit=[sh("end")])),"""
    )
    alone = names(EXITS)
    assert {"first-1", "second-2"} <= alone  # nothing else comes in between
    assert {"nested", "deeper", "other"} <= alone  # `other` may come before the loading is done
    assert {"first-1", "second", "late"} <= names(EXITS + timer)
    # A function may start anything at any time.
    output = "RegisterEventHandler(OnProcessIO(on_stdout=lambda event: None)),"
    assert {"first-1", "late"} <= names(f'sh("first"), {timer} {output}')
    assert {"first-1", "late-2"} <= names(f'sh("first"), {timer}')


def test_what_a_signal_ends_has_no_time(tree):
    lines = tree(
        """
        first := sh("first"),
        TimerAction(period=4.0, actions=[EmitEvent(event=ShutdownProcess(
            process_matcher=lambda action: action is first))]),
        RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[
            sh("second"), TimerAction(period=2.0, actions=[sh("third")])])),
        """
    )
    assert detail(lines, "second-2") == ""
    assert detail(lines, "third-3") == "2 s after first-1 exits"


def test_what_a_function_yields_at_an_exit_stands_below_the_process(tree):
    lines = tree(
        """
        RegisterEventHandler(OnProcessExit(
            on_exit=lambda event, context: [LogInfo(msg="over")])),
        sh("first"),
        """
    )
    assert (1, "when it exits") in entries(lines)
    assert (2, "log: over") in entries(lines)


def test_a_handler_that_is_never_triggered_shows_its_actions(tree):
    lines = tree('RegisterEventHandler(OnProcessIO(on_stdout=print)), '
                 'RegisterEventHandler(OnShutdown(on_shutdown=[sh("bye")])),')  # fmt: skip
    assert entries(lines) == [
        (0, "when any process writes (not in this dry run)"),
        (0, "on shutdown (not in this dry run)"),
        (1, "process true bye"),
    ]


def test_groups_show_their_scope_and_hide_how_it_is_made(tree):
    lines = tree('GroupAction([sh("a")]), GroupAction([sh("b")], scoped=False),')
    assert entries(lines) == [
        (0, "group"),
        (1, "a-1"),
        (0, "group without a scope"),
        (1, "b-2"),
    ]


def test_components_stand_below_their_container(tree):
    lines = tree(
        """
        LoadComposableNodes(target_container="/box", composable_node_descriptions=[
            ComposableNode(package="p", plugin="p::A", name="a", parameters=[{"rate": 2.0}])]),
        Node(executable="true", name="box", namespace="/"),
        """
    )
    assert (1, "component /a") in entries(lines)
    assert any(line.strip().endswith("rate: 2.0") for line in lines)


def test_a_generated_parameter_file_is_shown_and_kept_for_the_command(tree, tmp_path):
    lines = tree('Node(executable="true", name="n", parameters=[{"gain": 1.5}]),')
    command = next(line for line in lines if "$ " in line)
    path = Path(command.rpartition("--params-file ")[2])
    assert path.read_text() == "/**:\n  ros__parameters:\n    gain: 1.5\n"
    assert path.stat().st_uid == os.getuid()
    assert any(line.strip().endswith("gain: 1.5") for line in lines)
    again = tree('Node(executable="true", name="n", parameters=[{"gain": 1.5}]),')
    assert again == lines


def test_a_folder_of_somebody_else_is_not_written_to(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    trap = tmp_path / "elsewhere"
    trap.mkdir()
    (tmp_path / f"launcher-plan-{os.getuid()}").symlink_to(trap)
    path, _ = ParameterFileWriter().keep("n", {"a": 1})
    assert path is not None and Path(path).is_file()
    assert list(trap.iterdir()) == []


@pytest.mark.thorough
def test_an_endless_launch_file_still_has_a_tree(tmp_path):
    file = tmp_path / "self.launch.py"
    file.write_text(f"{HEAD} IncludeLaunchDescription(__file__)])")
    plan = make_plan(str(file), [])
    assert plan.error is not None and plan.error.kind == "RecursionError"
    assert "... and so on" in draw(plan_tree(plan, ParameterFileWriter()), colour=False)


# ---- command lines


def spec(**fields) -> ProcessSpec:
    values = {"name": "x-1", "label": "x", "argv": ("true",), "env": {}, **fields}
    return ProcessSpec(**values)


@pytest.mark.parametrize("shell", [False, True])
def test_a_pasted_command_line_runs_with_words_folder_and_environment(tmp_path, shell):
    folder = tmp_path / "a b"
    folder.mkdir()
    program = "import os, sys; print(sys.argv[1:], os.getcwd(), sorted(os.environ))"
    words = (sys.executable, "-c", program, "it's", "$HOME", "a;b")
    before = {"PATH": os.environ["PATH"], "GONE": "1", "LC_CTYPE": "C.UTF-8"}
    env = {"PATH": before["PATH"], "LC_CTYPE": "C.UTF-8", "NEW": "two words"}
    if shell:
        words = (f"printf '%s' \"$NEW\"; {sys.executable}", "-c", "'import os; print(os.getcwd())'")
    line = command_line(spec(argv=words, cwd=str(folder), env=env, shell=shell), before, {})

    done = subprocess.run(
        ["sh", "-c", line], env=before, capture_output=True, text=True, check=True
    )

    if shell:
        assert done.stdout == f"two words{folder}\n"
    else:
        names = sorted(set(env) | {"PWD"} - {"GONE"})
        assert done.stdout.startswith(f"{list(words[3:])} {folder} ")
        assert set(names) >= {"NEW"} and "GONE" not in done.stdout


@pytest.mark.parametrize("env", [{}, {"PATH": "/bin", "NEW": "1"}])
def test_a_replaced_environment_is_written_as_a_whole(env: dict[str, str]):
    before = {"PATH": "/bin", "HOME": "/root", "SHELL": "/bin/sh", "LANG": "C"}

    line = command_line(spec(argv=("a",), env=env), before, {})

    assert line == " ".join(["env -i", *(f"{n}={v}" for n, v in sorted(env.items())), "a"])


def test_a_command_line_without_changes_is_the_words_alone():
    assert command_line(spec(argv=("a", "b c"), env={"X": "1"}), {"X": "1"}, {}) == "a 'b c'"


ODD = ["d\udcff r", "a\x1b[1m\nb\t'c' \\x", "\x9b7\u2028end", "\udce4\udcb8 12", "$'x'\r"]


@pytest.mark.parametrize("word", ODD)
def test_a_word_that_cannot_be_printed_is_pasted_as_it_was(word):
    drawn = draw(Branch(command_line(spec(argv=("printf", "%s", word)), {}, {})), colour=False)
    assert "$'" in drawn and drawn.isprintable()
    done = subprocess.run(["bash", "-c", drawn], capture_output=True, check=True)
    assert done.stdout == os.fsencode(word)


def test_a_place_in_a_folder_that_is_no_utf_8_can_be_pasted():
    assert short_path("/x/d\udcff r/a.launch.py") == r"$'/x/d\377 r/a.launch.py'"
    assert short_path("/x/ä b.launch.py") == "/x/ä b.launch.py"


# ---- drawing


def test_control_characters_do_not_reach_the_terminal():
    assert draw(Branch("a\x1b[2Jb\nc"), colour=False) == "a\\x1b[2Jb\\nc"
    assert draw(Branch("ä 日本"), colour=False) == "ä 日本"


def test_colour_is_only_there_when_asked_for():
    root = Branch("root", style="scope", aside="remark", children=[Branch("x", style="process")])
    assert "\x1b" not in draw(root, colour=False)
    assert "\x1b[1;36mx\x1b[0m" in draw(root, colour=True)


def test_arguments_are_listed_in_ros2_launchs_words(tmp_path):
    file = tmp_path / "a.launch.py"
    file.write_text(
        f"""{HEAD}
        DeclareLaunchArgument("req", description="A required one"),
        DeclareLaunchArgument("nodesc", default_value=""),
        DeclareLaunchArgument("mode", default_value="a", choices=["a", "b"], description="pick"),
        DeclareLaunchArgument("sub", default_value=[LaunchConfiguration("mode"), "_x"]),
        GroupAction([DeclareLaunchArgument("maybe", default_value="1")],
                    condition=IfCondition("0")),
    ])"""
    )
    text = describe_arguments(make_plan(str(file), [("req", "1")]).arguments or [])
    assert text == textwrap.dedent(
        """\
        Arguments (pass arguments as '<name>:=<value>'):

            'req':
                A required one

            'nodesc':
                no description given
                (default: '')

            'mode':
                pick. Valid choices are: ['a', 'b']
                (default: 'a')

            'sub':
                no description given
                (default: LaunchConfig('mode') + '_x')

            'maybe':*
                no description given
                (default: '1')

        * argument(s) which are only used if specific conditions occur"""
    )


def test_a_file_without_arguments_says_so():
    expected = "Arguments (pass arguments as '<name>:=<value>'):\n\n  No arguments."
    assert describe_arguments([]) == expected


def test_a_transition_follows_one_of_the_same_node(tree):
    found = tree(
        """
        LifecycleNode(executable="/bin/cat", name="a", namespace="", autostart=True),
        LoadComposableNodes(target_container="/box", composable_node_descriptions=[
            ComposableLifecycleNode(package="p", plugin="P", name="c", autostart=True)]),
        LifecycleNode(executable="/bin/cat", name="b", namespace="", autostart=True),
        """
    )
    when = {line.split("── ")[1] for line in found if ": activate" in line}
    assert when == {
        "/a: activate  when cat-1 goes from configuring to inactive",
        "/b: activate  when cat-2 goes from configuring to inactive",
        "/c: activate  when component /c goes from configuring to inactive",
    }


def test_settings_of_a_scope_are_shown_with_name_and_value(tree):
    lines = tree("""
        SetLaunchConfiguration("v", "3"),
        SetParameter("rate", 5),
        SetParameter("name", [LaunchConfiguration("v"), "x"]),
        SetParameter("list", [1, 2]),
        SetRemap("a", "b"),
        SetUseSimTime(True),
        TimerAction(period=LaunchConfiguration("v"), actions=[]),
        ForLoop(LaunchConfiguration("v"), function=lambda i: []),
        ForEach([LaunchConfiguration("w", default="{a: 1}")], function=lambda a: []),
        GroupAction([ReplaceEnvironmentVariables({"A": "1", "B": LaunchConfiguration("v")})]),
        GroupAction([ReplaceEnvironmentVariables({})]),
    """)

    texts = [text for _, text in entries(lines)]
    assert texts == [
        "set v = '3'",
        "parameter rate = 5",
        "parameter name = 3x",
        "parameter list = [1, 2]",
        "remap a to b",
        "timers use simulated time: True",
        "after 3 s",
        "for i from 0, 3 times",
        "for each of LaunchConfig('w')",
        "group",
        "the environment is A=1 B=3",
        "group",
        "the environment is empty",
    ]


@pytest.mark.parametrize("forwarding", [True, False])
def test_values_that_a_group_sets_are_not_from_the_command_line(tree, forwarding: bool):
    lines = tree(f"""
        GroupAction([LogInfo(msg=LaunchConfiguration("v"))], forwarding={forwarding},
                    launch_configurations={{"v": "1"}}),
    """)

    assert "command line" not in "\n".join(lines)
    assert not forwarding or any("set v = '1'  set at a.launch.py:" in line for line in lines)
