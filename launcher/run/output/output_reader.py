"""Reads the output of processes, and writes it to the screen and to log files in whole lines."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Collection

from launcher.output.lines import Block
from launcher.output.logs.run_directory import RunDirectory
from launcher.output.stdout import StdoutWriter
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import most_open_files, read_stream
from launcher.run.processes.machine_events import ProcessState
from launcher.run.processes.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.compose.group_output import GroupOutput
    from launcher.run.core_driver import CoreDriver
    from launcher.run.output.stream import Stream

PARTIAL_LINE_S = 0.1  # after which an unfinished line or traceback is shown
# While other processes write much, a silent process may just not have been scheduled.
BUSY_PARTIAL_LINE_S = 1.0
DRAIN_BYTES = 1024 * 1024  # the largest pipe an unprivileged process can have
# Instead of descriptors, for streams that are read on another host.
_KEYS = {"stdout": -1, "stderr": -2, "both": -3}


class OutputReader:
    """Reads the streams of processes. `processes` is the live collection of them.

    What a process has started may write to its streams when it has exited, or runs again: these are
    kept, and read to their end. It pauses while the screen is slow: then the pipes fill, and the
    children block. `read_at_s` is when output was last read, on the monotonic clock.
    """

    def __init__(
        self,
        reactor: Reactor,
        screen: StdoutWriter,
        directory: RunDirectory,
        processes: Collection[Process],
        core: CoreDriver,
    ) -> None:
        self._reactor = reactor
        self._screen = screen
        self._directory = directory
        self._processes = processes
        self._core = core
        self._paused = False
        self._kept: dict[int, Process] = {}  # descriptor -> process, the oldest first
        self.read_at_s = 0.0
        self.on_pause: Callable[[bool], None] = lambda paused: None
        screen.on_pressure = self._pause

    def attach(self, process: Process) -> None:
        assert process.child is not None
        if process.group is not None:
            process.group.begin()
        for fd, name in process.child.streams.items():
            stream = process.streams[fd] = _new_stream(process, name)
            if process.group is not None:
                stream.buffer = process.group.buffer()
            if not self._paused:
                self._listen(process, fd)
        if process.group is not None:
            take = functools.partial(self._take_ends, process, process.group)
            self._reactor.add_reader(process.child.stdin, take)

    def _listen(self, process: Process, fd: int) -> None:
        self._reactor.add_reader(fd, functools.partial(self._read, process, fd))

    def _pause(self, paused: bool) -> None:
        self._paused = paused
        for process in self._processes:
            for fd in process.streams:
                self._reactor.remove(fd)
                if not paused and fd >= 0:
                    self._listen(process, fd)
        self.on_pause(paused)

    def drain(self, process: Process) -> None:
        """Read the rest of the output of a process that has exited, and flush its last line.

        A grandchild may keep writing to the pipe, so this reads at most what a pipe can hold; the
        loop reads later output. Without a child: of all that is kept.
        """
        is_over = process.child is None
        for fd in self._descriptors(process):
            if fd in self._kept and not is_over:
                continue
            self._read_what_is_there(process, fd)
            if fd in process.streams:
                self._finish(process, fd, process.streams[fd])
        if process.group is not None and process.child is not None:
            self._take_ends(process, process.group)
            self._reactor.remove(process.child.stdin)

    def keep(self, process: Process) -> list[Process]:
        """Its child is about to be released: keep what others may still write to.

        Returns the processes of which something had to be closed instead, since half of the
        descriptors that this process may have are kept already.
        """
        for fd in () if process.child is None else process.child.give_streams():
            self._kept[fd] = process
        for fd in [fd for fd in process.streams if fd < 0]:  # of another host
            del process.streams[fd]
        most = most_open_files(len(self._kept)) // 2
        oldest = list(self._kept.items())[: max(0, len(self._kept) - most)]
        for fd, other in oldest:
            self._close(other, fd)
        return [other for _, other in oldest]

    def detach(self, process: Process) -> None:
        """Stop reading; the child closes its descriptors, and what was kept is closed here."""
        for fd in self._descriptors(process):
            self._close(process, fd)

    def _descriptors(self, process: Process) -> list[int]:
        return list(process.streams)

    def _close(self, process: Process, fd: int) -> None:
        self._finish(process, fd, process.streams[fd])
        del process.streams[fd]
        self._close_descriptor(process, fd)

    def _close_descriptor(self, process: Process, fd: int) -> None:
        self._reactor.remove(fd)
        if self._kept.pop(fd, None) is not None:
            os.close(fd)
        elif process.child is not None:
            process.child.close_stream(fd)

    def _read(self, process: Process, fd: int) -> int:
        """Read once; the number of bytes."""
        chunk = read_stream(fd)
        if chunk is None:
            return 0
        if process.group is not None:  # a node may be new whose lines these are
            self._take_messages(process, process.group)
        stream = process.streams[fd]
        stream.read_at_s = self._reactor.now()
        if not chunk:
            self._close(process, fd)
            return 0
        self.read_at_s = stream.read_at_s
        self._accept(process, fd, stream, chunk)
        if process.group is not None and process.group.has_ends:
            self._reactor.call_later(0, functools.partial(self._take_ends, process, process.group))
        return len(chunk)

    def feed(self, process: Process, name: str, chunk: bytes, read_at_s: float) -> None:
        """What another host has read of a stream (`stdout`, `stderr` or `both`) at that time.

        An empty chunk says that the process is silent: what is unfinished is shown.
        """
        fd = _KEYS[name]
        if fd not in process.streams:
            process.streams[fd] = _new_stream(process, name)
        stream = process.streams[fd]
        now = self._reactor.now()
        stream.read_at_s, stream.ago_s = read_at_s, now - read_at_s
        if chunk:
            self.read_at_s = now
            self._accept(process, fd, stream, chunk)
        elif stream.waits:
            self._show_unfinished(process, fd, stream)

    def _accept(self, process: Process, fd: int, stream: Stream, chunk: bytes) -> None:
        if self._core.watches(process):
            self._core.output(process, stream.name, chunk)
        lines, shown = stream.buffer.feed(chunk)
        if lines:
            self._deliver(process, fd, stream, lines, shown)
        if fd >= 0 and process.idle_timer is None and stream.waits:
            self._expect_end(process)

    def _deliver(
        self, process: Process, fd: int, stream: Stream, lines: bytes, shown: int = 0
    ) -> None:
        if process.group is not None:
            self._deliver_parts(process, fd, stream, lines, process.group)
            return
        process.ring.append(stream.name, stream.read_at_s, lines)
        if stream.shown:  # before the log files
            stopping = process.machine.state is ProcessState.STOPPING
            passed = stream.gate.feed(lines, stopping=stopping)
            if passed:
                unchanged = passed is lines
                self._show(process, fd, stream, passed, shown if unchanged else 0)
        else:
            process.history.unshown_lines += lines.count(b"\n")
        policy = process.spec.output
        self._directory.write_lines(process.name, policy, stream.name, lines, stream.ago_s)
        if process.on_lines is not None and fd not in self._kept:
            process.on_lines(lines)
        self._screen.push()

    def _deliver_parts(
        self, process: Process, fd: int, stream: Stream, lines: bytes, group: GroupOutput
    ) -> None:
        policy = process.spec.output
        for part in group.parts(lines, stream.buffer.mark):
            process.ring.append(stream.name, stream.read_at_s, part.kept)
            shown = part.lines
            if part.prefix is process.prefix:  # the end of a member is in its own lines
                stopping = process.machine.state is ProcessState.STOPPING
                shown = stream.gate.feed(shown, stopping=stopping) if stream.shown else b""
            if stream.shown and shown:
                self._show(process, fd, stream, shown, prefix=part.prefix)
            self._directory.write_lines(part.name, policy, stream.name, part.lines, stream.ago_s)

    def _take_ends(self, process: Process, group: GroupOutput) -> None:
        """Take messages of a process with members, and act on them behind its output."""
        self._take_messages(process, group)
        group.settle(functools.partial(self._read_all, process))

    def _take_messages(self, process: Process, group: GroupOutput) -> None:
        child = process.child
        while child is not None and (message := read_stream(child.stdin)) is not None:
            if not message:
                self._reactor.remove(child.stdin)
                break
            group.take(message)

    def _read_all(self, process: Process) -> None:
        for fd in list(process.streams):
            self._read_what_is_there(process, fd)

    def _read_what_is_there(self, process: Process, fd: int) -> None:
        left = DRAIN_BYTES
        while left > 0 and (size := self._read(process, fd)):
            left -= size

    def _show(
        self,
        process: Process,
        fd: int,
        stream: Stream,
        lines: bytes,
        shown: int = 0,
        prefix: bytes | None = None,
    ) -> None:
        if process.filter is not None:
            chosen = process.filter.choose(fd, lines)
            self._screen.end_partial(stream)
            if not chosen:
                return
            lines, shown = chosen, 0
        self._screen.write_lines(stream, prefix or process.prefix, lines, shown)

    def _finish(self, process: Process, fd: int, stream: Stream) -> None:
        """Flush an unfinished line and an unfinished traceback."""
        lines, shown = stream.buffer.take_partial()
        if lines:
            self._deliver(process, fd, stream, lines, shown)
        if stream.gate.holds:
            self._show(process, fd, stream, stream.gate.flush())
        self._screen.end_partial(stream)

    # ---- unfinished lines: prompts, progress bars, tracebacks

    def _expect_end(self, process: Process) -> None:
        show = functools.partial(self._show_what_waits, process)
        process.idle_timer = self._reactor.call_later(PARTIAL_LINE_S, show)

    def _show_what_waits(self, process: Process) -> None:
        process.idle_timer = None
        for fd, stream in list(process.streams.items()):
            if fd < 0 or not stream.waits:
                continue
            # The timer may be late: a stream with something to read is not silent.
            if not self._is_silent(stream.read_at_s) or self._read(process, fd):
                if process.idle_timer is None:
                    self._expect_end(process)
            else:
                self._show_unfinished(process, fd, stream)

    def _show_unfinished(self, process: Process, fd: int, stream: Stream) -> None:
        if stream.gate.holds:
            self._show(process, fd, stream, stream.gate.flush())
        buffer = stream.buffer
        if buffer.partial and process.filter is None:
            if not buffer.shown and process.ring.tap is not None:  # `logs -f`, the picker
                process.ring.tap(Block(stream.name, stream.read_at_s, buffer.partial + b"\n"))
            buffer.shown = self._screen.write_partial(
                stream, process.prefix, buffer.partial, buffer.shown
            )

    def _is_silent(self, read_at_s: float) -> bool:
        """Whether the rest of a line, read then, is not expected soon; False while paused."""
        if self._paused:
            return False
        now = self._reactor.now()
        is_busy = now - self.read_at_s < PARTIAL_LINE_S
        # A timer may fire a little early, by the granularity of the clock.
        return now - read_at_s >= (BUSY_PARTIAL_LINE_S if is_busy else PARTIAL_LINE_S * 0.99)


def _new_stream(process: Process, name: str) -> Stream:
    from launcher.run.output.stream import Stream  # the child is running already

    return Stream(name, shown=process.shows(name))
