"""Compression of frames, where a link is slower than the processor.

On a slow link, many lines wait to be sent: then whole batches of frames are packed into one. What
does not wait is sent as it is, so that the delay of a line stays the same.
"""

from __future__ import annotations

import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    Bytes = bytes | memoryview

METHOD = "zlib"  # as launcher and agent call it
LEAST_BYTES = 16 * 1024  # of a batch that is compressed
MOST_BYTES = 1024 * 1024  # of one; so a few bytes from a hostile host cannot become many
WAITING_BYTES = 1024 * 1024  # unacknowledged, with which the link is busy
_LEVEL = 1  # three times as fast as the usual one, for a tenth more bytes
_PERIOD_S = 0.5  # in which the link's speed is measured
_AGAIN_S = 10.0  # what could not be compressed is tried again
_USEFUL = 0.8  # of the size, at most
# Of one processor: predicted, to begin; measured, to stop.
_SHARE_TO_BEGIN, _SHARE_TO_STOP = 0.25, 0.5


class LinkCompression:
    """Decides whether batches are worth compressing. `is_wanted` may be asked at any time.

    The speed of the link is that at which frames are acknowledged while enough of them wait, so
    it includes the other side. The speed of the processor is measured as elapsed time: with more
    urgent work on this computer, compression stops.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self.is_possible = False  # the other side can unpack
        self.is_wanted = False
        self._is_trial = False
        self._not_before_s = 0.0
        self._since_s: float | None = None  # of the period; None: the link is not busy
        self._acknowledged = 0
        self._link_bytes_s = 0.0
        self._packed = self._bytes = 0
        self._seconds = 0.0

    def acknowledged(self, size: int, left: int, now_s: float) -> None:
        """Frames of `size` bytes have arrived, `left` bytes still wait."""
        if not self.is_possible:
            return
        if self._since_s is None or left + size < WAITING_BYTES:
            self._since_s = now_s if left >= WAITING_BYTES else None
            self._acknowledged = 0
            return
        self._acknowledged += size
        seconds = now_s - self._since_s
        if seconds >= _PERIOD_S:
            self._link_bytes_s = self._acknowledged / seconds
            self._since_s, self._acknowledged = now_s, 0
            self._judge(now_s)

    def _judge(self, now_s: float) -> None:
        if not self.is_wanted:
            self.is_wanted = self._is_trial = now_s >= self._not_before_s
        elif self._bytes and not self._is_trial:
            is_useless = self._packed > _USEFUL * self._bytes
            if is_useless or self._link_bytes_s > _SHARE_TO_STOP * self._speed:
                self._stop(now_s)
        self._packed = self._bytes = 0
        self._seconds = 0.0

    @property
    def _speed(self) -> float:
        """Bytes in a second that this processor compresses."""
        return self._bytes / max(self._seconds, 1e-9)

    def _stop(self, now_s: float) -> None:
        self.is_wanted = False
        self._not_before_s = now_s + _AGAIN_S

    def pack(self, parts: Sequence[Bytes]) -> bytes:
        """The parts of frames in one, compressed."""
        import zlib  # most links never need it

        begin_s = self._clock()
        data = b"".join(parts)
        packed = zlib.compress(data, _LEVEL)
        now_s = self._clock()
        self._packed += len(packed)
        self._bytes += len(data)
        self._seconds += now_s - begin_s
        if self._is_trial:
            self._is_trial = False
            faster = self._link_bytes_s * self._bytes / self._packed
            is_useless = self._packed > _USEFUL * self._bytes
            if is_useless or faster > _SHARE_TO_BEGIN * self._speed:
                self._stop(now_s)
        return packed


def unpacked(data: bytes) -> bytes:
    """What `pack` was given; ValueError if that was something else, or longer than MOST_BYTES."""
    import zlib

    stream = zlib.decompressobj()
    try:
        found = stream.decompress(data, MOST_BYTES + 1)
    except zlib.error as error:
        raise ValueError(f"it cannot be unpacked: {error}") from None
    if not stream.eof or stream.unused_data or len(found) > MOST_BYTES:
        raise ValueError("what was packed is too long, or not all")
    return found
