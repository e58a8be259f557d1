"""Status line, number formats, completion, command input and history of the console."""

from __future__ import annotations

import asyncio
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import pytest
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document

from launcher.base import verb_table as commands
from launcher.base.errors import UsageError
from launcher.base.program import program
from launcher.control.client import Reply
from launcher.control.console.bar import (
    filter_line,
    folder_line,
    status_line,
    status_lines,
    width,
)
from launcher.control.console.completion import WordCompleter
from launcher.control.console.feed import split
from launcher.control.console.prompt import MAX_LINES, history_path, open_history
from launcher.control.console.requests import (
    SHELL_VERBS,
    answer,
    follows,
    read_call,
    read_shell_words,
)
from launcher.control.console.short_forms import duration, memory
from launcher.control.verbs import VERBS
from tests.control.unit.console.rows import process


def text_of(line: list[tuple[str, str]]) -> str:
    return "".join(text for _, text in line)


FLEET = [process("dispatcher-1"), process("robot_1-2"), process("robot_2-3")]


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (0, "0"),
        (999, "999"),
        (1000, "1k"),
        (31_400_000, "31M"),
        (999_600_000, "1.0G"),
        (2.5e12, "2.5T"),
    ],
)
def test_memory_is_short(size: float, text: str):
    assert memory(size) == text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(59.9, "59 s"), (65, "1:05"), (3 * 3600 + 5, "3:00:05"), (90_000, "1 d 01:00")],
)
def test_durations_are_short(seconds: float, text: str):
    assert duration(seconds) == text


def test_the_bar_has_figures_then_names_then_counts_as_it_gets_narrower():
    full = "dispatcher 2% 31M | robot_1 2% 31M | robot_2 2% 31M"
    assert text_of(status_line(FLEET, len(full))) == full
    without_memory = "dispatcher 2% | robot_1 2% | robot_2 2%"
    assert text_of(status_line(FLEET, len(full) - 1)) == without_memory
    names = "dispatcher | robot_1 | robot_2"
    assert text_of(status_line(FLEET, len(without_memory) - 1)) == names
    assert text_of(status_line(FLEET, 20)) == "3 running | 7% 93M"


def test_the_bar_shows_unusual_states():
    fleet = [
        process("a-1", "BACKOFF", restarts=2),
        process("b-2", paused=True),
        process("c-3", muted=True),
        process("d-4", "FATAL"),
    ]
    line = text_of(status_line(fleet, 100))
    assert line == "a backoff x2 | b paused 2% 31M | c muted 2% 31M | d fatal"


def ended(name: str, code: int | None, text: str, state: str = "EXITED", **more: object):
    last = {"returncode": code, "text": text, "asked": code == -2}
    return process(name, state, last_exit=last, **more)


ENDED = [
    ended("a-1", 0, "exit code 0"),
    ended("b-2", 4, "exit code 4"),
    ended("c-3", -11, "SIGSEGV, core dumped"),
    ended("d-4", 1, "exit code 1", "FATAL", restarts=3),
    ended("e-5", -9, "SIGKILL, out of memory", "BACKOFF", restarts=1),
    ended("f-6", None, "could not be started: No such file or directory"),
    ended("g-7", 1, "exit code 1", "RUNNING", restarts=2),
    ended("h-8", -2, "SIGINT", "STOPPED"),
    ended("i-9", -11, "SIGSEGV", "STOPPED"),
]


def test_the_bar_shows_what_cannot_be_reached():
    there = process("a-1", host="bot1", unreachable_s=4.7)
    assert "a unreachable 4 s" in text_of(status_line([there], 80))
    crowd = [process(f"robot_{n}-{n}", host="bot1", unreachable_s=4.7) for n in range(40)]
    assert text_of(status_line(crowd, 60)).startswith("40 unreachable")


def test_the_bar_shows_what_does_not_respond_or_is_debugged():
    hangs = process("a-1", not_responding_s=4.7)
    assert "a not responding 4 s" in text_of(status_line([hangs], 80))
    crowd = [process(f"robot_{n}-{n}", not_responding_s=4.7) for n in range(40)]
    assert text_of(status_line(crowd, 60)).startswith("40 not responding")
    assert "not" not in text_of(status_line([process("a-1", not_responding_s=0.0)], 80))
    debugged = process("a-1", debugger="127.0.0.1:5678")
    assert "a debugger at 127.0.0.1:5678" in text_of(status_line([debugged], 80))


def test_success_and_failure_are_told_in_words():
    assert text_of(status_line(ENDED, 200)) == (
        "a finished | b exit 4 | c SIGSEGV | d fatal exit 1 x3 | e backoff SIGKILL x1 | "
        "f not started | g x2 2% 31M | h stopped | i SIGSEGV"
    )


