"""The result of a smoke run as text: a table, the failures, and a summary."""

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

from launcher.base.text import escape
from launcher.smoke.reports.failure import describe
from launcher.smoke.reports.result import Judged, SmokeResult

PLAIN_WIDTH = 120  # without a terminal, as in a CI log
ROWS = 200  # at most; of more expectations only failures are shown


def console_for(stream: IO[str], *, colour: bool) -> Console:
    """As wide as the terminal; without colours and control sequences elsewhere."""
    width = shutil.get_terminal_size().columns if stream.isatty() else PLAIN_WIDTH
    return Console(
        file=stream,
        width=width,
        color_system="standard" if colour else None,
        highlight=False,
        force_terminal=colour,
    )


def show(console: Console, result: SmokeResult) -> None:
    rows = shown_rows(result)
    if rows:
        table = _table("", "expectation", "seen")
        for one in rows:
            table.add_row(_mark(one), _shown(one.expectation.name), _shown(one.verdict.seen))
        console.print(table)
    if len(rows) < len(result.judged):
        console.print(Text(left_out(result, rows)))
    described: dict[str, str] = {}
    for one in result.failures[:ROWS]:
        console.print()
        console.print(Text("\n".join(describe(one, result.facts, described))), soft_wrap=True)
    for trouble in result.facts.troubles:
        console.print(_shown(f"note: {trouble}"), soft_wrap=True)
    console.print()
    style = "green" if not result.exit_code else "red"
    console.print(Text(summary(result), style=style), soft_wrap=True)


def _table(*heads: str) -> Table:
    table = Table(box=SIMPLE, show_edge=False, pad_edge=False)
    for head in heads:
        table.add_column(head, overflow="fold")
    return table


def shown_rows(result: SmokeResult) -> tuple[Judged, ...]:
    return result.judged if len(result.judged) <= ROWS else result.failures[:ROWS]


def left_out(result: SmokeResult, rows: Sequence[Judged]) -> str:
    """`... and 300 met: smoke.log and report.json list all`, for those without a row."""
    met = len(result.judged) - len(result.failures)
    unmet = len(result.failures) - len(rows)
    parts = [f"{met} met"] if met else []
    parts += [f"{unmet} not met"] if unmet > 0 else []
    return f"... and {' and '.join(parts)}: smoke.log and report.json list all"


def _shown(text: str) -> Text:
    return Text(escape(text))


def _mark(one: Judged) -> Text:
    return Text("met", style="green") if one.is_met else Text("NOT MET", style="bold red")


def summary(result: SmokeResult) -> str:
    """`smoke: 12 of 12 expectations met, exit code 0`."""
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


def show_flakes(console: Console, results: Sequence[SmokeResult]) -> None:
    """How often each expectation was met, and the spread of its values."""
    table = _table("", "met", "expectation", "min / median / max")
    for row in flake_rows(results):
        style = "green" if row.met == row.runs else "bold red"
        table.add_row(
            Text(row.verdict, style=style),
            Text(f"{row.met} of {row.runs}"),
            _shown(row.name),
            Text(row.spread),
        )
    console.print(table)
    console.print(Text(flake_summary(results)))


def flake_summary(results: Sequence[SmokeResult]) -> str:
    good = sum(not result.exit_code for result in results)
    return f"smoke: {good} of {len(results)} runs without a failure"


@dataclass(frozen=True, slots=True)
class FlakeRow:
    """One expectation over all runs; `values` are what was measured."""

    name: str
    met: int
    runs: int
    values: tuple[float, ...] = ()
    unit: str = ""

    @property
    def verdict(self) -> str:
        return "always" if self.met == self.runs else ("NEVER" if self.met == 0 else "FLAKY")

    @property
    def spread(self) -> str:
        """`0.98 / 1.00 / 1.01 Hz`: minimum, median, maximum."""
        if not self.values:
            return ""
        least, median, most = min(self.values), statistics.median(self.values), max(self.values)
        return f"{least:.3g} / {median:.3g} / {most:.3g} {self.unit}".rstrip()


def flake_rows(results: Sequence[SmokeResult]) -> list[FlakeRow]:
    """One for each expectation, in their order."""
    names = dict.fromkeys(one.expectation.name for result in results for one in result.judged)
    return [_flake_row(name, results) for name in names]


def _flake_row(name: str, results: Sequence[SmokeResult]) -> FlakeRow:
    found = [one for r in results for one in r.judged if one.expectation.name == name]
    measured = [one.verdict for one in found if one.verdict.value is not None]
    # Some expectations have a row only where they are not met.
    met = len(results) - sum(not one.is_met for one in found)
    values = tuple(verdict.value for verdict in measured if verdict.value is not None)
    return FlakeRow(name, met, len(results), values, measured[0].unit if measured else "")
