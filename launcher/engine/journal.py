"""Journal: `events.jsonl`, one line per start, end, restart and signal of a run.

Each line is a JSON object with `wall_s` (seconds since 1970), `monotonic_s`, `event`, and what
belongs to the event: `process`, `pid`, `returncode`, `signal`, `delay_s`, `reason`.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

RECENT = 4000  # entries that are kept in memory, for whoever asks for the story so far


class Journal:
    """Collects entries and hands them on as lines; `json` is imported with the first flush.

    The first process of a run does not wait for that: the supervisor flushes when it has nothing
    better to do. `listeners` get each line when it is written.
    """

    def __init__(self, write: Callable[[bytes], None]) -> None:
        self._write = write
        self._entries: list[dict[str, object]] = []
        self._recent: deque[str] = deque(maxlen=RECENT)
        self._resources = ""
        self.listeners: list[Callable[[str], None]] = []

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to flush."""
        return not self._entries

    def note(self, event: str, **details: object) -> None:
        """Remember an event that happens now."""
        now, since_boot = time.time(), time.monotonic()
        entry = {"wall_s": now, "monotonic_s": since_boot, "event": event, **details}
        self._entries.append(entry)

    def flush(self) -> None:
        """Hand on what was noted."""
        if not self._entries:
            return
        import json

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
        """The last entries so far, a line each; of the samples of resources, the newest alone."""
        self.flush()
        return [*self._recent, *([self._resources] if self._resources else [])]
