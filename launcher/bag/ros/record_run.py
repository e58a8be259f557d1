"""`bag record`: records until Ctrl-C, the end of `--for`, or a full disk."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass
from typing import TYPE_CHECKING

from launcher.bag.bag_model import BagError
from launcher.bag.quantity_texts import clock, size
from launcher.bag.ros.control_services import PACKAGE, are_installed
from launcher.bag.ros.ending import ending
from launcher.bag.ros.keys_and_status import Keys, StatusLine, StatusRates
from launcher.bag.ros.named_sources import NamedSources
from launcher.bag.ros.record_services import (
    IN_RECORDING,
    NODE,
    MessageTimes,
    RecorderEvents,
    RecorderServices,
)
from launcher.bag.ros.recorder import PERIOD_S, Recorded, Recorder, RecorderOptions
from launcher.bag.ros.sinks import FileSink, Ring
from launcher.bag.writer import BagWriter, Storage
from launcher.base.errors import ExitCode
from launcher.base.text import count
from launcher.packages.distribution import installed
from launcher.posix.allocator import keep_freed_memory
from launcher.posix.domains import why_empty
from launcher.ros.verb import GraphAccess, observing, warn

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

_SNAPSHOT_HINT = "s or SIGUSR1 writes what is in memory"
_PLACES = ("on the transport layer", "in the recorder")
_MISSING_S = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordOptions:
    """What `bag record` was asked for, besides what is recorded.

    `node_name` is that of the services; what was lost is published every `lost_period_s`.
    """

    folder: str
    storage: Storage
    cache_bytes: int
    cache_s: int
    start_paused: bool
    snapshot: bool
    keyboard: bool
    for_s: float | None
    custom_data: dict[str, str]
    node_name: str | None
    lost_period_s: float | None


def record(access: GraphAccess, options: RecordOptions, recorder_options: RecorderOptions) -> int:
    """Record; the exit code. BagError if the folder exists, or cannot be written."""
    keep_freed_memory()
    with ending(interrupts=False) as stopped, ExitStack() as stack:
        writer = _new_writer(options, options.folder)
        observer = stack.enter_context(observing(access, listens=True))
        run = _RecordRun(observer, options, recorder_options, stopped)
        run.begin_with(writer)
        try:
            return run.run()
        except KeyboardInterrupt:
            warn(f"{writer.folder} has no end\nhint: bag check --repair {writer.folder}")
            return ExitCode.INTERRUPTED


def _new_writer(options: RecordOptions, folder: str) -> BagWriter:
    try:
        return BagWriter(
            folder,
            options.storage,
            ros_distro=installed() or "",
            custom_data=options.custom_data,
        )
    except OSError as error:
        raise BagError(f"cannot write {folder}: {error.strerror}") from None


def _unused(folder: str) -> str:
    """With a number behind it if it exists, as rosbag2 names it."""
    number, found = 0, folder
    while os.path.lexists(found):
        number += 1
        found = f"{folder}({number})"
    return found


class _RecordRun:
    """One recording, or several, one after the other, if services ask for them."""

    def __init__(
        self,
        observer: Observer,
        options: RecordOptions,
        recorder_options: RecorderOptions,
        stopped: Callable[[], bool],
    ) -> None:
        self._options = options
        self._observer = observer
        self._recorder_options = recorder_options
        self._named = NamedSources(observer, recorder_options)
        self._stopped = stopped
        self._status = StatusLine(self._line)
        self._writer: BagWriter
        self._files: FileSink
        self._ring: Ring | None = None
        self._recorder: Recorder
        self._paused = options.start_paused
        self._snapshot_wanted = False
        self._code = int(ExitCode.OK)
        self._due: list[tuple[int, Callable[[], None]]] = []
        self.is_recording = False
        self.times = MessageTimes()
        self._services: RecorderServices | None = None
        self._events: RecorderEvents | None = None
        self._offer_services()

    def _offer_services(self) -> None:
        name = self._options.node_name
        if are_installed():
            node = self._observer.companion(name or NODE)
            self._services = RecorderServices(node, self)
            self._events = RecorderEvents(node, self._options.lost_period_s)
        elif name is not None:
            self._status.print(
                f"there is no node {name}, since there are no services: "
                f"{PACKAGE} is not installed\nhint: build it in a workspace: build"
            )

    # ---- what services do

    def begin(self, folder: str) -> None:
        if self.is_recording:
            raise BagError(IN_RECORDING)
        self.begin_with(_new_writer(self._options, _unused(folder or self._options.folder)))
        self._greet(has_keys=False)

    def begin_with(self, writer: BagWriter) -> None:
        self._writer = writer
        limits = self._options.cache_bytes, self._options.cache_s or None
        self._files = FileSink(writer, *limits)
        self._ring = Ring(*limits, clock_ns=None) if self._options.snapshot else None
        sink = self._files if self._ring is None else self._ring
        options = self._recorder_options
        self._recorder = Recorder(self._observer, options, sink, self._status.print)
        self._recorder.paused = self._paused
        if self._services is not None:
            self._recorder.watch = self.times.note
        self._reports_missing = bool(self._named)
        self._started_s = time.monotonic()
        self._rates = StatusRates()
        self.is_recording = True

    def end(self) -> None:
        self._recorder.take()
        self._recorder.close()
        self.is_recording = False
        error = self._files.finish()
        self._print_notes()
        if error is not None:
            self._code = self._failed(error)
        else:
            self._report()
            is_empty = self._named and not self._recorder.published
            self._code = ExitCode.PROCESS_FAILED if is_empty else ExitCode.OK
        self.times.clear()
        if self._events is not None:
            self._events.publish_lost(self._recorder.topics, now=True)
            self._events.forget()

    def split(self) -> None:
        self._take()
        self._files.split()

    def _take(self) -> None:
        if self.is_recording and not self._recorder.is_taking:
            self._recorder.take()

    @property
    def takes_snapshots(self) -> bool:
        return self._options.snapshot

    @property
    def paused(self) -> bool:
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self._take()  # what has arrived until now
        self._paused = self._recorder.paused = paused
        self._status.draw(now=True)

    @property
    def discovers(self) -> bool:
        return self._recorder.discovers

    @discovers.setter
    def discovers(self, discovers: bool) -> None:
        self._recorder.discovers = discovers

    def at(self, due_ns: int | None, action: Callable[[], None]) -> None:
        if due_ns is None or due_ns <= self._recorder.now_ns():
            action()
        else:
            self._due.append((due_ns, action))

    def _do_what_is_due(self) -> None:
        for one in list(self._due):
            due_ns, action = one
            if due_ns <= self._recorder.now_ns():
                self._due.remove(one)
                try:
                    action()
                except BagError as error:
                    self._status.print(f"error: {error.message}")

    # ---- the loop

    def run(self) -> int:
        try:
            self._loop()
        except Exception:  # what has been recorded is a whole bag in any case
            if self.is_recording:
                self._files.finish()
            raise
        if self.is_recording:
            self.end()
        return self._code

    def _loop(self) -> None:
        signal.signal(signal.SIGUSR1, self._want_snapshot)
        with closing(self._status), Keys(enabled=self._options.keyboard) as keys:
            self._greet(keys.enabled)
            while not self._is_over():
                self._handle(keys)
                if self._services is not None:
                    self._services.poll()
                    self._do_what_is_due()
                if self.is_recording:
                    self._record()
                self._status.draw()
                if not (self.is_recording and self._recorder.is_behind):
                    time.sleep(PERIOD_S)

    def _record(self) -> None:
        if self._recorder.poll():
            self._files.wake()
        if self._ring is not None:
            self._ring.forget_old()
        self._print_notes()
        self._rates.update(self._recorder.count, self._recorder.bytes)
        if self._events is not None:
            self._events.publish_lost(self._recorder.topics)
        self._report_missing()

    def _print_notes(self) -> None:
        while self._writer.notes:
            self._status.print(self._writer.notes.popleft())
        while self._writer.splits:
            closed, opened = self._writer.splits.popleft()
            if self._events is not None:
                self._events.split(closed, opened)

    def _want_snapshot(self, *_: object) -> None:
        self._snapshot_wanted = True

    def _greet(self, has_keys: bool) -> None:
        keys = " (space pauses)" if has_keys else ""
        self._status.print(f"recording into {self._writer.folder}{keys}")
        if self._ring is not None:
            self._status.print(f"in memory only: {_SNAPSHOT_HINT}")

    def _report_missing(self) -> None:
        """Once, what was named and is not there after a while."""
        if self._reports_missing and time.monotonic() - self._started_s >= _MISSING_S:
            self._reports_missing = False
            for note in self._named.missing_yet(self._recorder.published):
                self._status.print(note)

    def _is_over(self) -> bool:
        limit = self._options.for_s
        late = limit is not None and time.monotonic() - self._started_s >= limit
        failed = self.is_recording and self._files.error is not None
        return self._stopped() or late or failed

    def _handle(self, keys: Keys) -> None:
        for key in keys.pressed():
            if key == " ":
                self.paused = not self.paused
            elif key == "s":
                self._snapshot_wanted = True
        if self._snapshot_wanted:
            self._snapshot_wanted = False
            self.snapshot()

    def snapshot(self) -> None:
        """Write what the ring has; the next snapshot has what comes after."""
        if self._ring is None or not self.is_recording:
            return
        self._recorder.take()
        contents = self._ring.contents()
        for topic in self._ring.topics.values():
            self._files.add_topic(topic)
        for message, publisher in contents:
            while not self._files.put(message, publisher) and self._files.error is None:
                self._files.wake()
                time.sleep(PERIOD_S)
        self._ring.clear()
        self._files.wake()
        self._status.print(f"wrote {count(len(contents), 'message')}")

    def _line(self, width: int) -> str:
        recorder = self._recorder
        parts = [
            "paused" if recorder.paused else "recording" if self.is_recording else "stopped",
            clock(time.monotonic() - self._started_s),
            count(len(recorder.topics), "topic"),
            f"{recorder.count} messages",
            f"{self._rates.messages:.0f}/s",
            f"{size(self._rates.bytes)}/s",
            f"{size(self._files.written_bytes)} written",
            f"{recorder.lost} lost",
        ]
        while len(text := "  ".join(parts)) > width and len(parts) > 2:
            parts.pop(-2)
        return text

    def _failed(self, error: OSError) -> int:
        self._status.print(f"error: cannot write {self._writer.path}: {error.strerror}")
        if self._files.is_whole:
            self._status.print("what was written before is a whole bag")
        else:
            self._status.print(
                f"hint: when there is room again: bag check --repair {self._writer.folder}"
            )
        return ExitCode.PROCESS_FAILED

    def _report(self) -> None:
        recorder = self._recorder
        written = self._writer.total
        self._status.print(
            f"wrote {self._writer.folder}: {count(written, 'message')} of "
            f"{count(len(recorder.topics), 'topic')}, {size(self._writer.size_bytes)}, "
            f"{recorder.lost} lost"
        )
        lost = [(one.lost, one.dropped) for one in recorder.topics.values()]
        for where, numbers in zip(_PLACES, zip(*lost, strict=True), strict=False):
            if number := sum(numbers):
                self._status.print(f"warning: Number of messages lost {where}: {number}")
        for note in self._named.missing_at_the_end(recorder.published):
            self._status.print(note)
        if not recorder.topics:
            why = f"no such {self._named.kinds} was published"
            if not self._observer.node_names():
                why = why_empty(self._observer.domain_id)
            self._status.print(f"nothing was recorded: {why}")
        for name, one in sorted(recorder.topics.items()):
            if one.lost or one.dropped:
                self._status.print(f"  {name}: {one.count} recorded, {_reasons(one)}")


def _reasons(one: Recorded) -> str:
    reasons = []
    if one.lost:
        reasons.append(f"{one.lost} published and not received")
    if one.dropped:
        reasons.append(f"{one.dropped} dropped since the disk is too slow (--max-cache-size)")
    return ", ".join(reasons)
