"""The lines that pages get: numbers, levels, counts, what is kept."""

from __future__ import annotations

from typing import Any

import pytest

from launcher.web import log_store
from launcher.web.log_store import LogStore


def item(text: str, process: str | None = "robot-1", stream: str = "stdout") -> dict[str, Any]:
    return {"process": process, "stream": stream, "wall_s": 1.5, "text": text}


def test_lines_get_numbers_and_levels():
    store = LogStore()
    store.add(item("[WARN] [1.0] [robot]: slow"))
    store.add(item("plain"))
    store.add(item("Traceback (most recent call last):", stream="stderr"))
    store.add(item("  File x", stream="stderr"))
    store.add(item("ValueError: <b>", stream="stderr"))
    store.add(item("plain again"))

    first, rows = store.after(0, 100)

    assert first == 1
    assert [row[3] for row in rows] == ["WARN", "INFO", "ERROR", "ERROR", "ERROR", "INFO"]
    assert store.errors["robot-1"] == {"time": 1.5, "text": "ValueError: <b>", "number": 5}
    assert store.counts["robot-1", "ERROR"] == 3
    assert store.lines["robot-1"] == 6


def test_what_was_left_out_is_a_row_and_counts_as_lines():
    store = LogStore()
    store.add({"dropped": 1234, "processes": {"robot-1": 1200, "": 34}, "wall_s": 2.0})

    row = store.after(0, 10)[1][0]

    assert row[:4] == (None, "skipped", 2.0, None)
    assert row.text == "1,234 lines of launch, robot-1 came too fast and are not shown here"
    assert store.lines["robot-1"] == 1200
    assert store.skipped == 1234


@pytest.mark.parametrize("number", [0, 1, 2, 40, 50, 51, 99, 100, 101, 5000])
def test_older_and_newer_lines_meet(number: int, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(log_store, "KEEP_LINES", 60)
    store = LogStore()
    for index in range(1, 101):
        store.add(item(str(index)))

    first, older = store.before(number, 10)
    begin, newer = store.after(number - 1, 1000)

    assert store.first == 41
    end = min(max(number, 41), 101)
    assert [row[4] for row in older] == [str(n) for n in range(max(41, end - 10), end)]
    assert first + len(older) == end
    assert [row[4] for row in newer] == [str(n) for n in range(max(41, number), 101)]
    assert begin == max(41, number)


def test_long_lines_are_kept_within_bounds(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(log_store, "KEEP_BYTES", 10_000)
    store = LogStore()
    for _ in range(100):
        store.add(item("x" * 1000))

    _, rows = store.after(0, 1000)

    assert len(rows) == 10
    assert store.next_number == 101
