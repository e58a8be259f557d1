"""The picker's list and the pager: keys, search, drawing."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.control.console.bar import width
from launcher.control.console.pager import MAX_LINES, Pager
from launcher.control.console.panel import PENDING_LINES, ProcessView, _fitting, _height
from launcher.control.console.picker import CLOSE, Picker, key_hints
from tests.control.unit.console.rows import process

FLEET = [process("dispatcher-1"), process("robot_1-2"), process("robot_2-3", "STOPPED")]


def picker_of(fleet: list[dict[str, Any]] = FLEET, keys: str = "") -> Picker:
    picker = Picker()
    picker.update(fleet)
    picker.lines(80, 12, colour=False)
    for key in keys.split():
        press(picker, key)
    return picker


def press(picker: Picker, key: str, text: str | None = None) -> tuple[str, ...] | None:
    return picker.press(key, key if text is None else text)


def texts(lines: list[list[tuple[str, str]]]) -> list[str]:
    return ["".join(text for _, text in line).rstrip() for line in lines]


def chosen(picker: Picker) -> str:
    assert picker.chosen is not None
    return picker.chosen["name"]


# ---- keys


@pytest.mark.parametrize(
    ("keys", "name"),
    [
        ("", "dispatcher-1"),
        ("down", "robot_1-2"),
        ("down down down down", "robot_2-3"),
        ("end up", "robot_1-2"),
        ("end home", "dispatcher-1"),
        ("pagedown", "robot_2-3"),
        ("pagedown pageup", "dispatcher-1"),
        ("2", "robot_1-2"),
        ("2 9", "robot_1-2"),
    ],
)
def test_arrows_and_digits_choose_a_process(keys: str, name: str):
    assert chosen(picker_of(keys=keys)) == name


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("c-m", "logs robot_1-2"),
        ("s", "stop robot_1-2"),
        ("k", "kill robot_1-2"),
        ("r", "restart robot_1-2"),
        ("m", "mute robot_1-2"),
        ("o", "solo robot_1-2"),
        ("i", "info robot_1-2"),
    ],
)
def test_a_key_is_a_command_for_the_chosen_process(key: str, words: str):
    assert press(picker_of(keys="down"), key) == tuple(words.split())


@pytest.mark.parametrize("state", ["STOPPED", "EXITED", "FATAL"])
def test_what_has_ended_is_started(state: str):
    assert press(picker_of([process("a-1", state)]), "s") == ("start", "a-1")


def test_mute_and_solo_are_taken_back_by_the_same_key():
    alone, beside = process("a-1"), process("b-2", muted=True, hidden_by="solo")
    assert press(picker_of([alone, beside]), "o") == ("unmute",)
    assert press(picker_of([alone, beside], "down"), "o") == ("solo", "b-2")
    assert press(picker_of([alone, beside], "down"), "m") == ("unmute", "b-2")
    assert key_hints(alone, [alone, beside]) == [
        "s stop",
        "k kill",
        "r restart",
        "m mute",
        "o end solo",
    ]


@pytest.mark.parametrize("key", ["q", "escape", "c-d", "f2"])
def test_the_way_back(key: str):
    assert press(picker_of(), key) == CLOSE


@pytest.mark.parametrize("key", ["x", "z", "<bracketed-paste>", "c-a", "f3", "<sigint>", "�", "é"])
def test_any_other_key_does_nothing(key: str):
    assert press(picker_of(), key, "kill everything\n") is None


def test_without_processes_only_the_way_back_does_something():
    picker = picker_of([])
    assert [press(picker, key) for key in ("s", "k", "c-m", "down", "1")] == [None] * 5
    assert texts(picker.lines(40, 5, colour=False)) == ["processes: 0", "no process has this name"]
    assert press(picker, "q") == CLOSE


# ---- search


def test_a_search_narrows_the_list_and_esc_widens_it():
    picker = picker_of(keys="/ r o b")
    assert texts(picker.lines(80, 12, colour=False))[0] == "processes: 2  /rob"
    assert chosen(picker) == "robot_1-2"
    press(picker, "down")
    press(picker, "c-m")
    assert press(picker, "s") == ("start", "robot_2-3")
    assert press(picker, "escape") is None
    assert texts(picker.lines(80, 12, colour=False))[0] == "processes: 3"
    assert chosen(picker) == "robot_2-3"


def test_letters_of_a_search_are_no_commands():
    picker = picker_of(keys="/")
    assert [press(picker, key) for key in ("k", "s", "q", "1", "/")] == [None] * 5
    assert picker.search == "ksq1/"
    assert picker.chosen is None
    press(picker, "c-u")
    press(picker, "<bracketed-paste>", "ROBOT_2\nkill all\n")
    assert chosen(picker) == "robot_2-3"
    for _ in range(8):
        press(picker, "c-h")
    assert not picker.is_searching


def test_nodes_are_found_too():
    fleet = [*FLEET, process("component_container-4", node_names=["/east/camera"])]
    assert chosen(picker_of(fleet, "/ c a m")) == "component_container-4"


# ---- drawing


def test_the_list_has_a_title_a_head_and_a_mark():
    lines = texts(picker_of(keys="down").lines(60, 12, colour=False))
    assert lines[0] == "processes: 3"
    assert lines[1].split()[:3] == ["name", "state", "pid"]
    assert [line[:14] for line in lines[2:]] == [
        " 1 dispatcher-",
        ">2 robot_1-2  ",
        " 3 robot_2-3  ",
    ]


def test_a_hundred_processes_scroll_and_the_chosen_one_is_always_seen():
    crowd = [process(f"worker_{n}-{n}") for n in range(100)]
    picker = picker_of(crowd)
    for key in ["down"] * 50 + ["pagedown"] * 3 + ["up"] * 90 + ["end", "home"]:
        press(picker, key)
        drawn = picker.lines(80, 11, colour=False)
        lines = texts(drawn)
        assert len(lines) == 11
        (row,) = (number for number, line in enumerate(lines) if line.startswith(">"))
        assert chosen(picker) in lines[row]
        assert picker.cursor(drawn) == (0, row)
    assert lines[0] == "processes: 1-9 of 100"


def test_the_chosen_process_stays_chosen_while_others_start():
    picker = picker_of(keys="down")
    picker.update([process("early-9"), *FLEET])
    assert chosen(picker) == "robot_1-2"


@given(columns=st.integers(1, 130), rows=st.integers(1, 30), count=st.integers(0, 120))
def test_the_list_is_never_larger_than_its_place(columns: int, rows: int, count: int):
    picker = picker_of([process(f"arbeiter_機器_{n}-{n}") for n in range(count)])
    lines = picker.lines(columns, rows, colour=True)
    assert len(lines) <= rows
    assert all(width(line) <= columns for line in lines)


@pytest.mark.parametrize(
    ("rows", "lists", "logs"), [(4, 2, 2), (8, 4, 4), (20, 11, 14), (50, 26, 34)]
)
def test_the_panel_leaves_room_for_output(rows: int, lists: int, logs: int):
    assert (_height(rows, 1 / 2), _height(rows, 2 / 3)) == (lists, logs)


def test_the_way_back_is_the_last_key_to_be_left_out():
    keys = ["Enter log", "s stop", "k kill", "q back"]
    assert _fitting(keys, 35) == "Enter log  s stop  k kill  q back"
    assert _fitting(keys, 30) == "Enter log  s stop  q back"
    assert _fitting(keys, 3) == "q back"


# ---- pager


def pager_of(count: int, *, follows: bool = True) -> Pager:
    pager = Pager(follows=follows)
    pager.add(f"line {number}" for number in range(count))
    return pager


def seen(pager: Pager, columns: int = 40, rows: int = 3) -> list[str]:
    return texts(pager.lines(columns, rows))


def test_it_follows_until_it_is_scrolled_and_again_at_the_end():
    pager = pager_of(10)
    assert seen(pager) == ["line 7", "line 8", "line 9"]
    pager.add(["line 10"])
    assert seen(pager)[-1] == "line 10"
    pager.press("up")
    assert not pager.is_following
    for number in range(11, 2000):
        pager.add([f"line {number}"])
    assert seen(pager) == ["line 7", "line 8", "line 9"]
    pager.press("end")
    assert pager.is_following
    assert seen(pager)[-1] == "line 1999"


@pytest.mark.parametrize(
    ("keys", "last"),
    [
        ("up", 8),
        ("pageup", 6),
        ("home", 2),
        ("home up up", 2),
        ("home down", 3),
        ("up down", 9),
        ("pageup pageup pageup pageup", 2),
        ("home end", 9),
    ],
)
def test_keys_scroll(keys: str, last: int):
    pager = pager_of(10)
    seen(pager)
    for key in keys.split():
        assert pager.press(key)
    assert seen(pager)[-1] == f"line {last}"


def test_a_few_lines_do_not_scroll():
    pager = pager_of(2)
    for key in ("up", "pageup", "home"):
        seen(pager)
        pager.press(key)
        assert seen(pager) == ["line 0", "line 1"]


def test_a_text_begins_at_its_top():
    pager = Pager(follows=False)
    assert seen(pager) == []
    pager.add(["a", "b", "c", "d"])
    assert seen(pager, rows=2) == ["a", "b"]
    pager.press("down")
    assert seen(pager, rows=2) == ["b", "c"]


def test_long_lines_are_wrapped_and_every_row_can_be_reached():
    pager = Pager(follows=True)
    pager.add(["first", "x" * 25, "機器人" * 3, "\x1b[31mred\x1b[0m\tend"])
    rows = ["first", "x" * 10, "x" * 10, "x" * 5, "機器人機器", "人機器人", "red     en", "d"]
    assert seen(pager, 10, 20) == rows
    seen(pager, 10, 2)
    for bottom in range(7, 1, -1):
        pager.press("up")
        assert seen(pager, 10, 2) == rows[bottom - 2 : bottom]
    assert pager.lines(10, 20)[6][0] == ("ansired", "red")


def test_a_resized_terminal_wraps_again():
    pager = Pager(follows=True)
    pager.add(["a" * 30] * 5)
    seen(pager, 10, 4)
    pager.press("up")
    assert seen(pager, 40, 2) == ["a" * 30] * 2


def test_old_lines_are_dropped_also_while_they_are_looked_at():
    pager = pager_of(10)
    seen(pager)
    pager.press("home")
    pager.add(str(number) for number in range(MAX_LINES))
    assert seen(pager) == ["0", "1", "2"]
    assert pager.place == f"13 of {MAX_LINES + 10}"


@given(
    lines=st.lists(st.text(max_size=30), max_size=30),
    keys=st.lists(st.sampled_from(["up", "down", "pageup", "pagedown", "home", "end"]), max_size=9),
    columns=st.integers(2, 20),
    rows=st.integers(1, 8),
)
def test_the_pager_never_shows_more_than_its_place(
    lines: list[str], keys: list[str], columns: int, rows: int
):
    pager = Pager(follows=True)
    pager.add(lines)
    for key in ["end", *keys]:
        pager.press(key)
        shown = pager.lines(columns, rows)
        assert len(shown) <= rows
        assert all(width(line) <= columns for line in shown)


def test_lines_that_are_looked_at_are_kept_until_the_end_is_followed_again():
    async def scenario() -> None:
        drawn: list[int] = []
        view = ProcessView("logs", "a-1", lambda: drawn.append(1))
        view.pager.add(map(str, range(MAX_LINES)))
        seen(view.pager)
        view.pager.press("home")
        view._add("new")
        view.take()
        assert (seen(view.pager), drawn) == (["0", "1", "2"], [])
        view.pager.press("end")
        view.take()
        assert seen(view.pager)[-1] == "new"
        assert drawn == [1]
        view.close()
        view._add("after its end", *map(str, range(PENDING_LINES)))  # must not wait

    asyncio.run(scenario())
