"""Status line, filters and number formats of the console."""

from __future__ import annotations

import pytest

from launcher.control.console.bar import filter_line, folder_line, status_line, status_lines, width
from launcher.control.console.short_forms import duration, memory
from tests.control.unit.console.rows import FLEET, process


def text_of(line: list[tuple[str, str]]) -> str:
    return "".join(text for _, text in line)


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


LINK = "http://127.0.0.1:8770/?token=" + "x" * 32


@pytest.mark.parametrize(
    ("columns", "text"),
    [
        (130, f"help | F2 processes | Ctrl-C stops the run | page: {LINK} | .../vm-4711"),
        (114, f"help | F2 processes | Ctrl-C stops the run | page: {LINK}"),
        (100, f"help | Ctrl-C stops the run | page: {LINK}"),
        (80, "help | F2 processes | Ctrl-C stops the run | w opens http://127.0.0.1:8770"),
        (60, "help | Ctrl-C stops the run | w opens http://127.0.0.1:8770"),
        (50, "help | Ctrl-C stops the run | w opens the page"),
        (40, "help | Ctrl-C stops the run"),
    ],
)
def test_the_link_of_the_page_stays_in_the_bar(columns: int, text: str):
    line = text_of(folder_line("~/.ros/log/2026-11-21-vm-4711", columns, LINK))
    assert line.replace("...26-11-21-", ".../").replace("...1-21-", ".../") == text


@pytest.mark.parametrize("few", [False, True])
def test_the_link_of_the_page_stays_beside_filters_and_keys(few: bool):
    muted = hidden("a-1", "mute")
    for rows, hint in ((FLEET, ""), (FLEET, "q back"), (muted, ""), (muted, "q back")):
        lines = status_lines(rows, "~/log", 160, hint=hint, few=few, page=LINK)
        shown = [text_of(line) for line in lines]
        assert sum(LINK in line for line in shown) == 1


def test_without_processes_the_bar_says_so():
    assert text_of(status_line([], 80)) == "no processes"


# ---- filters


def hidden(names: str, by: str | None, lines: int = 0, **more: object):
    """Rows of processes, all filtered alike."""
    return [
        process(name, muted=by is not None, hidden_by=by, hidden_lines=lines, **more)
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
