"""Forwards the output of processes in the blocks in which it was read."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection

from launcher.engine.output.reader import DRAIN_BYTES, OutputReader
from launcher.engine.posix.reactor import Reactor
from launcher.engine.process import Process

_NUMBERS = {"stdout": 0, "stderr": 1, "both": 2}  # of `frames.STREAMS`


class Forwarder(OutputReader):
    """An OutputReader without lines: `send(process id, number of the stream, block)`."""

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
        self._numbers: dict[int, dict[int, int]] = {}  # process id -> descriptor -> stream
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
        self._numbers[process.process_id] = numbers
        if not self._paused:
            for fd in numbers:
                self._listen(process, fd)

    def _listen(self, process: Process, fd: int) -> None:
        self._reactor.add_reader(fd, functools.partial(self._read, process, fd))

    def drain(self, process: Process) -> None:
        for fd in list(self._numbers.get(process.process_id, ())):
            left = DRAIN_BYTES
            while left > 0 and (size := self._read(process, fd)):
                left -= size

    def detach(self, process: Process) -> None:
        for fd in self._numbers.pop(process.process_id, ()):
            self._reactor.remove(fd)

    def _read(self, process: Process, fd: int) -> int:
        child = process.child
        chunk = None if child is None else child.read(fd)
        if child is None or chunk is None:
            return 0
        numbers = self._numbers[process.process_id]
        self.read_at_s = self._reactor.now()
        if chunk:
            self._send(process.process_id, numbers[fd], chunk)
            return len(chunk)
        self._reactor.remove(fd)
        del numbers[fd]
        child.close_stream(fd)
        return 0
