"""The description of a failure: what was expected, what was seen, and the last lines."""

from __future__ import annotations

from launcher.base.document.quantities import seconds_text
from launcher.base.text import escape
from launcher.smoke.judges.common import shorten
from launcher.smoke.observe.facts import Facts
from launcher.smoke.reports.result import Judged

LINES = 10
PROCESSES = 3  # whose last lines are shown


def describe(one: Judged, facts: Facts, described: dict[str, str] | None = None) -> list[str]:
    """The lines about an expectation that is not met.

    `described`: processes whose last lines are already shown, with the name of that expectation.
    """
    verdict, expectation = one.verdict, one.expectation
    lines = [
        f"{expectation.name}    ({expectation.origin})",
        f"    expected: {verdict.expected}",
        f"    seen:     {verdict.seen or 'nothing'}",
    ]
    if verdict.at_s is not None:
        lines.append(f"    since:    {seconds_text(max(0.0, verdict.at_s))} after the start")
    if verdict.guess:
        lines.append(f"    maybe:    {verdict.guess}")
    for process in verdict.about[:PROCESSES]:
        if described is not None and process in described:
            lines.append(f"    last lines of {process}: above, under '{described[process]}'")
            continue
        lines += _last_lines(process, facts)
        if described is not None:
            described[process] = expectation.name
    return [escape(line) for line in lines]


def _last_lines(process: str, facts: Facts) -> list[str]:
    last = facts.last_lines(process, LINES)
    if not last:
        return [f"    {process} printed nothing"]
    shown = [f"        [{line.at_s:6.1f} s] {shorten(line.plain)}" for line in last]
    return [f"    last lines of {process}:", *shown]
