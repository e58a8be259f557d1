"""Texts in parameters reach a node as texts, however they are written; rcl decides."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from launcher.base.model.parameter_text import file_text
from tests.support.repository import REPOSITORY
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import launcher

Printed = Callable[..., dict[str, Any]]

TEXTS = (
    *("0483", "0123", "1e5", "1.5e3", "-7", "0x1F", "0x1p3", "1_000", "9223372036854775808"),
    *("y", "n", "yes", "No", "on", "OFF", "true", "nan", "NAN(1)", ".nan", "-inf", ".inf"),
    *("~", "null", "", " lead", "trail ", "a: b", "a #b", "#x", "!tag", "&x", "*x", "@x", "%x"),
    *("-", "- 1", "?", "[", "{", "|", ">", "=", "<<", "...", "1:30", "2026-01-01"),
    *("ünïcode 😀", "new\nline", "tab\t", "\r\n", "\x85", "\ufeffx", "\\", '"q"', "'q'", "a" * 300),
)

IMPORTS = """
import json, sys, tempfile
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteLocal
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.descriptions import Node as NodeDescription, RosExecutable
from launch_ros.parameter_descriptions import Parameter, ParameterFile, ParameterValue

TEXTS = json.load(open(%(texts)r))
PRINTER = ["-m", "tests.support.parameter_printer"]

def named():
    return {f"t{number}": text for number, text in enumerate(TEXTS)}

def copied(path):
    with tempfile.NamedTemporaryFile("w", delete=False) as file:
        file.write(open(path).read())
    return file.name

def printer(name, **options):
    return Node(
        executable=sys.executable, arguments=PRINTER, name=name, output="screen", **options)

def generate_launch_description():
    return LaunchDescription([
        %(actions)s
    ])
"""


@pytest.fixture(scope="module")
def env(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path_factory.mktemp("log")) as env:
        yield env


@pytest.fixture
def printed(env: dict[str, str], tmp_path: Path) -> Printed:
    """Runs actions of a launch file; node -> parameters that it was given."""

    def run(actions: str, *words: str, suffix: str = "py") -> dict[str, Any]:
        file = tmp_path / f"a.launch.{suffix}"
        texts = tmp_path / "texts.json"
        texts.write_text(json.dumps(TEXTS))
        given = {"texts": str(texts), "actions": actions}
        file.write_text(IMPORTS % given if suffix == "py" else actions, encoding="utf-8")
        command = [sys.executable, "-m", "launcher", str(file), "--no-parameter-check", *words]
        done = subprocess.run(
            command, env=env, cwd=REPOSITORY, capture_output=True, text=True, timeout=120
        )
        assert done.returncode == 0, done.stdout + done.stderr
        lines = [line.partition("] ")[2] for line in done.stdout.splitlines() if '{"node"' in line]
        return {one["node"].lstrip("/"): one["parameters"] for one in map(json.loads, lines)}

    return run


NAMED = {f"t{number}": text for number, text in enumerate(TEXTS)}


def test_every_text_reaches_a_node_as_it_is(printed: Printed):
    found = printed(
        """
        printer("single", parameters=[named()]),
        printer("lists", parameters=[{"all": TEXTS, "two": ["1e5", "a"]}]),
        printer("typed", parameters=[
            {name: ParameterValue(text, value_type=str) for name, text in named().items()}]),
        printer("ruled", parameters=[
            Parameter(name, text, value_type=str) for name, text in named().items()]),
        ExecuteLocal(output="screen", process_description=RosExecutable(
            executable=sys.executable, arguments=PRINTER, nodes=[
                NodeDescription(node_name="described", parameters=[
                    Parameter(name, text, value_type=str) for name, text in named().items()])])),
        """
    )
    assert found.pop("lists") == {"all": list(TEXTS), "two": ["1e5", "a"]}
    assert sorted(found) == ["described", "ruled", "single", "typed"]
    for node, parameters in found.items():
        assert parameters == NAMED, node


XML = """
<launch>
  <arg name="serial"/>
  <arg name="speed"/>
  <node exec="{python}" args="-m tests.support.parameter_printer" name="x" output="screen">
    <param name="serial" value="$(var serial)" type="str"/>
    <param name="other" value="0483" type="str"/>
    <param name="axis" value="y"/>
    <param name="speed" value="$(var speed)"/>
  </node>
</launch>
"""
YAML = """
launch:
- arg: {{name: serial}}
- arg: {{name: speed}}
- node:
    exec: "{python}"
    args: -m tests.support.parameter_printer
    name: x
    output: screen
    param:
    - {{name: serial, value: $(var serial), type: str}}
    - {{name: other, value: "0483", type: str}}
    - {{name: axis, value: y}}
    - {{name: speed, value: $(var speed)}}
