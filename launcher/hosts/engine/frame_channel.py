"""One end of a connection between launcher and agent: reads, writes, numbers, acknowledges.

It outlives its transport (two descriptors): what was not acknowledged is sent on the next one.
"""

from __future__ import annotations

import os
import time
from collections import deque

from launcher.hosts.engine import compression
from launcher.hosts.engine.frames import (
    FIRST_SEQUENCED,
    Decoder,
    Frame,
    FrameError,
    FrameKind,
    encode,
)
from launcher.hosts.engine.outbox import Outbox

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    from launcher.posix.reactor import Reactor

    class ChannelListener(Protocol):
        """The owner of a channel."""

        # A frame, each sequenced one once and in order; FrameError if it is malformed.
        def received(self, frame: Frame) -> None: ...

        # The transport has ended, and is closed; what was wrong, empty if it just ended.
        def lost(self, reason: str) -> None: ...

        # What has come is no frame; nothing more is read. It can still be answered.
        def malformed(self, reason: str) -> None: ...

        # Frames were acknowledged.
        def relieved(self) -> None: ...


READ_BYTES = 256 * 1024
# Of a pipe with output, to sshd or from ssh: neither end has to wait for each block of the other.
# With a quarter of it, a flood takes a tenth longer with log files, and a quarter without.
PIPE_BYTES = 1024 * 1024
ACK_BYTES = 256 * 1024  # of what was received, after which it is acknowledged
WRITE_BYTES = 256 * 1024  # at once
WRITE_PARTS = 1000  # at once; the kernel takes at most 1024 (IOV_MAX)
MOST_CONTROL = 256  # frames without a number that wait for the transport
_buffers: list[memoryview] = []  # of READ_BYTES, for all channels: those of which none reads


