"""Messages to pages: what a slow page loses, and what it never does."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from launcher.web.hub import MOST_BYTES, QUEUE_BYTES, Hub, PageOutbox, encode


def everything(outbox: PageOutbox, count: int) -> list[dict[str, Any]]:
    async def take() -> list[str]:
        return [await asyncio.wait_for(outbox.get(), 1) for _ in range(count)]

    return [json.loads(text) for text in asyncio.run(take())]


def lines(number: int, text: str = "x") -> dict[str, Any]:
    return {"event": "lines", "first": number, "lines": [[None, "stdout", 0.0, "INFO", text]]}


def joined(hub: Hub) -> PageOutbox:
    outbox = PageOutbox()
    hub.join(outbox)
    return outbox


def test_messages_come_in_order():
    hub = Hub(lambda: None)
    page = joined(hub)
    hub.send(lines(1))
    hub.send({"event": "run_events", "items": [1]})
    hub.send(lines(2))

    found = everything(page, 3)

    assert [one["event"] for one in found] == ["lines", "run_events", "lines"]


def test_of_a_state_only_the_newest_is_sent():
    hub = Hub(lambda: None)
    page = joined(hub)
    for wall in range(100):
        hub.send({"event": "processes", "wall": wall, "processes": []})
    hub.send(lines(1))

    first, second = everything(page, 2)

    assert first["wall"] == 99
    assert second["event"] == "lines"


def test_a_page_that_does_not_read_loses_lines_but_no_events():
    hub = Hub(lambda: None)
    slow, quick = joined(hub), joined(hub)
    long = "x" * 100_000
    sent = 2 * QUEUE_BYTES // len(long)
    for number in range(sent):
        hub.send(lines(number, long))
        everything(quick, 1)
    for number in range(1000):
        hub.send({"event": "run_events", "items": [number], "reset": False})

    kept = sent - slow.skipped_lines
    found = everything(slow, kept + 1000)

    assert 0 < kept < sent
    assert [one["first"] for one in found[:kept]] == list(range(kept))
    assert [one["items"][0] for one in found[kept:]] == list(range(1000))
    assert quick.skipped_lines == 0


def test_what_waits_for_a_page_that_reads_nothing_is_bounded():
    full: list[bool] = []
    outbox = PageOutbox(lambda: full.append(True))
    text = "x" * 1000
    for number in range(2 * MOST_BYTES // len(text)):
        outbox.put("alive", f"{number}")  # of a day there are 43,200
        if not full:
            outbox.put("run_events", text)

    waiting = len(outbox._queue) + len(outbox._latest)
    assert full
    assert waiting <= MOST_BYTES // len(text) + 3


def test_subscriptions_are_those_of_all_pages_and_end_with_them():
    calls: list[set[str]] = []
    hub = Hub(lambda: calls.append(hub.subscribed("echo")))
    one, other = joined(hub), joined(hub)

    hub.set_subscription(one, "echo", "/a", on=True)
    hub.set_subscription(other, "echo", "/a", on=True)
    hub.set_subscription(other, "echo", "/b", on=True)
    hub.leave(one)
    hub.set_subscription(other, "echo", "/b", on=False)
    hub.leave(other)

    assert calls == [{"/a"}, {"/a"}, {"/a", "/b"}, {"/a", "/b"}, {"/a"}, set()]
    assert len(hub) == 0


def test_a_subscribed_message_goes_only_to_its_subscribers():
    hub = Hub(lambda: None)
    one, other = joined(hub), joined(hub)
    hub.set_subscription(one, "echo", "/a", on=True)

    hub.send({"event": "message", "topic": "/a"}, to=("echo", "/a"))
    hub.send({"event": "ended"})

    assert [message["event"] for message in everything(one, 2)] == ["message", "ended"]
    assert [message["event"] for message in everything(other, 1)] == ["ended"]


def test_integers_that_javascript_would_round_are_texts():
    big = 2**63 - 1
    data = {"data": [big, -big, 2**53 - 1, 1.5, True, f"{big}"]}

    found = json.loads(encode({"event": "message", "topic": "/a", "data": data}))
    answer = json.loads(encode({"id": 1, "ok": True, "result": {"value": big}}))

    assert found["data"]["data"] == [str(big), str(-big), 2**53 - 1, 1.5, True, str(big)]
    assert answer["result"]["value"] == str(big)
    assert json.loads(encode({"event": "graph", "deadline_ns": big}))["deadline_ns"] == big


def test_what_ends_the_work_for_all_pages_is_a_failure():
    failures: list[BaseException] = []
    problem = KeyError("x")

    async def fail() -> None:
        raise problem

    async def work() -> None:
        hub = Hub(lambda: None, failures.append)
        task = hub.start(asyncio.sleep(60))
        task.cancel()
        await asyncio.wait([task, hub.start(fail())])

    asyncio.run(work())
    assert failures == [problem]


def test_what_is_no_character_can_be_sent():
    hub = Hub(lambda: None)
    page = joined(hub)
    hub.send(lines(1, "a\udcff"))
    (found,) = everything(page, 1)
    assert found["lines"][0][4] == "a\ufffd"
