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
    PACKED = 8  # of the agent, if OPEN `accepts` that: other frames, compressed
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
_OF_BYTES = frozenset(map(int, (FrameKind.STDIN, FrameKind.OUTPUT)))


class FrameError(ValueError):
    """What was received is no frame of this protocol."""


class Frame:
    """One frame; `kind` is one of `FrameKind`.

    Of one with an OUTPUT_HEADER, that is the payload here, and `rest` has the bytes behind it.
    """

    __slots__ = ("kind", "payload", "rest", "sequence", "time_s")

    def __init__(
        self, kind: int, sequence: int, time_s: float, payload: bytes, rest: bytes = b""
    ) -> None:
        self.kind = kind
        self.sequence = sequence
        self.time_s = time_s
        self.payload = payload
        self.rest = rest

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
        process_id, stream = OUTPUT_HEADER.unpack(self.payload)
        if stream >= len(STREAMS):
            raise FrameError(f"there is no stream {stream}")
        return process_id, stream, self.rest


def encode(
    kind: int, sequence: int, time_s: float, payload: bytes = b"", *, follow: int = 0
) -> bytes:
    """ValueError if the payload is too long, with so many bytes that follow."""
    size = len(payload) + follow
    if size > MAX_PAYLOAD:
        raise ValueError(f"a payload of {size} bytes is too long")
    return HEADER.pack(size, kind, sequence, time_s) + payload


def pack(content: Mapping[str, Any]) -> bytes:
    """An object as a payload."""
    return strict_json.packed(content, separators=(",", ":")).encode()


class Decoder:
    """Takes blocks of bytes, gives frames. `skips_noise`: a PREAMBLE comes first.

    Each byte of a payload is copied once: output comes by the megabyte.
    """

    def __init__(self, *, skips_noise: bool = False) -> None:
        self._rest = bytearray()  # the beginning of a frame
        self._is_noise = skips_noise
        self.noise = b""

    @property
    def is_between(self) -> bool:
        """Whether no part of a frame is waiting for the rest."""
        return not self._rest

    def feed(self, block: bytes | memoryview) -> Iterator[Frame]:
        """The frames that are complete; FrameError, after which nothing more can be read.

        A memoryview may lead to other bytes when all frames were taken.
        """
        view = memoryview(block)
        if self._is_noise:
            self._rest += view
            before, preamble, after = bytes(self._rest).partition(PREAMBLE)
            if not preamble:
                if len(before) > MAX_NOISE:
                    raise FrameError("there is no agent")
                return
            self._is_noise, self.noise, view = False, before, memoryview(after)
            self._rest.clear()
        while self._rest and view:
            missing = self._missing()
            self._rest += view[:missing]
            view = view[missing:]
            if not self._missing():
                rest, self._rest = memoryview(self._rest), bytearray()
                yield _frame(rest, 0, len(rest))
        start, size = 0, len(view)
        while size - start >= HEADER.size:
            end = start + HEADER.size + _length(view, start)
            if end > size:
                break
            yield _frame(view, start, end)
            start = end
        self._rest += view[start:]

    def _missing(self) -> int:
        """How many bytes the frame needs that has begun, as far as that is known."""
        if len(self._rest) < HEADER.size:
            return HEADER.size - len(self._rest)
        return HEADER.size + _length(self._rest, 0) - len(self._rest)


def _length(buffer: memoryview | bytearray, start: int) -> int:
    """The size of the payload of the frame that begins there; FrameError."""
    length: int
    length, kind, _, _ = HEADER.unpack_from(buffer, start)
    if length > MAX_PAYLOAD or kind not in _KINDS:
        raise FrameError(f"not a frame: kind {kind}, {length} bytes")
    return length


def _frame(buffer: memoryview, start: int, end: int) -> Frame:
    _, kind, sequence, time_s = HEADER.unpack_from(buffer, start)
    start += HEADER.size
    if kind not in _OF_BYTES:
        return Frame(kind, sequence, time_s, bytes(buffer[start:end]))
    middle = min(start + OUTPUT_HEADER.size, end)
    return Frame(kind, sequence, time_s, bytes(buffer[start:middle]), bytes(buffer[middle:end]))
