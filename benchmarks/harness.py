"""A row of the result table, alternating runs, statistics, and temporary folders."""

from __future__ import annotations

import math
import os
import shutil
import statistics
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, TypeVar

T = TypeVar("T")


class NotHereError(Exception):
    """The machine lacks what the benchmark needs; the text says what."""


class Row(NamedTuple):
    """A measured value, its limit, and details.

    `unit` applies to both; "x" is a `ratio` within this run. With `at_least` the limit is a
    lower one; an infinite one is none.
    """

    what: str
    measured: float
    unit: str
    limit: float
    detail: str
    at_least: bool = False

    @property
    def is_met(self) -> bool:
        if self.at_least:
            return self.measured >= self.limit
        return self.measured <= self.limit

    def cells(self) -> tuple[str, str, str, str, str]:
        side = ">=" if self.at_least else "<="
        limit = f"{side} {self.limit:g} {self.unit}" if math.isfinite(self.limit) else ""
        verdict = "ok" if self.is_met else "OVER" if not self.at_least else "UNDER"
        return (
            self.what,
            f"{self.measured:.3g} {self.unit}",
            limit,
            verdict,
            self.detail,
        )


def interleaved(runs: int, measures: Mapping[str, Callable[[], T]]) -> dict[str, list[T]]:
    """Measure all of them in turn, `runs` times, after one warm-up turn.

    The order is reversed every second time, so that a machine that becomes slower affects all
    alike.
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
    return statistics.median(values)


def ratio(ours: list[float], theirs: list[float]) -> float:
    """The median of the ratios of each turn, so that a temporary slowdown cancels out."""
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
    """A folder with `count` links, NAME-0, NAME-1, ..., to a private copy of a program."""
    with scratch() as folder, scratch() as store:
        found = shutil.which(name)
        if found is None:
            raise FileNotFoundError(name)
        copy = store / name
        shutil.copy(os.path.realpath(found), copy)
        for number in range(count):
            os.link(copy, folder / f"{name}-{number}")
        yield folder
