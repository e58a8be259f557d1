"""Process tables for every terminal width, and scrolling and sorting in `top`."""

from __future__ import annotations

import re

import pytest
from rich.cells import cell_len

from launcher.control.console.help_view import MAX_ROWS, ROWS
from launcher.control.console.process_tables import manual, process_table, render
from launcher.control.console.requests import SHELL_VERBS
from launcher.control.console.short_forms import killed_text
from launcher.control.console.stream_view import table_rows
from launcher.control.console.top import Top
from launcher.control.verbs import VERBS
from launcher.posix.keys import parse_keys
from tests.control.unit.console.rows import process

FLEET = [process("dispatcher-1"), process("robot_1-2"), process("robot_2-3")]
CROWD = [
    process(f"worker_{n}-{n + 1}", cpu_percent=float(n), uss_bytes=(50 - n) * 1_000_000)
    for n in range(50)
]


def table(rows: list[dict[str, object]], columns: int) -> list[str]:
    return render(process_table(rows, columns), columns, colour=False).splitlines()


def seen(top: Top, columns: int = 80, rows: int = 10) -> list[str]:
    return top.lines(CROWD, columns, rows, colour=False).split("\n")


# ---- help


def test_a_narrow_manual_has_each_text_below_its_name():
    rows = [("logs [NAME ...] [-n N] [-f]", "print the last lines of processes, hidden ones too")]
    wide = render(manual(rows, 80), 80, colour=False)
    assert wide == f"{rows[0][0]}  {rows[0][1]}"
    narrow = render(manual(rows, 40), 40, colour=False).splitlines()
    assert narrow[0] == rows[0][0]
    assert [line[:2] for line in narrow[1:]] == ["  ", "  "]
    assert " ".join(map(str.strip, narrow[1:])) == rows[0][1]


@pytest.mark.parametrize("columns", [1, 7, 20, 79])
def test_a_manual_is_never_wider_than_the_terminal(columns: int):
    lines = render(manual(ROWS, columns), columns, colour=False).splitlines()
    assert max(map(cell_len, lines)) <= columns


def test_the_short_help_has_twelve_lines_and_names_real_verbs():
    assert len(render(manual(ROWS, 66), 66, colour=False).splitlines()) == MAX_ROWS == 12
    named = {word for name, _ in ROWS[:-3] for word in re.findall(r"[a-z]+", name)}
    known = {verb.name for verb in VERBS} | set(SHELL_VERBS)
    assert named - known == {"f", "list", "on"}


# ---- columns


def test_with_room_for_all_nothing_is_cut():
    died = process("a-1", "EXITED", last_exit={"text": "exit code 3 after 12.4 s", "returncode": 3})
    head, *rows = table([died, *FLEET], 120)
    titles = "name state pid restarts up cpu USS threads shown"
    assert head.split() == titles.split()
    assert rows[0].startswith("a-1           exited: exit code 3 after 12.4 s")


def test_hosts_are_a_column_where_there_are_some():
    there = process("a-1", host="bot1", unreachable_s=4.7)
    head, *rows = table([there, process("b-2", host="local", unreachable_s=None)], 120)
    assert head.split()[:4] == ["name", "state", "host", "pid"]
    assert rows[0].startswith("a-1   running, unreachable 4 s  bot1")
    assert rows[1].startswith("b-2   running                   local")


@pytest.mark.parametrize(
    ("columns", "titles"),
    [
        (80, "name state restarts up cpu USS shown"),
        (60, "name state restarts cpu USS"),
        (40, "name state cpu USS"),
        (20, "name state"),
        (6, "name"),
    ],
)
def test_the_least_important_columns_go_first(columns: int, titles: str):
    muted = process("robot_with_long_name-1", muted=True, hidden_lines=1234, pid=12345)
    assert table([muted, *FLEET], columns)[0].split() == titles.split()


@pytest.mark.parametrize("columns", [1, 2, 5, 10, 17, 20, 33, 40, 59, 80, 100])
def test_no_row_is_wider_than_the_terminal(columns: int):
    rows = [
        process("a_very_long_name_of_a_process_that_nobody_can_read_at_once-12"),
        process("機器人倉庫管理員_二號_備用機-13", "FATAL"),
        process("x-1", "EXITED", last_exit={"text": "exit code 3 after 12.4 s", "returncode": 3}),
        process("y-2", muted=True, level="WARN", grep="a.*long.*pattern", hidden_lines=99999),
    ]
    lines = table(rows, columns)
    assert len(lines) == 5
    assert max(map(cell_len, lines)) <= columns


