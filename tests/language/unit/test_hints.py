"""Hints for mistakes of newcomers."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from launcher.base.errors import LaunchFileError
from launcher.launch.plan.planner import make_plan
from tests.language.unit.test_errors import HEAD


def fault(tmp_path: Path, text: str, name: str = "x.launch.py") -> LaunchFileError:
    """The error of a launch file; line 7 of a Python file is the first one of the text."""
    file = tmp_path / name
    file.write_text(f"{HEAD}{text}\n" if name.endswith(".py") else text)
    error = make_plan(str(file), []).error
    assert error is not None
    return error.fault


def description(*entries: str) -> str:
    """The text of a function; the first entry is in line 8."""
    return (
        "    return LaunchDescription([\n"
        + "".join(f"        {one},\n" for one in entries)
        + "    ])"
    )


# ---- files


def test_a_missing_include_in_the_working_directory_has_its_line_and_a_near_name(
    tmp_path: Path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "child.launch.py").write_text("")

    error = fault(tmp_path, description("IncludeLaunchDescription('chlid.launch.py')"))

    assert error.message == f"the included launch file {tmp_path}/chlid.launch.py does not exist"
    assert error.hint == "did you mean 'child.launch.py'?"
    assert str(error.where).endswith("x.launch.py:8")


def test_a_missing_include_without_its_suffix_has_the_file_with_it(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "go.launch.py").write_text("")

    error = fault(tmp_path, description("IncludeLaunchDescription('go.launch')"))

    assert error.hint == "did you mean 'go.launch.py'?"


def test_a_missing_include_of_a_yaml_file_has_its_line_and_a_near_name(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.launch.yaml").write_text("")
    text = "launch:\n- include:\n    file: thre.launch.yaml\n"

    error = fault(tmp_path, text, "x.launch.yaml")

    assert error.hint == "did you mean 'there.launch.yaml'?"
    assert str(error.where).endswith("x.launch.yaml:3")


def test_a_relative_include_beside_the_launch_file_is_not_one_below_the_working_directory(
    tmp_path: Path, monkeypatch
):
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    (tmp_path / "child.launch.py").write_text("")

    error = fault(tmp_path, description("IncludeLaunchDescription('child.launch.py')"))

    assert error.hint == (
        f"relative paths are those below {here}; "
        "write PathJoinSubstitution([ThisLaunchFileDir(), 'child.launch.py'])"
    )


def test_a_missing_parameter_file_is_reported_once_with_a_near_name(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "params.yaml").write_text("")
    node = "Node(package='group_gp1', executable='robot_1', parameters=['prams.yaml'])"
    file = tmp_path / "x.launch.py"
    file.write_text(HEAD + description(node))

    plan = make_plan(str(file), [])

    (warning,) = plan.warnings
    assert warning.text == (
        "Parameter file path is not a file: prams.yaml; the node starts without it; "
        "hint: did you mean 'params.yaml'?"
    )
    assert [text for text, _ in plan.logs if "prams" in text] == []


def test_a_cycle_of_relative_includes_is_named(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "y.launch.py").write_text(
        HEAD + description("IncludeLaunchDescription('x.launch.py')")
    )

    error = fault(tmp_path, description("IncludeLaunchDescription('y.launch.py')"))

    assert error.message == (
        "launch files include each other endlessly: x.launch.py -> y.launch.py -> x.launch.py"
    )


# ---- expressions


def test_a_syntax_error_of_an_expression_in_xml_has_its_line_and_the_expression(tmp_path: Path):
    text = (
        "<launch>\n  <arg name='a' default='$(eval 1+)'/>\n  <log message='$(var a)'/>\n</launch>"
    )

    error = fault(tmp_path, text, "x.launch.xml")

    assert error.message == "in the Python expression `1+`: invalid syntax"
    assert str(error.where).endswith("x.launch.xml:2")
    assert error.column == text.split("\n")[1].index("eval") + 1


def test_a_value_without_quotes_in_an_expression_is_explained(tmp_path: Path):
    expression = "PythonExpression([LaunchConfiguration('mode'), \" == 'sim'\"])"
    argument = "DeclareLaunchArgument('mode', default_value='sim')"

    error = fault(tmp_path, description(argument, f"LogInfo(msg={expression})"))

    assert error.message.endswith("NameError: name 'sim' is not defined")
    assert error.hint is not None
    assert error.hint.startswith("it is the value of mode: put it in quotes")
    assert str(error.where).endswith("x.launch.py:9")


def test_a_comparison_with_a_text_in_a_condition_is_an_equals_substitution(tmp_path: Path):
    condition = "IfCondition(LaunchConfiguration('mode') == 'sim')"
    start = "    from launch.conditions import IfCondition\n"

    error = fault(tmp_path, start + description(f"LogInfo(msg='x', condition={condition})"))

    assert error.message == "a substitution is compared with a text, and is never equal to it"
    assert error.hint == "write EqualsSubstitution(LaunchConfiguration('mode'), 'sim')"


def test_the_text_of_a_number_is_that_of_the_number(tmp_path: Path):
    error = fault(tmp_path, "    n = 42\n" + description("LogInfo(msg=n)"))

    assert error.hint == "write it as a text, as in '42'"


def test_a_value_that_is_nearly_true_gets_one_hint(tmp_path: Path):
    text = "<launch>\n  <log message='x' if='True1'/>\n</launch>"

    assert fault(tmp_path, text, "x.launch.xml").hint == "did you mean true?"


# ---- XML


def test_an_ampersand_in_xml_is_written_as_an_entity(tmp_path: Path):
    text = "<launch>\n  <executable cmd='echo a & b'/>\n</launch>"

    error = fault(tmp_path, text, "x.launch.xml")

    assert (error.hint, str(error.where)[-2:]) == ("write &amp; for a literal '&'", ":2")


def test_a_tag_without_its_end_in_xml_is_named_with_its_line(tmp_path: Path):
    text = "<launch>\n  <node pkg='p' exec='e'\n</launch>"

    assert fault(tmp_path, text, "x.launch.xml").hint == "<node in line 2 has no '>' at its end"


# ---- declarations and imports


def test_an_argument_that_is_declared_below_its_use_is_named_with_that_line(tmp_path: Path):
    use = "LogInfo(msg=LaunchConfiguration('p'))"

    error = fault(tmp_path, description(use, "DeclareLaunchArgument('p', default_value='1')"))

    assert error.hint == "'p' is declared below, in line 9; move the declaration in front"


def test_an_argument_that_is_declared_below_its_use_in_markup_is_named(tmp_path: Path):
    xml = "<launch>\n  <log message='$(var p)'/>\n  <arg name='p' default='1'/>\n</launch>"
    yaml = "launch:\n- log:\n    message: $(var p)\n- arg:\n    name: p\n    default: '1'\n"

    for text, name, line in ((xml, "x.launch.xml", 3), (yaml, "x.launch.yaml", 4)):
        hint = fault(tmp_path, text, name).hint
        assert hint == f"'p' is declared below, in line {line}; move the declaration in front"


def test_a_node_of_descriptions_is_imported_from_actions(tmp_path: Path):
    start = "    from launch_ros.descriptions import Node\n"

    error = fault(tmp_path, start + description("Node(package='p', executable='e')"))

    assert error.hint == "import Node from launch_ros.actions instead of launch_ros.descriptions"


def test_an_empty_launch_key_is_written_as_a_list(tmp_path: Path):
    assert fault(tmp_path, "launch:\n", "x.launch.yaml").hint == "write 'launch: []'"


def test_a_misspelt_class_and_a_keyword_of_xml_are_suggested(tmp_path: Path):
    assert fault(tmp_path, description("ExecuteProces(cmd=['x'])")).hint == (
        "did you mean 'ExecuteProcess'?"
    )
    node = "Node(pkg='p', executable='e')"
    assert fault(tmp_path, description(node), "y.launch.py").hint == "did you mean 'package'?"


MY_PATH = """    class MyPath:
        def __fspath__(self):
            return "/x"
