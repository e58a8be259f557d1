"""The protocol between a launcher and the agent on a host: frames on a stream of bytes.

    u32 length of the payload | u8 kind | u64 sequence | f64 time of the sender | payload

Numbers are big-endian, times are seconds on the sender's monotonic clock. A sequenced frame is kept
by its sender until the receiver has acknowledged its number, and sent again on a new connection.
The others are numbered by what their sender has received: they acknowledge.
"""

from __future__ import annotations

import enum
import struct
from collections.abc import Iterator, Mapping

from launcher.base import strict_json
from launcher.hosts.identity import PROTOCOL as PROTOCOL

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

# The agent sends this before its first frame; a login shell may have printed something before.
PREAMBLE = b"\0launcher-agent\n"
MAX_NOISE = 64 * 1024
CLOCK_SAMPLES = 3  # BEATs that are answered before the host counts as ready
MAX_PAYLOAD = 32 * 1024 * 1024  # an order with some files of 1 MiB
HEADER = struct.Struct("!IBQd")
OUTPUT_HEADER = struct.Struct("!IB")  # process, stream
ECHO = struct.Struct("!dQ")  # the time of the BEAT, the number of the last frame
STREAMS = ("stdout", "stderr", "both")


class FrameKind(enum.IntEnum):
    """Kinds of frames; from the operator if not said otherwise. Most payloads are JSON objects."""

    # not sequenced
    OPEN = 1  # the first frame: the run, the policy
    BEAT = 2  # once a second
    ACK = 3  # both ways
    HELLO = 4  # of the agent, its first frame
    ECHO = 5  # of the agent, at once after a BEAT: the time of that
    SAMPLES = 6  # of the agent: resources of processes
    REFUSAL = 7  # of the agent, its last frame: why it ends
    # sequenced
    PREPARE = 16
    COMMAND = 17
    SIGNAL = 18
    STDIN = 19  # OUTPUT_HEADER, bytes
    FINISH = 20
    EVENT = 32  # of the agent, as the following
    OUTPUT = 33  # OUTPUT_HEADER, bytes
    DROPPED = 34
    WARNING = 35
    FINISHED = 36


FIRST_SEQUENCED = FrameKind.PREPARE
_KINDS = frozenset(map(int, FrameKind))


class FrameError(ValueError):
    """What was received is no frame of this protocol."""


class Frame:
    """One frame; `kind` is one of `FrameKind`."""

    __slots__ = ("kind", "payload", "sequence", "time_s")

    def __init__(self, kind: int, sequence: int, time_s: float, payload: bytes) -> None:
        self.kind = kind
        self.sequence = sequence
        self.time_s = time_s
        self.payload = payload

    def content(self) -> Mapping[str, Any]:
        """The object in the payload; FrameError."""
        try:
            value = strict_json.unpacked(self.payload)
        except ValueError:
            raise FrameError(f"the payload of a frame of kind {self.kind} is no JSON") from None
        if not isinstance(value, dict):
            raise FrameError(f"the payload of a frame of kind {self.kind} is no object")
        return value

    def data(self) -> tuple[int, int, bytes]:
        """(process, stream, bytes); FrameError."""
        if len(self.payload) < OUTPUT_HEADER.size:
            raise FrameError("a frame of bytes is too short")
        process_id, stream = OUTPUT_HEADER.unpack_from(self.payload)
        if stream >= len(STREAMS):
            raise FrameError(f"there is no stream {stream}")
        return process_id, stream, self.payload[OUTPUT_HEADER.size :]


def encode(kind: int, sequence: int, time_s: float, payload: bytes = b"") -> bytes:
    """ValueError if the payload is too long."""
    if len(payload) > MAX_PAYLOAD:
        raise ValueError(f"a payload of {len(payload)} bytes is too long")
    return HEADER.pack(len(payload), kind, sequence, time_s) + payload


def pack(content: Mapping[str, Any]) -> bytes:
    """An object as a payload."""
    return strict_json.packed(content, separators=(",", ":")).encode()


class Decoder:
    """Takes blocks of bytes, gives frames. `skips_noise`: a PREAMBLE comes first."""

    def __init__(self, *, skips_noise: bool = False) -> None:
        self._rest = b""
        self._is_noise = skips_noise
        self.noise = b""

    @property
    def is_between(self) -> bool:
        """Whether no part of a frame is waiting for the rest."""
        return not self._rest

    def feed(self, block: bytes) -> Iterator[Frame]:
        """The frames that are complete; FrameError, after which nothing more can be read."""
        buffer = self._rest + block if self._rest else block
        self._rest = b""
        if self._is_noise:
            before, preamble, after = buffer.partition(PREAMBLE)
            if not preamble:
                if len(buffer) > MAX_NOISE:
                    raise FrameError("there is no agent")
                self._rest = buffer
                return
            self._is_noise, self.noise, buffer = False, before, after
        start, size = 0, len(buffer)
        while size - start >= HEADER.size:
            length, kind, sequence, time_s = HEADER.unpack_from(buffer, start)
            if length > MAX_PAYLOAD or kind not in _KINDS:
                raise FrameError(f"not a frame: kind {kind}, {length} bytes")
            end = start + HEADER.size + length
            if end > size:
                break
            yield Frame(kind, sequence, time_s, buffer[start + HEADER.size : end])
            start = end
        self._rest = buffer[start:]
