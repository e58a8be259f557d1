"""Answers of the control socket as lines of text."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from launcher.base.model.run_events import Sample
from launcher.control.answer_lines import (
    event_line,
    filters,
    info_lines,
    notes,
    table,
    unreachable,
    without_colour,
)
from tests.support.run_events import entry, event, line

ROW: dict[str, Any] = {
    "name": "a-1",
    "state": "RUNNING",
    "paused": False,
    "pid": 7,
    "restarts": 0,
    "uptime_s": 2.0,
    "cpu_percent": 3.2,
    "uss_bytes": 31_000_000,
    "rss_bytes": 58_000_000,
    "last_exit": None,
}
INFO: dict[str, Any] = {
    "node_names": [],
    "cmd": ["a"],
    "cwd": None,
    "restart_policy": "never",
    "stop_policy": "SIGINT",
    "threads": 1,
    "fds": 3,
    "log_file": None,
    "env": {},
    "env_set": {},
    "env_unset": [],
}


@pytest.mark.parametrize(
    ("facts", "lines"),
    [
        ({}, []),
        ({"env_set": {"A": "1"}, "env_unset": ["B"]}, ["A=1", "B is not set"]),
        ({"env": None}, ["not known: another launcher started it"]),
    ],
)
def test_info_tells_how_the_environment_differs(facts: dict[str, Any], lines: list[str]):
    shown = info_lines({**ROW, **INFO, **facts})
    prefix = "  env        "
    assert [one.removeprefix(prefix) for one in shown if one.startswith(prefix)] == lines


@pytest.mark.parametrize(
    ("what", "text"),
    [
        (event("asked", verb="stop"), "requested a-1 verb=stop"),
        (event("asked", verb="kill", signal=10), "requested a-1 verb=kill signal=SIGUSR1"),
        (event("signal", pid=7, signal=2), "signal a-1 pid=7 signal=SIGINT"),
        (
            event("ended", pid=7, returncode=-11, asked=False, restart_in_s=None),
            "ended a-1 pid=7 returncode=SIGSEGV",
        ),
        (
            event("ended", pid=None, returncode=3, asked=True, restart_in_s=0.0),
            "ended a-1 returncode=3 requested restart_in_s=0.0",
        ),
        (event("waiting", after=("x", "y"), timeout_s=30), "waiting a-1 after=x,y timeout_s=30"),
        (event("link", host="bot1", state="ready", reason=""), "link host=bot1 state=ready"),
        (event("stopping", reason="a\nb\x1b[2J"), "stopping reason=a\\nb\\x1b[2J"),
        (event("withdrawn"), "withdrawn a-1"),
    ],
)
def test_an_event_is_one_line_with_names_of_signals_and_only_what_is_known(what, text: str):
    assert re.fullmatch(rf"\d\d:\d\d:\d\d {re.escape(text)}", event_line(entry(what).item))


def test_memory_is_the_uss_by_this_name_everywhere():
    sample = {
        "pid": 7, "cpu_percent": 3.2, "rss_bytes": 58_000_000, "uss_bytes": 31_000_000,
        "threads": 1, "fds": 3, "processes": 1,
    }  # fmt: skip
    samples = {"a-1": Sample(**sample), "b-2": Sample(**{**sample, "uss_bytes": None})}
    item = json.loads(line(entry(event("resources", processes=samples))))
    assert event_line(item).endswith(" resources (CPU, USS): a-1=3%,31MB b-2=3%")
    (head, row) = table([ROW])
    assert head.split()[-1] == "USS" and row.endswith("31.0 MB")
    assert "  memory     31.0 MB USS, 58.0 MB RSS" in info_lines({**ROW, **INFO})


def test_colours_are_removed_where_there_are_none():
    assert without_colour("\x1b[33m[WARN] a\x1b[0m \x1b[38;5;39mb\x1b[m") == "[WARN] a b"


@pytest.mark.parametrize(
    ("hidden", "text"),
    [(0, "muted"), (1, "muted, 1 line not shown"), (2, "muted, 2 lines not shown")],
)
def test_hidden_lines_are_counted_if_there_are_any(hidden: int, text: str):
    assert filters({"muted": True, "hidden_lines": hidden}) == text


def test_a_process_without_filters_has_nothing_hidden():
    assert filters({"hidden_lines": 3}) == ""


def test_hosts_are_a_column_where_there_are_some():
    here = {**ROW, "host": "local", "unreachable_s": None}
    there = {**ROW, "name": "b-2", "host": "bot1", "unreachable_s": 4.7}
    head, first, second = table([here, there])
    assert head.split()[:4] == ["NAME", "HOST", "STATE", "PID"]
    assert first.startswith("a-1   local  RUNNING                     7")
    assert second.startswith("b-2   bot1   RUNNING, unreachable 4 s    7")
    assert unreachable({"unreachable_s": 0.2}) == "unreachable"  # it has just answered
    lines = info_lines({**there, **INFO})
    assert lines[1:3] == ["  host       bot1", "  state      RUNNING, unreachable 4 s"]


def test_how_often_resources_are_sampled_is_told_only_if_it_is_seldom():
    assert notes({"sampled_every_s": 1.0}) == []
    seldom = notes({"sampled_every_s": 5.0})
    assert seldom == ["CPU and memory are sampled every 5 s: there are many processes"]


def test_who_was_not_asked_and_who_has_not_answered_is_below_the_table_with_the_reason():
    unnamed = "no node name in the launch file"
    result = {
        "sampled_every_s": 1.0,
        "processes": [{"name": "hang.py-1", "uptime_s": 12.3}, {"name": "c-4", "uptime_s": None}],
        "unanswered": [
            {"name": "hang.py-1", "asked": True, "reason": "has never answered"},
            {"name": "a-2", "asked": False, "reason": unnamed},
            {"name": "b-3", "asked": False, "reason": unnamed},
            {"name": "c-4", "asked": True, "reason": "does not answer any more"},
        ],
    }
    assert notes(result) == [
        "has never answered: hang.py-1 (started 12 s ago); it hangs or has no parameter services",
        f"not asked, {unnamed}: a-2, b-3",
        "does not answer any more: c-4; it hangs or has no parameter services",
    ]


def test_a_node_that_does_not_respond_and_a_debugger_are_told_with_the_state():
    hangs = {**ROW, "not_responding_s": 4.7}
    assert table([hangs])[1].split("  ")[1].strip() == "RUNNING, not responding 4 s"
    assert "not responding" not in table([{**ROW, "not_responding_s": 0.0}])[1]
    assert (
        "RUNNING, debugger at 127.0.0.1:5678" in table([{**ROW, "debugger": "127.0.0.1:5678"}])[1]
    )