def test_a_long_name_keeps_its_end_which_tells_it_from_others():
    twins = [process(f"warehouse_robot_number_{n}-{n}", "FATAL") for n in (17, 18)]
    _, first, second = table(twins, 30)
    assert "17-17" in first
    assert "18-18" in second
    assert first != second


# ---- top


def test_those_that_use_most_come_first_and_the_rest_is_counted():
    head, *rows, place = seen(Top())
    assert head.startswith("name ")
    assert [row.split()[0] for row in rows[:2]] == ["worker_49-50", "worker_48-49"]
    assert len(rows) == 8
    assert place == "1-8 of 50 by cpu: 42 more below"


@pytest.mark.parametrize(
    ("typed", "place"),
    [
        (["down", "down"], "3-10 of 50 by cpu: 2 more above, 40 more below"),
        (["pagedown", "up"], "8-15 of 50 by cpu: 7 more above, 35 more below"),
        (["end"], "43-50 of 50 by cpu: 42 more above"),
        (["end", "pagedown", "pageup"], "35-42 of 50 by cpu: 34 more above, 8 more below"),
        (["end", "home", "up"], "1-8 of 50 by cpu: 42 more below"),
        (["end", "n"], "1-8 of 50 by name: 42 more below"),
    ],
)
def test_keys_scroll_to_every_process(typed: list[str], place: str):
    top = Top()
    for key in typed:
        seen(top)
        assert top.press(key)
    assert seen(top)[-1] == place


@pytest.mark.parametrize(
    ("key", "first"), [("c", "worker_49-50"), ("m", "worker_0-1"), ("n", "worker_0-1")]
)
def test_keys_sort(key: str, first: str):
    top = Top()
    top.press(key)
    assert seen(top)[1].split()[0] == first


def test_numbers_in_names_are_sorted_as_numbers_and_trouble_first_by_state():
    rows = [process("w_10-1"), process("w_9-2"), process("w_1-3", "FATAL")]
    assert [p["name"] for p in Top("name").sorted(rows)] == ["w_1-3", "w_9-2", "w_10-1"]
    assert [p["name"] for p in Top("state").sorted(rows)] == ["w_1-3", "w_10-1", "w_9-2"]


def test_another_key_means_nothing_to_the_table():
    assert not Top().press("x")


@pytest.mark.parametrize(
    ("rows", "processes", "place"),
    [(1, 1, None), (2, 1, "1 of 50 by …"), (3, 2, "1-2 of 50 b…"), (4, 2, "1-2 of 50 b…")],
)
def test_a_tiny_terminal_shows_a_process_at_least(rows: int, processes: int, place: str | None):
    lines = seen(Top(), 12, rows)
    assert len(lines) == rows
    assert sum(line.startswith("wo") for line in lines) == processes
    assert place is None or lines[-1] == place


@pytest.mark.parametrize("rows", [1, 2, 3, 5, 7, 8, 12, 24, 60])
def test_a_table_leaves_room_for_the_prompt_and_the_bar(rows: int):
    assert 1 <= table_rows(rows) <= max(1, rows - 2)


def test_keys_are_known_by_what_a_terminal_sends():
    assert parse_keys("\x1b[A\x1bOBn\x1b[6~\x1bq") == ["up", "down", "n", "pagedown", "\x1b", "q"]


def test_a_killed_launcher_leaves_processes_on_other_hosts():
    text = "the launcher was killed; its watchdog kills its processes"
    here = {"host": "local", "pid": 1, "unit": None, "stop_after_s": None}
    on_bot1 = {"host": "bot1", "pid": 2, "unit": "launcher-a.service", "stop_after_s": None}
    on_bot2 = {"host": "bot2", "pid": 3, "unit": None, "stop_after_s": 10.0}
    assert killed_text([{"pid": 1}]) == text
    assert killed_text([here, {**on_bot1, "pid": None}]) == text
    assert killed_text([here, on_bot1, on_bot1, on_bot2]) == (
        f"{text} on this machine; those on bot1 run on (python -m launcher attach);"
        " those on bot2 are stopped there"
    )
