"""Journal: `events.jsonl`, one line per start, end, restart and signal of a run.

Each line is a JSON object with `wall_s` (seconds since 1970), `monotonic_s`, `event`, and what
belongs to the event: `process`, `pid`, `returncode`, `signal`, `delay_s`, `reason`.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from launcher.engine.output.lines import LogRing
from launcher.engine.output.stdout import Screen
from launcher.engine.posix.reactor import Reactor
from launcher.engine.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.engine.logs.messages import Line
    from launcher.engine.logs.run_directory import RunDirectory

RECENT = 4000  # entries that are kept in memory, for whoever asks for the story so far


class EventLog:
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


class RunLog:
    """One voice for a run; `ring` holds the last lines of its own."""

    def __init__(self, reactor: Reactor, screen: Screen, directory: RunDirectory) -> None:
        self._reactor = reactor
        self._screen = screen
        self._directory = directory
        self.ring = LogRing()

    def say(self, level: str, logger: str, text: str) -> None:
        """A line of our own, on the screen and in the log."""
        text = text if text.isascii() else _encodable(text)
        line = f"[{level}] [{logger}]: {text}\n".encode(errors="surrogateescape")
        self.ring.append("", self._reactor.now(), line)
        self._screen.log(level, logger, text)
        self._directory.log(level, logger, text)

    def warn(self, text: str) -> None:
        """A warning of the launcher itself."""
        self.say("WARNING", "launch", text)

    def tell(self, process: Process, line: Line) -> None:
        """A line about a process."""
        self.say(line.level, process.name, line.text)

    def keep_up(self) -> None:
        """See whether the files are still there; now and then."""
        self._directory.keep_up()

    @property
    def has_lost_output(self) -> bool:
        """Whether the screen's disk had no room for something."""
        return self._screen.dropped_bytes > 0

    @property
    def journal(self) -> EventLog:
        """Where the entries go."""
        return self._directory.journal

    def note(self, event: str, process: Process | None = None, **details: object) -> None:
        """An entry of the journal, written when this pass of the loop is done."""
        journal = self._directory.journal
        if journal.is_empty:
            self._reactor.call_later(0, journal.flush)
        if process is not None:
            details = {"process": process.name, **details}
        journal.note(event, **details)


def _encodable(text: str) -> str:
    """The text, in which bytes that were no UTF-8 stay, and halves of characters do not."""
    try:
        text.encode(errors="surrogateescape")
    except UnicodeEncodeError:
        return text.encode(errors="replace").decode()
    return text
