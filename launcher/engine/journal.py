"""Journal: `events.jsonl`, one line per start, end, restart and signal of a run.

Each line is a JSON object with `wall_s` (seconds since 1970), `monotonic_s`, `event`, and what
belongs to the event: `process`, `pid`, `returncode`, `signal`, `delay_s`, `reason`.
"""

from __future__ import annotations

import time
from collections.abc import Callable


class Journal:
    """Collects entries and hands them on as lines; `json` is imported with the first flush.

    The first process of a run does not wait for that: the supervisor flushes when it has nothing
    better to do.
    """

    def __init__(self, write: Callable[[bytes], None]) -> None:
        self._write = write
        self._entries: list[dict[str, object]] = []

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to flush."""
        return not self._entries

    def note(self, event: str, **details: object) -> None:
        """Remember an event that happens now."""
        entry = {"wall_s": time.time(), "monotonic_s": time.monotonic(), "event": event}
        self._entries.append({**entry, **details})

    def flush(self) -> None:
        """Hand on what was noted."""
        if not self._entries:
            return
        import json

        lines = "".join(json.dumps(entry) + "\n" for entry in self._entries)
        self._entries.clear()
        self._write(lines.encode())
