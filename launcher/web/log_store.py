"""The last lines of all processes as rows, for the page and for the report of smoke."""

from __future__ import annotations

import itertools
from collections import Counter, deque
from typing import Any, NamedTuple

from launcher.output.filters import ERROR, LEVELS, LineLevels

KEEP_LINES = 100_000
KEEP_BYTES = 64 * 1024 * 1024
SKIPPED = "skipped"  # the stream of a row that stands for lines that were not read


class LogRow(NamedTuple):
    """A line as the message `lines` has it, its time in seconds since 1970."""

    process: str | None
    stream: str | None
    time: float | None
    level: str | None
    text: str


class LogStore:
    """`next_number` is that of the next line. `counts`: lines by (process, level), `errors`: the
    last one of each process."""

    def __init__(self) -> None:
        self._rows: deque[LogRow] = deque()
        self._bytes = 0
        self._levels = LineLevels()
        self.first = 1
        self.counts: Counter[tuple[str | None, str]] = Counter()
        self.lines: Counter[str | None] = Counter()
        self.skipped = 0
        self.errors: dict[str | None, dict[str, Any]] = {}

    @property
    def next_number(self) -> int:
        return self.first + len(self._rows)

    def add(self, item: dict[str, Any]) -> LogRow:
        """Keep an item of `logs`."""
        if "dropped" in item:
            return self._skip(item)
        process, text = item["process"], item["text"]
        index = self._levels.of((process, item["stream"]), text.encode(errors="surrogateescape"))
        level = LEVELS[index]
        if index >= ERROR:
            number = self.next_number
            self.errors[process] = {"time": item["wall_s"], "text": text, "number": number}
        self.counts[process, level] += 1
        self.lines[process] += 1
        return self._keep(LogRow(process, item["stream"], item["wall_s"], level, text))

    def _skip(self, item: dict[str, Any]) -> LogRow:
        self.skipped += item["dropped"]
        for process, count in (item.get("processes") or {}).items():
            self.lines[process or None] += count
        names = ", ".join(sorted(name or "launch" for name in item.get("processes") or {}))
        of = f" of {names}" if names else ""
        text = f"{item['dropped']:,} lines{of} came too fast and are not shown here"
        return self._keep(LogRow(None, SKIPPED, item.get("wall_s"), None, text))

    def _keep(self, row: LogRow) -> LogRow:
        self._rows.append(row)
        self._bytes += len(row.text)
        while len(self._rows) > KEEP_LINES or self._bytes > KEEP_BYTES:
            self._bytes -= len(self._rows.popleft().text)
            self.first += 1
        return row

    def before(self, number: int, count: int) -> tuple[int, list[LogRow]]:
        """(number of the first, rows): at most `count` rows that come before this number."""
        end = max(self.first, min(number, self.next_number))
        begin = max(self.first, end - count)
        return begin, self._slice(begin, end)

    def after(self, number: int, most: int) -> tuple[int, list[LogRow]]:
        """The newest rows behind this number, at most so many."""
        begin = max(self.first, number + 1, self.next_number - most)
        return begin, self._slice(begin, self.next_number)

    def _slice(self, begin: int, end: int) -> list[LogRow]:
        rows = self._rows
        if begin >= end:
            return []
        if begin - self.first > len(rows) // 2:  # a deque is read fastest from its nearer end
            last = list(itertools.islice(reversed(rows), self.next_number - begin))
            return last[::-1][: end - begin]
        return list(itertools.islice(rows, begin - self.first, end - self.first))
