"""The flight recorder of a run: `python -m launcher.bag.ros.flight SETTINGS`, by `--record`.

It keeps the last messages of all topics in memory, and writes them with logs and events when a
process has died unasked, when a fault of a watched run is confirmed that does not follow from
another, or when it is requested. SETTINGS is JSON (see `FlightSettings`). It reads lines of JSON on
stdin, `{"snapshot": REASON, "id": NUMBER, "of_fault": BOOL}` and `{"end": true}`, and writes lines
to stdout: `{"snapshot": PATH}` or `{"error": TEXT}`, with the ids of the requests that it answers
as `asked`; `{"note": TEXT}` is for the launcher's log. The end of stdin without `end` is the death
of the launcher.
"""

from __future__ import annotations

import contextlib
import os
import queue
import re
import shutil
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from launcher.bag import snapshot_folder
from launcher.bag.bag_model import Message, Qos, Topic
from launcher.bag.ros.recorder import PERIOD_S, REMEMBER_S, Recorder, RecorderOptions
from launcher.bag.ros.sinks import FileSink, Ring
from launcher.bag.snapshot_folder import SnapshotContents
from launcher.bag.topic_selection import Selection
from launcher.bag.writer import BagWriter
from launcher.base import strict_json
from launcher.base.model.event_entries import entry_of
from launcher.base.model.fault_events import FaultConfirmed
from launcher.base.model.run_event import Entry, exit_text
from launcher.base.model.run_events import Ended
from launcher.control.client import Connection
from launcher.packages.distribution import installed
from launcher.posix import dispositions
from launcher.posix.socket_directory import ControlError
from launcher.posix.stdio import keep_for_messages
from launcher.ros.discovery.observer import Observer

AFTER_S = 1.0  # what follows a death or a fault belongs to it
APART_S = 10.0  # between two automatic snapshots: a process may die again and again
# Kinds of snapshots, in the names of their folders.
AUTOMATIC = ("death", "fault")  # a death may be a fault, too
ASKED = "asked"  # by a user
KEEP_SNAPSHOTS = 10  # automatic ones of a run; older ones are removed
_FORGET_S = 0.5
_QUEUE_BYTES = 64 * 1024 * 1024


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightSettings:
    """`topics` is a regular expression; `everything`: write all messages into `RUN/bag`."""

    run_folder: str
    socket: str
    keep_s: float = 60.0
    keep_bytes: int = 256 * 1024 * 1024
    topics: str | None = None
    everything: bool = False


@dataclass(slots=True)
class _Due:
    """A snapshot that is to be written at `at_s`, for these reasons."""

    at_s: float
    reasons: list[str] = field(default_factory=list)
    asked: list[int] = field(default_factory=list)  # ids of requests; actions of faults have some
    kinds: set[str] = field(default_factory=set)  # ASKED, or of AUTOMATIC

    @property
    def kind(self) -> str:
        """The one that its folder is called by."""
        return next(one for one in (ASKED, *AUTOMATIC) if one in self.kinds)


class _RingBeside(Ring):
    """Passes on what is recorded to files as well."""

    def __init__(self, max_bytes: int, keep_s: float, files: FileSink) -> None:
        super().__init__(max_bytes, keep_s)
        self._files = files

    def add_topic(self, topic: Topic) -> None:
        super().add_topic(topic)
        self._files.add_topic(topic)

    def set_qos(self, topic: str, profiles: list[Qos]) -> None:
        super().set_qos(topic, profiles)
        self._files.set_qos(topic, profiles)

    def put(self, message: Message, publisher: bytes) -> bool:
        super().put(message, publisher)
        return self._files.put(message, publisher)


