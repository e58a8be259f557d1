"""Read the files of a run: they have what the control socket could not deliver in time."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path

from launcher.base.model.event_entries import entry_in
from launcher.base.model.run_event import Entry, RunEvent
from launcher.output.lines import for_terminal
from launcher.output.logs.rotating_file import BACKUPS
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.facts import LogLine, ProcessEvent

_STAMPED = re.compile(rb"(\d+\.\d{7}) (.*)", re.DOTALL)
_OF_PROCESS = re.compile(rb"\[([^\]]+)\] ?(.*)", re.DOTALL)
_OF_LAUNCHER = re.compile(rb"\[(?:DEBUG|INFO|WARNING|WARN|ERROR|FATAL|CRITICAL)\] \[")


def folder_of(log_root: Path, launcher_pid: int) -> Path | None:
    """The log folder of the run of this launcher, if there is one."""
    return next((p for p in log_root.glob(f"*-{launcher_pid}") if p.is_dir()), None)


def events(folder: Path, recorder: FactRecorder) -> list[ProcessEvent[RunEvent]]:
    lines: list[bytes] = []
    with contextlib.suppress(OSError):
        lines = (folder / "events.jsonl").read_bytes().splitlines()
    return [event_of(entry, recorder) for entry in filter(None, map(entry_in, lines))]


def event_of(entry: Entry, recorder: FactRecorder) -> ProcessEvent[RunEvent]:
    return ProcessEvent(
        at_s=recorder.of_monotonic(entry.monotonic_s),
        event=entry.event,
        process=entry.process,
        host=entry.host,
    )


def is_complete(folder: Path) -> bool:
    """False if the log was so long that its beginning may have been dropped."""
    return not (folder / f"launch.log.{BACKUPS}").exists()


def lines(folder: Path, recorder: FactRecorder) -> list[LogLine]:
    """The lines of launch.log, with texts as the control socket has them.

    Those without a timestamp have the time of the one before.
    """
    found: list[LogLine] = []
    at_s = 0.0
    for line in _lines(folder):
        process, text = None, line
        stamped = _STAMPED.fullmatch(line)
        if stamped is not None:
            at_s, text = recorder.of_wall(float(stamped[1])), stamped[2]
            of_process = None if _OF_LAUNCHER.match(text) else _OF_PROCESS.fullmatch(text)
            if of_process is not None:
                process, text = of_process[1].decode(errors="replace"), of_process[2]
        shown = for_terminal(text).decode(errors="replace")
        found.append(LogLine(at_s=at_s, process=process, text=shown))
    return found


def _lines(folder: Path) -> Iterator[bytes]:
    """The lines of the rotated log files, oldest first."""
    names = [*(f"launch.log.{number}" for number in range(BACKUPS, 0, -1)), "launch.log"]
    for name in names:
        with contextlib.suppress(FileNotFoundError):
            yield from (folder / name).read_bytes().split(b"\n")[:-1]