def test_the_counts_tell_success_from_failure():
    crowd = [*ENDED[:3], *(ended(f"worker_{n}-{n}", 0, "exit code 0") for n in range(20))]
    assert text_of(status_line(crowd, 50)) == "21 finished, 2 failed | b exit 4 | c SIGSEGV | 0%"


def test_seven_processes_at_120_columns_keep_the_cpu_and_drop_memory():
    fleet = [process(f"robot_{n}-{n}", cpu_percent=12.0) for n in range(1, 6)]
    fleet += [process("dispatcher-6"), process("monitor-7")]
    assert text_of(status_line(fleet, 120)) == (
        "robot_1 12% | robot_2 12% | robot_3 12% | robot_4 12% | robot_5 12% | "
        "dispatcher 2% | monitor 2%"
    )


def test_a_long_name_is_cut_in_its_middle_before_all_names_give_way_to_counts():
    fleet = [process("warehouse_robot_with_a_long_name_17-1"), process("機器人倉庫管理員-2")]
    assert text_of(status_line(fleet, 44)) == "warehouse_…g_name_17 | 機器人倉庫管理員"
    assert text_of(status_line(fleet, 28)) == "wareho…me_17 | 機器人…理員"
    assert text_of(status_line(fleet, 20)) == "2 running | 5% 62M"


@pytest.mark.parametrize(
    ("columns", "text"),
    [
        (80, "16 running, 4 fatal | worker_0 | worker_1 | worker_2 | +1"),
        (50, "16 running, 4 fatal | worker_0 | worker_1 | +2"),
        (40, "16 running, 4 fatal | worker_0 | +3"),
        (30, "16 running, 4 fatal"),
        (15, "16 running, ..."),
    ],
)
def test_failed_processes_are_named_as_far_as_there_is_room(columns: int, text: str):
    crowd = [process(f"worker_{n}-{n}", "FATAL" if n < 4 else "RUNNING") for n in range(20)]
    assert text_of(status_line(crowd, columns)) == text


def test_two_of_the_same_label_keep_their_full_names():
    twins = [process("node-1"), process("node-2")]
    assert text_of(status_line(twins, 100)) == "node-1 2% 31M | node-2 2% 31M"


@pytest.mark.parametrize("columns", [1, 3, 5, 20, 40])
def test_the_bar_is_never_wider_than_the_terminal(columns: int):
    crowd = [process(f"arbeiter_機器_{n}-{n}", "FATAL" if n % 3 else "RUNNING") for n in range(50)]
    assert 0 < width(status_line(crowd, columns)) <= columns


@pytest.mark.parametrize(
    ("columns", "text"),
    [
        (75, "help | F2 processes | Ctrl-C stops the run | ~/.ros/log/2026-11-21-vm-4711"),
        (67, "help | F2 processes | Ctrl-C stops the run | .../2026-11-21-vm-4711"),
        (43, "help | F2 processes | Ctrl-C stops the run"),
        (40, "help | Ctrl-C stops the run"),
        (16, "help | Ctrl-C..."),
    ],
)
def test_the_folder_line_gives_way_to_the_key_hints(columns: int, text: str):
    assert text_of(folder_line("~/.ros/log/2026-11-21-vm-4711", columns)) == text


def test_without_processes_the_bar_says_so():
    assert text_of(status_line([], 80)) == "no processes"


# ---- filters


def hidden(names: str, by: str | None, lines: int = 0, **more: object):
    """Rows of processes, all filtered alike."""
    return [
        process(name, muted=by is not None, hidden_by=by, muted_lines=lines, **more)
        for name in names.split()
    ]


STRICT = {"level": "ERROR", "grep": "Fleet"}


@pytest.mark.parametrize(
    ("fleet", "text"),
    [
        (FLEET, ""),
        (
            [*hidden("monitor-1", None, 2, **STRICT), *hidden("a-2 b-3", "solo", 405, **STRICT)],
            "level>=ERROR  grep 'Fleet'  solo monitor  hidden 812",
        ),
        ([*FLEET, *hidden("loud-4", "mute", 7)], "mute loud  hidden 7"),
        ([*FLEET, *hidden("a-4", None, 7, level="WARN")], "level>=WARN a  hidden 7"),
        ([*hidden("a-4 b-5 c-6 d-7", None, grep="x"), *FLEET], "grep 'x' a b +2  hidden 0"),
        (hidden("a-1 b-2", "solo"), "solo  hidden 0"),
        (
            [*hidden("a-1", None, 1, level="WARN"), *hidden("b-2", None, 1, level="ERROR")],
            "level>=WARN a  level>=ERROR b  hidden 2",
        ),
    ],
)
def test_active_filters_are_told(fleet: list[dict[str, object]], text: str):
    assert text_of(filter_line(fleet, 200)) == text


