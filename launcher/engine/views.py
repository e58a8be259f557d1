"""Views: who is muted, shown alone, or shown in part, on the screen of a run."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from launcher.engine.pattern import Pattern
from launcher.engine.process import Process
from launcher.engine.view import LEVELS, View
from launcher.model.record import Record

NOT_MUTED = "was not muted"


class Shown(Record):
    """What is shown of a process now, as a sentence; `hidden_lines` were not since it changed."""

    process: str
    text: str
    hidden_lines: int = 0


class Views:
    """Changes what is shown of processes; `everyone()` are all of the run.

    `warn` is called when a pattern has to be given up.
    """

    def __init__(
        self, everyone: Callable[[], Collection[Process]], warn: Callable[[str], None]
    ) -> None:
        self._everyone = everyone
        self._warn = warn
        self._common = View()  # for whoever is started later

    def adopt(self, process: Process) -> None:
        """Show a process that is new as everybody is shown."""
        if self._common.is_open:
            return
        view = self._view(process)
        view.outside, view.level = self._common.outside, self._common.level
        view.pattern = self._common.pattern

    def mute(self, processes: Sequence[Process]) -> list[Shown]:
        """Show nothing of them."""
        for process in processes:
            self._view(process).muted = True
        return [Shown(p.name, f"{p.name} is muted; its files go on") for p in processes]

    def unmute(self, processes: Sequence[Process]) -> list[Shown]:
        """Show them again; with all of them, a `solo` is over."""
        if len(processes) == len(self._everyone()):
            self._common.outside = False
        return [self._unmute(process) for process in processes]

    def _unmute(self, process: Process) -> Shown:
        if process.view is None or not process.view.is_silent:
            return Shown(process.name, f"{process.name} {NOT_MUTED}")
        view = process.view
        view.muted = view.outside = False
        hidden, view.hidden_lines = view.hidden_lines, 0
        _drop_if_open(process)
        lines = "1 line was" if hidden == 1 else f"{hidden} lines were"
        return Shown(process.name, f"{process.name} is shown again; {lines} not shown", hidden)

    def solo(self, processes: Sequence[Process]) -> list[Shown]:
        """Show these alone."""
        alone = {process.process_id for process in processes}
        self._common.outside = True
        for process in self._everyone():
            view = self._view(process)
            view.outside = process.process_id not in alone
            view.muted = view.muted and view.outside
            _drop_if_open(process)
        return [Shown(p.name, f"{p.name} is shown alone; `unmute` shows all") for p in processes]

    def level(self, level: int, processes: Sequence[Process]) -> list[Shown]:
        """Show only lines of this level (an index into LEVELS) and above; 0 shows all."""
        if len(processes) == len(self._everyone()):
            self._common.level = level
        for process in processes:
            self._view(process).level = level
            _drop_if_open(process)
        return _told(processes, _levels(level))

    def levels(self, processes: Sequence[Process]) -> list[Shown]:
        """What is shown of them now."""
        levels = [0 if p.view is None else p.view.level for p in processes]
        return [
            shown
            for process, level in zip(processes, levels, strict=True)
            for shown in _told([process], _levels(level))
        ]

    def grep(self, pattern: Pattern | None, processes: Sequence[Process]) -> list[Shown]:
        """Show only lines in which this is found; None shows all."""
        if len(processes) == len(self._everyone()):
            self._common.pattern = pattern
        for process in processes:
            self._view(process).pattern = pattern
            _drop_if_open(process)
        what = "every line" if pattern is None else f"only those lines that have {pattern.text!r}"
        return _told(processes, what)

    def _view(self, process: Process) -> View:
        if process.view is None:
            process.view = View()
            process.view.on_slow = self._give_up
        return process.view

    def _give_up(self, pattern: Pattern) -> None:
        """Nobody may wait for it again."""
        self._warn(f"looking for {pattern.text!r} takes too long; every line is shown again")
        for view in (self._common, *(p.view for p in self._everyone() if p.view is not None)):
            if view.pattern is pattern:
                view.pattern = None


def _levels(level: int) -> str:
    return f"{LEVELS[level]} and above" if level else "all levels"


def _told(processes: Sequence[Process], what: str) -> list[Shown]:
    return [Shown(p.name, f"{p.name} is shown with {what}") for p in processes]


def _drop_if_open(process: Process) -> None:
    """A process that is shown as a whole pays nothing for it."""
    if process.view is not None and process.view.is_open:
        process.view = None