"""


@pytest.mark.thorough
@pytest.mark.parametrize(("suffix", "text"), [("xml", XML), ("yaml", YAML)])
def test_markup_has_texts_too_and_a_number_without_a_point_is_one(
    printed: Printed, suffix: str, text: str
):
    actions = text.format(python=sys.executable)
    for speed, given in (("1e-3", "1e-3"), ("1.0e-3", 0.001)):
        found = printed(actions, "serial:=1e5", f"speed:={speed}", suffix=suffix)
        assert found["x"] == {"serial": "1e5", "other": "0483", "axis": "y", "speed": given}


@pytest.mark.thorough
def test_a_value_without_a_type_is_a_text_where_yaml_makes_it_one(printed: Printed):
    found = printed(
        """
        DeclareLaunchArgument("v", default_value="2E6"),
        DeclareLaunchArgument("typed", default_value="2E6"),
        DeclareLaunchArgument("several", default_value="[1e-3, 2e-3]"),
        DeclareLaunchArgument("mixed", default_value="[1e-3, a]"),
        printer("x", parameters=[
            {name: LaunchConfiguration(name) for name in ("v", "several", "mixed")},
            {"typed": ParameterValue(LaunchConfiguration("typed"), value_type=float)}]),
        """
    )
    assert found["x"] == {
        "v": "2E6",
        "typed": 2e6,
        "several": ["1e-3", "2e-3"],
        "mixed": ["1e-3", "a"],
    }


@pytest.mark.thorough
@pytest.mark.parametrize(
    "given", ["ParameterFile({path!r}, allow_substs=True)", "copied({path!r})"]
)
def test_a_temporary_file_is_planned_with_the_types_that_it_has(
    printed: Printed, env: dict[str, str], tmp_path: Path, given: str
):
    file = tmp_path / "p.yaml"
    file.write_text(
        "/**: {ros__parameters: {axis: y, speed: 1e5, octal: 0123, serial: '0483', name: null}}"
    )
    actions = f'printer("x", parameters=[{given.format(path=str(file))}]),'
    expected = {"axis": True, "speed": 1e5, "octal": 83, "serial": "0483", "name": "null"}
    assert printed(actions)["x"] == expected
    command = [sys.executable, "-m", "launcher", "plan", str(tmp_path / "a.launch.py")]
    plan = subprocess.run(command, env=env, cwd=REPOSITORY, capture_output=True, text=True)
    (line,) = [line.partition("$ ")[2] for line in plan.stdout.splitlines() if "$ " in line]
    assert "launcher-plan" in line
    pasted = subprocess.run(
        line, shell=True, env=env, cwd=REPOSITORY, capture_output=True, text=True, timeout=60
    )
    assert json.loads(pasted.stdout)["parameters"] == expected, line


def test_what_dump_prints_another_node_gets_with_the_same_types(
    env: dict[str, str], tmp_path: Path
):
    file = tmp_path / "p.yaml"
    values = {**NAMED, "all": list(TEXTS), "speed": 2.0, "group": {"a": 1, "b": True}}
    file.write_text(file_text({"/site/east/listener": {"ros__parameters": values}}))
    with talking(env, "tests.support.sample_nodes"):
        loaded = launcher(env, "param", "load", "/site/east/listener", str(file))
        assert loaded.code == 0, loaded
        dumped = launcher(env, "param", "dump", "/site/east/listener")
    file.write_text(dumped.out, encoding="utf-8")
    names = ("-r", "__node:=listener", "-r", "__ns:=/site/east", "--params-file", str(file))
    words = [sys.executable, "-m", "tests.support.parameter_printer", "--ros-args", *names]
    printed = subprocess.run(
        words, env=env, cwd=REPOSITORY, capture_output=True, text=True, timeout=60
    )
    found = json.loads(printed.stdout)["parameters"]
    assert {name: found[name] for name in NAMED} == NAMED
    assert found["all"] == list(TEXTS)
    assert (found["speed"], found["group.a"], found["group.b"]) == (2.0, 1, True)


@pytest.mark.thorough
def test_dump_leaves_out_what_has_no_value(env: dict[str, str]):
    with talking(env, "tests.support.parameter_node"):
        dumped = launcher(env, "param", "dump", "/tunable")
    assert dumped.code == 0, dumped
    assert "later" not in dumped.out
    assert '    serial: "A7"' in dumped.lines


@pytest.mark.thorough
def test_only_a_parameter_that_may_changes_its_type(env: dict[str, str]):
    with talking(env, "tests.support.parameter_node"):
        words = ("5", "abc", "-.inf", "-1e3")
        for word, shown in zip(words, ("5", "abc", "-inf", "-1000.0"), strict=True):
            done = launcher(env, "param", "set", "/tunable", "loose", word)
            assert (done.code, done.err) == (0, ""), done
            assert (
                launcher(env, "param", "get", "/tunable", "loose", "--hide-type").out
                == f"{shown}\n"
            )
        done = launcher(env, "param", "set", "/tunable", "loose", "7", "--atomic")
        assert done.code == 0, done
        assert launcher(env, "param", "get", "/tunable", "loose").out == "Integer value is: 7\n"
        assert launcher(env, "param", "set", "/tunable", "gears", "x").code == 1
