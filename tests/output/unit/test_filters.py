"""Filters of the shown output, and the ring of the last lines."""

import tracemalloc

import pytest

from launcher.output.filters import LEVELS, LineFilter, Pattern, level_named, level_of
from launcher.output.lines import BLOCK_BYTES, LIMIT_BYTES, LogRing

WARN = LEVELS.index("WARN")


@pytest.mark.parametrize(
    ("line", "level"),
    [
        (b"[INFO] [1700000000.1] [robot_1]: hello", "INFO"),
        (b"\x1b[33m[WARN] [1700000000.1] [robot_1]: hello\x1b[0m", "WARN"),
        (b"[1700000000.1] [ERROR] [robot_1]: hello", "ERROR"),
        (b"WARNING:root:hello", "WARN"),
        (b"CRITICAL: hello", "FATAL"),
        (b"DEBUG hello", "DEBUG"),
        (b"hello [robot] INFO", None),
        (b"INFORMATION", None),
        (b"", None),
    ],
)
def test_the_level_of_a_line_is_what_ros_and_python_print(line: bytes, level: str | None):
    found = level_of(line)
    assert (None if found is None else LEVELS[found]) == level


def test_only_lines_of_the_level_and_what_belongs_to_them_are_shown():
    view = LineFilter()
    view.level = WARN
    lines = b"[INFO] a\n  of a\n[WARN] b\n  of b\nplain\n[ERROR] c\n"
    assert view.choose(3, lines) == b"[WARN] b\n  of b\n[ERROR] c\n"
    assert view.hidden_lines == 3


def test_a_traceback_is_an_error_to_its_last_line_and_not_beyond():
    view = LineFilter()
    view.level = WARN
    trace = b'Traceback (most recent call last):\n  File "x"\nValueError: no\n'
    assert view.choose(3, b"before\n" + trace + b"after\n") == trace


def test_a_level_is_remembered_from_block_to_block_for_each_stream():
    view = LineFilter()
    view.level = WARN
    assert view.choose(3, b"[ERROR] a\n")
    assert view.choose(4, b"  of another stream\n") == b""
    assert view.choose(3, b"  of a\n") == b"  of a\n"


def test_a_muted_process_shows_nothing_and_counts_its_lines():
    view = LineFilter()
    view.muted = True
    assert view.choose(3, b"a\nb\n") == b""
    assert view.choose(3, b"\n") == b""
    assert view.hidden_lines == 3
    assert not view.is_open


def test_a_pattern_shows_the_lines_in_which_it_is_found():
    view = LineFilter()
    view.pattern = Pattern(r"task \d")
    assert view.choose(3, b"a task 7\nnone\ntask 8\n") == b"a task 7\ntask 8\n"
    assert view.choose(3, b"none\n") == b""
    assert view.hidden_lines == 2


def test_a_pattern_that_takes_too_long_is_dropped_and_everything_shown():
    view = LineFilter()
    view.pattern = Pattern(r"(a+)+$")
    given_up = []
    view.on_slow = given_up.append
    lines = b"a" * 60 + b"!\nb\n"
    assert view.choose(3, lines) == lines
    assert [pattern.text for pattern in given_up] == ["(a+)+$"]
    assert view.choose(3, lines) == lines
    assert view.is_open


def test_levels_are_named_as_people_name_them():
    assert level_named("warning") == level_named("WARN") == WARN
    assert level_named("all") == 0
    with pytest.raises(ValueError, match="loud"):
        level_named("loud")


def test_the_ring_gives_back_the_last_lines_over_its_blocks():
    ring = LogRing()
    ring.append("stdout", 1.0, b"a\nb\n")
    ring.append("stderr", 2.0, b"c\n\nd\xff\n")
    assert ring.texts(4) == ["b", "c", "", "d�"]
    assert [block.stream for block in ring.last(4)] == ["stdout", "stderr"]
    assert ring.texts(0) == []
    assert ring.texts(100) == ["a", "b", "c", "", "d�"]


def test_the_ring_forgets_the_oldest():
    ring = LogRing()
    most = LIMIT_BYTES // (BLOCK_BYTES + len(b"1000\n"))
    for number in range(1000, 1000 + most + 10):
        ring.append("stdout", 0.0, b"%d\n" % number)
    assert ring.texts(most * 2)[0] == "1010"
    for _ in range(20):
        ring.append("stdout", 0.0, b"x" * 64 * 1024 + b"\n")
    assert sum(len(block.lines) for block in ring.last(10**6)) <= LIMIT_BYTES


@pytest.mark.parametrize("line_bytes", [1, 100, 20_000])
def test_the_ring_takes_no_more_memory_than_its_limit(line_bytes):
    ring = LogRing()
    tracemalloc.start()
    try:
        for number in range(5000):
            ring.append("stdout", float(number), bytes(line_bytes) + b"\n")
        taken, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert LIMIT_BYTES / 2 < taken < LIMIT_BYTES * 1.1
