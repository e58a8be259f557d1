"""Reads what `journalctl -f -o json` prints: lines of processes, our records, systemd's messages.

Every stream of a process and every record of ours has an identifier with the run's id, which comes
from the one who opens the stream. The unit and the slice do not: the journal looks them up when it
accepts the stream, and a process that exits at once has none by then.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from launcher.base import strict_json
from launcher.base.model.record import Record
from launcher.hosts.ssh import quoted

# Messages of systemd, by their id, see systemd's sd-messages.h.
STOPPING = "de5b426a63be47a7b6ac3eaac82e2f6f"
FAILED = "d9b373ed55a64feb8242e02dbe79a49c"
RESTART_SCHEDULED = "5eb03494b6584870a536b337290809b3"
_OF_SYSTEMD = (STOPPING, FAILED, RESTART_SCHEDULED)

_FIELDS = (
    "MESSAGE",
    "MESSAGE_ID",
    "PRIORITY",
    "SYSLOG_IDENTIFIER",
    "UNIT",
    "USER_UNIT",
    "UNIT_RESULT",
    "_LINE_BREAK",
    "_PID",
    "_STREAM_ID",
    "_SYSTEMD_UNIT",
    "_SYSTEMD_USER_UNIT",
    "_UID",
)
# Priorities of systemd-cat for the streams of a process, where they are apart.
STDOUT_PRIORITY, STDERR_PRIORITY = 6, 5
_ANNOUNCEMENT = re.compile(rb"launcher: output of ([0-9]+)\n")
_ANNOUNCEMENTS = 20  # that may be among the last lines, and two with each of them
_LATEST = 200  # records, and announcements, that are looked at for starts before the last lines


def identifier(run: str) -> str:
    """Of the output of all processes of a run; records have `-events` after it."""
    return f"launcher-{run}"


def records_identifier(run: str) -> str:
    return f"launcher-{run}-events"


def words(run: str, cursor: str | None, *, first: str | None = None) -> list[str]:
    """The command line that follows the journal of a run, from behind the cursor, or from `first`
    on.
    """
    start = "--since=now" if first is None else f"--cursor={first}"
    start = start if cursor is None else f"--after-cursor={cursor}"
    return [
        *("journalctl", "--follow", "--quiet", "--output=json", "--all"),
        f"--output-fields={','.join(_FIELDS)}",
        *("--no-tail", start),
        *matches(run),
    ]


def past(run: str, lines: int, uid: int, process_ids: Iterable[int]) -> str:
    """A script that prints the latest records, the latest announcements of these processes, and
    then the first of so many last lines of output, or an earlier one, since announcements are
    among them.
    """
    output = f"SYSLOG_IDENTIFIER={identifier(run)}"
    most = 3 * lines + _ANNOUNCEMENTS if lines else 1
    fields = "MESSAGE,SYSLOG_IDENTIFIER,_STREAM_ID,_SYSTEMD_UNIT,_SYSTEMD_USER_UNIT,_UID"
    begin = f"journalctl --quiet --boot --output=json --output-fields={fields}"
    latest = f"{begin} --lines={_LATEST}"
    texts = quoted(f"MESSAGE={announcement(one)}" for one in process_ids)  # any of them
    return "\n".join(
        [
            "exec 2>/dev/null",
            f"{latest} SYSLOG_IDENTIFIER={records_identifier(run)} _UID={uid}",
            *([f"{latest} {output} {texts}"] if texts else []),
            f"{begin} --lines={most} {output} | head -n 1",
        ]
    )


def read_past(
    run: str, text: str, begin_s: float
) -> tuple[list[Note], list[JournalLine], str | None]:
    """Records from before the last lines, announcements, and the cursor of the first of the last
    lines. None: the lines since `begin_s` are more, or there are none.
    """
    reader = JournalReader(run)
    found = list(reader.feed(text.encode() + b"\n"))
    notes = [one for one in found if isinstance(one, Note)]
    lines = [one for one in found if isinstance(one, JournalLine)]
    is_past = bool(lines) and lines[-1].monotonic_s < begin_s
    until_s = lines[-1].monotonic_s if is_past else begin_s
    notes = [one for one in notes if one.monotonic_s <= until_s]
    return notes, lines[:-1], reader.cursor if is_past else None


def new_mark() -> str:
    """A token for a mark; the journal has those of other launchers of the run, too."""
    return os.urandom(4).hex()


def announcement(process_id: int) -> str:
    """The first line of a stream whose unit the journal may not know."""
    return f"launcher: output of {process_id}"


def announced(line: JournalLine) -> int:
    """The process that it announces; -1 for other lines."""
    found = _ANNOUNCEMENT.fullmatch(line.data)
    return int(found[1]) if found and line.stream_id else -1


def entry_at(cursor: str) -> str:
    """A script that prints the entry at the cursor, or the next one if that is gone."""
    words = ("--quiet", "--output=json", "--output-fields=_BOOT_ID", f"--cursor={cursor}")
    return f"journalctl {' '.join(map(shlex.quote, words))} 2>/dev/null | head -n 1"


def is_gone(cursor: str, entry: str) -> bool:
    """Whether what `entry_at` has printed is another entry."""
    try:
        found = strict_json.loads(entry)["__CURSOR"]
    except (ValueError, KeyError, TypeError):
        return False  # it may not be read
    return bool(found != cursor)


def matches(run: str) -> list[str]:
    return [
        f"SYSLOG_IDENTIFIER={identifier(run)}",
        f"SYSLOG_IDENTIFIER={records_identifier(run)}",
        "+",
        *(f"MESSAGE_ID={one}" for one in _OF_SYSTEMD),
    ]


class JournalLine(Record):
    """Output of a process; `unit` is empty if the journal does not know it, `pid` wrote it.

    `is_last`: its stream has ended without a newline.
    """

    unit: str
    pid: int
    uid: int
    stream_id: str
    stream: str
    data: bytes
    monotonic_s: float
    is_last: bool = False


class Note(Record):
    """A record of ours: `words` are those that were written, `uid` the user who did."""

    words: tuple[str, ...]
    uid: int
    monotonic_s: float


class UnitMessage(Record):
    """A message of systemd about a unit."""

    message_id: str
    unit: str
    uid: int
    result: str
    monotonic_s: float


Entry = JournalLine | Note | UnitMessage


class JournalReader:
    """Makes entries of blocks of output; `cursor` is behind the last."""

    def __init__(self, run: str) -> None:
        self._output, self._records = identifier(run), records_identifier(run)
        self._partial = b""
        self.cursor: str | None = None
        self.damaged = 0  # lines that are no JSON

    def restart(self) -> None:
        """Another journalctl begins behind the cursor."""
        self._partial = b""

    def feed(self, data: bytes) -> Iterator[Entry]:
        *lines, self._partial = (self._partial + data).split(b"\n")
        for line in lines:
            if not line:
                continue
            try:
                fields = strict_json.loads(line)
            except ValueError:
                self.damaged += 1
                continue
            entry = self._entry(fields)
            self.cursor = fields.get("__CURSOR", self.cursor)
            if entry is not None:
                yield entry

    def _entry(self, fields: Mapping[str, Any]) -> Entry | None:
        at_s = int(_one(fields, "__MONOTONIC_TIMESTAMP", "0")) / 1e6
        tag = _one(fields, "SYSLOG_IDENTIFIER")
        if tag == self._records:
            return Note(tuple(_text(fields).split()), int(_one(fields, "_UID", "-1")), at_s)
        if tag == self._output:
            return _line(fields, at_s)
        unit = _one(fields, "UNIT") or _one(fields, "USER_UNIT")
        if unit and (message_id := _one(fields, "MESSAGE_ID")):
            uid, result = int(_one(fields, "_UID", "-1")), _one(fields, "UNIT_RESULT")
            return UnitMessage(message_id, unit, uid, result, at_s)
        return None


def _line(fields: Mapping[str, Any], at_s: float) -> JournalLine:
    # A line that is too long comes in pieces. One that another process continues is broken, and if
    # that has added only the newline, nothing more comes of it.
    line_break = _one(fields, "_LINE_BREAK")
    newline = b"" if line_break in ("line-max", "eof") else b"\n"
    is_error = _one(fields, "PRIORITY") == str(STDERR_PRIORITY)
    return JournalLine(
        unit=_one(fields, "_SYSTEMD_USER_UNIT") or _one(fields, "_SYSTEMD_UNIT"),
        pid=int(_one(fields, "_PID", "0")),
        uid=int(_one(fields, "_UID", "-1")),
        stream_id=_one(fields, "_STREAM_ID"),
        stream="stderr" if is_error else "stdout",
        data=_bytes(fields.get("MESSAGE")) + newline,
        monotonic_s=at_s,
        is_last=line_break == "eof",
    )


def _bytes(value: object) -> bytes:
    """A field: text, numbers of bytes where it is not printable, a list of both if it repeats."""
    if isinstance(value, str):
        return value.encode("utf-8", "surrogateescape")
    if isinstance(value, list):
        if value and not isinstance(value[0], int):
            return _bytes(value[0])
        return bytes(value)
    return b""


def _text(fields: Mapping[str, Any]) -> str:
    return _bytes(fields.get("MESSAGE")).decode(errors="replace")


def _one(fields: Mapping[str, Any], name: str, default: str = "") -> str:
    """A field that is given once, normally."""
    value = fields.get(name, default)
    return value if isinstance(value, str) else _bytes(value).decode(errors="replace")
