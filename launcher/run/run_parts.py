"""The parts that one run has."""

from __future__ import annotations

import functools

from launcher.base.by_name import load
from launcher.run.part import Part, PartRow, StartStage, When
from launcher.run.parts import ROWS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from typing import TypeVar

    from launcher.run.run import Run

    P = TypeVar("P", bound=Part)

_RANKS = {row.part: rank for rank, row in enumerate(ROWS)}


class RunParts:
    """The parts of one run, in the order of the table."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._parts: tuple[Part, ...] = ()
        self.stages: Sequence[StartStage] = ()

    def __iter__(self) -> Iterator[Part]:
        return iter(self._parts)

    def find(self, kind: type[P]) -> P | None:
        """The part of this class, if it was made."""
        return next((part for part in self._parts if type(part) is kind), None)

    def need(self, kind: type[P]) -> P:
        """The part of this class, which is made if there is none yet."""
        found = self.find(kind)
        if found is not None:
            return found
        part = kind(self._run)
        self._parts = tuple(sorted((*self._parts, part), key=_rank))
        self.stages = [one for one in self._parts if isinstance(one, StartStage)]
        return part

    def _wanted(self, when: When) -> list[PartRow]:
        return [row for row in ROWS if row.when is when and row.wanted(self._run)]

    def make_first(self) -> None:
        """Make the parts that are wanted before the first start; UsageError."""
        for row in self._wanted(When.FIRST):
            self.need(load(row.part))

    def begin(self, when: When) -> None:
        """Make those that are wanted from then on, in idle moments."""
        for row in self._wanted(when):
            begin = functools.partial(self._begin, row)
            if row.delay_s:
                self._run.reactor.call_later(row.delay_s, begin)
            else:
                begin()

    def _begin(self, row: PartRow) -> None:
        when_idle = self._run.reactor.when_idle
        for name in row.imports:
            when_idle(functools.partial(__import__, name))
        when_idle(lambda: self.need(load(row.part)).begin())


def _rank(part: Part) -> int:
    kind = type(part)
    return _RANKS[f"{kind.__module__}:{kind.__qualname__}"]
