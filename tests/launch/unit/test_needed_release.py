"""Which distribution of ROS 2 a launch file needs, and what plan says about it."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.language.compat.compat_table import MODULES
from launcher.language.diagnostics.origin import FileLine
from launcher.language.frontends.parsers.tables import ACTIONS, SUBSTITUTIONS
from launcher.launch.needed_release import FIRST, TARGETS, warnings
from launcher.launch.verbs import plan

XML = """<launch>
  <for len="1" name="i"><log message="$(index i)"/></for>
  <log level="info" message="$(any 1) $(path-join a)"/>
  <include file="FOLDER/b.launch.py"><let name="q" value="1"/></include>
</launch>
"""
PYTHON = """from launch import LaunchDescription, actions
from launch.actions import *
from launch.substitutions import StringJoinSubstitution, TextSubstitution
HAS_LOOPS = hasattr(actions, "ForEach")

def generate_launch_description():
    actions.LogError(msg="x")
    return LaunchDescription([LogInfo(msg=StringJoinSubstitution(["a", "b"]))])
"""
OF_KILTED = [
    "a.launch.xml:3: $(path-join)",
    "a.launch.xml:3: <log level>",
    "b.launch.py:7: LogError",
]
OF_JAZZY = [
    *("a.launch.xml:2: $(index)", "a.launch.xml:2: <for>", *OF_KILTED),
    "b.launch.py:3: StringJoinSubstitution",
]


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A launch file that includes another one, with Jazzy installed."""
    monkeypatch.setenv("ROS_DISTRO", "jazzy")
    (tmp_path / "b.launch.py").write_text(PYTHON)
    path = tmp_path / "a.launch.xml"
    path.write_text(XML.replace("FOLDER", str(tmp_path)))
    return path


def said(text: str, folder: Path, end: str) -> list[str]:
    """What `plan` says needs a newer release, without the distributions."""
    lines = [line for line in text.splitlines() if " needs ROS 2 " in line]
    assert all(line.endswith(end) for line in lines)
    found = [line.removeprefix(f"warning: {folder}/").partition(" needs ")[0] for line in lines]
    return sorted(found)


@pytest.mark.parametrize(
    ("target", "expected"), [("jazzy", OF_JAZZY), ("kilted", OF_KILTED), ("lyrical", [])]
)
def test_plan_warns_of_what_is_newer_than_the_target(
    file: Path, target: str, expected: list[str], capsys: pytest.CaptureFixture[str]
):
    assert plan.main([str(file), "--target", target]) == 0

    end = f"; the target is {target.title()}"
    assert said(capsys.readouterr().out, file.parent, end) == sorted(expected)


def test_plan_warns_of_what_is_newer_than_the_installed_one(
    file: Path, capsys: pytest.CaptureFixture[str]
):
    assert plan.main([str(file), "--json"]) == 0

    streams = capsys.readouterr()
    assert said(streams.err, file.parent, "; installed is Jazzy") == sorted(OF_JAZZY)
    assert "$(index) needs ROS 2 Kilted; " in streams.err
    assert " needs " not in streams.out


STAR = """from launch import Event, EventHandler, LaunchDescription
from launch.actions import *
import launch.actions

def generate_launch_description():
    return LaunchDescription([
        LogInfo(msg="x"), *(Log(msg=level, level=level) for level in ()),
        RegisterEventHandler(
            EventHandler(matcher=never, entities=LogInfo(msg="x"))),
        RegisterEventHandler(EventHandler(matcher=never, entities=[LogInfo(msg="x")])),
        launch.actions.ForLoop("0"),
        helper(),
    ])

def helper():
    return ForEach("", function=lambda: [ForEach("")])

def never(event):
    return False

LogDebug = LogInfo
LogDebug(msg="its own")
"""


def test_names_behind_import_star_and_single_entities_count_where_they_are_used(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = tmp_path / "c.launch.py"
    file.write_text(STAR)

    assert plan.main([str(file), "--target", "jazzy"]) == 0

    assert said(capsys.readouterr().out, tmp_path, "; the target is Jazzy") == [
        "c.launch.py:11: ForLoop",
        "c.launch.py:16: ForEach",
        "c.launch.py:7: Log",
        "c.launch.py:9: EventHandler(entities=ENTITY)",
    ]


@pytest.mark.parametrize("distribution", [None, "noetic"])
def test_nothing_is_said_of_an_unknown_distribution(distribution: str | None):
    uses = [("<rep_env>", FileLine("/a.xml", 1))]

    assert warnings(uses, distribution, is_target=False) == []
    assert warnings(uses, "humble", is_target=False) == [
        "warning: /a.xml:1: <rep_env> needs ROS 2 Lyrical; installed is Humble"
    ]


def test_the_table_has_names_that_exist():
    classes = {
        name.partition("=")[0]
        for modules in MODULES.values()
        for names in modules.values()
        for name in names.split()
    }
    elsewhere = {"EventHandler(entities=ENTITY)", "ComposableLifecycleNode"}
    for name in FIRST.keys() - elsewhere:
        if name.startswith("$("):
            assert name[2:-1] in SUBSTITUTIONS
        elif name.startswith("<"):
            assert name.strip("<>").split()[0] in {*ACTIONS, "composable_lifecycle_node"}
        else:
            assert name in classes
    assert set(FIRST.values()) == set(TARGETS)
