"""Budgets of actions, and what is shown on the desktop."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.model.fault_action import FaultAction
from launcher.faults.actions import desktop
from launcher.faults.actions.action_budget import ActionBudget


def test_a_budget_is_for_any_span_of_its_length_and_refuses_with_one_warning():
    budget = ActionBudget(2, 10.0)
    found = [(budget.take(at_s), budget.is_first_refusal) for at_s in (0, 4, 9, 9.5, 10, 11, 14)]
    assert [taken for taken, _ in found] == [True, True, False, False, True, False, True]
    assert [first for _, first in found] == [False, False, True, False, False, True, False]


@pytest.mark.parametrize(
    ("pattern", "is_possible"),
    [
        ("disk", True),
        ("robot_?", True),
        ("no deaths: robot_2-3", True),
        ("no *", True),
        ("*", True),
        ("no deaths", False),
        ("robot_10", False),
        ("QoS: *", False),
    ],
)
def test_a_pattern_may_fit_a_fault_of_every_watched_run(pattern: str, is_possible: bool):
    action = FaultAction(pattern, "snapshot")
    assert action.may_fit(["robot_1", "disk", "no deaths: *"]) is is_possible


def test_a_desktop_is_needed_and_a_program(tmp_path: Path):
    assert desktop.sender({"DISPLAY": ":0", "PATH": str(tmp_path)}) is None
    for name in ("busctl", "notify-send"):
        program = tmp_path / name
        program.touch(0o755)
        assert desktop.sender({"DISPLAY": ":0", "PATH": str(tmp_path)}) == str(program)
    assert desktop.sender({"PATH": str(tmp_path)}) is None


@pytest.mark.parametrize("program", ["/x/notify-send", "/x/busctl"])
def test_texts_of_nodes_are_neither_options_nor_markup(program: str):
    fault = {"state": "active", "fault": "--x\0", "seen": "<b>\x1b", "cause": "a & b"}
    words = desktop.words(program, fault)
    title, body = "active: --x\\x00", "&lt;b&gt;\\x1b; a &amp; b"
    assert words.index("--") < words.index(title) < words.index(body)
    assert words[words.index(title) + 1] == body
