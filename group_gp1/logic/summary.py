"""The report about a fleet that is too large to be listed robot by robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

MAX_NAMED = 5  # of each kind


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetSummary:
    """States and tasks; `missing` has never reported, `silent_s` says for how long by robot."""

    tasks: Mapping[str, int]
    busy: int
    idle: int
    silent_s: Mapping[str, float]
    missing: Sequence[str]

    def __str__(self) -> str:
        total = sum(self.tasks.values())
        states = (
            f'{len(self.tasks)} robots: {self.busy} busy, {self.idle} idle, '
            f'{len(self.silent_s)} silent, {len(self.missing)} not started'
        )
        return f'Fleet report -- {"; ".join([states, f"{total} tasks", *self._worst()])}'

    def _worst(self) -> Iterator[str]:
        if self.silent_s:
            longest = sorted(self.silent_s.items(), key=lambda one: -one[1])
            yield 'silent: ' + _named([f'{name} ({silent:.0f} s)' for name, silent in longest])
        if self.missing:
            yield 'not started: ' + _named(self.missing)
        away = {*self.silent_s, *self.missing}
        counts = {name: count for name, count in self.tasks.items() if name not in away}
        if counts:
            fewest = min(counts.values())
            names = [name for name, count in counts.items() if count == fewest]
            yield f'fewest tasks: {fewest} by {_named(names)}'


def _named(names: Sequence[str]) -> str:
    more = len(names) - MAX_NAMED
    return ', '.join(names[:MAX_NAMED]) + (f' and {more} more' if more > 0 else '')
