"""`events.jsonl`, the log of a run for programs.

It has a line per entry, a JSON object (`model.run_events`).
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from launcher.base.model.record import as_dict
from launcher.base.model.run_event import Entry, RunEvent
from launcher.base.model.run_events import Resources

# Entries that are kept in memory, for clients of the control socket: so many, and so much at most.
RECENT = 4000
RECENT_BYTES = 2 * 1024 * 1024


class EventLog:
    """Collects entries, and writes them on `flush`; `listeners` are called with each line."""

    def __init__(self, write: Callable[[bytes], None]) -> None:
        self._write = write
        self._entries: list[Entry] = []
        self._recent: deque[str] = deque()
        self._recent_bytes = 0
        self._resources = ""
        self.listeners: list[Callable[[str], None]] = []

    def note(
        self,
        event: RunEvent,
        at_s: float | None = None,
        *,
        process: str | None = None,
        host: str | None = None,
    ) -> bool:
        """Add an event of that time, or of now; True if it is the first since the last flush."""
        now, since_boot = time.time(), time.monotonic()
        if at_s is not None:
            now, since_boot = now - (since_boot - at_s), at_s
        self._entries.append(Entry(now, since_boot, event, process, host))
        return len(self._entries) == 1

    def flush(self) -> None:
        if not self._entries:
            return
        from launcher.base import strict_json  # here: not before the first process has started

        entries, self._entries = self._entries, []
        lines = []
        for entry in entries:
            line = strict_json.dumps(entry.item, default=as_dict)
            lines.append(line + "\n")
            if isinstance(entry.event, Resources):
                self._resources = line
            else:
                self._keep(line)
        self._write("".join(lines).encode())
        for listener in self.listeners:
            for line in lines:
                listener(line[:-1])

    def _keep(self, line: str) -> None:
        self._recent.append(line)
        self._recent_bytes += len(line)
        while len(self._recent) > RECENT or self._recent_bytes > RECENT_BYTES:
            self._recent_bytes -= len(self._recent.popleft())

    def history(self) -> list[str]:
        """The last entries, a line each; only the newest of the `resources`."""
        self.flush()
        return [*self._recent, *([self._resources] if self._resources else [])]
