"""The tree of a plan as data: the entries of the tree that `plan` prints."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import pytest

from launcher.launch.outline import outline
from launcher.launch.plan.planner import make_plan
from tests.launch.unit.test_render import HEAD


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The tree of a launch file, given the text of its actions."""
    monkeypatch.chdir(tmp_path)

    def make(actions: str) -> list[dict[str, Any]]:
        file = tmp_path / "a.launch.py"
        file.write_text(f"{HEAD}{textwrap.indent(textwrap.dedent(actions), '        ')}\n    ])\n")
        return outline(make_plan(str(file), ()))

    return make


def test_an_entry_has_its_kind_and_its_place(tree):
    (argument, process, skipped) = tree(
        """
        DeclareLaunchArgument("a", default_value="1, 2"),
        sh("x", condition=IfCondition("true")),
        sh("y", condition=IfCondition("false")),
        """
    )
    assert argument == {
        "kind": "value",
        "text": "argument a = '1, 2'",
        "detail": "default at a.launch.py:16",
        "place": "a.launch.py:16",
        "name": None,
        "children": [],
    }
    assert (process["kind"], process["name"], process["text"]) == ("process", "x-1", "x-1")
    assert (process["detail"], process["place"]) == ("if true: yes", "a.launch.py:11")
    assert (skipped["kind"], skipped["name"]) == ("skipped", None)


def test_what_happens_later_is_below_its_cause(tree):
    (timer, handler) = tree(
        """
        TimerAction(period=2.0, actions=[sh("late")]),
        RegisterEventHandler(OnProcessStart(on_start=[sh("then")])),
        """
    )
    (late,) = timer["children"]
    assert (timer["kind"], late["name"], late["detail"]) == ("event", "late-1", "at 2 s")
    assert handler["kind"] == "event" and handler["place"] == "a.launch.py:17"
