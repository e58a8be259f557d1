"""Screen: the end of a smoke run for a person: a table, and every failure explained."""

from __future__ import annotations

import shutil
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from typing import IO

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table
from rich.text import Text

from launcher.smoke.expect.quantities import printable
from launcher.smoke.reports.failure import describe
from launcher.smoke.reports.result import Judged, Result

PLAIN_WIDTH = 120  # what a log of CI shows without a terminal
ROWS = 200  # of more expectations only those are shown that are not met, as many at most


def console_for(stream: IO[str], *, colour: bool) -> Console:
    """As wide as the terminal; no colours and no control sequences elsewhere."""
    width = shutil.get_terminal_size().columns if stream.isatty() else PLAIN_WIDTH
    return Console(
        file=stream,
        width=width,
        color_system="standard" if colour else None,
        highlight=False,
        force_terminal=colour,
    )


def show(console: Console, result: Result) -> None:
    """The table of all expectations, then the failures, then one line."""
    rows = result.judged if len(result.judged) <= ROWS else result.failures[:ROWS]
    if rows:
        console.print(_table(rows))
    if len(rows) < len(result.judged):
        met = len(result.judged) - len(result.failures)
        console.print(Text(f"... and {_others(met, len(result.failures) - len(rows))}"))
    told: dict[str, str] = {}
    for one in result.failures[:ROWS]:
        console.print()
        console.print(Text("\n".join(describe(one, result.facts, told))), soft_wrap=True)
    for trouble in result.facts.troubles:
        console.print(_shown(f"note: {trouble}"), soft_wrap=True)
    console.print()
    style = "green" if not result.exit_code else "red"
    console.print(Text(summary(result), style=style), soft_wrap=True)


def _table(rows: Sequence[Judged]) -> Table:
    table = Table(box=SIMPLE, show_edge=False, pad_edge=False)
    for head in ("", "expectation", "seen"):
        table.add_column(head, overflow="fold")
    for one in rows:
        table.add_row(_mark(one), _shown(one.expectation.name), _shown(one.verdict.seen))
    return table


def _others(met: int, unmet: int) -> str:
    parts = [f"{met} that are met"] if met else []
    parts += [f"{unmet} that are not"] if unmet > 0 else []
    return f"{' and '.join(parts)}: smoke.log and report.json have all"


def _shown(text: str) -> Text:
    return Text(printable(text))


def _mark(one: Judged) -> Text:
    return Text("met", style="green") if one.is_met else Text("NOT MET", style="bold red")


def summary(result: Result) -> str:
    """`smoke: 12 of 12 expectations met` and what else there is to say."""
    met = len(result.judged) - len(result.failures)
    parts = [f"smoke: {met} of {len(result.judged)} expectations met"]
    if result.gave_up:
        parts.append("the system was not ready in time")
    if result.trouble:
        parts.append(result.trouble)
    if result.interrupted:
        parts.append("interrupted")
    parts.append(f"exit code {int(result.exit_code)}")
    return ", ".join(parts)


def show_flakes(console: Console, results: Sequence[Result]) -> None:
    """How often each expectation was met, and the spread of what was measured."""
    table = Table(box=SIMPLE, show_edge=False, pad_edge=False)
    for head in ("", "met", "expectation", "min / median / max"):
        table.add_column(head, overflow="fold")
    for row in flake_rows(results):
        style = "green" if row.met == row.runs else "bold red"
        table.add_row(
            Text(row.verdict, style=style),
            Text(f"{row.met} of {row.runs}"),
            _shown(row.name),
            Text(row.spread),
        )
    console.print(table)
    good = sum(not result.exit_code for result in results)
    console.print(Text(f"smoke: {good} of {len(results)} runs without a failure"))


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


def flake_rows(results: Sequence[Result]) -> list[Row]:
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
