"""Contents of files on their way to a host."""

from __future__ import annotations

import io
import os
import struct
import zlib

import pytest

from launcher.hosts.sync.on_host import wire


def received(data: bytes) -> list[bytes]:
    return list(wire.receive_content(io.BytesIO(data)))


def packed(data: bytes) -> bytes:
    return struct.pack(">I", len(data) | 1 << 31) + data + bytes(4)


def test_blocks_arrive_as_they_were_sent():
    blocks = [b"x" * 100_000, os.urandom(100_000), b"short"]
    sent = io.BytesIO()
    wire.send_content(sent, blocks, lambda count: None)
    assert received(sent.getvalue()) == blocks
    assert len(sent.getvalue()) < 110_000


@pytest.mark.parametrize("data", [b"none", zlib.compress(b"x" * 1000)[:-5], b""])
def test_a_damaged_block_is_no_content(data: bytes):
    with pytest.raises(wire.Closed):
        received(packed(data))


def test_a_block_is_not_unpacked_beyond_its_limit(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(wire, "MAX_MESSAGE_BYTES", 1000)
    with pytest.raises(wire.Closed):
        received(packed(zlib.compress(bytes(1001))))


@pytest.mark.parametrize("text", [b"{", b"\xff", b"[" * 100_000])
def test_a_message_that_is_no_json(text: bytes):
    with pytest.raises(wire.Closed, match="no message"):
        wire.receive(io.BytesIO(struct.pack(">I", len(text)) + text))
