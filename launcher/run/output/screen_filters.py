"""The verbs `mute`, `unmute`, `solo`, `level`, `grep`, `show`: which lines are on the screen."""

from __future__ import annotations

import enum
from collections.abc import Collection, Sequence

from launcher.base.model.record import Record
from launcher.output.filters import LineFilter, Pattern
from launcher.run.logs.run_log import RunLog
from launcher.run.processes.process import Process


class FilterChange(enum.Enum):
    """What a request has changed."""

    MUTED = enum.auto()
    NOT_MUTED = enum.auto()  # `unmute` had no effect
    UNMUTED = enum.auto()
    ALONE = enum.auto()
    LEVEL = enum.auto()
    PATTERN = enum.auto()
    EVERYTHING = enum.auto()
    NOT_HIDDEN = enum.auto()  # `show` had no effect


class Shown(Record):
    """What is shown of a process now, whatever was changed; `hidden_lines` were hidden before.

    `level` is an index into LEVELS; a `pattern` of None matches every line.
    """

    process: str
    change: FilterChange
    hidden_lines: int = 0
    level: int = 0
    pattern: str | None = None
    muted: bool = False
    outside: bool = False  # of a `solo` of others
    was_muted: bool = False  # by name, until a `solo` of it


class ScreenFilters:
    """Changes what is shown of processes. `processes` is the live collection of all of a run."""

    def __init__(self, processes: Collection[Process], log: RunLog) -> None:
        self._processes = processes
        self._log = log
        self._default = LineFilter()  # for processes that are started later

    def adopt(self, process: Process) -> None:
        """Apply the filters that were set for all processes to a new one."""
        if self._default.is_open:
            return
        line_filter = self._filter_of(process)
        line_filter.outside, line_filter.level = self._default.outside, self._default.level
        line_filter.pattern = self._default.pattern

    def mute(self, processes: Sequence[Process]) -> list[Shown]:
        for process in processes:
            self._filter_of(process).muted = True
        return [_shown(p, FilterChange.MUTED) for p in processes]

    def unmute(self, processes: Sequence[Process]) -> list[Shown]:
        """Show them again; if these are all processes, a `solo` ends."""
        if len(processes) == len(self._processes):
            self._default.outside = False
        return [self._unmute(process) for process in processes]

    def _unmute(self, process: Process) -> Shown:
        if process.filter is None or not process.filter.is_silent:
            return _shown(process, FilterChange.NOT_MUTED)
        line_filter = process.filter
        line_filter.muted = line_filter.outside = False
        hidden, line_filter.hidden_lines = line_filter.hidden_lines, 0
        _drop_if_open(process)
        return _shown(process, FilterChange.UNMUTED, hidden)

    def show(self, processes: Sequence[Process]) -> list[Shown]:
        """Remove all filters of these processes."""
        if len(processes) == len(self._processes):
            self._default = LineFilter()
        return [self._show(process) for process in processes]

    @staticmethod
    def _show(process: Process) -> Shown:
        if process.filter is None:
            return _shown(process, FilterChange.NOT_HIDDEN)
        hidden, process.filter = process.filter.hidden_lines, None
        return _shown(process, FilterChange.EVERYTHING, hidden)

    def solo(self, processes: Sequence[Process]) -> list[Shown]:
        alone = {process.process_id for process in processes}
        muted = {p.process_id for p in processes if p.filter is not None and p.filter.muted}
        self._default.outside = True
        for process in self._processes:
            line_filter = self._filter_of(process)
            line_filter.outside = process.process_id not in alone
            line_filter.muted = line_filter.muted and line_filter.outside
            _drop_if_open(process)
        return [_shown(p, FilterChange.ALONE, was_muted=p.process_id in muted) for p in processes]

    def level(self, level: int, processes: Sequence[Process]) -> list[Shown]:
        """Show only lines of this level (an index into LEVELS) and above."""
        if len(processes) == len(self._processes):
            self._default.level = level
        for process in processes:
            self._filter_of(process).level = level
            _drop_if_open(process)
        return self.levels(processes)

    def levels(self, processes: Sequence[Process]) -> list[Shown]:
        return [_shown(p, FilterChange.LEVEL) for p in processes]

    def grep(self, pattern: Pattern | None, processes: Sequence[Process]) -> list[Shown]:
        """Show only lines that match; None shows all."""
        if len(processes) == len(self._processes):
            self._default.pattern = pattern
        for process in processes:
            self._filter_of(process).pattern = pattern
            _drop_if_open(process)
        return [_shown(p, FilterChange.PATTERN) for p in processes]

    def _filter_of(self, process: Process) -> LineFilter:
        if process.filter is None:
            process.filter = LineFilter()
            process.filter.on_slow = self._give_up
        return process.filter

    def _give_up(self, pattern: Pattern) -> None:
        """Show every line again where this pattern was used."""
        self._log.warn(f"matching {pattern.text!r} takes too long; every line is shown again")
        for line_filter in (
            self._default,
            *(p.filter for p in self._processes if p.filter is not None),
        ):
            if line_filter.pattern is pattern:
                line_filter.pattern = None


def _drop_if_open(process: Process) -> None:
    """Remove a filter that hides nothing."""
    if process.filter is not None and process.filter.is_open:
        process.filter = None


def _shown(
    process: Process, change: FilterChange, hidden_lines: int = 0, *, was_muted: bool = False
) -> Shown:
    one = process.filter
    if one is None:
        return Shown(process.name, change, hidden_lines, was_muted=was_muted)
    return Shown(
        process.name,
        change,
        hidden_lines,
        one.level,
        None if one.pattern is None else one.pattern.text,
        muted=one.muted,
        outside=one.outside,
        was_muted=was_muted,
    )
