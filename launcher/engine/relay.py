"""Relay: carries what processes write to the screen and to the files, in whole lines."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from launcher.engine.lines import LineBuffer
from launcher.engine.process import Process
from launcher.engine.reactor import Reactor
from launcher.engine.runfolder import RunFolder
from launcher.engine.screen import Screen

PARTIAL_S = 0.1  # how long the beginning of a line waits for its end before it is shown
DRAIN_BYTES = 1024 * 1024  # the largest pipe an unprivileged process can have

Watcher = Callable[[Process, str, bytes], None]


class Relay:
    """Reads the streams of running processes.

    `watcher` gets every chunk of the processes for which `watched(process)` says so.
    """

    def __init__(
        self,
        reactor: Reactor,
        screen: Screen,
        folder: RunFolder,
        *,
        watched: Callable[[Process], bool],
        watcher: Watcher,
    ) -> None:
        self._reactor = reactor
        self._screen = screen
        self._folder = folder
        self._watched = watched
        self._watcher = watcher
        self._paused = False

    def attach(self, process: Process) -> None:
        """Begin to read a child that has just been started."""
        assert process.child is not None
        for fd in process.child.streams:
            process.buffers[fd] = LineBuffer()
            if not self._paused:
                self._listen(process, fd)

    def _listen(self, process: Process, fd: int) -> None:
        self._reactor.add_reader(fd, lambda: self._readable(process, fd))

    def pause(self, paused: bool, processes: Iterable[Process]) -> None:
        """Stop reading while the screen cannot follow (the pipes fill, the children wait)."""
        self._paused = paused
        for process in processes:
            for fd in process.buffers:
                self._reactor.remove(fd)
                if not paused:
                    self._listen(process, fd)

    def drain(self, process: Process) -> None:
        """Carry what an ended process has left in its pipes, its unfinished last line included.

        A grandchild may hold a pipe open and even flood it, so this ends at what a pipe can
        hold; what comes later is still carried by the loop until the stream ends.
        """
        for fd in list(process.buffers):
            left = DRAIN_BYTES
            while left > 0 and (size := self._read(process, fd)):
                left -= size
            buffer = process.buffers.get(fd)
            if buffer is not None:
                self._flush(process, fd, buffer)

    def detach(self, process: Process) -> None:
        """Stop reading and forget; the child closes the descriptors."""
        for fd in process.buffers:
            self._reactor.remove(fd)
        process.buffers.clear()

    def _readable(self, process: Process, fd: int) -> None:
        self._read(process, fd)

    def _read(self, process: Process, fd: int) -> int:
        """One read; how many bytes it brought."""
        assert process.child is not None
        chunk = process.child.read(fd)
        if chunk is None:
            return 0
        stream = process.child.streams[fd]
        buffer = process.buffers[fd]
        if not chunk:
            self._flush(process, fd, buffer)
            self._reactor.remove(fd)
            del process.buffers[fd]
            process.child.close_stream(fd)
            return 0
        if self._watched(process):
            self._watcher(process, stream, chunk)
        lines, shown = buffer.feed(chunk)
        if lines:
            self._deliver(process, stream, fd, lines, shown)
        if buffer.partial and process.shows(stream):
            self._expect_end(process)
        return len(chunk)

    def _deliver(self, process: Process, stream: str, fd: int, lines: bytes, shown: int) -> None:
        if process.shows(stream):
            self._screen.write_lines((process.process_id, fd), process.prefix, lines, shown)
        self._folder.write_lines(process.name, process.spec.output, stream, lines)

    def _flush(self, process: Process, fd: int, buffer: LineBuffer) -> None:
        assert process.child is not None
        lines, shown = buffer.take_partial()
        if lines:
            self._deliver(process, process.child.streams[fd], fd, lines, shown)

    # ---- beginnings of lines: prompts, progress bars

    def _expect_end(self, process: Process) -> None:
        if process.idle_timer is None:
            process.idle_timer = self._reactor.call_later(
                PARTIAL_S, lambda: self._show_partials(process)
            )

    def _show_partials(self, process: Process) -> None:
        process.idle_timer = None
        if process.child is None:
            return
        for fd, buffer in process.buffers.items():
            if buffer.partial and process.shows(process.child.streams[fd]):
                buffer.shown = self._screen.write_partial(
                    (process.process_id, fd), process.prefix, buffer.partial, buffer.shown
                )