"""


@pytest.mark.parametrize(
    ("entry", "message", "hint"),
    [
        ("LogInfo(msg=MyPath())", "a MyPath", "write os.fspath(MyPath())"),
        ("LogInfo(msg=['a', MyPath()])", "a MyPath", "write os.fspath(MyPath())"),
        ("LogInfo(msg=x)", "a MyPath", "write it as a text, as in os.fspath(...)"),
        ("PathJoinSubstitution([x, 'b'])", "a MyPath", "write it as a text, as in os.fspath(...)"),
        ("LogInfo(msg=b'xy')", "bytes", "write 'xy'"),
        ("Node(executable=b'xy')", "bytes", "write 'xy'"),
    ],
)
def test_paths_of_other_classes_and_bytes_are_no_texts(
    tmp_path: Path, entry: str, message: str, hint: str
):
    imports = "    from launch.substitutions import PathJoinSubstitution\n"
    error = fault(tmp_path, imports + MY_PATH + "    x = MyPath()\n" + description(entry))

    assert error.message == f"{message} where a text or a substitution is expected"
    assert error.hint == hint


# ---- keyword arguments


@pytest.mark.parametrize(
    ("entry", "message", "meant"),
    [
        ("Node(exectuable='x', package='p')", "Node has no argument 'exectuable'", "executable"),
        ("Node(package='p', exec='x')", "Node has no argument 'exec'", "executable"),
        ("Node(pkg='p', exec='x')", "Node has no argument 'pkg'", "package"),
        ("LogInfo(mesage='x')", "LogInfo has no argument 'mesage'", "msg"),
        ("LogInfo(text='x')", "LogInfo has no argument 'text'", "msg"),
        ("TimerAction(period=1.0, action=[])", "TimerAction has no argument 'action'", "actions"),
        (
            "launch.actions.ExecuteProcess(comand=['ls'])",
            "ExecuteProcess has no argument 'comand'",
            "cmd",
        ),
        (
            "RegisterEventHandler(OnProcessExit(on_exti=[]))",
            "OnProcessExit has no argument 'on_exti'",
            "on_exit",
        ),
    ],
)
def test_a_misspelt_argument_that_is_required_gets_the_near_name(tmp_path, entry, message, meant):
    imports = "    import launch\n    from launch.event_handlers import OnProcessExit\n"
    error = fault(tmp_path, imports + description(entry))

    assert (error.message, error.hint) == (message, f"did you mean '{meant}'?")
    assert str(error.where).endswith("x.launch.py:10")
    assert error.source_line is not None
    assert error.source_line[(error.column or 0) - 1 :].startswith(message.split("'")[1])


def test_a_misspelt_argument_over_several_lines_is_shown_in_its_line(tmp_path):
    error = fault(tmp_path, description("Node(\n    package='p',\n    exectuable='x')"))

    assert str(error.where).endswith("x.launch.py:10")
    assert error.hint == "did you mean 'executable'?"


@pytest.mark.parametrize(
    ("entry", "meant"),
    [
        ("LogInfo(msg=LaunchConfiguration('x', defualt='x'))", "default"),
        ("LogInfo(msg='x', condition=IfCondition(predicate='x'))", "predicate_expression"),
        ("RegisterEventHandler(OnProcessExit(target_acton=1, on_exit=[]))", "target_action"),
        ("ComposableNode(package='a', plugn='b')", "plugin"),
    ],
)
def test_a_misspelt_argument_gets_the_near_name_of_its_class(tmp_path, entry, meant):
    imports = (
        "    from launch.conditions import IfCondition\n"
        "    from launch.event_handlers import OnProcessExit\n"
        "    from launch_ros.descriptions import ComposableNode\n"
    )
    error = fault(tmp_path, imports + description(entry))

    assert "unexpected keyword argument" in error.message
    assert error.hint == f"did you mean '{meant}'?"


def test_a_required_argument_that_nothing_stands_for_is_named_as_missing(tmp_path):
    error = fault(tmp_path, description("Node(package='p', name='x')"))

    assert "missing 1 required keyword-only argument: 'executable'" in error.message
    assert error.hint is None


# ---- names that no ROS 2 has

PROPOSED = (
    "launch_ros.substitutions AmentIndexResource ament-index-resource",
    "launch.substitutions FindLaunchfile find-launchfile",
    "launch_ros.substitutions FindPackageFile find-pkg-file",
    "launch.substitutions IsEmptySubstitution is-empty",
    "launch.substitutions NotEmptySubstitution not-empty",
    "launch.substitutions StringStripSubstitution string-strip",
)


@pytest.mark.parametrize("names", PROPOSED, ids=lambda names: names.split()[1])
def test_a_substitution_that_was_only_proposed_has_one_that_exists(tmp_path: Path, names: str):
    module, cls, word = names.split()

    imported = fault(tmp_path, f"    from {module} import {cls}")
    word_used = fault(tmp_path, f'<launch><log message="$({word} a b)"/></launch>', "x.launch.xml")

    assert f"{module}.{cls} is not provided" in imported.message
    assert word_used.message == f"unknown substitution $({word} ...)"
    for error in (imported, word_used):
        assert (error.hint or "").startswith("no release of ROS 2 has it; write ")
    assert cls not in str(imported.hint) and f"$({word}" not in str(word_used.hint)


def test_the_module_of_a_proposed_substitution_has_the_same_hint(tmp_path: Path):
    error = fault(tmp_path, "    import launch.substitutions.is_empty_substitution")

    assert error.hint == "no release of ROS 2 has it; write EqualsSubstitution(VALUE, '')"


def test_what_the_hints_about_proposed_substitutions_suggest_works(tmp_path: Path):
    python = tmp_path / "a.launch.py"
    stripped = "PythonExpression([\"'''\", VALUE, \"'''.strip()\"])"
    empty = "EqualsSubstitution(VALUE, ''), NotEqualsSubstitution(VALUE, '')"
    entries = f"LogInfo(msg=one) for one in ({stripped}, {empty})"
    python.write_text(
        "from launch import LaunchDescription\nfrom launch.actions import LogInfo\n"
        "from launch.substitutions import *\nVALUE = TextSubstitution(text=' a ')\n"
        f"def generate_launch_description():\n    return LaunchDescription([{entries}])\n"
    )
    xml = tmp_path / "a.launch.xml"
    words = ("$(eval &quot;' a '.strip()&quot;)", "$(equals ' a ' '')", "$(not-equals ' a ' '')")
    xml.write_text("<launch>" + "".join(f'<log message="{word}"/>' for word in words) + "</launch>")
    for file in (python, xml):
        plan = make_plan(str(file), [])
        assert plan.error is None
        assert [text for text, _ in plan.logs] == ["a", "false", "true"]


@pytest.mark.skipif(sys.version_info < (3, 11), reason="exceptions have no notes")
def test_an_error_in_an_included_file_has_the_includes_as_notes(tmp_path: Path):
    method = "def describe_conditional_sub_entities(self): raise OSError"
    odd = f"class Odd(Action):\n    {method}\n"
    head = "from launch import Action, LaunchDescription\n"
    make = "def generate_launch_description():\n    return LaunchDescription([Odd()])\n"
    (tmp_path / "odd.launch.py").write_text(f"{head}{odd}{make}")

    error = fault(tmp_path, description(f"IncludeLaunchDescription('{tmp_path}/odd.launch.py')"))

    notes = getattr(error.__cause__, "__notes__", [])
    assert f"while executing IncludeLaunchDescription({tmp_path}/odd.launch.py)" in notes
