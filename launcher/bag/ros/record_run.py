"""`bag record`: records until Ctrl-C, the end of `--for`, or a full disk."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from launcher.bag.bag_model import BagError
from launcher.bag.quantity_texts import clock, size
from launcher.bag.ros.keys_and_status import Keys, StatusLine
from launcher.bag.ros.recorder import PERIOD_S, Recorded, Recorder, RecorderOptions
from launcher.bag.ros.sinks import FileSink, Ring
from launcher.bag.writer import BagWriter, Storage
from launcher.base.errors import ExitCode
from launcher.base.ros_errors import did_you_mean
from launcher.base.text import count
from launcher.packages.distribution import installed
from launcher.posix.dispositions import Handled
from launcher.posix.domains import why_empty
from launcher.ros.verb import GraphAccess, observing

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

_SNAPSHOT_HINT = "s or SIGUSR1 writes what is in memory"
_RATE_S = 1.0
_MISSING_S = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordOptions:
    """What `bag record` was asked for, besides what is recorded."""

    folder: str
    storage: Storage
    cache_bytes: int
    cache_s: int
    start_paused: bool
    snapshot: bool
    keyboard: bool
    for_s: float | None
    custom_data: dict[str, str]


def record(access: GraphAccess, options: RecordOptions, recorder_options: RecorderOptions) -> int:
    """Record; the exit code. BagError if the folder exists, or cannot be written."""
    with _stopping() as stopped, ExitStack() as stack:
        try:
            writer = BagWriter(
                options.folder,
                options.storage,
                ros_distro=installed() or "",
                custom_data=options.custom_data,
            )
        except OSError as error:
            raise BagError(f"cannot write {options.folder}: {error.strerror}") from None
        observer = stack.enter_context(observing(access, listens=True))
        run = _RecordRun(observer, options, recorder_options, writer, stopped)
        return run.run()


@contextmanager
def _stopping() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C or SIGTERM came; the second one interrupts the finishing, too."""
    seen: list[int] = []

    def handle(number: int, frame: object) -> None:
        seen.append(number)
        if len(seen) > 1:
            raise KeyboardInterrupt

    with Handled(handle, (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)):
        yield lambda: bool(seen)


class _RecordRun:
    """One recording."""

    def __init__(
        self,
        observer: Observer,
        options: RecordOptions,
        recorder_options: RecorderOptions,
        writer: BagWriter,
        stopped: Callable[[], bool],
    ) -> None:
        self._options = options
        self._observer = observer
        self._named = sorted(recorder_options.selection.topics)
        self._unreported = self._named
        self._writer = writer
        self._stopped = stopped
        self._status = StatusLine(self._line)
        limits = options.cache_bytes, options.cache_s or None
        self._ring = Ring(*limits, clock_ns=None) if options.snapshot else None
        self._files = FileSink(writer, *limits)
        sink = self._files if self._ring is None else self._ring
        self._recorder = Recorder(observer, recorder_options, sink, self._status.print)
        self._recorder.paused = options.start_paused
        self._started_s = time.monotonic()
        self._rates = _Rates()
        self._snapshot_wanted = False

    def run(self) -> int:
        signal.signal(signal.SIGUSR1, self._want_snapshot)
        with closing(self._status), Keys(enabled=self._options.keyboard) as keys:
            self._greet(keys.enabled)
            while not self._is_over():
                self._handle(keys)
                if self._recorder.poll():
                    self._files.wake()
                if self._ring is not None:
                    self._ring.forget_old()
                self._print_notes()
                self._rates.update(self._recorder)
                self._report_missing()
                self._status.draw()
                time.sleep(PERIOD_S)
        return self._finish()

    def _print_notes(self) -> None:
        while self._writer.notes:
            self._status.print(self._writer.notes.popleft())

    def _want_snapshot(self, *_: object) -> None:
        self._snapshot_wanted = True

    def _greet(self, has_keys: bool) -> None:
        keys = " (space pauses)" if has_keys else ""
        self._status.print(f"recording into {self._options.folder}{keys}")
        if self._ring is not None:
            self._status.print(f"in memory only: {_SNAPSHOT_HINT}")

    def _report_missing(self) -> None:
        """Once, which of the topics that were named are not there after a while."""
        if not self._unreported or time.monotonic() - self._started_s < _MISSING_S:
            return
        named, self._unreported = self._unreported, []
        for name in named:
            if name not in self._recorder.topics:
                self._status.print(f"{name} does not appear to be published yet{self._near(name)}")

    def _near(self, name: str) -> str:
        near = did_you_mean(name, self._observer.topic_types())
        return f" ({near})" if near else ""

    def _is_over(self) -> bool:
        limit = self._options.for_s
        late = limit is not None and time.monotonic() - self._started_s >= limit
        return self._stopped() or late or self._files.error is not None

    def _handle(self, keys: Keys) -> None:
        for key in keys.pressed():
            if key == " ":
                self._recorder.take()  # what has arrived until now
                self._recorder.paused = not self._recorder.paused
                self._status.draw(now=True)
            elif key == "s":
                self._snapshot_wanted = True
        if self._snapshot_wanted:
            self._snapshot_wanted = False
            self._snapshot()

    def _snapshot(self) -> None:
        """Write what the ring has; the next snapshot has what comes after."""
        if self._ring is None:
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
            "paused" if recorder.paused else "recording",
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

    def _finish(self) -> int:
        self._recorder.take()
        self._recorder.close()
        error = self._files.finish()
        self._print_notes()
        if error is not None:
            return self._failed(error)
        self._report()
        is_empty = self._named and not self._recorder.topics
        return ExitCode.PROCESS_FAILED if is_empty else ExitCode.OK

    def _failed(self, error: OSError) -> int:
        self._status.print(f"error: cannot write {self._writer.path}: {error.strerror}")
        if self._files.is_whole:
            self._status.print("what was written before is a whole bag")
        else:
            self._status.print(
                f"hint: when there is room again: bag check --repair {self._options.folder}"
            )
        return ExitCode.PROCESS_FAILED

    def _report(self) -> None:
        recorder = self._recorder
        written = self._writer.total
        self._status.print(
            f"wrote {self._options.folder}: {count(written, 'message')} of "
            f"{count(len(recorder.topics), 'topic')}, {size(self._writer.size_bytes)}, "
            f"{recorder.lost} lost"
        )
        for name in self._named:
            if name not in recorder.topics:
                self._status.print(f"warning: {name} was not published{self._near(name)}")
        if not recorder.topics:
            known = self._observer.node_names()
            why = "no such topic was published" if known else why_empty(self._observer.domain_id)
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


class _Rates:
    """Messages and bytes per second, over the last second."""

    def __init__(self) -> None:
        self.messages = self.bytes = 0.0
        self._last = (time.monotonic(), 0, 0)

    def update(self, recorder: Recorder) -> None:
        then, messages, amount = self._last
        now = time.monotonic()
        if now - then >= _RATE_S:
            self.messages = (recorder.count - messages) / (now - then)
            self.bytes = (recorder.bytes - amount) / (now - then)
            self._last = (now, recorder.count, recorder.bytes)
