"""Frames of the protocol between launcher and agent."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.base.model.events import Outcome
from launcher.hosts.engine.frames import (
    HEADER,
    MAX_NOISE,
    MAX_PAYLOAD,
    PREAMBLE,
    Decoder,
    Frame,
    FrameError,
    FrameKind,
    encode,
    pack,
)
from launcher.hosts.engine.reports import decode_event, encode_event
from launcher.run.processes.machine_events import Exited, MachineCommand, SignalSent, SpawnError

FRAMES = st.lists(
    st.tuples(
        st.sampled_from(list(FrameKind)),
        st.integers(0, 2**64 - 1),
        st.floats(0, 1e9),
        st.binary(max_size=200),
    ),
    max_size=6,
)


def as_tuples(frames: list[Frame]) -> list[tuple[int, int, float, bytes]]:
    return [(one.kind, one.sequence, one.time_s, one.payload + one.rest) for one in frames]


def in_pieces(decoder: Decoder, data: bytes, sizes: list[int]) -> list[Frame]:
    frames: list[Frame] = []
    for size in sizes:
        frames += decoder.feed(data[:size])
        data = data[size:]
    return [*frames, *decoder.feed(data)]


@given(frames=FRAMES, sizes=st.lists(st.integers(0, 100), max_size=20))
def test_frames_survive_any_division_into_blocks(
    frames: list[tuple[FrameKind, int, float, bytes]], sizes: list[int]
):
    data = b"".join(encode(*frame) for frame in frames)
    decoder = Decoder()

    found = in_pieces(decoder, data, sizes)

    assert as_tuples(found) == frames
    assert decoder.is_between


@given(noise=st.binary(max_size=100), sizes=st.lists(st.integers(0, 40), max_size=8))
def test_what_a_login_shell_prints_before_is_skipped(noise: bytes, sizes: list[int]):
    noise = noise.replace(b"\0", b"")
    data = noise + PREAMBLE + encode(FrameKind.HELLO, 0, 1.0, b"{}")
    decoder = Decoder(skips_noise=True)

    (frame,) = in_pieces(decoder, data, sizes)

    assert frame.kind == FrameKind.HELLO
    assert decoder.noise == noise


@given(data=st.binary(max_size=400), sizes=st.lists(st.integers(0, 60), max_size=8))
def test_random_bytes_are_frames_or_an_error(data: bytes, sizes: list[int]):
    try:
        for frame in in_pieces(Decoder(), data, sizes):
            assert len(frame.payload) <= MAX_PAYLOAD
            frame.content()
            frame.data()
    except FrameError:
        pass


def test_a_length_beyond_the_limit_is_refused_before_it_is_read():
    header = HEADER.pack(MAX_PAYLOAD + 1, FrameKind.PREPARE, 1, 0.0)

    with pytest.raises(FrameError, match="not a frame"):
        list(Decoder().feed(header))
    with pytest.raises(ValueError, match="too long"):
        encode(FrameKind.PREPARE, 1, 0.0, bytes(MAX_PAYLOAD + 1))


def test_endless_noise_is_refused():
    with pytest.raises(FrameError, match="no agent"):
        list(Decoder(skips_noise=True).feed(bytes(MAX_NOISE + 1)))


@pytest.mark.parametrize("payload", [b"", b"{", b"[]", b"\xff", b"[" * 100_000])
def test_a_payload_that_is_no_object_is_refused(payload: bytes):
    with pytest.raises(FrameError, match="payload"):
        Frame(FrameKind.OPEN, 0, 0.0, payload).content()


@pytest.mark.parametrize("payload", [b"", b"1234", struct.pack("!IB", 1, 3)])
def test_output_of_an_unknown_stream_is_refused(payload: bytes):
    with pytest.raises(FrameError):
        Frame(FrameKind.OUTPUT, 1, 0.0, payload).data()


EVENTS = [
    MachineCommand.STARTED,
    SpawnError(2, "working directory '/x'"),
    SignalSent(2, by_user=True),
    Exited(Outcome(returncode=-11, core_dumped=True)),
    Exited(Outcome(returncode=0)),
]


@pytest.mark.parametrize("event", EVENTS)
def test_events_survive_the_way(event: object):
    frame = Frame(FrameKind.EVENT, 1, 0.0, pack(encode_event(event)))  # type: ignore[arg-type]

    assert decode_event(frame.content()) == event