def test_filters_are_visible_in_any_terminal():
    fleet = hidden("a-1 b-2", None, 3, level="ERROR")

    def lines(columns: int, *, hint: str = "", few: bool = False) -> list[str]:
        return [text_of(one) for one in status_lines(fleet, "~/log", columns, hint=hint, few=few)]

    first, filters = "a 2% 31M | b 2% 31M", "level>=ERROR  hidden 6"
    assert lines(80) == [first, f"{filters} | `show` shows everything | ~/log"]
    assert lines(40) == [first, f"{filters} | ~/log"]
    assert lines(80, few=True) == [f"{filters} | {first}"]
    assert lines(80, hint="any key") == [first, filters, "any key"]
    assert lines(80, hint="any key", few=True) == [f"any key | {filters}"]


def test_a_process_beside_a_solo_is_not_marked_as_muted():
    fleet = [*hidden("a-1", "solo"), *hidden("b-2", "mute")]
    assert text_of(status_line(fleet, 80)) == "a 2% 31M | b muted 2% 31M"


def test_a_process_that_is_muted_beside_a_solo_is_marked_as_both():
    fleet = [*hidden("a-1", None), *hidden("b-2 c-3", "solo")]
    fleet[1]["muted_by_name"] = True
    assert text_of(status_line(fleet, 80)) == "a 2% 31M | b muted 2% 31M | c 2% 31M"
    assert text_of(filter_line(fleet, 80)) == "solo a  mute b  hidden 0"


# ---- completion


async def no_words(words: Sequence[str]) -> Sequence[tuple[str, str]]:
    return ()


def completed(text: str, fleet: list[dict[str, object]] = FLEET) -> list[str]:
    completer = WordCompleter(lambda: fleet, no_words)
    found = [c.text for c in completer.get_completions(Document(text), CompleteEvent())]
    return [one.removesuffix(" ") for one in found]


def test_a_blank_follows_what_was_completed():
    completer = WordCompleter(lambda: FLEET, no_words)
    (only,) = completer.get_completions(Document("unm"), CompleteEvent())
    assert only.text == "unmute "


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("un", ["unmute"]),
        ("kill r", ["robot_1", "robot_2", "robot_*"]),
        ("kill robot_1 r", ["robot_2", "robot_*"]),
        ("kill -s SIGTE", ["SIGTERM"]),
        ("kill -", ["-s", "--signal", "--as-crash"]),
        ("level W", ["WARN"]),
        ("level WARN d", ["dispatcher"]),
        ("stop robot_*", ["robot_1-2 robot_2-3"]),
        ("send robot_1 r", []),
        ("logs -n 5 d", ["dispatcher"]),
        ("logs -n ", []),
        ("grep r", []),
        ("help r", []),
        ("format c", ["compact"]),
        ("nonsense r", []),
    ],
)
def test_what_fits_at_the_cursor_is_offered(typed: str, offered: list[str]):
    assert completed(typed) == offered


def test_nodes_and_namespaces_are_offered():
    fleet = [process("talker-1", node_names=["/east/talker"], namespace="/east")]
    assert completed("info /e", fleet) == ["/east/talker", "/east"]


# ---- what is typed


def test_a_line_is_read_as_by_a_shell():
    call = read_call("send robot_1 'hello  world'")
    assert (call.verb.name, call.names, call.options) == (
        "send",
        ("robot_1",),
        {"text": "hello  world"},
    )


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("kil robot_1", "unknown verb 'kil'"),
        ("kill 'robot_1", "the line is not finished: No closing quotation"),
        ("kill", "kill needs the name of a process"),
    ],
)
def test_a_mistake_is_told(line: str, message: str):
    with pytest.raises(UsageError, match=message):
        read_call(line)


def asked_for(text: str) -> tuple[list[str], list[str]]:
    """The words that were asked for, and what is offered."""
    asked: list[str] = []

    async def ask(words: Sequence[str]) -> Sequence[tuple[str, str]]:
        asked.extend(words)
        return [("/chatter", "a topic"), ("a b", ""), ("--field=", "")]

    async def all_of(completer: WordCompleter) -> list[str]:
        found = completer.get_completions_async(Document(text), CompleteEvent())
        return [completion.text async for completion in found]

    return asked, asyncio.run(all_of(WordCompleter(lambda: FLEET, ask)))


def test_words_of_a_verb_for_shells_are_asked_for():
    asked, offered = asked_for("topic echo /ch")
    assert asked == ["topic", "echo", "/ch"]
    assert offered == ["/chatter ", "'a b' ", "--field="]


