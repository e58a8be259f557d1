"""Frames that are compressed, where the link is slower than the processor."""

from __future__ import annotations

import itertools
import os
import time
import zlib

import pytest

from launcher.hosts.engine.compression import (
    MOST_BYTES,
    WAITING_BYTES,
    LinkCompression,
    unpacked,
)
from launcher.posix.reactor import Reactor
from tests.hosts.unit.agent.test_channel import End

BATCH = 256 * 1024
TEXT = (b"a line of a node\n" * BATCH)[:BATCH]
SLOW, FAST = 100_000.0, 1e12  # bytes in a second


def allowed() -> LinkCompression:
    """On a processor that takes a millisecond for each batch."""
    ticks = itertools.count()
    begin_s = time.monotonic()
    compression = LinkCompression(lambda: begin_s + next(ticks) / 1000)
    compression.is_possible = True
    return compression


def busy_link(compression: LinkCompression, bytes_s: float, in_s: float = 0.0) -> None:
    """A second in which so much was acknowledged, and enough waits all the time."""
    begin_s = time.monotonic() + in_s
    for tenth in range(11):
        compression.acknowledged(int(bytes_s / 10), 2 * WAITING_BYTES, begin_s + tenth / 10)


def test_a_slow_link_is_worth_it():
    compression = allowed()
    busy_link(compression, SLOW)
    assert compression.is_wanted

    packed = compression.pack([TEXT])

    assert len(packed) < BATCH / 10
    assert compression.is_wanted


@pytest.mark.parametrize(("rate", "data"), [(FAST, TEXT), (SLOW, os.urandom(BATCH))])
def test_a_fast_link_or_noise_is_not(rate: float, data: bytes):
    compression = allowed()
    busy_link(compression, rate)
    compression.pack([data])  # a trial

    busy_link(compression, rate, in_s=1.0)
    assert not compression.is_wanted
    busy_link(compression, rate, in_s=30.0)
    assert compression.is_wanted  # another trial


def test_it_stops_when_the_link_has_become_fast():
    compression = allowed()
    busy_link(compression, SLOW)
    compression.pack([TEXT])
    compression.pack([TEXT])

    busy_link(compression, FAST, in_s=1.0)

    assert not compression.is_wanted


def test_a_link_on_which_nothing_waits_is_not_slow():
    compression = allowed()
    for second in range(20):
        compression.acknowledged(1000, 0, float(second))
    assert not compression.is_wanted


def test_nothing_is_compressed_for_a_launcher_that_cannot_unpack():
    compression = LinkCompression()
    busy_link(compression, SLOW)
    assert not compression.is_wanted


LONGEST = b"x" * MOST_BYTES


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"x" * 100,
        zlib.compress(TEXT)[:-5],
        zlib.compress(TEXT) + b"x",
        zlib.compress(LONGEST + b"x"),
    ],
)
def test_what_is_no_batch_or_too_long_is_refused(data: bytes):
    with pytest.raises(ValueError, match="pack"):
        unpacked(data)


def test_the_longest_batch_is_unpacked():
    assert unpacked(zlib.compress(LONGEST)) == LONGEST


def test_a_longer_frame_is_sent_as_it_is():
    text = b"x" * (2 * MOST_BYTES)
    with Reactor() as reactor:
        sender, receiver = End(reactor, 1), End(reactor, 1)
        sender.channel.send_output(b"", text)
        there, back = os.pipe(), os.pipe()
        receiver.channel.attach(there[0], back[1])
        sender.channel.attach(back[0], there[1])
        sender.channel.compression.is_wanted = True
        sender.channel.resume(0)
        reactor.call_later(60.0, reactor.stop)
        reactor.run()
        assert receiver.payloads == [text]
        sender.channel.detach()
        receiver.channel.detach()


def test_packed_frames_arrive_once_and_in_order():
    count, size = 60, 20_000
    texts = [b"%d %b" % (number, TEXT[:size]) for number in range(count)]
    with Reactor() as reactor:
        sender, receiver = End(reactor, 0), End(reactor, count)
        for text in texts:
            sender.channel.send_output(b"", text)
        there, back = os.pipe(), os.pipe()
        sender.channel.attach(back[0], there[1])
        sender.channel.compression.is_wanted = True
        sender.channel.resume(0)
        assert sender.channel.is_flushed
        data = os.read(there[0], count * size)
        assert len(data) < count * size / 10
        os.write(there[1], data)
        receiver.channel.attach(there[0], back[1])
        reactor.call_later(60.0, reactor.stop)
        reactor.run()
        assert receiver.payloads == texts
        assert sender.lost_because == receiver.lost_because == []
        sender.channel.detach()
        receiver.channel.detach()