class FlightRecorder:
    """Records until `end`; `requests` are those of the launcher and of the run's events."""

    def __init__(self, settings: FlightSettings, observer: Observer) -> None:
        self._settings = settings
        keep = settings.keep_bytes, settings.keep_s
        self._ring = Ring(*keep)
        self._files: FileSink | None = None
        if settings.everything:
            folder = os.path.join(settings.run_folder, "bag")
            writer = BagWriter(folder, ros_distro=installed() or "")
            self._files = FileSink(writer, _QUEUE_BYTES)
            self._ring = _RingBeside(*keep, self._files)
        regex = None if settings.topics is None else re.compile(settings.topics)
        selection = Selection(
            all_topics=regex is None,
            all_services=regex is None,
            all_actions=regex is None,
            regex=regex,
            hidden=True,
        )
        options = RecorderOptions(selection=selection, remember_s=settings.keep_s + REMEMBER_S)
        self._recorder = Recorder(observer, options, self._ring, lambda text: say(note=text))
        self._requests: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
        self._due: _Due | None = None
        self._last_automatic_s = -APART_S
        self._writing: threading.Thread | None = None
        self._is_over = False

    def run(self) -> None:
        for target in (self._read_orders, self._follow_events):
            threading.Thread(target=target, daemon=True).start()
        next_forget_s = 0.0
        while not self._is_over:
            if self._recorder.poll() and self._files is not None:
                self._files.wake()
            now = time.monotonic()
            if now >= next_forget_s:
                next_forget_s = now + _FORGET_S
                self._ring.forget_old()
            self._take_requests(now)
            if self._due is not None and now >= self._due.at_s:
                self._begin_writing()
            if not self._recorder.is_behind:
                time.sleep(PERIOD_S)
        self._finish()

    # ---- requests

    def _read_orders(self) -> None:
        for line in sys.stdin:
            order = strict_json.unpacked(line)
            if "snapshot" in order:
                kind = "snapshot of a fault" if order.get("of_fault") else "snapshot"
                self._requests.put((kind, (order["snapshot"], order["id"])))
            if order.get("end"):
                self._requests.put(("end", None))
                return
        self._requests.put(("lost", None))

    def _follow_events(self) -> None:
        silently = contextlib.suppress(ControlError, OSError)  # the launcher is gone
        with silently, Connection(self._settings.socket) as connection:
            for item in connection.follow("events"):
                entry = entry_of(item)
                kind = None if entry is None else _kind(entry)
                if entry is not None and kind is not None:
                    self._requests.put((kind, _story(entry)))

    def _take_requests(self, now: float) -> None:
        while not self._requests.empty():
            kind, detail = self._requests.get()
            match kind:
                case "death" | "fault":
                    at_s = max(now + AFTER_S, self._last_automatic_s + APART_S)
                    self._plan(kind, detail, at_s)
                case "snapshot":
                    reason, number = detail
                    self._plan(ASKED, reason, now, [number])
                case "snapshot of a fault":  # joins the automatic one
                    reason, number = detail
                    self._plan("fault", reason, now + AFTER_S, [number])
                case "lost":
                    self._plan("death", "the launcher was killed", now)
                    self._is_over = True
                case "end":
                    self._is_over = True

    def _plan(self, kind: str, reason: str, at_s: float, asked: Sequence[int] = ()) -> None:
        if self._due is None:
            self._due = _Due(at_s)
        self._due.at_s = min(self._due.at_s, at_s)
        self._due.asked += asked
        self._due.kinds.add(kind)
        if reason not in self._due.reasons:
            self._due.reasons.append(reason)

    # ---- writing

    def _begin_writing(self) -> None:
        """Write in a thread, so that the taking goes on."""
        if self._writing is not None and self._writing.is_alive():
            return
        due, self._due = self._due, None
        assert due is not None
        if due.kind in AUTOMATIC:
            self._last_automatic_s = time.monotonic()
        contents = self._contents("; ".join(due.reasons))
        self._writing = threading.Thread(target=self._write, args=(contents, due))
        self._writing.start()

    def _contents(self, reason: str) -> SnapshotContents:
        self._recorder.take()
        self._ring.forget_old()
        return SnapshotContents(
            reason=reason,
            end_ns=time.time_ns(),
            keep_s=self._settings.keep_s,
            topics=list(self._ring.topics.values()),
            messages=self._ring.contents(),
            nodes=dict(self._recorder.nodes),
            dropped_ns=self._ring.dropped_ns,
            run_folder=self._settings.run_folder,
        )

    def _write(self, contents: SnapshotContents, due: _Due) -> None:
        parent = os.path.join(self._settings.run_folder, "snapshots")
        stamp = time.strftime("%Y-%m-%d-%H-%M-%S", time.localtime(contents.end_ns // 10**9))
        folder = _unused(os.path.join(parent, f"{stamp}-{due.kind}"))
        try:
            os.makedirs(parent, exist_ok=True)
            snapshot_folder.write(folder, contents, installed() or "")
            _prune(parent)
        except OSError as error:
            say(error=f"cannot write {folder}: {error.strerror or error}", asked=due.asked)
        else:
            say(
                snapshot=folder,
                reason=contents.reason,
                messages=len(contents.messages),
                asked=due.asked,
            )

    def _finish(self) -> None:
        if self._writing is not None:
            self._writing.join()
        if self._due is not None:
            self._begin_writing()
            assert self._writing is not None
            self._writing.join()
        self._recorder.close()
        if self._files is not None and (error := self._files.finish()) is not None:
            say(note=f"not everything was written: {error.strerror}")


def _kind(entry: Entry) -> str | None:
    """Which of AUTOMATIC it is, if any."""
    if isinstance(entry.event, FaultConfirmed):
        return "fault" if entry.event.follows is None else None
    return "death" if entry.event.is_failure else None


def _story(entry: Entry) -> str:
    if isinstance(entry.event, FaultConfirmed):
        return entry.event.text
    if isinstance(entry.event, Ended):
        return f"{entry.process} died ({exit_text(entry.event.returncode)})"
    return f"{entry.process} could not be started"


def _unused(path: str) -> str:
    number, found = 1, path
    while os.path.exists(found) or os.path.exists(f"{found}.part"):
        number += 1
        found = f"{path}-{number}"
    return found


def _prune(parent: str) -> None:
    """Remove the oldest automatic snapshots."""
    names = sorted(
        name
        for name in os.listdir(parent)
        if any(f"-{kind}" in name for kind in AUTOMATIC) and ".part" not in name
    )
    for name in names[:-KEEP_SNAPSHOTS]:
        shutil.rmtree(os.path.join(parent, name), ignore_errors=True)


_saying = threading.Lock()


def say(**values: object) -> None:
    with _saying, contextlib.suppress(OSError):
        sys.stdout.write(strict_json.packed(values) + "\n")
        sys.stdout.flush()


def main() -> None:
    keep_for_messages()
    dispositions.ignore()  # it ends with the launcher
    settings = FlightSettings(**strict_json.unpacked(sys.argv[1]))
    with Observer(purpose="flight recorder") as observer:
        FlightRecorder(settings, observer).run()


if __name__ == "__main__":
    main()
