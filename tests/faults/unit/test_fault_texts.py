"""Faults in words: the order of the table, lines of a stream, the mark in the status bar."""

from __future__ import annotations

import time
from typing import Any

from launcher.control.console.bar import status_lines, width
from launcher.control.console.fault_table import fault_table
from launcher.control.console.process_tables import process_table, render
from launcher.control.fault_texts import FaultLines, arranged
from tests.control.unit.console.rows import FLEET, process
from tests.support.watcher_stand_in import fault

HEALED = {"state": "healed", "healed_s": time.time()}


def text_of(line: list[tuple[str, str]]) -> str:
    return "".join(text for _, text in line)


def test_active_faults_come_first_and_what_follows_is_below():
    faults = [
        fault("old", first_s=1.0, **HEALED),
        fault("doubt", first_s=2.0, state="suspected"),
        fault("second", first_s=4.0, follows="first"),
        fault("third", first_s=5.0, follows="second", **HEALED),
        fault("first", first_s=3.0),
        fault("other", first_s=1.0, follows="gone"),
        fault("new", first_s=6.0, **HEALED),
    ]
    expected = [
        (0, "other"),
        (0, "first"),
        (1, "second"),
        (2, "third"),
        (0, "doubt"),
        (0, "new"),
        (0, "old"),
    ]
    assert [(depth, one["fault"]) for depth, one in arranged(faults)] == expected


def test_faults_that_follow_from_each_other_are_shown_once():
    faults = [fault("a", first_s=1.0, follows="b"), fault("b", first_s=2.0, follows="a")]

    assert [(depth, one["fault"]) for depth, one in arranged(faults)] == [(0, "a"), (1, "b")]


def test_a_narrow_table_has_the_cause_below_what_was_seen():
    result = {"faults": [fault("x", seen="\x1b[31mred [bold]", cause="a was killed", count=3)]}
    wide, narrow = (render(fault_table(result, n), n, colour=False) for n in (160, 80))

    assert "active x3  x " in wide and wide.endswith("  \\x1b[31mred [bold]  a was killed")
    assert narrow.splitlines()[-1].strip() == "because: a was killed"


def test_updates_are_lines_only_if_more_than_a_value_has_changed():
    lines = FaultLines()

    def said(change: str, **fields: Any) -> str:
        return (lines.of({**fault(**fields), "change": change}) or "").partition(" ")[2]

    cause = "; cat-1 was killed (SIGKILL)"
    assert said("confirmed") == f"confirmed: robot_1 reports: no message for 3.0 s{cause}"
    assert said("updated", seen="no message for 3.2 s") == ""
    muted = {"reason": None, "until_s": None}
    assert said("updated", seen="none", muted=muted) == f"muted: robot_1 reports: none{cause}"
    assert said("healed", **HEALED, cause=None, seen="\n") == "healed: robot_1 reports: \\n"


def test_the_status_bar_has_a_mark_that_stays_when_it_is_narrow():
    for columns in (30, 160):
        line = status_lines(FLEET, "~/log", columns, hint="", few=True, faults=2)[0]
        assert line[0] == ("class:bar.trouble", "2 faults")
        assert width(line) <= columns
    shown = status_lines(FLEET, "~/log", 160, hint="", few=True, faults=0)[0]
    assert "fault" not in text_of(shown)


def test_ps_has_a_column_only_where_there_is_a_fault():
    rows = [process("a-1", faults=["one", "two", "three"]), process("b-2", faults=[])]
    texts = [render(process_table(one, 120), 120, colour=False) for one in (rows, rows[1:])]

    assert "one +2" in texts[0] and "faults" not in texts[1]