@pytest.mark.parametrize("text", ["kill ro", "to", "attach ", "nonsense "])
def test_words_of_other_verbs_are_not_asked_for(text: str):
    asked, offered = asked_for(text)
    assert asked == []
    assert offered == [f"{one} " for one in completed(text)]


def test_verbs_of_shells_are_offered():
    assert "topic" in completed("to") and "param" in completed("pa")
    assert "attach" not in completed("att")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("topic list -t", ["topic", "list", "-t"]),
        ("topic pub /a b 'c d'", ["topic", "pub", "/a", "b", "c d"]),
        ("runs", ["runs"]),
        ("help topic", ["help", "topic"]),
        ("ps", None),
        ("help", None),
        ("help ps", None),
        ("attach", None),
    ],
)
def test_verbs_of_shells_run_here(line: str, words: list[str] | None):
    assert read_shell_words(line) == words


@pytest.mark.parametrize("line", ["attach", "launch system", "agent"])
def test_a_verb_for_shells_is_told_with_its_command(line: str):
    with pytest.raises(UsageError, match="is a verb for shells") as raised:
        read_call(line)
    assert raised.value.hint == f"in another shell: {program()} {line}"


def test_every_verb_of_the_command_line_is_known_in_the_console():
    names = [verb.name for verb in VERBS]
    assert {*commands.VERBS, *commands.CONTROL_VERBS} <= {*names, *SHELL_VERBS}
    assert not set(names) & set(SHELL_VERBS)


class Answering:
    """A run that answers every request with this text."""

    def __init__(self, text: str) -> None:
        self._text = text

    def connect(self) -> Answering:
        return self

    def __enter__(self) -> Answering:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def ask(self, verb: str, names: list[str], **options: object) -> Reply:
        return Reply(result={}, text=(self._text,))


@pytest.mark.parametrize(("line", "shown"), [("detach", ""), ("quit", "done")])
def test_what_the_run_itself_writes_is_not_answered(line: str, shown: str):
    run = Answering("done")
    text = answer(cast("Any", run), read_call(line), 80, colour=False)
    assert text.strip() == shown


@pytest.mark.parametrize(("word", "verb"), [("exit", "quit"), ("q", "quit"), ("?", "help")])
def test_the_help_names_every_spelling(word: str, verb: str):
    assert read_call(word).verb.name == verb
    text = answer(None, read_call("help"), 120, colour=False)  # type: ignore[arg-type]
    assert re.search(rf"^{re.escape(verb)} .*{re.escape(word)}", text, re.M)
    assert re.search("^clear +clear the screen", text, re.M)


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("bogus", "`help` lists all verbs"),
        ("hepl", "did you mean 'help'?"),
        ("sp", "did you mean 'ps'?"),
        ("retsart robot_1", "did you mean 'restart'?"),
    ],
)
def test_only_what_is_near_is_suggested(line: str, hint: str):
    with pytest.raises(UsageError) as raised:
        read_call(line)
    assert raised.value.hint == hint


def test_top_is_live_and_logs_are_if_asked():
    assert follows(read_call("top"))
    assert follows(read_call("logs -f robot_1"))
    assert not follows(read_call("logs robot_1"))
    assert not follows(read_call("ps"))


# ---- lines


@pytest.mark.parametrize(
    ("data", "lines", "partial"),
    [
        (b"a\nb\n", b"a\nb\n", b""),
        (b"a\nb", b"a\n", b"b"),
        (b"10%\r\x1b[K[p] 20%", b"", b"[p] 20%"),
        (b"x\n10%\r\x1b[K[p] 99%\nnext", b"x\n[p] 99%\n", b"next"),
    ],
)
def test_a_block_is_split_into_whole_lines_and_a_beginning(
    data: bytes, lines: bytes, partial: bytes
):
    assert split(data) == (lines, partial)


# ---- history


def test_the_history_is_bounded_and_for_its_user_alone(tmp_path: Path):
    path = tmp_path / "state" / "ros-launcher" / "history"
    history = open_history(path)
    for number in range(2 * MAX_LINES + 1):
        history.store_string(f"line {number}")
    assert os.stat(path).st_mode & 0o077 == 0
    again = list(open_history(path).load_history_strings())
    assert again[0] == f"line {2 * MAX_LINES}"
    assert len(again) == len(path.read_text().splitlines()) == MAX_LINES


def test_the_history_is_in_the_state_directory():
    assert history_path({"XDG_STATE_HOME": "/s"}) == Path("/s/ros-launcher/history")
    assert history_path({}).parts[-4:] == (".local", "state", "ros-launcher", "history")
