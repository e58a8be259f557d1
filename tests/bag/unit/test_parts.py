"""Parts of recording and playing that need no node: the clock, the ring, the writing thread."""

from __future__ import annotations

import math
import threading
from pathlib import Path

import pytest

from launcher.bag.bag_model import Span
from launcher.bag.reader import Bag
from launcher.bag.ros import bag_qos
from launcher.bag.ros.player import PlayClock
from launcher.bag.ros.read_ahead import ReadAhead
from launcher.bag.ros.sinks import FileSink, Ring
from launcher.bag.writer import BagWriter
from launcher.base.errors import UsageError
from tests.support.bags import QOS, START_NS, counting, message, string_topic, text_of, write_bag
from tests.support.waiting import wait_until

S = 10**9


def test_the_clock_of_a_bag():
    clock = PlayClock(100 * S, 5.0, rate=2.0)
    assert clock.time_ns(6.0) == 102 * S
    assert clock.wait_s(103 * S, 6.0) == pytest.approx(0.5)
    assert clock.wait_s(101 * S, 6.0) == pytest.approx(-0.5)
    clock.set_paused(True, 6.0)
    assert clock.time_ns(60.0) == 102 * S
    assert clock.wait_s(103 * S, 60.0) == math.inf
    assert clock.wait_s(102 * S, 60.0) == math.inf  # also what is due now
    clock.set_paused(False, 60.0)
    clock.set_rate(0.5, 61.0)
    assert clock.time_ns(63.0) == 105 * S
    clock.jump(10 * S, 64.0)
    assert clock.time_ns(64.0) == 10 * S
    clock.set_rate(1e9, 64.0)
    assert clock.rate == 1000.0


def test_the_ring_keeps_the_newest_within_its_bounds():
    now = [START_NS]
    ring = Ring(10_000, keep_s=10.0, clock_ns=lambda: now[0])
    for n in range(100):
        ring.put(message("/a", n * 0.1, "x" * 100), b"p")
    assert ring._bytes <= 10_000
    newest = [one.log_ns for one, _ in ring.contents()]
    assert newest[-1] == START_NS + round(9.9 * S)
    assert ring.dropped_ns is not None
    now[0] = START_NS + round(19.5 * S)
    ring.forget_old()
    assert len(ring.contents()) == 5
    now[0] = START_NS + 60 * S
    ring.forget_old()
    assert (ring.contents(), ring._bytes) == ([], 0)


def test_a_message_that_is_larger_than_the_ring_is_dropped():
    ring = Ring(1000)
    ring.put(message("/a", 0, "x" * 2000), b"p")
    assert ring.contents() == []


def test_the_writing_thread_writes_everything_and_refuses_what_has_no_room(
    tmp_path: Path, monkeypatch
):
    writer = BagWriter(str(tmp_path / "b"))
    may_write = threading.Event()
    write = writer.write

    def slow(one):
        may_write.wait()
        write(one)

    monkeypatch.setattr(writer, "write", slow)
    sink = FileSink(writer, max_bytes=2000)
    sink.add_topic(string_topic("/a"))
    taken = [sink.put(one, b"p") for one in counting("/a", 200)]
    sink.wake()
    assert taken[0]
    assert not all(taken)
    may_write.set()
    assert sink.finish() is None
    assert Bag(str(tmp_path / "b")).extent.total == sum(taken)


def test_what_is_written_can_be_read_although_nothing_follows(tmp_path: Path):
    writer = BagWriter(str(tmp_path / "b"))
    sink = FileSink(writer, max_bytes=10**6)
    sink.add_topic(string_topic("/a"))
    sink.put(message("/a", 0, "x"), b"p")

    def is_there() -> bool:
        sink.wake()  # as at each look of the recorder
        return Bag(str(tmp_path / "b")).extent.total == 1

    wait_until(is_there, "the message in the file")
    assert sink.finish() is None


def test_reading_ahead_is_bounded_and_may_end_at_any_time(tmp_path: Path):
    bag = Bag(str(write_bag(tmp_path / "b", counting("/a", 500))))
    source = ReadAhead([bag], [frozenset(["/a"])], Span(), 10)
    for n in range(500):
        one = source.peek()
        assert one is not None
        assert text_of(one.data) == f"message {n}"
        source.pop()
    assert source.peek() is None
    source.close()
    ReadAhead([bag], [frozenset(["/a"])], Span(), 10).close()


def test_any_error_of_reading_ahead_is_raised_where_it_plays():
    class Failing:
        def messages(self, *given: object) -> None:
            raise ArithmeticError("unexpected")

    source = ReadAhead([Failing()], [frozenset(["/a"])], Span(), 10)
    with pytest.raises(ArithmeticError):
        source.peek()
    source.close()


def test_the_profile_of_several_publishers():
    best_effort = {**QOS, "reliability": "best_effort"}
    latched = {**QOS, "durability": "transient_local"}
    assert bag_qos.to_play([QOS, best_effort]).reliability.name == "RELIABLE"
    assert bag_qos.to_play([best_effort, best_effort]).reliability.name == "BEST_EFFORT"
    assert bag_qos.to_play([latched, QOS]).durability.name == "VOLATILE"
    assert bag_qos.to_play([latched]).durability.name == "TRANSIENT_LOCAL"
    assert bag_qos.to_play([]).reliability.name == "RELIABLE"
    assert bag_qos.to_play([QOS]).deadline.nanoseconds == 0
    odd = {
        **QOS,
        "reliability": "sometimes",
        "depth": 2**40,
        "lifespan": 3,
        "deadline": {"sec": "x"},
    }
    assert (
        bag_qos.to_play([{**odd, "durability": "transient_local"}]).durability.name
        == "TRANSIENT_LOCAL"
    )
    assert bag_qos.to_play([odd]).reliability.name == "RELIABLE"
    assert bag_qos.to_play([odd]).depth == 10
    short = {**QOS, "deadline": {"sec": 1, "nsec": 5}}
    assert bag_qos.to_play([short]).deadline.nanoseconds == S + 5


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[1, 2]", "does not map topics to policies"),
        ("/a: 3", "/a has no policies"),
        ("/a: {reliable: true}", "/a: unknown policy 'reliable'"),
        ("/a: {durability: eternal}", "/a: unknown durability 'eternal'"),
        ("/a: {depth: many}", "/a: "),
        ("/a: {depth: 9999999999}", "/a: a depth is at most 2147483647"),
        ("/a: {deadline: 3}", "/a: deadline is a time"),
        ("{", "qos.yaml:2: invalid YAML: "),
    ],
)
def test_overrides_with_mistakes(tmp_path: Path, text: str, problem: str):
    file = tmp_path / "qos.yaml"
    file.write_text(text)
    with pytest.raises(UsageError) as raised:
        bag_qos.read_overrides(str(file))
    assert problem in raised.value.message


def test_a_topic_of_overrides_may_lack_its_slash(tmp_path: Path):
    file = tmp_path / "qos.yaml"
    file.write_text("a/b: {depth: 3}\n/c: {depth: 4}\n")
    assert set(bag_qos.read_overrides(str(file))) == {"/a/b", "/c"}
