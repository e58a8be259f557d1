"""Buffering of the probe's output for a slow reader, over a real pipe."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator

import pytest

from launcher.ros.probe import protocol as module
from launcher.ros.probe.protocol import LineOutbox, encoded


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    read, write = os.pipe()
    os.set_blocking(read, False)
    os.set_blocking(write, False)
    yield read, write
    for descriptor in (read, write):
        os.close(descriptor)


def read_all(descriptor: int, outbox: LineOutbox) -> list[dict]:
    data = b""
    while not outbox.is_empty:
        outbox.flush()
        data += os.read(descriptor, 2**20)
    return [json.loads(line) for line in data.splitlines()]


def test_lines_come_in_order_and_survive_a_full_pipe(pipe):
    outbox = LineOutbox(pipe[1])
    for number in range(20_000):
        outbox.push({"number": number})
    outbox.flush()
    assert not outbox.is_empty  # the pipe is full
    assert [line["number"] for line in read_all(pipe[0], outbox)] == list(range(20_000))


def test_messages_over_the_limit_are_dropped_and_counted_answers_are_not(pipe, monkeypatch):
    monkeypatch.setattr(module, "LIMIT_BYTES", 100)
    outbox = LineOutbox(pipe[1])
    for number in range(50):
        outbox.push({"message": number})
        outbox.send({"answer": number})
    lines = read_all(pipe[0], outbox)
    kept = [line["message"] for line in lines if "message" in line]
    assert [line["answer"] for line in lines if "answer" in line] == list(range(50))
    assert kept == list(range(len(kept)))
    assert lines[-1]["event"] == "dropped"
    assert lines[-1]["messages"] == 50 - len(kept) > 0


def test_the_number_of_dropped_messages_comes_before_the_next_message(pipe, monkeypatch):
    monkeypatch.setattr(module, "LIMIT_BYTES", 20)
    outbox = LineOutbox(pipe[1])
    outbox.push({"m": 1})
    outbox.push({"long": "x" * 30})
    outbox.push({"m": 2})
    lines = read_all(pipe[0], outbox)
    assert [line.get("m") or line["messages"] for line in lines] == [1, 1, 2]


def test_a_graph_that_waits_is_replaced_by_a_newer_one(pipe):
    outbox = LineOutbox(pipe[1])
    for number in range(10):
        outbox.show({"graph": number})
    assert read_all(pipe[0], outbox) == [{"graph": 9}]


def test_a_huge_message_is_reported_without_its_content(pipe):
    outbox = LineOutbox(pipe[1])
    outbox.push({"sub": "s", "data": "x" * module.MESSAGE_BYTES})
    (line,) = read_all(pipe[0], outbox)
    assert (line["sub"], line["data"]) == ("s", None)
    assert line["bytes"] > module.MESSAGE_BYTES


def test_a_reader_that_is_gone_is_noticed():
    read, write = os.pipe()
    os.close(read)
    outbox = LineOutbox(write)
    outbox.send({"answer": 1})
    outbox.flush()
    assert outbox.is_broken
    os.close(write)


def test_values_without_a_json_form_become_text():
    assert json.loads(encoded({"data": [math.nan, {"a": -math.inf}, 1.5]})) == {
        "data": ["nan", {"a": "-inf"}, 1.5]
    }
