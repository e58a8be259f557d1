"""Frames that are kept until they are acknowledged."""

from __future__ import annotations

import json

from hypothesis import example, given
from hypothesis import strategies as st

from launcher.hosts.engine.frames import OUTPUT_HEADER, Decoder, Frame, FrameKind
from launcher.hosts.engine.outbox import Outbox


def output(text: bytes) -> bytes:
    return OUTPUT_HEADER.pack(1, 0) + text


def frames_of(outbox: Outbox) -> list[Frame]:
    """Send everything."""
    found: list[Frame] = []
    decoder = Decoder()
    while outbox.has_unsent:
        found += decoder.feed(b"".join(outbox.take()))
    return found


def numbers(frames: list[Frame]) -> list[int]:
    return [frame.sequence for frame in frames]


def test_what_was_not_acknowledged_is_sent_again():
    outbox = Outbox()
    for _ in range(5):
        outbox.add(FrameKind.EVENT, 1.0, b"{}")
    assert numbers(frames_of(outbox)) == [1, 2, 3, 4, 5]

    outbox.acknowledge(2)
    outbox.add(FrameKind.EVENT, 1.0, b"{}")
    outbox.resume(3)

    assert numbers(frames_of(outbox)) == [4, 5, 6]
    outbox.acknowledge(6)
    assert outbox.is_empty
    assert outbox.bytes == 0


def test_the_oldest_output_is_dropped_and_counted_and_events_never():
    outbox = Outbox()
    for number in range(50):
        outbox.add(FrameKind.OUTPUT, 1.0, output(b"line\n" * 10))
        if number % 10 == 0:
            outbox.add(FrameKind.EVENT, 2.0, b"{}")

    outbox.limit(outbox.bytes // 2, 3.0)

    frames = frames_of(outbox)
    assert numbers(frames) == sorted(numbers(frames))
    assert sum(frame.kind == FrameKind.EVENT for frame in frames) == 5
    left = sum(frame.data()[2].count(b"\n") for frame in frames if frame.kind == FrameKind.OUTPUT)
    dropped = sum(json.loads(f.payload)["lines"] for f in frames if f.kind == FrameKind.DROPPED)
    assert dropped > 200
    assert left + dropped == 500
    last_drop = max(frame.sequence for frame in frames if frame.kind == FrameKind.DROPPED)
    assert all(frame.sequence > last_drop for frame in frames if frame.kind == FrameKind.OUTPUT)


ACTIONS = st.lists(
    st.one_of(
        st.tuples(st.just("output"), st.integers(0, 4)),
        st.tuples(st.just("event"), st.just(0)),
        st.tuples(st.just("send"), st.integers(1, 5)),
        st.tuples(st.just("resume"), st.integers(0, 3)),
        st.tuples(st.just("acknowledge"), st.integers(0, 3)),
        st.tuples(st.just("limit"), st.integers(0, 4)),
    ),
    max_size=60,
)


class Receiver:
    """The other side: takes each number once, in order."""

    def __init__(self) -> None:
        self.last = 0
        self.events: list[int] = []
        self.lines = 0

    def take(self, frames: list[Frame]) -> None:
        for frame in frames:
            if frame.sequence <= self.last:
                continue
            self.last = frame.sequence
            if frame.kind == FrameKind.EVENT:
                self.events.append(frame.sequence)
            elif frame.kind == FrameKind.OUTPUT:
                self.lines += frame.data()[2].count(b"\n")
            else:
                self.lines += json.loads(frame.payload)["lines"]


@given(actions=ACTIONS)
@example(actions=[("output", 1), ("limit", 0), ("resume", 0), ("limit", 0)])
def test_every_event_arrives_once_in_order_whatever_happens(actions: list[tuple[str, int]]):
    outbox, receiver = Outbox(), Receiver()
    events, lines, dropped = [], 0, False
    for action, amount in actions:
        if action == "output":
            outbox.add(FrameKind.OUTPUT, 1.0, output(b"x\n" * amount))
            lines += amount
        elif action == "event":
            outbox.add(FrameKind.EVENT, 1.0, b"{}")
            events.append(outbox.sequence)
        elif action == "send":
            for _ in range(amount):
                if outbox.has_unsent:
                    receiver.take(list(Decoder().feed(b"".join(outbox.take()))))
        elif action == "resume":
            outbox.resume(receiver.last)
        elif action == "acknowledge":
            outbox.acknowledge(max(0, receiver.last - amount))
        else:
            before = outbox.bytes
            outbox.limit(amount * 300, 1.0)
            dropped = dropped or outbox.bytes != before
        assert outbox.bytes >= 0
    outbox.resume(receiver.last)
    receiver.take(frames_of(outbox))
    assert receiver.events == events
    # Output that was dropped after it had arrived is counted twice: then it is "about so many".
    assert receiver.lines >= lines if dropped else receiver.lines == lines
    outbox.acknowledge(receiver.last)
    assert (outbox.bytes, outbox.is_empty) == (0, True)
