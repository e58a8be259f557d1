"""Writes bytes to a descriptor without blocking, and queues what it does not take yet."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections import deque
from collections.abc import Callable, Iterator

from launcher.posix.reactor import Reactor

TYPE_CHECKING = False
if TYPE_CHECKING:
    Bytes = bytes | memoryview

HIGH_WATER = 1024 * 1024  # queued bytes above which children are not read
# The same for a terminal: what is queued is shown before the answer to a key, and after a `mute`.
TERMINAL_HIGH_WATER = 128 * 1024
COLLECT_S = 0.02  # for so long, lines may be collected and written together
# Errors of a full disk, which do not end the run. Any other error means that nobody reads.
FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
TOGETHER_BYTES = 16 * 1024  # a terminal takes half as much, and most lines are far shorter
LOW_PART = 4  # the children are read again when the queue is below a quarter of its high water


class OutputQueue:
    """What is written to `fd`, in order; a descriptor that others use, too, is opened again.

    `on_pressure(True)` is called when the queue is long, `on_pressure(False)` when it is short
    again; `on_closed()` once when the output has no reader any more (`| head`).
    """

    def __init__(self, reactor: Reactor, fd: int) -> None:
        self._reactor = reactor
        self.fd, self._own = _non_blocking(fd)
        self.is_tty = os.isatty(fd)
        self.closed = False
        self.dropped_bytes = 0
        self._waiting: deque[Bytes] = deque()
        self._waiting_bytes = 0
        self._pressed = False
        self._next_fd: int | None = None  # written to instead, once the queue is empty
        self._collected: list[bytes] | None = None
        self._collect_until_s = 0.0
        self._high_water = TERMINAL_HIGH_WATER if self.is_tty else HIGH_WATER
        self.on_pressure: Callable[[bool], None] = lambda pressed: None
        self.on_closed: Callable[[], None] = lambda: None

    @contextlib.contextmanager
    def collecting(self) -> Iterator[None]:
        """Within, collect what is written for COLLECT_S, so that many lines are one write."""
        self._collected = []
        try:
            yield
        finally:
            collected, self._collected = self._collected, None
            if collected:
                self.write(b"".join(collected))

    def _collect(self, collected: list[bytes], block: bytes) -> None:
        now = self._reactor.now()
        if not collected:
            self._collect_until_s = now + COLLECT_S
        collected.append(block)
        if now > self._collect_until_s:
            self._collected = None
            self.write(b"".join(collected))
            self._collected = []

    def write(self, block: bytes) -> None:
        """Write bytes as they are."""
        if self._collected is not None:
            self._collect(self._collected, block)
            return
        if self.closed:
            return
        if self._waiting:
            self._waiting.append(block)
            self._waiting_bytes += len(block)
            self.push()
        else:
            rest = self._try(block)
            if not rest or self.closed:
                return
            self._reactor.remove(self.fd)  # it is still watched if `push` has emptied the queue
            self._reactor.add_writer(self.fd, self.flush)
            self._waiting.append(rest)
            self._waiting_bytes += len(rest)
        if self._waiting_bytes > self._high_water:
            self._press()

    def push(self) -> None:
        """Write of the queue what the output takes now; `flush` follows when it can take more.

        A terminal takes a few KB: it would have nothing to do while much more is being read.
        """
        while self._waiting:
            block = self._take_block()
            rest = self._try(block)
            self._waiting_bytes -= len(block) - len(rest)
            if rest:
                self._waiting.appendleft(rest)
                break

    def flush(self) -> None:
        """The same when the output can be written to, and what an empty queue allows."""
        self.push()
        if not self._waiting:
            self._reactor.remove(self.fd)
            self._has_emptied()
        if self._waiting_bytes < self._high_water // LOW_PART and self._next_fd is None:
            self._release()

    def _has_emptied(self) -> None:
        """Called when the queue has become empty."""

    def _take_block(self) -> Bytes:
        """The next block of the queue, together with those after it if they are short."""
        block = self._waiting.popleft()
        if len(block) >= TOGETHER_BYTES or not self._waiting:
            return block
        parts, size = [block], len(block)
        while self._waiting and size < TOGETHER_BYTES:
            parts.append(self._waiting.popleft())
            size += len(parts[-1])
        return b"".join(parts)

    def _press(self) -> None:
        if not self._pressed:
            self._pressed = True
            self.on_pressure(True)

    def _release(self) -> None:
        if self._pressed:
            self._pressed = False
            self.on_pressure(False)

    def _try(self, block: Bytes) -> Bytes:
        """Write without blocking; returns the rest."""
        try:
            written = os.write(self.fd, block)
            if written == len(block):
                return b""
            block = memoryview(block)[written:]  # a terminal takes 4 KB: do not copy the rest
            while block:
                block = block[os.write(self.fd, block) :]
        except BlockingIOError:
            pass
        except OSError as error:
            if error.errno in FULL:
                self._drop(block, error)
            else:
                self._close_output()  # EPIPE, EIO: it has no reader any more
            return b""
        return block

    def _drop(self, block: Bytes, error: OSError) -> None:
        if not self.dropped_bytes:
            from launcher.output.backlog import complain

            reason = f"cannot write the output: {error.strerror}"
            complain(f"{reason}; what does not fit is dropped")
        self.dropped_bytes += len(block)

    def _close_output(self) -> None:
        self.closed = True
        self._waiting.clear()
        self._waiting_bytes = 0
        self._reactor.remove(self.fd)
        self._release()
        self.on_closed()

    @property
    def waiting_bytes(self) -> int:
        return self._waiting_bytes

    def take_waiting(self) -> bytes:
        """What could not be written yet; it is forgotten here."""
        waiting = b"".join(self._waiting)
        self._waiting.clear()
        self._waiting_bytes = 0
        self._reactor.remove(self.fd)
        return waiting


def _non_blocking(fd: int) -> tuple[int, bool]:
    """A non-blocking descriptor for the same output, and whether it is ours to close.

    O_NONBLOCK on a descriptor that we inherited would change the shell's as well, so terminals
    and pipes are opened again. Files do not block, and a second opening would lose the offset.
    """
    mode = os.fstat(fd).st_mode
    if stat.S_ISFIFO(mode) or stat.S_ISCHR(mode):
        with contextlib.suppress(OSError):
            flags = os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
            return os.open(f"/proc/self/fd/{fd}", flags), True
    return fd, False
