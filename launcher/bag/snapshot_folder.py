"""A folder about the last seconds of a run: bag, logs, events and plan, with an index."""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from launcher.bag.bag_model import Message, Topic
from launcher.bag.quantity_texts import size
from launcher.bag.writer import BagWriter, Storage
from launcher.base.model.event_entries import entry_in
from launcher.base.model.run_event import Entry
from launcher.base.text import count, escape

INDEX = "index.txt"
_LOG_BYTES = 1024 * 1024  # of each log file, counted from its end
_LOG_TIME = re.compile(rb"^(?:\[[^\]]*\] )*?\[?(\d{9,11}\.\d+)\]?[ \]]|\[(\d{9,11}\.\d{6,9})\]")
_OF_RCL = re.compile(r"_\d+_\d{13}\.log$")  # what each node writes by itself


@dataclass(frozen=True, slots=True, kw_only=True)
class SnapshotContents:
    """What goes into a snapshot. `messages` are in the order of their times.

    `nodes` maps ids of publishers to names of nodes; `dropped_ns` is the time of the newest message
    for which there was no room in memory; `keep_s` how long messages are kept.
    """

    reason: str
    end_ns: int
    keep_s: float
    topics: Sequence[Topic]
    messages: Sequence[tuple[Message, bytes]]
    nodes: Mapping[bytes, str] = field(default_factory=dict)
    dropped_ns: int | None = None
    run_folder: str | None = None

    @property
    def start_ns(self) -> int:
        return self.end_ns - round(self.keep_s * 1e9)


@dataclass(frozen=True, slots=True)
class _Line:
    at_ns: int
    text: str


def write(folder: str, contents: SnapshotContents, ros_distro: str = "") -> None:
    """Write a snapshot into a new folder, which is complete when it has its name; OSError."""
    partial = f"{folder}.part"
    os.makedirs(partial)
    try:
        _write_bag(os.path.join(partial, "bag"), contents, ros_distro)
        found = list(_entries(contents))
        events = [entry for entry, _ in found]
        _write_lines(os.path.join(partial, "events.jsonl"), (line.decode() for _, line in found))
        logs = _copy_logs(partial, contents)
        plan = _copy_plan(partial, contents)
        lines = _index(contents, events, logs, has_plan=plan)
        _write_lines(os.path.join(partial, INDEX), lines)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    os.rename(partial, folder)


def _write_bag(folder: str, contents: SnapshotContents, ros_distro: str) -> None:
    writer = BagWriter(
        folder,
        Storage(),
        ros_distro=ros_distro,
        custom_data={"reason": contents.reason},
    )
    for topic in contents.topics:
        writer.add_topic(topic)
    for message, _ in contents.messages:
        writer.write(message)
    writer.close()


def _write_lines(path: str, lines: Iterable[str]) -> None:
    with open(path, "w", encoding="utf-8", errors="surrogateescape") as file:
        file.writelines(f"{line}\n" for line in lines)


def _entries(contents: SnapshotContents) -> Iterator[tuple[Entry, bytes]]:
    """The events of the span, with their lines."""
    if contents.run_folder is None:
        return
    for line in _lines_from_end(os.path.join(contents.run_folder, "events.jsonl")):
        entry = entry_in(line)
        if entry is not None and contents.start_ns <= _at_ns(entry) <= contents.end_ns:
            yield entry, line


def _at_ns(entry: Entry) -> int:
    return round(entry.wall_s * 1e9)


def _lines_from_end(path: str) -> list[bytes]:
    try:
        with open(path, "rb") as file:
            start = max(0, file.seek(0, os.SEEK_END) - _LOG_BYTES)
            file.seek(start)
            lines = file.read().splitlines()
    except OSError:
        return []
    return lines[1:] if start else lines


def _copy_logs(folder: str, contents: SnapshotContents) -> list[str]:
    """The lines of the span; the names of the files."""
    run_folder = contents.run_folder
    names = sorted(os.listdir(run_folder)) if run_folder else []
    copied = []
    for name in names:
        if run_folder is None or not name.endswith(".log") or _OF_RCL.search(name):
            continue
        lines = _since(_lines_from_end(os.path.join(run_folder, name)), contents.start_ns)
        if lines:
            os.makedirs(os.path.join(folder, "logs"), exist_ok=True)
            with open(os.path.join(folder, "logs", name), "wb") as file:
                file.write(b"\n".join(lines) + b"\n")
            copied.append(name)
    return copied


def _since(lines: list[bytes], start_ns: int) -> list[bytes]:
    """From the first line of that time on; all, if no line has a time."""
    first = 0
    for number, line in enumerate(lines):
        at_ns = _time_of(line)
        if at_ns is not None:
            if at_ns >= start_ns:
                break
            first = number + 1
    return lines[first:]


def _time_of(line: bytes) -> int | None:
    match = _LOG_TIME.search(line)
    return None if match is None else round(float(match[1] or match[2]) * 1e9)


def _copy_plan(folder: str, contents: SnapshotContents) -> bool:
    path = os.path.join(contents.run_folder or "", "plan.json")
    if contents.run_folder is None or not os.path.exists(path):
        return False
    shutil.copyfile(path, os.path.join(folder, "plan.json"))
    return True


def _index(
    contents: SnapshotContents, events: list[Entry], logs: list[str], *, has_plan: bool
) -> Iterator[str]:
    entries = [*_of_events(events), *_of_topics(contents)]
    entries.sort(key=lambda entry: entry.at_ns)
    written = sum(len(message.data) for message, _ in contents.messages)
    yield f"why: {contents.reason}"
    yield f"end: {_date(contents.end_ns)}"
    yield f"span: {_span(contents)}"
    yield ""
    yield "seconds before the end"
    for entry in entries:
        yield f"{(contents.end_ns - entry.at_ns) / 1e9:9.3f}  {escape(entry.text, keep='')}"
    yield ""
    yield "files"
    topics = count(len({message.topic for message, _ in contents.messages}), "topic")
    messages = count(len(contents.messages), "message")
    yield f"  bag            {messages} of {topics}, {size(written)}; play: bag play bag"
    yield f"  events.jsonl   {count(len(events), 'event')} of the launcher"
    if logs:
        yield f"  logs/          {', '.join(logs)}"
    if has_plan:
        yield "  plan.json      what the launch file started, and why"


def _span(contents: SnapshotContents) -> str:
    span = f"the last {contents.keep_s:g} s"
    if contents.dropped_ns is not None and contents.dropped_ns > contents.start_ns:
        reached_s = (contents.end_ns - contents.dropped_ns) / 1e9
        span += f"; messages of the last {reached_s:.1f} s, since memory was full"
    return span


def _date(ns: int) -> str:
    local = time.localtime(ns // 10**9)
    return f"{time.strftime('%Y-%m-%d %H:%M:%S', local)}.{ns // 10**6 % 1000:03}"


def _of_events(entries: Iterable[Entry]) -> Iterator[_Line]:
    for entry in entries:
        if not entry.event.is_sample:
            yield _Line(_at_ns(entry), entry.sentence)


def _of_topics(contents: SnapshotContents) -> Iterator[_Line]:
    """The last message of each publisher of a topic."""
    last: dict[tuple[str, bytes], int] = {}
    for message, publisher in contents.messages:
        last[message.topic, publisher] = message.log_ns
    for (topic, publisher), at_ns in last.items():
        node = contents.nodes.get(publisher)
        yield _Line(at_ns, f"last {topic}" + (f" of {node.rpartition('/')[2]}" if node else ""))
