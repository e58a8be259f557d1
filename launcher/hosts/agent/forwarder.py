"""Forwards the output of processes in the blocks in which it was read."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection

from launcher.output.tracebacks import has_begin
from launcher.posix.reactor import Reactor, Timer
from launcher.posix.spawn import read_stream
from launcher.run.output.output_reader import PARTIAL_LINE_S, OutputReader
from launcher.run.processes.process import Process

_NUMBERS = {"stdout": 0, "stderr": 1, "both": 2}  # of `frames.STREAMS`


class Forwarder(OutputReader):
    """An OutputReader without lines: `send(process id, number of the stream, block)`.

    An empty block says that the process is silent after a line or traceback that is not finished.
    Only this side can detect it: on a slow link, blocks come late.
    """

    def __init__(
        self,
        reactor: Reactor,
        processes: Collection[Process],
        send: Callable[[int, int, bytes], None],
    ) -> None:
        self._reactor = reactor
        self._processes = processes
        self._send = send
        self._paused = False
        self._kept = {}
        self._numbers: dict[int, dict[int, int]] = {}  # process id -> descriptor -> stream
        self._unfinished: dict[tuple[Process, int], float] = {}  # when it wrote last
        self._silence: Timer | None = None
        self.read_at_s = 0.0

    def pause(self, paused: bool) -> None:
        """Stop reading, so that the pipes fill and the processes wait, or go on."""
        if paused == self._paused:
            return
        self._paused = paused
        for process in self._processes:
            for fd in self._numbers.get(process.process_id, ()):
                self._reactor.remove(fd)
                if not paused:
                    self._listen(process, fd)

    def attach(self, process: Process) -> None:
        assert process.child is not None
        numbers = {fd: _NUMBERS[name] for fd, name in process.child.streams.items()}
        self._numbers.setdefault(process.process_id, {}).update(numbers)
        if not self._paused:
            for fd in numbers:
                self._listen(process, fd)

    def _listen(self, process: Process, fd: int) -> None:
        self._reactor.add_reader(fd, functools.partial(self._read, process, fd))

    def _descriptors(self, process: Process) -> list[int]:
        return list(self._numbers.get(process.process_id, ()))

    def _close(self, process: Process, fd: int) -> None:
        self._unfinished.pop((process, fd), None)
        del self._numbers[process.process_id][fd]
        self._close_descriptor(process, fd)

    def _read(self, process: Process, fd: int) -> int:
        chunk = read_stream(fd)
        if chunk is None:
            return 0
        numbers = self._numbers[process.process_id]
        self.read_at_s = self._reactor.now()
        if chunk:
            self._send(process.process_id, numbers[fd], chunk)
            self._expect_rest((process, fd), chunk)
            return len(chunk)
        self._close(process, fd)
        return 0

    def _expect_rest(self, stream: tuple[Process, int], chunk: bytes) -> None:
        """The rest of what is not finished; several chunks may end in the middle of a traceback."""
        if stream in self._unfinished or not chunk.endswith(b"\n") or has_begin(chunk):
            self._unfinished[stream] = self.read_at_s
            if self._silence is None:
                self._silence = self._reactor.call_later(PARTIAL_LINE_S, self._report_silence)

    def _report_silence(self) -> None:
        self._silence = None
        for (process, fd), read_at_s in list(self._unfinished.items()):
            # The timer may be late: a stream with something to read is not silent.
            if not self._is_silent(read_at_s) or self._read(process, fd):
                continue
            if self._unfinished.pop((process, fd), None) is not None:  # it was not closed
                self._send(process.process_id, self._numbers[process.process_id][fd], b"")
        if self._unfinished and self._silence is None:
            self._silence = self._reactor.call_later(PARTIAL_LINE_S, self._report_silence)
