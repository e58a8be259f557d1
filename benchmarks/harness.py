"""Row: one line of the table, and what the measurements have in common."""

from __future__ import annotations

import os
import shutil
import statistics
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, TypeVar

T = TypeVar("T")


class Row(NamedTuple):
    """A measured value, its bar, and the figures behind it.

    `unit` is written behind both; "x" is a `ratio` within this run. `at_least` tells on
    which side of the bar is good.
    """

    what: str
    measured: float
    unit: str
    bar: float
    detail: str
    at_least: bool = False

    @property
    def is_met(self) -> bool:
        """Whether the bar is kept."""
        if self.at_least:
            return self.measured >= self.bar
        return self.measured <= self.bar

    def cells(self) -> tuple[str, str, str, str, str]:
        """What the table shows."""
        side = ">=" if self.at_least else "<="
        verdict = "ok" if self.is_met else "OVER" if not self.at_least else "UNDER"
        return (
            self.what,
            f"{self.measured:.3g} {self.unit}",
            f"{side} {self.bar:g} {self.unit}",
            verdict,
            self.detail,
        )


def interleaved(runs: int, measures: Mapping[str, Callable[[], T]]) -> dict[str, list[T]]:
    """Measure all of them in turn, `runs` times, after one turn that does not count.

    Every other turn goes backwards, so that a machine that becomes slower meanwhile hurts none
    more than the others.
    """
    for measure in measures.values():
        measure()
    results: dict[str, list[T]] = {name: [] for name in measures}
    for turn in range(runs):
        names = list(measures)
        for name in reversed(names) if turn % 2 else names:
            results[name].append(measures[name]())
    return results


def median(values: list[float]) -> float:
    """The middle one."""
    return statistics.median(values)


def ratio(ours: list[float], theirs: list[float]) -> float:
    """The median of the ratios of each turn: what slows the machine for a while cancels out."""
    return median([a / b for a, b in zip(ours, theirs, strict=True)])


def milliseconds(values: list[float]) -> str:
    """The median of seconds, and the best and the worst, in ms."""
    middle, best, worst = (x * 1000 for x in (median(values), min(values), max(values)))
    return f"{middle:.3g} ms ({best:.3g}..{worst:.3g})"


@contextmanager
def scratch() -> Iterator[Path]:
    """An empty folder (below TMPDIR) for one run."""
    with tempfile.TemporaryDirectory(prefix="launcher-bench-") as name:
        yield Path(name)


@contextmanager
def programs(name: str, count: int) -> Iterator[Path]:
    """A folder with so many links, NAME-0, NAME-1, ..., to a private copy of a program."""
    with scratch() as folder, scratch() as store:
        found = shutil.which(name)
        if found is None:
            raise FileNotFoundError(name)
        copy = store / name
        shutil.copy(os.path.realpath(found), copy)
        for number in range(count):
            os.link(copy, folder / f"{name}-{number}")
        yield folder
