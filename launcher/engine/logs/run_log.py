"""The supervisor's own log of a run, and `events.jsonl`, the log for programs.

`events.jsonl` has a line per start, end, restart and signal: a JSON object with `wall_s` (seconds
since 1970), `monotonic_s`, `event`, and fields of the event as `process`, `pid`, `returncode`.
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

RECENT = 4000  # entries that are kept in memory, for clients of the control socket


class EventLog:
    """Collects entries and writes them as lines; `listeners` get each line when it is written.

    `json` is imported with the first flush, for which the first process does not wait.
    """

    def __init__(self, write: Callable[[bytes], None]) -> None:
        self._write = write
        self._entries: list[dict[str, object]] = []
        self._recent: deque[str] = deque(maxlen=RECENT)
        self._resources = ""
        self.listeners: list[Callable[[str], None]] = []

    def note(self, event: str, **details: object) -> bool:
        """Add an event that happens now; whether it is the first to be flushed."""
        now, since_boot = time.time(), time.monotonic()
        self._entries.append({"wall_s": now, "monotonic_s": since_boot, "event": event, **details})
        return len(self._entries) == 1

    def flush(self) -> None:
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
    """What the supervisor itself reports; `ring` holds the last of its lines."""

    def __init__(self, reactor: Reactor, screen: Screen, directory: RunDirectory) -> None:
        self._reactor = reactor
        self._screen = screen
        self._directory = directory
        self.ring = LogRing()

    def say(self, level: str, logger: str, text: str) -> None:
        """Write a line to the screen and to `launch.log`."""
        text = text if text.isascii() else _encodable(text)
        line = f"[{level}] [{logger}]: {text}\n".encode(errors="surrogateescape")
        self.ring.append("", self._reactor.now(), line)
        self._screen.log(level, logger, text)
        self._directory.log(level, logger, text)

    def warn(self, text: str) -> None:
        self.say("WARNING", "launch", text)

    def tell(self, process: Process, line: Line) -> None:
        self.say(line.level, process.name, line.text)

    def keep_up(self) -> None:
        self._directory.keep_up()

    @property
    def has_lost_output(self) -> bool:
        """Whether output was dropped because the disk is full."""
        return self._screen.dropped_bytes > 0

    @property
    def journal(self) -> EventLog:
        return self._directory.journal

    def note(self, event: str, process: Process | None = None, **details: object) -> None:
        """Add an entry to `events.jsonl`, which is written after this pass of the loop."""
        if process is not None:
            details = {"process": process.name, **details}
        if self.journal.note(event, **details):
            self._reactor.call_later(0, self.journal.flush)


def _encodable(text: str) -> str:
    """The text without lone surrogates, except those that stand for bytes that are not UTF-8."""
    try:
        text.encode(errors="surrogateescape")
    except UnicodeEncodeError:
        return text.encode(errors="replace").decode()
    return text
