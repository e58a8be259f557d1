"""`events.jsonl`, the log of a run for programs.

It has a line per start, exit, restart and signal: a JSON object with `wall_s` (seconds since 1970),
`monotonic_s`, `event`, and fields of the event such as `process`, `pid`, `returncode`.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

RECENT = 4000  # entries that are kept in memory, for clients of the control socket


class EventLog:
    """Collects entries, and writes them on `flush`; `listeners` are called with each line."""

    def __init__(self, write: Callable[[bytes], None]) -> None:
        self._write = write
        self._entries: list[dict[str, object]] = []
        self._recent: deque[str] = deque(maxlen=RECENT)
        self._resources = ""
        self.listeners: list[Callable[[str], None]] = []

    def note(self, event: str, at_s: float | None = None, **details: object) -> bool:
        """Add an event of that time, or of now; True if it is the first since the last flush."""
        now, since_boot = time.time(), time.monotonic()
        if at_s is not None:
            now, since_boot = now - (since_boot - at_s), at_s
        self._entries.append({"wall_s": now, "monotonic_s": since_boot, "event": event, **details})
        return len(self._entries) == 1

    def flush(self) -> None:
        if not self._entries:
            return
        import json  # here: not before the first process has started

        entries, self._entries = self._entries, []
        lines = []
        for entry in entries:
            line = json.dumps(entry)
            lines.append(line + "\n")
            if entry["event"] == "resources":
                self._resources = line
            else:
                self._recent.append(line)
        self._write("".join(lines).encode())
        for listener in self.listeners:
            for line in lines:
                listener(line[:-1])

    def history(self) -> list[str]:
        """The last entries, a line each; only the newest of the `resources`."""
        self.flush()
        return [*self._recent, *([self._resources] if self._resources else [])]
