"""The log of a run for its page: lines with levels, at most as many as a page can hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from launcher.output.filters import ERROR, LEVELS, LineLevels
from launcher.smoke.observe.facts import LogLine
from launcher.web.log_store import SKIPPED, LogRow

MAX_LINES = 100_000
MAX_CHARACTERS = 24 * 1024 * 1024
MAX_OF_LINE = 20_000
_HEAD = 10  # one part in so many is of the beginning, if a log is too long


def rows_of(lines: Iterable[LogLine], started_s: float) -> list[LogRow]:
    """All lines with their levels."""
    levels = LineLevels()
    rows: list[LogRow] = []
    for line in lines:
        data = line.text.encode(errors="surrogateescape")
        index = levels.of((line.process, line.stream or "stdout"), data)
        text, more = line.text[:MAX_OF_LINE], len(line.text) - MAX_OF_LINE
        if more > 0:
            text += f"… ({more:,} more characters)"
        time_s = started_s + line.at_s
        rows.append(LogRow(line.process, line.stream, time_s, LEVELS[index], text))
    return rows


def shortened(
    rows: Sequence[LogRow], most: int = MAX_LINES, characters: int = MAX_CHARACTERS
) -> list[LogRow]:
    """The beginning and the end of a log that is too long; a row says what is left out."""
    if len(rows) <= most and sum(len(row.text) for row in rows) <= characters:
        return list(rows)
    head = _fitting(rows, most // _HEAD, characters // _HEAD)
    rest = rows[head:]
    room = characters - characters // _HEAD
    tail = _fitting(rest[::-1], most - most // _HEAD - 1, room)
    left_out = rest[: len(rest) - tail]
    if not left_out:
        return list(rows)
    names = Counter(row.process or "launch" for row in left_out)
    of = ", ".join(f"{count:,} of {name}" for name, count in names.most_common(5))
    others = ", ..." if len(names) > 5 else ""
    text = f"{len(left_out):,} lines are left out of this file: {of}{others}"
    note = LogRow(None, SKIPPED, left_out[0].time, None, text)
    return [*rows[:head], note, *rest[len(rest) - tail :]]


def _fitting(rows: Sequence[LogRow], most: int, characters: int) -> int:
    """How many rows fit, of the first ones."""
    for number, row in enumerate(rows[:most]):
        characters -= len(row.text)
        if characters < 0:
            return number
    return min(most, len(rows))


def last_errors(rows: Sequence[LogRow]) -> dict[str | None, dict[str, Any]]:
    """The last error line of each process, with its number on the page."""
    found = {}
    for number, row in enumerate(rows, 1):
        if row.level is not None and LEVELS.index(row.level) >= ERROR:
            found[row.process] = {"time": row.time, "text": row.text, "number": number}
    return found
