"""Flakes: how often each expectation was met over several runs, and how far its values spread."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from launcher.smoke.result import Result


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One expectation over all runs; the values are None where nothing was measured."""

    name: str
    met: int
    runs: int
    unit: str = ""
    least: float | None = None
    median: float | None = None
    most: float | None = None

    @property
    def verdict(self) -> str:
        """`always`, `FLAKY` or `NEVER`."""
        return "always" if self.met == self.runs else ("NEVER" if self.met == 0 else "FLAKY")

    @property
    def spread(self) -> str:
        """`0.98 / 1.00 / 1.01 Hz`."""
        if self.least is None or self.median is None or self.most is None:
            return ""
        return f"{self.least:.3g} / {self.median:.3g} / {self.most:.3g} {self.unit}".rstrip()


def rows(results: Sequence[Result]) -> list[Row]:
    """One for each expectation, in their order."""
    names = dict.fromkeys(one.expectation.name for result in results for one in result.judged)
    return [_row(name, results) for name in names]


def _row(name: str, results: Sequence[Result]) -> Row:
    found = [one for r in results for one in r.judged if one.expectation.name == name]
    values = [one.verdict.value for one in found if one.verdict.value is not None]
    units = [one.verdict.unit for one in found if one.verdict.value is not None]
    return Row(
        name=name,
        met=len(results) - sum(not one.is_met for one in found),  # some are told only if not met
        runs=len(results),
        unit=units[0] if units else "",
        least=min(values, default=None),
        median=statistics.median(values) if values else None,
        most=max(values, default=None),
    )
