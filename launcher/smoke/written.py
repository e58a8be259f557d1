"""Written: the files of a run read back, where the socket told less than all.

A run that is over before anybody could connect has told nothing; its files have everything.
"""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from launcher.engine.logs.rotating_file import BACKUPS
from launcher.smoke.facts import LogLine, ProcessEvent
from launcher.smoke.recorder import Recorder

_STAMPED = re.compile(r"(\d+\.\d{7}) (.*)", re.DOTALL)
_OF_PROCESS = re.compile(r"\[([^\]]+)\] ?(.*)", re.DOTALL)
_OWN = re.compile(r"\[(?:DEBUG|INFO|WARNING|WARN|ERROR|FATAL|CRITICAL)\] \[")


def folder_of(log_root: Path, launcher_pid: int) -> Path | None:
    """The folder of the run whose launcher had this pid; None if it has none."""
    return next((p for p in log_root.glob(f"*-{launcher_pid}") if p.is_dir()), None)


def events(folder: Path, recorder: Recorder) -> list[ProcessEvent]:
    """The journal."""
    return [event_of(entry, recorder) for entry in _entries(folder / "events.jsonl")]


def _entries(path: Path) -> Iterator[dict[str, Any]]:
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return
    for line in lines:
        try:
            entry = json.loads(line)
        except ValueError:
            continue  # the launcher was killed while it wrote
        yield entry


def event_of(entry: dict[str, Any], recorder: Recorder) -> ProcessEvent:
    """An entry of the journal as a fact."""
    known = ("event", "process", "monotonic_s", "wall_s")
    return ProcessEvent(
        at_s=recorder.of_monotonic(float(entry["monotonic_s"])),
        kind=str(entry["event"]),
        process=entry.get("process"),
        details={name: value for name, value in entry.items() if name not in known},
    )


def is_whole(folder: Path) -> bool:
    """Whether the log has not been so long that its beginning was dropped."""
    return not (folder / f"launch.log.{BACKUPS}").exists()


def _texts(folder: Path) -> Iterator[str]:
    """The lines of the log and of the files that it filled before, the oldest first."""
    names = [*(f"launch.log.{number}" for number in range(BACKUPS, 0, -1)), "launch.log"]
    for name in names:
        with contextlib.suppress(FileNotFoundError):
            text = (folder / name).read_text(encoding="utf-8", errors="replace")
            yield from text.split("\n")[:-1]


def lines(folder: Path, recorder: Recorder) -> list[LogLine]:
    """The log; a line without a stamp belongs to the one before it."""
    found: list[LogLine] = []
    at_s = 0.0
    for line in _texts(folder):
        stamped = _STAMPED.fullmatch(line)
        rest = line
        if stamped is not None:
            at_s, rest = recorder.of_wall(float(stamped[1])), stamped[2]
        found.append(_line(rest, at_s, is_stamped=stamped is not None))
    return found


def _line(text: str, at_s: float, *, is_stamped: bool) -> LogLine:
    process = _OF_PROCESS.fullmatch(text) if is_stamped and not _OWN.match(text) else None
    if process is None:
        return LogLine(at_s=at_s, process=None, text=text)
    return LogLine(at_s=at_s, process=process[1], text=process[2])