class FrameChannel:
    """`heard_s` is when something was received last.

    `received` is the number of the last frame that the listener has. With `holds_output` it gets
    output only before the next other frame: what is held is not acknowledged, so that the other
    side stops sending.
    """

    def __init__(self, reactor: Reactor, listener: ChannelListener) -> None:
        self._reactor = reactor
        self._listener = listener
        self.outbox = Outbox()
        self.compression = compression.LinkCompression()
        self._control: deque[bytes] = deque(maxlen=MOST_CONTROL)
        self._rest: list[bytes | memoryview] = []  # of what is being written
        self._decoder = Decoder()
        self._read_fd = self._write_fd = -1
        self._is_writing = False
        self._writes_soon = False
        self._sends_kept = False
        self.received = self._seen = 0
        self._held: deque[Frame] = deque()
        self.holds_output = False
        self._unacknowledged = 0
        self.heard_s = reactor.now()

    @property
    def is_attached(self) -> bool:
        return self._read_fd >= 0

    @property
    def is_flushed(self) -> bool:
        """Whether all frames have been written, or cannot be."""
        return not self._rest and not self._control and not self.outbox.has_unsent

    def attach(self, read_fd: int, write_fd: int, *, skips_noise: bool = False) -> None:
        """Use this transport, which is closed at its end. OSError (EPERM) if it cannot be.

        Frames with a number are sent after `resume`.
        """
        self.detach()
        for fd in (read_fd, write_fd):
            os.set_blocking(fd, False)
        self._decoder = Decoder(skips_noise=skips_noise)
        self._rest.clear()
        self._control.clear()
        self._sends_kept = False
        self.compression = compression.LinkCompression()
        self._held.clear()
        self._seen = self.received
        self._reactor.add_reader(read_fd, self._read)
        self._read_fd, self._write_fd = read_fd, write_fd

    def detach(self) -> None:
        """Close the transport, if there is one."""
        if self._read_fd < 0:
            return
        self._reactor.remove(self._read_fd)
        if self._is_writing:
            self._reactor.remove(self._write_fd)
        self._is_writing = False
        for fd in {self._read_fd, self._write_fd}:
            os.close(fd)
        self._read_fd = self._write_fd = -1

    def resume(self, sequence: int) -> None:
        """The other side has received the frames up to this one: send those after it."""
        self.outbox.resume(sequence)
        self._sends_kept = True
        self._write()

    # ---- sending

    def send(self, kind: FrameKind, payload: bytes, at_s: float | None = None) -> None:
        """A frame with a number, now or later; `at_s` is its time, by default now."""
        self.outbox.add(kind, time.monotonic() if at_s is None else at_s, payload)
        if not self._is_writing:
            self._write()

    def send_output(self, header: bytes, data: bytes) -> None:
        """An OUTPUT frame, when the other descriptors that are ready in this turn were read.

        So what many processes have written goes to ssh at once: it makes a packet of each write.
        """
        self.outbox.add(FrameKind.OUTPUT, time.monotonic(), header, data)
        if not (self._is_writing or self._writes_soon):
            self._writes_soon = True
            self._reactor.call_later(0, self._write_collected)

    def _write_collected(self) -> None:
        self._writes_soon = False
        if not self._is_writing:
            self._write()

    def send_now(self, kind: FrameKind, payload: bytes = b"") -> None:
        """A frame without a number: now, or never. It acknowledges what was received."""
        if self._read_fd < 0:
            return
        self._unacknowledged = 0
        self._control.append(encode(kind, self.received, time.monotonic(), payload))
        if not self._is_writing:
            self._write()

    def raw(self, data: bytes) -> None:
        """Bytes that are no frame, before the first frame."""
        self._control.append(data)

    def _write(self) -> None:
        if self._write_fd < 0:
            return
        while self._fill():
            try:
                written = os.writev(self._write_fd, self._rest)
            except BlockingIOError:
                break
            except OSError:
                # The reader will notice, too, after what is still to be read.
                self._rest.clear()
                self._control.clear()
                self._sends_kept = False
                break
            self._remove(written)
        self._await_writable(bool(self._rest))

    def _fill(self) -> bool:
        """Take frames to write; whether there are any."""
        outbox = self.outbox
        if self.compression.is_wanted and self._sends_kept and outbox.has_unsent:
            if not self._rest:
                self._take_batch()
            return True
        size = sum(map(len, self._rest))
        while (size < WRITE_BYTES and len(self._rest) < WRITE_PARTS) and (
            self._control or (self._sends_kept and outbox.has_unsent)
        ):
            parts = (self._control.popleft(),) if self._control else outbox.take()
            self._rest += parts
            size += sum(map(len, parts))
        return bool(self._rest)

    def _take_batch(self) -> None:
        """Take a batch of frames; as one, if that is worth it."""
        parts: list[bytes] = []
        size = 0
        while self.outbox.has_unsent and size < WRITE_BYTES:
            taken = self.outbox.take()
            parts += taken
            size += sum(map(len, taken))
        if compression.LEAST_BYTES <= size <= compression.MOST_BYTES:
            packed = self.compression.pack(parts)
            parts = [encode(FrameKind.PACKED, self.received, time.monotonic(), packed)]
        self._rest += [*self._control, *parts]
        self._control.clear()

    def _remove(self, written: int) -> None:
        rest = self._rest
        index = 0
        while index < len(rest) and written >= len(rest[index]):
            written -= len(rest[index])
            index += 1
        del rest[:index]
        if written:
            rest[0] = memoryview(rest[0])[written:]

    def _await_writable(self, wanted: bool) -> None:
        if wanted and not self._is_writing:
            self._reactor.add_writer(self._write_fd, self._write)
        elif not wanted and self._is_writing:
            self._reactor.remove(self._write_fd)
        self._is_writing = wanted

    # ---- receiving

    def read_rest(self) -> None:
        """The process at the other end has exited: read what it has left."""
        while self._read_fd >= 0 and self._read():
            pass

    def _read(self) -> bool:
        """Read once; whether there was anything."""
        buffer = _buffers.pop() if _buffers else memoryview(bytearray(READ_BYTES))
        try:
            return self._read_into(buffer)
        finally:
            _buffers.append(buffer)

    def _read_into(self, buffer: memoryview) -> bool:
        try:
            size = os.readv(self._read_fd, (buffer,))
        except BlockingIOError:
            return False
        except OSError as error:
            self._lose(os.strerror(error.errno or 0))
            return False
        if not size:
            self._lose("" if self._decoder.is_between else "the connection broke within a frame")
            return False
        self.heard_s = self._reactor.now()
        decoder = self._decoder
        try:
            for frame in decoder.feed(buffer[:size]):
                self._accept(frame)
                if self._decoder is not decoder or self._read_fd < 0:
                    return False  # the listener has changed the transport
        except FrameError as error:
            self._reactor.remove(self._read_fd)
            self._listener.malformed(str(error))
            return False
        self._unacknowledged += size
        if self._unacknowledged >= ACK_BYTES:
            self.send_now(FrameKind.ACK)
        return True

    def _accept(self, frame: Frame) -> None:
        if frame.kind < FIRST_SEQUENCED:
            if frame.kind not in (FrameKind.OPEN, FrameKind.HELLO):
                self._acknowledged(frame.sequence)
            if frame.kind == FrameKind.PACKED:
                self._unpack(frame)
            else:
                self._listener.received(frame)
        elif frame.sequence > self._seen:
            self._seen = frame.sequence
            self._held.append(frame)
            if not (self.holds_output and frame.kind == FrameKind.OUTPUT):
                self._deliver()

    def _acknowledged(self, sequence: int) -> None:
        size = self.outbox.acknowledge(sequence)
        self.compression.acknowledged(size, self.outbox.bytes, self.heard_s)
        self._listener.relieved()

    def _unpack(self, packed: Frame) -> None:
        """FrameError if it is not what `_take_batch` makes."""
        try:
            data = compression.unpacked(packed.payload)
        except ValueError as error:
            raise FrameError(str(error)) from None
        self._unacknowledged += len(data)
        decoder, outer = Decoder(), self._decoder
        for frame in decoder.feed(data):
            if frame.kind < FIRST_SEQUENCED:
                raise FrameError(f"a frame of kind {frame.kind} was packed")
            self._accept(frame)
            if self._decoder is not outer or self._read_fd < 0:
                return  # the listener has changed the transport
        if not decoder.is_between:
            raise FrameError("a frame was packed in part")

    def release(self) -> None:
        """Pass on the output that is held."""
        self.holds_output = False
        self._deliver()
        self.send_now(FrameKind.ACK)

    def _deliver(self) -> None:
        while self._held:
            frame = self._held.popleft()
            self.received = frame.sequence
            self._listener.received(frame)

    def _lose(self, reason: str) -> None:
        self.detach()
        self._listener.lost(reason)
