"""The start-up of a run, by its `events.jsonl`: all times are seconds since its beginning."""

from __future__ import annotations

import contextlib
import os
import re
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from launcher.base.errors import UsageError
from launcher.base.model.event_entries import entry_in
from launcher.base.model.run_event import Entry, RunEvent
from launcher.base.model.run_events import Ended, NotStarted, Ready, Released, Started, Waiting
from launcher.output.logs.rotating_file import BACKUPS
from launcher.output.logs.run_directory import EVENTS

# A run folder is named by the time when the launcher began, in local time.
_STAMP = re.compile(r"(\d{4}-\d\d-\d\d-\d\d-\d\d-\d\d)-(\d{6})-.*")


@dataclass(slots=True)
class FirstStart:
    """The first start of a process; None: that has not happened.

    `waited_for` are the processes that it had to wait for, `why` how the wait has ended.
    `has_facts`: something says when it is ready.
    """

    name: str
    queued_s: float
    released_s: float | None = None
    started_s: float | None = None
    ready_s: float | None = None
    ended_s: float | None = None
    why: str = ""
    waited_for: tuple[str, ...] = ()
    has_facts: bool = False

    @property
    def done_s(self) -> float | None:
        """When its start was complete: when it was ready, without facts when it ran."""
        return self.ready_s if self.has_facts else self.started_s

    @property
    def waited_s(self) -> float:
        """How long its start was held back."""
        return (self.released_s or self.queued_s) - self.queued_s

    @property
    def own_s(self) -> float | None:
        """How long it took to be ready from its start."""
        if self.done_s is None or self.started_s is None:
            return None
        return self.done_s - self.started_s


@dataclass(slots=True)
class Timeline:
    """`until_s` is the time of the last event: of a running launch, about now."""

    folder: str
    processes: dict[str, FirstStart] = field(default_factory=dict)
    until_s: float = 0.0

    @property
    def done_s(self) -> float:
        """When the last process was ready, of those that were."""
        return max((one.done_s or 0.0 for one in self.processes.values()), default=0.0)

    @property
    def unready(self) -> list[FirstStart]:
        return [one for one in self.processes.values() if one.done_s is None]


def read(folder: str) -> Timeline:
    """The timeline of the run with this log folder; UsageError if it cannot be read."""
    return timeline(folder, _entries(folder))


def _entries(folder: str) -> Iterator[Entry]:
    names = [*(f"{EVENTS}.{number}" for number in range(BACKUPS, 0, -1)), EVENTS]
    for name in names:
        path = os.path.join(folder, name)
        if name != EVENTS and not os.path.exists(path):
            continue
        try:
            with open(path, encoding="utf-8", errors="replace") as file:
                yield from filter(None, map(entry_in, file))
        except OSError as error:
            raise UsageError(f"cannot read {path}: {error.strerror}") from None


def timeline(folder: str, entries: Iterable[Entry]) -> Timeline:
    """The timeline of these entries, in order."""
    found = Timeline(folder)
    begun_s = _begun(folder)
    for entry in entries:
        begun_s = entry.wall_s if begun_s is None else begun_s
        at_s = max(0.0, entry.wall_s - begun_s)
        found.until_s = max(found.until_s, at_s)
        if entry.process is not None:
            _take(found.processes, entry.process, entry.event, at_s)
    return found


def _begun(folder: str) -> float | None:
    stamp = _STAMP.fullmatch(os.path.basename(folder))
    if stamp is None:
        return None
    with contextlib.suppress(ValueError, OverflowError):
        seconds = time.mktime(time.strptime(stamp[1], "%Y-%m-%d-%H-%M-%S"))
        return seconds + int(stamp[2]) / 1e6
    return None


def _take(processes: dict[str, FirstStart], name: str, event: RunEvent, at_s: float) -> None:
    if isinstance(event, (Waiting, Started, NotStarted)):
        processes.setdefault(name, FirstStart(name, at_s))
    if name not in processes:
        return
    start = processes[name]
    match event:
        case Released() if start.released_s is None:
            start.released_s, start.why, start.waited_for = at_s, event.why, event.processes
        case Started() if start.started_s is None:
            start.started_s, start.has_facts = at_s, bool(event.ready_when)
        case Ready() if start.ready_s is None:
            start.ready_s, start.has_facts = at_s, True
        case Ended() | NotStarted() if start.ended_s is None:
            start.ended_s = at_s


def critical_chain(found: Timeline) -> list[FirstStart]:
    """The process that was ready last, the one that it waited for last, and so on."""
    done = [one for one in found.processes.values() if one.done_s is not None]
    chain: list[FirstStart] = []
    last = max(done, key=lambda one: one.done_s or 0.0, default=None)
    while last is not None and last not in chain:
        chain.append(last)
        before = [found.processes[name] for name in last.waited_for if name in found.processes]
        ready = [one for one in before if one.done_s is not None]
        is_cause = last.why == "ready"
        last = max(ready, key=lambda one: one.done_s or 0.0, default=None) if is_cause else None
    return chain
