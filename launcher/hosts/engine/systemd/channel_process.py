"""A session of ssh on the event loop."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Callable, Mapping, Sequence

from launcher.posix.reactor import Reactor
from launcher.posix.spawn import execute, reap

READ_BYTES = 256 * 1024
MAX_ERRORS = 8 * 1024  # of messages of ssh that are kept


class ChannelProcess:
    """A process here whose output comes to `on_data`, until `on_end(return code, messages)`.

    OSError if it cannot be started. After `close` nothing comes any more.
    """

    def __init__(
        self,
        reactor: Reactor,
        words: Sequence[str],
        environment: Mapping[str, str],
        *,
        on_data: Callable[[bytes], None],
        on_end: Callable[[int, str], None],
    ) -> None:
        self._reactor = reactor
        self._on_data, self._on_end = on_data, on_end
        self._errors = b""
        self._unsent = bytearray()
        self._is_writing = self._is_paused = False
        pipes = [os.pipe() for _ in range(3)]
        (theirs_in, self._in), (self._out, theirs_out), (self._err, theirs_err) = pipes
        streams = (theirs_in, theirs_out, theirs_err)
        try:
            self.pid = execute(words, env=environment, streams=streams)
        except OSError:
            for fd in (self._in, self._out, self._err):
                os.close(fd)
            raise
        finally:
            for fd in streams:
                os.close(fd)
        self._pidfd = os.pidfd_open(self.pid)
        for fd in (self._in, self._out, self._err):
            os.set_blocking(fd, False)
        reactor.add_reader(self._out, self._read)
        reactor.add_reader(self._err, self._read_errors)
        reactor.add_reader(self._pidfd, self._exited)

    @property
    def is_open(self) -> bool:
        return self._pidfd >= 0

    def write(self, data: bytes) -> None:
        """Queue this for its standard input."""
        self._unsent += data
        if not self._is_writing:
            self._flush()

    def _flush(self) -> None:
        try:
            del self._unsent[: os.write(self._in, self._unsent)]
        except BlockingIOError:
            pass
        except OSError:
            self._unsent.clear()  # it has exited, which is noticed elsewhere
        if bool(self._unsent) is not self._is_writing:
            self._is_writing = bool(self._unsent)
            if self._is_writing:
                self._reactor.add_writer(self._in, self._flush)
            else:
                self._reactor.remove(self._in)

    def pause(self, paused: bool) -> None:
        """Do not read its output, or go on."""
        if not self.is_open or paused is self._is_paused:
            return
        self._is_paused = paused
        if paused:
            self._reactor.remove(self._out)
        else:
            self._reactor.add_reader(self._out, self._read)

    def _read(self) -> None:
        data = _read(self._out)
        if data:
            self._on_data(data)
        elif data is not None:
            self._reactor.remove(self._out)

    def _read_errors(self) -> None:
        data = _read(self._err)
        if data:
            self._errors = (self._errors + data)[-MAX_ERRORS:]
        elif data is not None:
            self._reactor.remove(self._err)

    def _exited(self) -> None:
        while data := _read(self._out):
            self._on_data(data)
            if not self.is_open:
                return
        self._read_errors()
        errors = self._errors.decode(errors="replace")
        returncode = self._release()
        self._on_end(returncode, errors)

    def close(self) -> None:
        """End it; idempotent."""
        if self.is_open:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGKILL)
            self._release()

    def _release(self) -> int:
        for fd in (self._in, self._out, self._err, self._pidfd):
            self._reactor.remove(fd)
        returncode, _ = reap(self._pidfd)
        for fd in (self._in, self._out, self._err, self._pidfd):
            os.close(fd)
        self._pidfd = -1
        return returncode


def _read(fd: int) -> bytes | None:
    """b'' at the end, None if there is nothing yet."""
    try:
        return os.read(fd, READ_BYTES)
    except BlockingIOError:
        return None
    except OSError:
        return b""
